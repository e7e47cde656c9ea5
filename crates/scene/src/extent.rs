//! Part of the resting sea that a camera may see.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use crate::{Projector, Ray};

/// Distance at which the sea ends, in meters: its edge lies within 1e-5 pixel of the horizon of any picture.
pub(crate) const HORIZON_M: f64 = 1e7;

/// Bounds of the displacement, in meters: how far a point rises or falls, and how far it moves sideways.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) rise: f64,
    pub(crate) reach: f64,
    /// How far few points rise or fall.
    pub(crate) usual: f64,
}

/// A sector of the resting sea: a wedge that opens in the direction in which the camera looks, or a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sector {
    pub(crate) apex: [f64; 2],
    /// Direction in which the wedge opens.
    pub(crate) heading: [f64; 2],
    /// Angle of the wedge, in radians; a full turn for a disc.
    pub(crate) width: f64,
    /// Distance of the apex behind the camera's foot.
    pub(crate) setback: f64,
    /// First and last radius around the apex.
    pub(crate) radii: [f64; 2],
    /// Distance from the camera of the nearest point in the picture that few others rise above; 0 if there is none.
    pub(crate) nearest: f64,
}

/// A rectangle of the resting sea along two unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Strip {
    pub(crate) across: [f64; 2],
    pub(crate) along: [f64; 2],
    pub(crate) u: [f64; 2],
    pub(crate) v: [f64; 2],
}

/// Returns the range of horizontal distances s ≥ 0, or of any other measure along a ray, over which the height
/// `start` + `slope`·s stays within ±`rise`; `None` if it never does.
fn slab(start: f64, slope: f64, rise: f64) -> Option<[f64; 2]> {
    if slope == 0.0 {
        return (start.abs() <= rise).then_some([0.0, f64::INFINITY]);
    }
    let (a, b) = ((-rise - start) / slope, (rise - start) / slope);
    let (near, far) = (a.min(b).max(0.0), a.max(b));
    (far >= 0.0).then_some([near, far])
}

/// Returns whether a direction is in the picture of a perspective camera.
fn sees(projector: &Projector, direction: DVec3) -> bool {
    projector.project(projector.position + direction).is_some_and(|([x, y], _)| {
        x >= -1.0 && y >= -1.0 && x <= projector.size[0] + 1.0 && y <= projector.size[1] + 1.0
    })
}

impl Sector {
    /// Returns the sector whose displaced points may fall into a perspective camera's picture; `None` if it sees only
    /// sky.
    ///
    /// The visible points lie in a wedge of azimuths around the camera's foot, and come from rest points that are at
    /// most `reach` away from it. A wedge of the same angle whose apex is set back by reach/sin(width/2) contains all
    /// of these: its sides are parallel to those of the first wedge at exactly that distance.
    pub(crate) fn new(projector: &Projector, level: f64, bounds: Bounds) -> Option<Self> {
        let eye = projector.position;
        let height = eye.y - level;
        let vertical = sees(projector, DVec3::NEG_Y) || sees(projector, DVec3::Y);
        let heading = projector.heading();
        let center = libm::atan2(heading[1], heading[0]);
        let (mut near, mut far, mut usual) = (f64::INFINITY, 0.0_f64, f64::INFINITY);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        let border = projector.border();
        for (index, ray) in border.iter().enumerate() {
            let direction = ray.direction;
            let next = border[(index + 1) % border.len()].direction;
            let slope = direction.y / horizontal(direction).max(1e-300);
            if let Some(seen) = slab(height, slope, bounds.rise) {
                near = near.min(seen[0] * 0.98);
                far = far.max(seen[1] * 1.02);
                widen(&mut left, &mut right, turn(direction, center));
            }
            if let Some([first, _]) = slab(height, slope, bounds.usual) {
                usual = usual.min(first);
            }
            // If the border crosses the horizon, or nearly touches it, the sea is visible to its end.
            let crosses = (direction.y <= 0.0) != (next.y <= 0.0);
            if crosses || slope.abs() < 2e-3 {
                // A sum with positive weights lies between the two rays; these weights make its y vanish.
                let level = if crosses { direction * next.y.abs() + next * direction.y.abs() } else { direction };
                far = f64::INFINITY;
                near = near.min(HORIZON_M / 2.0);
                widen(&mut left, &mut right, turn(level, center));
            }
        }
        if left > right {
            return None;
        }
        if vertical {
            // The nearest point is right below or above.
            (near, usual) = (0.0, 0.0);
        }
        let below = (height.abs() - bounds.usual).max(0.0);
        let nearest = if usual.is_finite() { libm::sqrt(usual * usual + below * below) } else { 0.0 };
        let far = (far + bounds.reach).min(HORIZON_M);
        let foot = [eye.x, eye.z];
        // The same on both sides, and a little wider than the border rays, since the true border curves between them.
        let width = 2.0 * left.abs().max(right.abs()) * 1.02 + 1e-4;
        if vertical || width > FRAC_PI_2 * 1.6 {
            let first = (near - bounds.reach).max(0.0);
            return Some(Self { apex: foot, heading, width: TAU, setback: 0.0, radii: [first, far], nearest });
        }
        let setback = bounds.reach / libm::sin(width / 2.0);
        let apex = [foot[0] - setback * heading[0], foot[1] - setback * heading[1]];
        // Distance from the apex to a point at distance `near` from the foot and on the wedge's side, by the law of
        // cosines.
        let first = libm::sqrt(setback * setback + near * near + 2.0 * setback * near * libm::cos(width / 2.0));
        Some(Self {
            apex,
            heading,
            width,
            setback,
            radii: [(first - bounds.reach).max(0.0), (far + setback).min(HORIZON_M)],
            nearest,
        })
    }

    /// Returns whether the last column coincides with the first.
    pub(crate) fn closed(&self) -> bool {
        self.width >= TAU
    }
}

fn horizontal(direction: DVec3) -> f64 {
    libm::sqrt(direction.x * direction.x + direction.z * direction.z)
}

/// Returns the azimuth relative to `center`, −π to π.
fn turn(direction: DVec3, center: f64) -> f64 {
    let angle = libm::atan2(direction.z, direction.x) - center;
    angle - TAU * (angle / TAU).round()
}

fn widen(left: &mut f64, right: &mut f64, value: f64) {
    *left = left.min(value);
    *right = right.max(value);
}

impl Strip {
    /// Returns the rectangle whose displaced points may fall into an orthographic camera's picture, at most `depth`
    /// meters deep; `None` if it sees none.
    pub(crate) fn new(projector: &Projector, level: f64, bounds: Bounds, depth: f64) -> Option<Self> {
        let along = projector.heading();
        let across = [-along[1], along[0]];
        let (mut u, mut v) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        for Ray { origin, direction } in projector.border() {
            let Some(seen) = slab(origin.y - level, direction.y, bounds.rise) else { continue };
            for distance in seen {
                // A horizontal ray never leaves the slab; its end is limited below.
                let point = origin + direction * distance.min(HORIZON_M);
                let ([u_low, u_high], [v_low, v_high]) = (&mut u, &mut v);
                widen(u_low, u_high, point.x * across[0] + point.z * across[1]);
                widen(v_low, v_high, point.x * along[0] + point.z * along[1]);
            }
        }
        if u[0] > u[1] {
            return None;
        }
        let margin = |[low, high]: [f64; 2]| [low - bounds.reach, high + bounds.reach];
        let (u, mut v) = (margin(u), margin(v));
        v[1] = v[1].min(v[0] + depth);
        Some(Self { across, along, u, v })
    }
}
