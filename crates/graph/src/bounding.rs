//! What is certain of a stage's inputs at a sample, and bounds by what follows for its outputs.

use crate::{Block, Bound, Channel, Connected, Inputs, LITERAL, Outputs, REFERENCE, Span};

/// Arguments of [`Prepared::bound`](crate::Prepared::bound): a stage bounds the errors of the planes that it filled.
pub struct Bounding<'a> {
    /// The samples.
    pub block: &'a Block<'a>,
    /// Inputs from which the planes were filled.
    pub inputs: &'a Inputs<'a>,
    /// Bounds of every plane of the inputs ([`Bound`], encoded).
    pub bounds: &'a Inputs<'a>,
    /// Planes that the stage filled, by output and channel; `None` for unwanted channels.
    pub filled: &'a [Vec<Option<&'a [f32]>>],
}

/// What is certain of a channel of an input, by sample.
#[derive(Clone, Copy, Debug)]
pub struct Spans<'a> {
    /// Values, and encoded bounds; `None` if all are the background.
    planes: Option<(&'a [f32], &'a [f32])>,
    background: f32,
}

impl Spans<'_> {
    /// Returns the span of the reference at a sample.
    #[inline]
    pub fn at(&self, sample: usize) -> Span {
        let Some((values, bounds)) = self.planes else { return Span::exactly(f64::from(self.background)) };
        let value = values[sample];
        let Span { low, high, clear } = Span::around(f64::from(value), Bound::decode(bounds[sample]));
        // ∞ − ∞ leaves everything open.
        let end = |end: f64, open: f64| if end.is_nan() && !value.is_nan() { open } else { end };
        Span { low: end(low, f64::NEG_INFINITY), high: end(high, f64::INFINITY), clear }
    }

    /// Returns the span of a mask that is 0 where no surface is seen, and `mask` elsewhere. These are the spans of the
    /// view's coverage.
    #[inline]
    pub fn covered(&self, sample: usize, mask: impl FnOnce() -> Span) -> Span {
        let coverage = self.at(sample);
        if coverage.high <= 0.0 {
            Span::exactly(0.0)
        } else if coverage.low > 0.0 {
            mask()
        } else {
            mask().or(Span::exactly(0.0)).with(false)
        }
    }
}

/// Returns a plane of a port's first connection.
fn plane<'a>(inputs: &Inputs<'a>, port: &impl Connected, channel: usize) -> Option<&'a [f32]> {
    inputs.all(port).first()?.planes.get(channel).copied()?
}

impl<'a> Bounding<'a> {
    /// Bounds a stage without inputs that computes in f64 like its reference, and rounds once.
    pub fn rounded_once(&self, outputs: &mut Outputs<'_>) {
        for (output, channels) in self.filled.iter().enumerate() {
            for (channel, filled) in channels.iter().enumerate() {
                let (Some(filled), Some(bounds)) = (filled, outputs.take(output, channel)) else { continue };
                for (bound, value) in bounds.iter_mut().zip(*filled) {
                    *bound = Bound::of(f64::from(value.abs()) * LITERAL + f64::from(f32::from_bits(1))).encode();
                }
            }
        }
    }

    /// Returns the span of a channel of a port's first connection in the reference; `None` if there is no connection.
    pub fn known(&self, port: &impl Connected, channel: usize, sample: usize) -> Option<Span> {
        self.spans(port, channel).map(|spans| spans.at(sample))
    }

    /// Returns the spans of a channel of a port's first connection in the reference; `None` if there is no connection.
    fn spans(&self, port: &impl Connected, channel: usize) -> Option<Spans<'a>> {
        let planes = (plane(self.inputs, port, channel)?, plane(self.bounds, port, channel)?);
        Some(Spans { planes: Some(planes), background: 0.0 })
    }

    /// Returns the spans of a channel of the view; its background if the view does not supply it.
    pub fn channel(&self, view: &impl Connected, channel: Channel) -> Spans<'a> {
        let background = Spans { planes: None, background: channel.background() };
        self.spans(view, channel as usize).unwrap_or(background)
    }

    /// Returns the span of a channel of the view at a sample; its background if the view does not supply it.
    pub fn certain(&self, view: &impl Connected, channel: Channel, sample: usize) -> Span {
        self.channel(view, channel).at(sample)
    }

    /// Returns the span of a mask that is 0 where no surface is seen, and `mask` elsewhere.
    pub fn where_covered(&self, view: &impl Connected, sample: usize, mask: impl FnOnce() -> Span) -> Span {
        self.channel(view, Channel::Coverage).covered(sample, mask)
    }

    /// Bounds a channel of an output by the span of the reference at each sample.
    pub fn bound_by(
        &self,
        outputs: &mut Outputs<'_>,
        output: impl Into<usize>,
        channel: usize,
        mut may_give: impl FnMut(usize) -> Span,
    ) {
        let output = output.into();
        let (Some(filled), Some(bounds)) = (self.filled[output][channel], outputs.take(output, channel)) else {
            return;
        };
        for (sample, (bound, filled)) in bounds.iter_mut().zip(filled).enumerate() {
            *bound = may_give(sample).bound(f64::from(*filled)).encode();
        }
    }

    /// Bounds a channel that depends only on the sample's position. `truth` is the reference there.
    pub fn bound_at(
        &self,
        outputs: &mut Outputs<'_>,
        output: impl Into<usize>,
        channel: usize,
        mut truth: impl FnMut([f64; 2]) -> f64,
    ) {
        let output = output.into();
        let (Some(filled), Some(bounds)) = (self.filled[output][channel], outputs.take(output, channel)) else {
            return;
        };
        for ((bound, filled), at) in bounds.iter_mut().zip(filled).zip(self.block.places()) {
            let (filled, truth) = (f64::from(*filled), truth(at));
            let size = if filled == truth { 0.0 } else { (filled - truth).abs() + truth.abs() * REFERENCE };
            *bound = Bound::of(size).encode();
        }
    }

    /// Bounds every output of a stage that equals its reference bit for bit.
    pub fn exact(&self, outputs: &mut Outputs<'_>) {
        for (output, channels) in self.filled.iter().enumerate() {
            for channel in 0..channels.len() {
                if let Some(bounds) = outputs.take(output, channel) {
                    bounds.fill(Bound::EXACT.encode());
                }
            }
        }
    }
}
