//! Masks that follow from some channels of a view at each sample by itself.

use super::is_covered;
use trochoid_graph::*;

/// A mask in [0, 1] from the values of channels at a sample.
pub(crate) type Formula = Box<dyn Fn(&[f64]) -> f64 + Send + Sync>;

/// A node type whose one output is a mask by a formula, 0 where nothing is seen.
pub(crate) struct ViewMask {
    /// Its declaration; the port is `view`.
    pub(crate) declaration: &'static Declaration,
    /// The channels, in the order in which the formula takes them.
    pub(crate) channels: &'static [ViewChannel],
    /// The formula for some knobs.
    pub(crate) formula: fn(&Settled) -> Formula,
}

/// 0 up to `from`, 1 from `from + width` on, straight between; with width 0 a step that includes `from`.
pub(crate) fn ramp(x: f64, from: f64, width: f64) -> f64 {
    if width > 0.0 {
        ((x - from) / width).clamp(0.0, 1.0)
    } else if x >= from {
        1.0
    } else {
        0.0
    }
}

impl NodeType for ViewMask {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for ViewMask {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(self.channels).union(ViewChannel::Coverage.into())
    }

    fn interval(&self, _node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn formatted(&self) -> bool {
        false
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(Masking { node: node.clone(), channels: self.channels, formula: (self.formula)(node) }))
    }
}

struct Masking {
    node: Settled,
    channels: &'static [ViewChannel],
    formula: Formula,
}

impl Prepared for Masking {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        let planes: Vec<&[f32]> = self.channels.iter().map(|channel| inputs.view("view", *channel)).collect();
        let coverage = inputs.view("view", ViewChannel::Coverage);
        let mut values = vec![0.0; planes.len()];
        for (index, out) in mask.iter_mut().enumerate() {
            values.iter_mut().zip(&planes).for_each(|(value, plane)| *value = f64::from(plane[index]));
            *out = if coverage[index] > 0.0 { (self.formula)(&values) as f32 } else { 0.0 };
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(&self.node, inputs) {
            return Ok(super::nothing());
        }
        let view = self.node.source("view");
        let values: Vec<f64> = self.channels.iter().map(|channel| inputs.view(view, *channel)).collect();
        Ok(vec![Reference::Mask((self.formula)(&values))])
    }
}
