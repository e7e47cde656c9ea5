//! Operations over the weights of partitions, chunk by chunk.

use crate::audit::WeightAudit;
use crate::code::CHUNK;
use trochoid_weights::arithmetic as a;

/// One channel of one color, as a Blend reads it.
#[derive(Clone, Copy)]
pub(crate) enum ChannelOperand<'a> {
    Row(&'a [f32; CHUNK]),
    Constant(f32),
}

/// Computes Σ wᵢ·cᵢ of one channel, in f64, rounded once.
#[inline(always)]
pub(crate) fn blend<'a>(to: &mut [f32; CHUNK], terms: impl Iterator<Item = (&'a [f32; CHUNK], ChannelOperand<'a>)>) {
    let mut sums = [0.0f64; CHUNK];
    for (weights, channel) in terms {
        match channel {
            ChannelOperand::Row(row) => {
                for ((sum, weight), value) in sums.iter_mut().zip(weights).zip(row) {
                    *sum = a::accumulate(*sum, *weight, *value);
                }
            }
            ChannelOperand::Constant(value) => {
                for (sum, weight) in sums.iter_mut().zip(weights) {
                    *sum = a::accumulate(*sum, *weight, value);
                }
            }
        }
    }
    for (to, sum) in to.iter_mut().zip(sums) {
        *to = sum as f32;
    }
}

/// Returns the smallest weight, and the largest deviation of the sum of weights from 1.
#[inline(always)]
pub(crate) fn audit<'a>(weights: impl Iterator<Item = &'a [f32; CHUNK]>) -> WeightAudit {
    let mut sums = [0.0f64; CHUNK];
    let mut min = [f32::INFINITY; CHUNK];
    for row in weights {
        for ((sum, min), weight) in sums.iter_mut().zip(&mut min).zip(row) {
            *sum += f64::from(*weight);
            *min = if *weight < *min { *weight } else { *min };
        }
    }
    let mut deviation = 0.0f64;
    for sum in sums {
        // NaN must count; a maximum would drop it.
        let off = (sum - 1.0).abs();
        deviation = if off <= deviation { deviation } else { off };
    }
    WeightAudit { min: min.into_iter().fold(f32::INFINITY, f32::min), max_deviation: deviation }
}
