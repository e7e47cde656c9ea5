//! Values of the slow f64 evaluation, one sample at a time.

use crate::{Channel, FrameContext, Handle, Source};

/// A value of the f64 reference at one sample.
#[derive(Clone)]
pub enum Reference {
    /// Color.
    Color([f64; 3]),
    /// Mask: t.
    Mask(f64),
    /// Weights of n ≠ 2 controls.
    Weights(Vec<f64>),
    /// Field.
    Field(Vec<f64>),
    /// View: a value per channel.
    View(Vec<f64>),
    /// Surface, camera or light.
    Handle(Handle),
}

/// What a reference evaluation is given at one sample.
#[derive(Clone, Copy)]
pub struct References<'a> {
    /// The frame.
    pub frame: &'a FrameContext,
    /// The sample's place in the picture, in pixels.
    pub at: [f64; 2],
    /// That of the pixel's first sample, where the document shades by the pixel; else its own.
    first: [f64; 2],
    inputs: &'a Upstream<'a>,
}

/// Gives the value of a connection at a place in the picture.
type Upstream<'a> = dyn Fn(&Source<Vec<f64>>, [f64; 2]) -> Reference + 'a;

impl<'a> References<'a> {
    /// Made by the engine. `inputs` gives the values of everything that the node is connected to, at any place; beyond
    /// the extent of an image that of the nearest pixel within, at the same place in its pixel.
    pub fn new(frame: &'a FrameContext, at: [f64; 2], inputs: &'a Upstream<'a>) -> Self {
        Self { frame, at, first: at, inputs }
    }

    /// The same of a pixel whose first sample stands there.
    #[must_use]
    pub fn with_first(self, first: [f64; 2]) -> Self {
        Self { first, ..self }
    }

    /// What the pixel's first sample is given, where the document shades by the pixel; else the same: what a stage finds
    /// once for all samples, it finds there.
    pub fn first(&self) -> Self {
        Self { at: self.first, ..*self }
    }

    /// The same as the sample so many pixels away sees it: what a filter takes its inputs from.
    pub fn moved(&self, dx: f64, dy: f64) -> Self {
        let moved = |at: [f64; 2]| [at[0] + dx, at[1] + dy];
        Self { at: moved(self.at), first: moved(self.first), ..*self }
    }

    /// A connected or literal value, whatever its kind; a literal number counts as a mask.
    pub fn value(&self, source: &Source<Vec<f64>>) -> Reference {
        match source {
            Source::Output { .. } => (self.inputs)(source, self.at),
            Source::Number(values) => Reference::Mask(values[0]),
            Source::Color(values) => Reference::Color([values[0], values[1], values[2]]),
            Source::Numbers(numbers) => Reference::Weights(numbers.clone()),
        }
    }

    /// A connected or literal color.
    pub fn color(&self, source: &Source<Vec<f64>>) -> [f64; 3] {
        match self.value(source) {
            Reference::Color(color) => color,
            _ => unreachable!("checked to be a Color"),
        }
    }

    /// A connected or literal mask, or a field of one component.
    pub fn scalar(&self, source: &Source<Vec<f64>>) -> f64 {
        match self.value(source) {
            Reference::Mask(t) => t,
            Reference::Field(components) => components[0],
            _ => unreachable!("checked to be one number"),
        }
    }

    /// Connected or literal weights, one number a control.
    pub fn weights(&self, source: &Source<Vec<f64>>) -> Vec<f64> {
        match self.value(source) {
            Reference::Mask(t) => vec![1.0 - t, t],
            Reference::Weights(weights) => weights,
            _ => unreachable!("checked to be Weights"),
        }
    }

    /// A channel of a connected view.
    pub fn view(&self, source: &Source<Vec<f64>>, channel: Channel) -> f64 {
        match self.value(source) {
            Reference::View(channels) => channels[channel as usize],
            _ => unreachable!("checked to be a View"),
        }
    }
}
