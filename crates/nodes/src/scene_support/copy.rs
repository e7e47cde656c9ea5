//! Passes that hand on channels of a view as they are.

use super::check_trails;
use trochoid_graph::*;

/// A node type whose one output is some channels of its view.
pub(crate) struct ViewCopy {
    /// Its declaration; the port is `view`.
    pub(crate) declaration: &'static Declaration,
    /// The channels, in the order of the output's components.
    pub(crate) channels: &'static [Channel],
}

impl NodeType for ViewCopy {
    fn declaration(&self) -> &'static Declaration {
        self.declaration
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if self.channels.contains(&Channel::Rift) {
            check_trails(node, check);
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for ViewCopy {
    fn asks(&self, _node: &Settled, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(self.channels)
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(Copying { node: node.clone(), channels: self.channels }))
    }
}

struct Copying {
    node: Settled,
    channels: &'static [Channel],
}

impl Prepared for Copying {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for (index, channel) in self.channels.iter().enumerate() {
            if let Some(plane) = outputs.take(0, index) {
                plane.copy_from_slice(inputs.view("view", *channel));
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        for (index, channel) in self.channels.iter().enumerate() {
            if let Some(plane) = outputs.take(0, index) {
                plane.copy_from_slice(bounding.bounds.view("view", *channel));
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let view = self.node.source("view");
        Ok(vec![Reference::Field(self.channels.iter().map(|channel| inputs.view(view, *channel)).collect())])
    }
}
