//! Positions and normals of other renderers: unpacked, with y up, in meters.

use super::{ExactLines, Recipe};
use crate::geometry::Up;
use trochoid_graph::NodeError;

/// Length below which a normal is only rounding error.
const DEGENERATE: f64 = 1e-6;

/// Returns n/|n|, or up if n is degenerate.
pub(crate) fn unit(n: [f64; 3]) -> [f64; 3] {
    let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length > DEGENERATE && length.is_finite() { n.map(|v| v / length) } else { [0.0, 1.0, 0.0] }
}

/// What a recipe for three components computes besides them.
#[derive(Clone, Copy)]
pub(crate) enum Fourth {
    None,
    /// The height above a level.
    Height(f64),
    /// 0 where all components are 0, otherwise 1.
    Coverage,
}

/// Recipe for three components: unpacks them, rotates them so that y is up, finishes and scales them.
pub(crate) struct Turned {
    pub(crate) up: Up,
    pub(crate) unpack: fn(f64) -> f64,
    pub(crate) finish: fn([f64; 3]) -> [f64; 3],
    pub(crate) scale: f64,
    pub(crate) fourth: Fourth,
}

impl Turned {
    /// Returns the three components of a pixel and the fourth value.
    fn value(&self, stored: [f32; 3]) -> [f64; 4] {
        let unpacked = stored.map(|v| (self.unpack)(f64::from(v)));
        let turned = self.up.to_y_up(unpacked);
        let [x, y, z] = (self.finish)(turned).map(|v| v * self.scale);
        let fourth = match self.fourth {
            Fourth::None => 0.0,
            Fourth::Height(level) => y - level,
            Fourth::Coverage => f64::from(u8::from(unpacked != [0.0; 3])),
        };
        [x, y, z, fourth]
    }
}

impl Recipe for Turned {
    fn apply(&self, _at: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let [x, y, z, fourth @ ..] = lines else { return Ok(0) };
        let mut fourth = fourth.first_mut();
        for (index, ((x, y), z)) in x.iter_mut().zip(&mut **y).zip(&mut **z).enumerate() {
            let value = self.value([*x, *y, *z]);
            // Adding 0 turns −0 into 0.
            let [a, b, c, last] = value.map(|v| v as f32 + 0.0);
            [*x, *y, *z] = [a, b, c];
            if let Some(fourth) = &mut fourth {
                fourth[index] = last;
            }
        }
        Ok(0)
    }

    fn exact(&self) -> Option<ExactLines<'_>> {
        if self.scale == 1.0 {
            // Components are as stored, or as rounded.
            return None;
        }
        Some(Box::new(move |_, lines| {
            let [x, y, z, ..] = lines else { return Vec::new() };
            let mut values = vec![Vec::new(); 4];
            for ((x, y), z) in x.iter().zip(*y).zip(*z) {
                values.iter_mut().zip(self.value([*x, *y, *z])).for_each(|(values, value)| values.push(value));
            }
            values
        }))
    }
}
