use std::f64::consts::PI;
use trochoid_key::content_key;

use super::error::within;
use super::splat::{DriftStamp, Stamp};
use super::spline::Spline;
use super::{Basin, Drift, Rift, Shape, ToonError, ToonParameter};

content_key!(
    enum Shape {
        Intended,
        Literal,
    }
);

/// The center of a wave that travels along a cubic Bézier curve, over and over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Burst {
    /// Control points x, z, in meters.
    pub path: [[f64; 2]; 4],
    /// Seconds from one end of the path to the other.
    pub duration: f64,
    /// Seconds by which it is ahead at time 0.
    pub offset: f64,
    /// Height H, in meters.
    pub height: f64,
    /// Peak p: scales height and radius.
    pub peak: f64,
    /// Influence r, in meters: radii along and across the heading, or along x and z.
    pub influence: [f64; 2],
    /// Share of the path over which it grows at the start and fades out at the end; 0 as printed, at most ½.
    pub fade: f64,
    /// Times in seconds from which and until which it is active.
    pub active: [f64; 2],
    /// Offset from the middle of its group, across, in meters: the origin of its drift lines.
    pub lane: f64,
}

content_key!(Burst { path, duration, offset, height, peak, influence, fade, active, lane });

impl Burst {
    /// Makes a burst of 1 m height and 2 m radius along a path, in 10 s.
    pub fn along(path: [[f64; 2]; 4]) -> Self {
        Self {
            path,
            duration: 10.0,
            offset: 0.0,
            height: 1.0,
            peak: 1.0,
            influence: [2.0; 2],
            fade: 0.0,
            active: [f64::NEG_INFINITY, f64::INFINITY],
            lane: 0.0,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), ToonError> {
        for value in self.path.iter().flatten() {
            within(ToonParameter::ControlPoint, *value, (-1e9, 1e9), "-1e9 to 1e9 meters")?;
        }
        within(ToonParameter::Duration, self.duration, (1e-3, 1e9), "0.001 to 1e9 seconds")?;
        within(ToonParameter::Offset, self.offset, (-1e9, 1e9), "-1e9 to 1e9 seconds")?;
        within(ToonParameter::Height, self.height, (-1e6, 1e6), "-1e6 to 1e6 meters")?;
        within(ToonParameter::Peak, self.peak, (1e-3, 1e3), "0.001 to 1000")?;
        within(ToonParameter::Influence, self.influence[0], (1e-3, 1e6), "0.001 to 1e6 meters")?;
        within(ToonParameter::Influence, self.influence[1], (1e-3, 1e6), "0.001 to 1e6 meters")?;
        within(ToonParameter::Fade, self.fade, (0.0, 0.5), "0 to 0.5")?;
        within(ToonParameter::Lane, self.lane, (-1e6, 1e6), "-1e6 to 1e6 meters")?;
        let [start, end] = self.active;
        if start.is_nan() || end.is_nan() {
            let (parameter, expected) = (ToonParameter::Active, "two times in seconds");
            return Err(ToonError::Range { parameter, burst: None, found: f64::NAN, expected });
        }
        Ok(())
    }

    pub(crate) fn is_active(&self, time: f64) -> bool {
        self.active[0] <= time && time < self.active[1]
    }

    /// Returns the number of completed laps at a time, and the share of the current lap: t̂ = (t mod d)/d.
    pub(crate) fn progress(&self, time: f64) -> (f64, f64) {
        let turns = (time + self.offset) / self.duration;
        let lap = turns.floor();
        (lap, turns - lap)
    }

    /// Returns the share of the height that is left at a share of the path.
    pub(crate) fn left(&self, progress: f64) -> f64 {
        if self.fade > 0.0 { (progress.min(1.0 - progress) / self.fade).min(1.0) } else { 1.0 }
    }

    /// Returns the radii at which the profile ends, in meters, and its factor.
    pub(crate) fn profile(&self, shape: Shape) -> ([f64; 2], f64) {
        match shape {
            Shape::Intended => (self.influence.map(|radius| radius * self.peak), self.peak * self.height / 2.0),
            Shape::Literal => (self.influence.map(|radius| radius * PI / self.peak), self.height),
        }
    }

    /// Returns the effect of this burst on the cells of a basin at a time. `lengths` is its path's table of arc
    /// lengths, empty if no drift is wanted.
    pub(crate) fn stamp(&self, time: f64, at: &StampParameters<'_>, lengths: &[f64]) -> Stamp {
        let spline = Spline(self.path);
        let (lap, progress) = self.progress(time);
        let place = spline.point(progress);
        let left = self.left(progress);
        let spacing = at.basin.spacing;
        let (radii, factor) = self.profile(at.shape);
        let radii = radii.map(|radius| radius / spacing);
        // A round burst does not need its heading, unless drift lines do.
        let turned = (at.oriented && radii[0] != radii[1]) || at.drift.is_some();
        let heading = if turned { spline.heading(progress) } else { [1.0, 0.0] };
        let axis = if at.oriented { heading } else { [1.0, 0.0] };
        let mut reach = extents(axis, radii);
        if let Some(rift) = at.rift {
            reach = reach.map(|reach| reach.max(rift.distance / spacing));
        }
        let drift = at.drift.map(|drift| {
            let wide = [radii[0] * drift.reach[0], radii[1] * drift.reach[1]];
            let extents = extents(heading, wide);
            reach = [reach[0].max(extents[0]), reach[1].max(extents[1])];
            DriftStamp {
                heading: heading.map(|value| value as f32),
                inverse: wide.map(|radius| (1.0 / radius) as f32),
                turns: (spacing * drift.frequency()) as f32,
                along: drift.along(lap, progress, lengths) as f32,
                lane: (self.lane * drift.frequency()).rem_euclid(1.0) as f32,
                lag: drift.lag as f32,
                soft: (drift.softness(spacing) / (spacing * spacing)) as f32,
                weight: left as f32,
            }
        });
        Stamp {
            place: place.map(|value| value / spacing),
            form: form(axis, radii).map(|value| value as f32),
            factor: (factor * left) as f32,
            reach,
            drift,
        }
    }
}

/// Parameters that all stamps of one step share.
#[derive(Clone, Copy)]
pub(crate) struct StampParameters<'a> {
    pub(crate) basin: &'a Basin,
    pub(crate) shape: Shape,
    pub(crate) oriented: bool,
    pub(crate) rift: Option<Rift>,
    pub(crate) drift: Option<Drift>,
}

/// Returns the coefficients of x², 2xz, z² in |(u−x)/r|².
fn form([x, z]: [f64; 2], [along, across]: [f64; 2]) -> [f64; 3] {
    if along == across {
        // Exactly round for every heading.
        let inverse = 1.0 / (along * along);
        return [inverse, 0.0, inverse];
    }
    let (a, l) = (1.0 / (along * along), 1.0 / (across * across));
    [x * x * a + z * z * l, x * z * (a - l), z * z * a + x * x * l]
}

/// Returns half the sides of the box around the ellipse.
fn extents([x, z]: [f64; 2], [along, across]: [f64; 2]) -> [f64; 2] {
    if along == across {
        return [along; 2];
    }
    [libm::hypot(x * along, z * across), libm::hypot(z * along, x * across)]
}
