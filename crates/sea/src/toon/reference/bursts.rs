//! Bursts at one time, and the cells that they may change.

use std::f64::consts::FRAC_1_PI;
use std::ops::Range;

use crate::kernel64::LANES;
use crate::toon::spline::Spline;
use crate::toon::{Basin, Burst, Shape, ToonSea};

/// A burst at one time.
pub(super) struct ActiveBurst<'a> {
    pub(super) burst: &'a Burst,
    pub(super) center: [f64; 2],
    /// Cosine and sine of its heading.
    pub(super) heading: [f64; 2],
    /// Share of the height that the fade leaves.
    pub(super) left: f64,
    /// Turns of its drift lines.
    pub(super) turns: f64,
}

/// Half turns beyond which an angle has no precision left: angles of drift lines end there.
pub(super) const MOST_HALF_TURNS: f64 = (1_u64 << 50) as f64;

/// The heights of a burst: factor·(cos(π·(min(d, 1) + shift)) + raise), where d is the distance relative to the radii.
pub(super) struct Profile {
    /// Inverse radii, in 1/meters.
    pub(super) inverse: [f64; 2],
    pub(super) shift: f64,
    pub(super) raise: f64,
    pub(super) factor: f64,
}

impl<'a> ActiveBurst<'a> {
    /// Returns the bursts that are active. Their turns are 0 unless the sea has the lengths of paths.
    pub(super) fn all(sea: &'a ToonSea, time: f64) -> Vec<Self> {
        let passing = |(index, burst): (usize, &'a Burst)| {
            let spline = Spline(burst.path);
            let (lap, progress) = burst.progress(time);
            let drift = sea.behavior.drift;
            Self {
                burst,
                center: spline.point(progress),
                heading: spline.heading(progress),
                left: burst.left(progress),
                turns: sea.lengths.get(index).map_or(0.0, |lengths| drift.along(lap, progress, lengths)),
            }
        };
        sea.bursts.iter().enumerate().filter(|(_, burst)| burst.is_active(time)).map(passing).collect()
    }

    /// Returns the axis to which its radii belong, as cosine and sine.
    pub(super) fn axis(&self, oriented: bool) -> [f64; 2] {
        if oriented { self.heading } else { [1.0, 0.0] }
    }

    /// Returns its heights, of which a share is left.
    pub(super) fn profile(&self, shape: Shape) -> Profile {
        let (radii, factor) = self.burst.profile(shape);
        let (shift, raise) = match shape {
            Shape::Intended => (0.0, 1.0),
            Shape::Literal => (FRAC_1_PI, 0.0),
        };
        Profile { inverse: radii.map(|radius| 1.0 / radius), shift, raise, factor: factor * self.left }
    }

    /// Returns the radii within which it draws drift lines, along its heading and across.
    fn drawn_radii(&self, sea: &ToonSea) -> [f64; 2] {
        let (radii, _) = self.burst.profile(sea.behavior.shape);
        let reach = sea.behavior.drift.reach;
        [radii[0] * reach[0], radii[1] * reach[1]]
    }

    /// Returns one over these radii.
    pub(super) fn drawn_inverse(&self, sea: &ToonSea) -> [f64; 2] {
        self.drawn_radii(sea).map(|radius| 1.0 / radius)
    }

    /// Returns where it may add to the force; `None` if everywhere.
    pub(super) fn raised(&self, sea: &ToonSea) -> Option<Ellipse> {
        let radii = self.burst.influence.map(|radius| radius * self.burst.peak);
        let axis = self.axis(sea.behavior.oriented);
        (sea.behavior.shape == Shape::Intended).then(|| Ellipse::around(self.center, axis, radii, &sea.basin))
    }

    /// Returns where it may add to the rift.
    pub(super) fn torn(&self, sea: &ToonSea) -> Ellipse {
        Ellipse::around(self.center, [1.0, 0.0], [sea.behavior.rift.distance; 2], &sea.basin)
    }

    /// Returns where it may add to the coordinates of drift lines.
    pub(super) fn drawn(&self, sea: &ToonSea) -> Ellipse {
        Ellipse::around(self.center, self.heading, self.drawn_radii(sea), &sea.basin)
    }
}

/// An ellipse outside of which a burst adds exact zeros: slightly larger than its own.
///
/// With R the larger radius, rounding moves a point within 2R of the center by less than 1e-15·R in the frame of the
/// burst. Radii that are larger by 1e-6·R cover this: of a point outside, a coordinate below 1e-9·R counts for less than
/// a thousandth, and the other one is too large by 1e-6 of itself. Farther points are outside by either coordinate.
#[derive(Clone, Copy)]
pub(super) struct Ellipse {
    center: [f64; 2],
    /// Coefficients of x² and xz in its equation, and their determinant.
    square: f64,
    mixed: f64,
    determinant: f64,
    /// Half its size along z, with the slack.
    tall: f64,
    /// What rounding may take from the ends of a row, in meters.
    slack: f64,
    spacing: f64,
    columns: usize,
}

impl Ellipse {
    fn around(center: [f64; 2], [cos, sin]: [f64; 2], radii: [f64; 2], basin: &Basin) -> Self {
        let most = radii[0].max(radii[1]);
        let [along, across] = radii.map(|radius| 1.0 / (radius + 2e-6 * most));
        let square = cos * along * (cos * along) + sin * across * (sin * across);
        let tall = libm::sqrt(square) / (along * across);
        // Places of cells are rounded, too.
        let farthest = |axis: usize, cells: usize| center[axis].abs() + cells as f64 * basin.spacing;
        let slack = 1e-6 * most + 1e-12 * (farthest(0, basin.columns) + farthest(1, basin.rows));
        Self {
            center,
            square,
            mixed: cos * sin * (along * along - across * across),
            determinant: along * across * (along * across),
            tall: tall + slack,
            slack,
            spacing: basin.spacing,
            columns: basin.columns,
        }
    }

    /// Returns the cells of a row at z that may lie in it, and others beside them: from a multiple of [`LANES`].
    pub(super) fn columns(&self, z: f64) -> Range<usize> {
        let dz = z - self.center[1];
        if dz.abs() > self.tall {
            return 0..0;
        }
        let middle = self.center[0] - self.mixed / self.square * dz;
        let half = libm::sqrt((self.square - self.determinant * dz * dz).max(0.0)) / self.square + self.slack;
        // Numbers out of range become the nearest in range.
        let first = ((middle - half) / self.spacing).ceil() as usize;
        let end = ((middle + half) / self.spacing).floor() + 1.0;
        first / LANES * LANES..(end as usize).min(self.columns)
    }
}
