//! Values of the reference: the slow evaluation in f64, one sample at a time.

use crate::{Channel, FrameContext, Handle, Source};

/// A value of the f64 reference at one sample.
#[derive(Clone)]
pub enum Reference {
    /// Color.
    Color([f64; 3]),
    /// Mask: the number t.
    Mask(f64),
    /// Weights of n ≠ 2 controls.
    Weights(Vec<f64>),
    /// Field.
    Field(Vec<f64>),
    /// View: one value per channel.
    View(Vec<f64>),
    /// Surface, camera or light.
    Handle(Handle),
}

/// Inputs of a reference evaluation at one sample.
#[derive(Clone, Copy)]
pub struct References<'a> {
    /// Data that all nodes of the frame share.
    pub frame: &'a FrameContext,
    /// Position of the sample in the picture, in pixels.
    pub at: [f64; 2],
    /// Position of the pixel's first sample if the document shades per pixel; otherwise equal to `at`.
    first: [f64; 2],
    inputs: &'a Upstream<'a>,
}

/// Returns the value of a connection at a position in the picture.
type Upstream<'a> = dyn Fn(&Source<Vec<f64>>, [f64; 2]) -> Reference + 'a;

impl<'a> References<'a> {
    /// Makes the inputs of the sample at `at`; called by the engine. `inputs` returns the value of everything
    /// connected to the node at any position; outside of the extent of an image, the value in the nearest pixel
    /// inside, at the same offset.
    pub fn new(frame: &'a FrameContext, at: [f64; 2], inputs: &'a Upstream<'a>) -> Self {
        Self { frame, at, first: at, inputs }
    }

    /// Sets the position of the pixel's first sample.
    #[must_use]
    pub fn with_first(self, first: [f64; 2]) -> Self {
        Self { first, ..self }
    }

    /// Returns the inputs at the pixel's first sample if the document shades per pixel, otherwise the same inputs. A
    /// stage evaluates shared results ([`Prepared::find`](crate::Prepared::find)) there.
    pub fn first(&self) -> Self {
        Self { at: self.first, ..*self }
    }

    /// Returns the inputs of the sample that is (dx, dy) pixels away, from which a filter reads.
    pub fn moved(&self, dx: f64, dy: f64) -> Self {
        let moved = |at: [f64; 2]| [at[0] + dx, at[1] + dy];
        Self { at: moved(self.at), first: moved(self.first), ..*self }
    }

    /// Returns a connected or literal value of any kind; a literal number counts as a mask.
    pub fn value(&self, source: &Source<Vec<f64>>) -> Reference {
        match source {
            Source::Output { .. } => (self.inputs)(source, self.at),
            Source::Number(values) => Reference::Mask(values[0]),
            Source::Color(values) => Reference::Color([values[0], values[1], values[2]]),
            Source::Numbers(numbers) => Reference::Weights(numbers.clone()),
        }
    }

    /// Returns a connected or literal color.
    pub fn color(&self, source: &Source<Vec<f64>>) -> [f64; 3] {
        match self.value(source) {
            Reference::Color(color) => color,
            _ => unreachable!("checked to be a Color"),
        }
    }

    /// Returns a connected or literal mask, or a field of one component.
    pub fn scalar(&self, source: &Source<Vec<f64>>) -> f64 {
        match self.value(source) {
            Reference::Mask(t) => t,
            Reference::Field(components) => components[0],
            _ => unreachable!("checked to be one number"),
        }
    }

    /// Returns connected or literal weights, one per control.
    pub fn weights(&self, source: &Source<Vec<f64>>) -> Vec<f64> {
        match self.value(source) {
            Reference::Mask(t) => vec![1.0 - t, t],
            Reference::Weights(weights) => weights,
            _ => unreachable!("checked to be Weights"),
        }
    }

    /// Returns a channel of a connected view.
    pub fn view(&self, source: &Source<Vec<f64>>, channel: Channel) -> f64 {
        match self.value(source) {
            Reference::View(channels) => channels[channel as usize],
            _ => unreachable!("checked to be a View"),
        }
    }
}
