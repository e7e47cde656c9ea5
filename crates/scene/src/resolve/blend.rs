//! Blends values of vertices.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use super::block::Block;
use super::{BLOCK, Lanes};
use crate::{Channel, ChannelSet, Targets};

/// Points at which the vertices' attributes are interpolated: the same number of vertices for each hit.
pub(super) struct Blend<'a, const CORNERS: usize> {
    pub(super) vertices: &'a [[u32; BLOCK]; CORNERS],
    pub(super) weights: &'a [Lanes; CORNERS],
}

/// Gathers values of the vertices of some hits, by corner and component.
#[inline(always)]
pub(super) fn gather<const N: usize, const CORNERS: usize>(
    vertices: &[[u32; BLOCK]; CORNERS],
    count: usize,
    values: &[[f32; N]],
    gathered: &mut [[Lanes; N]; CORNERS],
) {
    let mut single = [[[0.0; BLOCK]; N]; CORNERS];
    for lane in 0..count {
        for corner in 0..CORNERS {
            let value = values[vertices[corner][lane] as usize];
            for component in 0..N {
                single[corner][component][lane] = value[component];
            }
        }
    }
    for corner in 0..CORNERS {
        for component in 0..N {
            for lane in 0..BLOCK {
                gathered[corner][component][lane] = f64::from(single[corner][component][lane]);
            }
        }
    }
}

impl<const CORNERS: usize> Blend<'_, CORNERS> {
    /// Computes Σ wᵢvᵢ over the corners, by component.
    #[inline(always)]
    pub(super) fn mean<const N: usize>(&self, values: &[[Lanes; N]; CORNERS], mean: &mut [Lanes; N]) {
        for component in 0..N {
            for lane in 0..BLOCK {
                let mut sum = values[0][component][lane] * self.weights[0][lane];
                for corner in 1..CORNERS {
                    sum += values[corner][component][lane] * self.weights[corner][lane];
                }
                mean[component][lane] = sum;
            }
        }
    }

    #[inline(always)]
    pub(super) fn of<const N: usize>(&self, block: &Block<'_>, values: &[[f32; N]]) -> [Lanes; N] {
        let (mut gathered, mut mean) = ([[[0.0; BLOCK]; N]; CORNERS], [[0.0; BLOCK]; N]);
        gather(self.vertices, block.hits.count, values, &mut gathered);
        self.mean(&gathered, &mut mean);
        mean
    }

    /// Writes an attribute if it was requested; the background if there is none.
    #[inline(always)]
    pub(super) fn put(
        &self,
        block: &Block<'_>,
        channel: Channel,
        values: &[f32],
        wanted: ChannelSet,
        out: &mut Targets<'_>,
    ) {
        if !wanted.contains(channel) {
            return;
        }
        if values.is_empty() {
            block.put_all(channel, channel.background(), out);
        } else {
            let [value] = self.of(block, values.as_chunks::<1>().0);
            block.put(channel, &value, out);
        }
    }
}

impl Blend<'_, 4> {
    /// Returns the derivatives by u and v of what is blended over cells, by component.
    #[inline(always)]
    pub(super) fn slopes<const N: usize>(
        &self,
        block: &Block<'_>,
        values: &[[f32; N]],
        u: &Lanes,
        v: &Lanes,
    ) -> [[Lanes; 2]; N] {
        let mut gathered = [[[0.0; BLOCK]; N]; 4];
        gather(self.vertices, block.hits.count, values, &mut gathered);
        let mut slopes = [[[0.0; BLOCK]; 2]; N];
        for component in 0..N {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| &gathered[corner][component]);
            for lane in 0..BLOCK {
                let (u, v) = (u[lane], v[lane]);
                slopes[component][0][lane] = (b[lane] - a[lane]) * (1.0 - v) + (d[lane] - c[lane]) * v;
                slopes[component][1][lane] = (c[lane] - a[lane]) * (1.0 - u) + (d[lane] - b[lane]) * u;
            }
        }
        slopes
    }
}
