//! Passes that copy channels of a view unchanged.

use crate::sea::check_trails;
use trochoid_graph::*;

/// A node whose only output consists of channels of its view.
pub(crate) trait ChannelCopy: Declare {
    /// The channels, in the order of the output's components.
    const CHANNELS: &'static [Channel];

    /// Returns the view.
    fn view(&self) -> &One<port::View>;
}

/// Node that copies channels of a view.
#[derive(Clone)]
pub(crate) struct ViewCopy<T>(T);

impl<T: ChannelCopy> Items for ViewCopy<T> {
    const ITEMS: &'static [Item] = T::ITEMS;

    fn read(reader: &mut Reader<'_>) -> Self {
        Self(T::read(reader))
    }
}

impl<T: ChannelCopy> Declare for ViewCopy<T> {
    const DECLARATION: &'static Declaration = T::DECLARATION;
}

impl<T: ChannelCopy> Node for ViewCopy<T> {
    fn check(&self, check: &mut Check<'_>) {
        if T::CHANNELS.contains(&Channel::Rift) {
            check_trails(self.0.view(), check);
        }
    }
}

impl<T: ChannelCopy> Computes for ViewCopy<T> {
    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl<T: ChannelCopy> Stage for ViewCopy<T> {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(T::CHANNELS)
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(self.clone()))
    }
}

impl<T: ChannelCopy> Prepared for ViewCopy<T> {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        for (index, channel) in T::CHANNELS.iter().enumerate() {
            if let Some(plane) = outputs.only(index) {
                plane.copy_from_slice(inputs.view(self.0.view(), *channel));
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        for (index, channel) in T::CHANNELS.iter().enumerate() {
            if let Some(plane) = outputs.only(index) {
                plane.copy_from_slice(bounding.bounds.view(self.0.view(), *channel));
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let view = self.0.view();
        Ok(vec![Reference::Field(T::CHANNELS.iter().map(|channel| inputs.view(view, *channel)).collect())])
    }
}
