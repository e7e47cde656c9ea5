//! ScreenX: a horizontal ramp across the picture.

use trochoid_graph::*;

/// A mask that rises from 0 at the left edge of the picture to 1 at the right.
///
/// # Formula
/// (x − ½)/(width − 1), limited to [0, 1], with x in pixels from the left edge.
///
/// # Edge cases
/// 0 at the center of the first pixel, 1 at the center of the last; ½ in a picture one pixel wide.
///
/// # Source
/// Conventions of the document format.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "The mask."))]
pub(crate) struct ScreenX;

impl Node for ScreenX {}

impl Stage for ScreenX {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn variance(&self, _output: usize) -> Variance {
        Variance::Column
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedScreenX { width: prepare.frame.format.width() }))
    }
}

/// Width of the picture, in pixels.
struct PreparedScreenX {
    width: u32,
}

impl Prepared for PreparedScreenX {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(plane) = outputs.only(0) else { return Ok(()) };
        let columns = block.window.width();
        if columns == 0 {
            return Ok(());
        }
        let last = f64::from(self.width) - 1.0;
        let start = block.window.x0 as f64 + block.offset[0] - 0.5;
        for (column, out) in plane.iter_mut().take(columns).enumerate() {
            *out = if last > 0.0 { ((start + column as f64) / last).clamp(0.0, 1.0) as f32 } else { 0.5 };
        }
        let (first, rest) = plane.split_at_mut(columns.min(plane.len()));
        rest.chunks_mut(columns).for_each(|row| row.copy_from_slice(&first[..row.len()]));
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.rounded_once(outputs);
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let last = f64::from(self.width) - 1.0;
        let t = if last > 0.0 { ((inputs.at[0] - 0.5) / last).clamp(0.0, 1.0) } else { 0.5 };
        Ok(vec![Reference::Mask(t)])
    }
}
