//! How bodies float on water.

use glam::DVec3;
use rayon::prelude::*;

use crate::rigid::Pose;
use crate::surface::Surface;

/// Points under a hull at which the water is sampled, along it and across it.
const POINTS: [usize; 2] = [9, 5];

/// A body that floats at a fixed horizontal position, whatever the water does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floating {
    /// World x and z of its middle, in meters.
    pub place: [f64; 2],
    /// Azimuth of its bow, the body's +x, in radians: 0 is +X, growing toward +Z.
    pub heading: f64,
    /// Length and width of the hull, in meters, more than 0. Shorter waves hardly move it.
    pub hull: [f64; 2],
    /// Height of the body's origin above the water's mean height under the hull, in meters.
    pub lift: f64,
    /// Share of the water's slope that the body follows: 0 keeps it upright.
    pub tilt: f64,
}

/// Plane fitted to the water under a hull by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// World y at the middle, in meters.
    pub height: f64,
    /// Slopes toward the bow and to starboard (the body's +z).
    pub slopes: [f64; 2],
}

impl Floating {
    /// Fits a plane to the water under the hull; `None` if `sea` is not a sea.
    ///
    /// The points form a regular grid that is symmetric about the middle, so that the normal equations of the fit
    /// decouple: height Σy/n, slopes Σuy/Σu² and Σvy/Σv². Waves between the points are smoothed away.
    pub fn water(&self, sea: &dyn Surface) -> Option<Plane> {
        let (sin, cos) = libm::sincos(self.heading);
        let steps: [f64; 2] = std::array::from_fn(|axis| self.hull[axis] / POINTS[axis] as f64);
        let footprint = steps[0].max(steps[1]);
        let from_middle = |index: usize, axis: usize| index as f64 - (POINTS[axis] - 1) as f64 / 2.0;
        let at = |point: usize| {
            let [i, j] = [point / POINTS[1], point % POINTS[1]];
            [from_middle(i, 0) * steps[0], from_middle(j, 1) * steps[1]]
        };
        // Each point takes many sines, so the threads share them.
        let heights: Vec<Option<f64>> = (0..POINTS[0] * POINTS[1])
            .into_par_iter()
            .map(|point| {
                let [u, v] = at(point);
                let place = [self.place[0] + u * cos - v * sin, self.place[1] + u * sin + v * cos];
                sea.height_at(place, footprint)
            })
            .collect();
        let (mut sum, mut moments, mut squares) = (0.0, [0.0; 2], [0.0; 2]);
        for (point, y) in heights.into_iter().enumerate() {
            let ([u, v], y) = (at(point), y?);
            sum += y;
            moments = [moments[0] + u * y, moments[1] + v * y];
            squares = [squares[0] + u * u, squares[1] + v * v];
        }
        let slopes = std::array::from_fn(|axis| moments[axis] / squares[axis]);
        Some(Plane { height: sum / (POINTS[0] * POINTS[1]) as f64, slopes })
    }

    /// Returns the body's pose; `None` if `sea` is not a sea.
    pub fn pose(&self, sea: &dyn Surface) -> Option<Pose> {
        let Plane { height, slopes } = self.water(sea)?;
        let (sin, cos) = libm::sincos(self.heading);
        // Tangents of the plane toward the bow and to starboard; up is perpendicular to both.
        let bow = DVec3::new(cos, self.tilt * slopes[0], sin);
        let starboard = DVec3::new(-sin, self.tilt * slopes[1], cos);
        let x = bow.normalize();
        let y = starboard.cross(bow).normalize();
        let origin = DVec3::new(self.place[0], height, self.place[1]) + y * self.lift;
        Some(Pose { axes: [x, y, x.cross(y)], origin })
    }
}
