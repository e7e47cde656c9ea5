//! Finds illegal samples of inputs, or makes them legal.

use crate::running::buffer_fault::rule;
use std::borrow::Cow;
use trochoid_graph::Kind;
use trochoid_weights::sums;

/// Moves every sample to the nearest one that a kind allows; NaN to 0.
#[expect(clippy::manual_clamp, reason = "`max` returns the 0 where `clamp` returns NaN")]
pub(super) fn clamp(kind: Kind, samples: &mut [f32]) {
    match kind {
        Kind::Color => samples.iter_mut().for_each(|sample| *sample = sample.max(0.0).min(f32::MAX)),
        Kind::Weights(_) => samples.iter_mut().for_each(|sample| *sample = sample.max(0.0).min(1.0)),
        _ => samples.iter_mut().for_each(|sample| *sample = if sample.is_nan() { 0.0 } else { *sample }),
    }
}

/// Divides clamped weights by their sum, however far it is from 1.
pub(super) fn divide(kind: Kind, channels: &mut [Cow<'_, [f32]>]) {
    if !matches!(kind, Kind::Weights(n) if n > 2) {
        return;
    }
    let rows: Vec<&[f32]> = channels.iter().map(|channel| &**channel).collect();
    let (sums, count) = (sums::sums(&rows), rows.len());
    for channel in channels {
        for (weight, sum) in channel.to_mut().iter_mut().zip(&sums) {
            *weight = sums::part(*weight, *sum, count) as f32;
        }
    }
}

/// Returns the first sample that a kind does not allow.
pub(super) fn first_illegal(kind: Kind, samples: &[f32]) -> Option<usize> {
    let (legal, _) = rule(kind);
    samples.iter().position(|sample| !legal(sample))
}
