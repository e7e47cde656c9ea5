//! What is certain of a stage's inputs at a sample, and bounds by what follows for its outputs.

use super::Span;
use trochoid_graph::{Bound, Bounding, Inputs, Outputs};

/// What a channel of the first connection of a port may be in the reference, by its bound; `None` where there is none.
pub(crate) fn known(bounding: &Bounding<'_>, port: &str, channel: usize, sample: usize) -> Option<Span> {
    let of = |inputs: &Inputs<'_>| Some(inputs.all(port).first()?.planes.get(channel).copied()??[sample]);
    let (value, bound) = (of(bounding.inputs)?, of(bounding.bounds)?);
    let Span { low, high, clear } = Span::around(f64::from(value), Bound::decode(bound));
    // ∞ − ∞ leaves everything open.
    let end = |end: f64, open: f64| if end.is_nan() && !value.is_nan() { open } else { end };
    Some(Span { low: end(low, f64::NEG_INFINITY), high: end(high, f64::INFINITY), clear })
}

/// Bounds a channel of an output by what the reference may give at each sample.
pub(crate) fn bound_by(
    bounding: &Bounding<'_>,
    outputs: &mut Outputs<'_>,
    (output, channel): (usize, usize),
    mut may_give: impl FnMut(usize) -> Span,
) {
    let (Some(filled), Some(bounds)) = (bounding.filled[output][channel], outputs.take(output, channel)) else { return };
    for (sample, (bound, filled)) in bounds.iter_mut().zip(filled).enumerate() {
        *bound = may_give(sample).bound(f64::from(*filled)).encode();
    }
}

/// Bounds the only mask of a stage that depends on nothing but the sample's place: it gives `reference` there.
pub(crate) fn bound_mask(
    bounding: &Bounding<'_>,
    outputs: &mut Outputs<'_>,
    mut reference: impl FnMut([f64; 2]) -> f64,
) {
    let mut places = bounding.block.places();
    bound_by(bounding, outputs, (0, 0), |_| places.next().map_or(Span::unclear(0.0, 1.0), |at| Span::of(&[reference(at)])));
}
