//! What is certain of a stage's inputs at a sample, and bounds by what follows for its outputs.

use trochoid_graph::{Bound, Bounding, Channel, Connected, Inputs, Outputs, REFERENCE, Span};

/// What a channel of the first connection of a port may be in the reference, by its bound; `None` where there is none.
pub(crate) fn known(bounding: &Bounding<'_>, port: &impl Connected, channel: usize, sample: usize) -> Option<Span> {
    let of = |inputs: &Inputs<'_>| Some(inputs.all(port).first()?.planes.get(channel).copied()??[sample]);
    let (value, bound) = (of(bounding.inputs)?, of(bounding.bounds)?);
    let Span { low, high, clear } = Span::around(f64::from(value), Bound::decode(bound));
    // ∞ − ∞ leaves everything open.
    let end = |end: f64, open: f64| if end.is_nan() && !value.is_nan() { open } else { end };
    Some(Span { low: end(low, f64::NEG_INFINITY), high: end(high, f64::INFINITY), clear })
}

/// What a channel of the view may be at a sample; its background where the view does not supply it.
pub(crate) fn certain(bounding: &Bounding<'_>, view: &impl Connected, channel: Channel, sample: usize) -> Span {
    known(bounding, view, channel as usize, sample).unwrap_or(Span::exactly(f64::from(channel.background())))
}

/// What a mask may be that is 0 where nothing is seen, and this elsewhere.
pub(crate) fn where_covered(
    bounding: &Bounding<'_>,
    view: &impl Connected,
    sample: usize,
    mask: impl FnOnce() -> Span,
) -> Span {
    let coverage = certain(bounding, view, Channel::Coverage, sample);
    if coverage.high <= 0.0 {
        Span::exactly(0.0)
    } else if coverage.low > 0.0 {
        mask()
    } else {
        mask().or(Span::exactly(0.0)).with(false)
    }
}

/// Bounds a channel of an output by what the reference may give at each sample.
pub(crate) fn bound_by(
    bounding: &Bounding<'_>,
    outputs: &mut Outputs<'_>,
    (output, channel): (impl Into<usize>, usize),
    mut may_give: impl FnMut(usize) -> Span,
) {
    let output = output.into();
    let (Some(filled), Some(bounds)) = (bounding.filled[output][channel], outputs.take(output, channel)) else {
        return;
    };
    for (sample, (bound, filled)) in bounds.iter_mut().zip(filled).enumerate() {
        *bound = may_give(sample).bound(f64::from(*filled)).encode();
    }
}

/// Bounds a channel that depends on nothing but the sample's place, where the reference gives `truth`.
pub(crate) fn bound_at(
    bounding: &Bounding<'_>,
    outputs: &mut Outputs<'_>,
    (output, channel): (impl Into<usize>, usize),
    mut truth: impl FnMut([f64; 2]) -> f64,
) {
    let output = output.into();
    let (Some(filled), Some(bounds)) = (bounding.filled[output][channel], outputs.take(output, channel)) else {
        return;
    };
    for ((bound, filled), at) in bounds.iter_mut().zip(filled).zip(bounding.block.places()) {
        let (filled, truth) = (f64::from(*filled), truth(at));
        let size = if filled == truth { 0.0 } else { (filled - truth).abs() + truth.abs() * REFERENCE };
        *bound = Bound::of(size).encode();
    }
}

/// Bounds every output of a stage that hands on what its reference does, bit for bit.
#[cfg(feature = "io")]
pub(crate) fn bound_exact(bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) {
    for (output, channels) in bounding.filled.iter().enumerate() {
        for channel in 0..channels.len() {
            if let Some(bounds) = outputs.take(output, channel) {
                bounds.fill(Bound::EXACT.encode());
            }
        }
    }
}
