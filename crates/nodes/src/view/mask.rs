//! Masks computed from channels of a view, each sample by itself.

use super::{is_covered, nothing};
use trochoid_graph::*;
use trochoid_memory::Scratch;

/// A node whose only output is a product of ramps over channels of its view, and 0 where nothing is seen.
pub(crate) trait ChannelMask: Declare {
    /// Returns the view.
    fn view(&self) -> &One<port::View>;

    /// Returns the ramps, each with its channel.
    fn ramps(&self) -> Vec<(Channel, Ramp)>;
}

/// Node with such a mask.
#[derive(Clone)]
pub(crate) struct ViewMask<T>(T);

impl<T: ChannelMask> Items for ViewMask<T> {
    const ITEMS: &'static [Item] = T::ITEMS;

    fn read(reader: &mut Reader<'_>) -> Self {
        Self(T::read(reader))
    }
}

impl<T: ChannelMask> Declare for ViewMask<T> {
    const DECLARATION: &'static Declaration = T::DECLARATION;
}

/// A ramp from 0 to 1 over the values of a channel.
#[derive(Clone, Copy)]
pub(crate) enum Ramp {
    /// 0 up to `from`, 1 from `from + width` on; with width 0, a step that includes `from`.
    Rising { from: f64, width: f64 },
    /// 0 from `from` on, 1 down from `from − width`; with width 0, a step that excludes `from`.
    Falling { from: f64, width: f64 },
}

impl Ramp {
    fn at(self, x: f64) -> f64 {
        match self {
            Self::Rising { from, width } => ramp(x, from, width),
            Self::Falling { from, width } if x < from => ramp(from - x, 0.0, width),
            Self::Falling { .. } => 0.0,
        }
    }

    /// Returns the span of the ramp over a span of the channel.
    fn span(self, channel: Span) -> Span {
        let (Self::Rising { width, .. } | Self::Falling { width, .. }) = self;
        let mask = channel.through(|x| self.at(x)).within(0.0, 1.0);
        let [low, high] = [channel.low, channel.high].map(|x| self.at(x));
        // If the ramp is constant on both sides, uncertainty of the channel does not matter.
        if low == high && (low == 0.0 || low == 1.0) { Span::exactly(low) } else { mask.with(width > 0.0) }
    }
}

/// Returns 0 up to `from`, 1 from `from + width` on, linear between; with width 0, a step that includes `from`.
#[inline(always)]
pub(crate) fn ramp(x: f64, from: f64, width: f64) -> f64 {
    if width > 0.0 {
        ((x - from) / width).clamp(0.0, 1.0)
    } else if x >= from {
        1.0
    } else {
        0.0
    }
}

impl<T: ChannelMask> Node for ViewMask<T> {}

impl<T: ChannelMask> Computes for ViewMask<T> {
    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl<T: ChannelMask> Stage for ViewMask<T> {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        let ramps = self.0.ramps();
        ramps.iter().map(|(channel, _)| *channel).chain([Channel::Coverage]).collect()
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedViewMask { view: self.0.view().clone(), ramps: self.0.ramps() }))
    }
}

struct PreparedViewMask {
    view: One<port::View>,
    ramps: Vec<(Channel, Ramp)>,
}

impl PreparedViewMask {
    fn mask(&self, values: &[f64]) -> f64 {
        self.ramps.iter().zip(values).map(|((_, ramp), value)| ramp.at(*value)).product()
    }
}

impl Prepared for PreparedViewMask {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let planes: Scratch<&[f32]> = self.ramps.iter().map(|(channel, _)| inputs.view(&self.view, *channel)).collect();
        let coverage = inputs.view(&self.view, Channel::Coverage);
        let mut values = Scratch::of(0.0, planes.len());
        for (index, out) in mask.iter_mut().enumerate() {
            values.iter_mut().zip(&planes).for_each(|(value, plane)| *value = f64::from(plane[index]));
            *out = if coverage[index] > 0.0 { self.mask(&values) as f32 } else { 0.0 };
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            bounding
                .where_covered(&self.view, sample, || {
                    let ramps = self.ramps.iter();
                    let ramps: Vec<Span> = ramps
                        .map(|(channel, ramp)| ramp.span(bounding.certain(&self.view, *channel, sample)))
                        .collect();
                    // A ramp that is 0 for certain hides what is not clear of the others.
                    if ramps.iter().any(|ramp| ramp.is_exact() && ramp.low == 0.0) {
                        return Span::exactly(0.0);
                    }
                    let ends = [|ramp: &Span| ramp.low, |ramp: &Span| ramp.high];
                    Span::of(&ends.map(|end| ramps.iter().map(end).product())).with(ramps.iter().all(|ramp| ramp.clear))
                })
                .within(0.0, 1.0)
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(inputs, &self.view) {
            return Ok(nothing());
        }
        let values: Vec<f64> = self.ramps.iter().map(|(channel, _)| inputs.view(&self.view, *channel)).collect();
        Ok(vec![Reference::Mask(self.mask(&values))])
    }
}
