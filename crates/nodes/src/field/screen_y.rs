//! ScreenY: a vertical ramp down the picture.

use trochoid_graph::*;

/// A mask that rises from 0 at the top of the picture to 1 at the bottom.
///
/// # Formula
/// (y − ½)/(height − 1), limited to [0, 1], with y in pixels from the upper edge.
///
/// # Edge cases
/// 0 at the center of the first pixel, 1 at the center of the last; ½ in a picture one pixel high.
///
/// # Source
/// Conventions of the document format.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "The mask."))]
pub(crate) struct ScreenY;

impl Node for ScreenY {}

impl Stage for ScreenY {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn variance(&self, _output: usize) -> Variance {
        Variance::Row
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedScreenY { height: prepare.frame.format.height() }))
    }
}

/// Height of the picture, in pixels.
struct PreparedScreenY {
    height: u32,
}

impl Prepared for PreparedScreenY {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(plane) = outputs.only(0) else { return Ok(()) };
        let last = f64::from(self.height) - 1.0;
        let start = block.window.y0 as f64 + block.offset[1] - 0.5;
        for (row, out) in plane.chunks_mut(block.window.width().max(1)).enumerate() {
            out.fill(if last > 0.0 { ((start + row as f64) / last).clamp(0.0, 1.0) as f32 } else { 0.5 });
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.rounded_once(outputs);
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let last = f64::from(self.height) - 1.0;
        let t = if last > 0.0 { ((inputs.at[1] - 0.5) / last).clamp(0.0, 1.0) } else { 0.5 };
        Ok(vec![Reference::Mask(t)])
    }
}
