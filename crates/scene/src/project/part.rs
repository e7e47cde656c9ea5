//! A part of a picture, and what of a grid may be seen in it.

use glam::DVec3;
use trochoid_image::Window;

use super::{BIN, MeshProjector, Raster, ScreenVertex, outside};
use crate::Projector;

/// Number of sides of a picture.
pub(crate) const SIDES: usize = 4;

/// A part of a picture, and what of a grid may be seen in it.
pub(crate) struct PictureOfPart<'a> {
    stage: MeshProjector<'a>,
    /// First and last coordinates in fixed point.
    low: [i64; 2],
    high: [i64; 2],
    /// Functions n·p + d that are negative beyond each side, for a point p relative to the camera that is not behind it.
    sides: [(DVec3, f64); SIDES],
}

impl<'a> PictureOfPart<'a> {
    pub(crate) fn new(projector: &'a Projector, part: Window) -> Self {
        let stage = MeshProjector { projector, raster: Raster::new(projector), bins: [0, 0] };
        let raster = stage.raster;
        let fix = |pixels: i64| raster.fix(pixels as f64);
        // Primitives are found by bins, of which some reach into the part.
        let (low, high) = ([part.x0 - BIN[0], part.y0 - BIN[1]], [part.x1 + BIN[0], part.y1 + BIN[1]]);
        let Projector { right, up, forward, scale, size, .. } = *projector;
        // Position on the picture, from its center: scale · across/depth.
        let side = |across: DVec3, at: f64| match projector.orthographic {
            true => (across * scale, -at),
            false => (across * scale - forward * at, 0.0),
        };
        let [left, bottom] = [low[0] as f64 - size[0] / 2.0, size[1] / 2.0 - high[1] as f64];
        let [last, top] = [high[0] as f64 - size[0] / 2.0, size[1] / 2.0 - low[1] as f64];
        let sides = [side(right, left), side(-right, -last), side(up, bottom), side(-up, -top)];
        Self { stage, low: low.map(fix), high: high.map(fix), sides }
    }

    /// Returns, by side, the part of a line between two points relative to the camera that has points within `spread` of it
    /// that are not beyond the side, from 0 at the first end to 1 at the second; `None` if there is none.
    pub(crate) fn parts(&self, ends: [DVec3; 2], spread: DVec3) -> [Option<[f64; 2]>; SIDES] {
        self.sides.map(|(normal, at)| {
            let more = normal.abs().dot(spread) + at;
            let [first, last] = ends.map(|end| normal.dot(end) + more);
            let change = first / (first - last);
            match (first >= 0.0, last >= 0.0) {
                (true, true) => Some([0.0, 1.0]),
                (true, false) => Some([0.0, change]),
                (false, true) => Some([change, 1.0]),
                (false, false) => None,
            }
        })
    }

    /// Projects a row of vertices.
    pub(crate) fn row(&self, positions: &[[f32; 3]]) -> Vec<(ScreenVertex, u8)> {
        let project = |&position: &[f32; 3]| {
            let (vertex, code) = self.stage.vertex(self.stage.view(position));
            (vertex, code as u8)
        };
        positions.iter().map(project).collect()
    }

    /// Returns whether a cell between two rows may be seen in the part.
    pub(crate) fn sees(&self, above: &[(ScreenVertex, u8)], below: &[(ScreenVertex, u8)]) -> bool {
        above.windows(2).zip(below.windows(2)).any(|(above, below)| {
            let corners = [above[0], above[1], below[0], below[1]];
            let all = corners.iter().fold(u8::MAX, |all, (_, code)| all & code);
            let any = corners.iter().fold(0, |any, (_, code)| any | code);
            if all & !outside::LIMIT != 0 {
                return false;
            }
            let range = |of: fn(&ScreenVertex) -> i32| {
                let values = corners.iter().map(|(vertex, _)| i64::from(of(vertex)));
                (values.clone().min().unwrap_or(0), values.max().unwrap_or(0))
            };
            let ((x0, x1), (y0, y1)) = (range(|vertex| vertex.x), range(|vertex| vertex.y));
            let touches = x1 >= self.low[0] && x0 <= self.high[0] && y1 >= self.low[1] && y0 <= self.high[1];
            // What is clipped may be seen anywhere.
            touches || any & (outside::NEAR | outside::LIMIT) != 0
        })
    }
}
