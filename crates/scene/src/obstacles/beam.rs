//! The beam of a packet: what all of its rays pass through, compared with the boxes of a node at once.

use super::packet::{EARLY, Packet};
use super::tree::{CHILDREN, Node};
use fearless_simd::{Simd, f32x8, prelude::*};

/// Factor by which ends of rays are moved away for rounding.
const LONGER: f32 = 1.0 + 1e-5;

/// Bounds of the rays of a packet. No ray enters a box that its beam does not enter, or before it.
///
/// *Proof.* A ray enters a box at the greatest of 0 and its three products (plane − origin)·inverse with the planes toward
/// its origin, and leaves it at the least of those with the others. Along an axis on which all directions have the same
/// sign, differences are monotone in the origin, and products in the inverse, rounded or not: so the products at the ends
/// of the intervals of origins and inverses bound those of all rays. Along another axis, a ray that enters a box
/// within its limit passes through it between its origin and its end; the interval contains both. ∎
pub(super) struct Beam {
    axes: [Axis; 3],
}

/// Bounds along one axis.
#[derive(Clone, Copy)]
enum Axis {
    /// Least and greatest origin and inverse direction, whose sign is that of `forward`.
    Together { origin: [f32; 2], inverse: [f32; 2], forward: bool },
    /// Interval in which the rays run.
    Apart { low: f32, high: f32 },
}

impl Axis {
    const EMPTY: Self = Self::Apart { low: f32::INFINITY, high: f32::NEG_INFINITY };
}

impl Beam {
    /// Returns the beam of a packet with so many rays.
    // Plain loops here and elsewhere: closures that are not inlined lack the instructions that `simd` enables.
    #[inline(always)]
    pub(super) fn new(packet: &Packet, rays: usize) -> Self {
        let mut axes = [Axis::EMPTY; 3];
        for (axis, bounds) in axes.iter_mut().enumerate() {
            let (origins, inverses) = (&packet.origin[axis], &packet.inverse[axis]);
            let (mut origin, mut inverse) = (NOTHING, NOTHING);
            for ray in 0..rays {
                origin = with(origin, origins[ray]);
                inverse = with(inverse, inverses[ray]);
            }
            *bounds = if inverse[0] > 0.0 || inverse[1] < 0.0 {
                Axis::Together { origin, inverse, forward: inverse[0] > 0.0 }
            } else {
                let mut span = origin;
                for ray in 0..rays {
                    // Longer than computed, and rounded outward.
                    span = with(span, origins[ray] + packet.nearest[ray] / inverses[ray] * LONGER);
                }
                Axis::Apart { low: span[0].next_down(), high: span[1].next_up() }
            };
        }
        Self { axes }
    }

    /// Returns the boxes of a node that the beam enters before a distance, as bits, and where it enters each.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, node: &Node, most: f32) -> (u32, [f32; CHILDREN]) {
        let mut near = f32x8::splat(simd, 0.0);
        let mut far = f32x8::splat(simd, f32::INFINITY);
        let mut beside = near.simd_lt(0.0);
        for (axis, bounds) in self.axes.iter().enumerate() {
            let (low, high) = (f32x8::from_slice(simd, &node.low[axis]), f32x8::from_slice(simd, &node.high[axis]));
            match *bounds {
                Axis::Together { origin, inverse, forward } => {
                    let (low, high) = (low - origin[1], high - origin[0]);
                    let (enter, leave) = if forward { (low, high) } else { (high, low) };
                    near = near.max((enter * inverse[0]).min(enter * inverse[1]));
                    far = far.min((leave * inverse[0]).max(leave * inverse[1]));
                }
                Axis::Apart { low: from, high: to } => {
                    beside |= low.simd_gt(to) | high.simd_lt(from);
                }
            }
        }
        let entry = near * EARLY;
        let entered = entry.simd_le(far) & entry.simd_le(most) & !beside;
        (entered.to_bitmask() as u32, entry.to_array())
    }
}

/// Least and greatest of no values.
const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// Returns the least and the greatest of some values and another one.
#[inline(always)]
fn with([low, high]: [f32; 2], value: f32) -> [f32; 2] {
    [if value < low { value } else { low }, if value > high { value } else { high }]
}
