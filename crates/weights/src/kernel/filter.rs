//! Separable filtering.

use super::Kernel;
use super::means::{Half, TOGETHER};
use super::runs::{Across, Down, LANES, transposed};
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Fewest and most rows in one task for a thread, down. Each task reads all rows under its kernel.
const BATCH: [usize; 2] = [64, 256];

/// Filters the part `from` of an image and writes the part `to` of the result. Beyond the edge of `from`, the nearest
/// pixel repeats; `extent` is the window of the whole image.
///
/// Sums are in f64, in the order of the kernel, and each result is rounded to f32 once across and once down. The bits
/// therefore do not depend on where a tile begins, and no result lies outside the values under the kernel
/// ([`arithmetic::blend`](crate::arithmetic::blend)). When `stop` returns true, filtering ends early and the contents of `out`
/// are unspecified.
pub fn filter(
    kernels: [&Kernel; 2],
    from: Window,
    samples: &[f32],
    extent: Window,
    to: Window,
    stop: &(dyn Fn() -> bool + Sync),
    out: &mut [f32],
) {
    let (stride, width) = (from.width(), to.width());
    if width == 0 || stride == 0 {
        return;
    }
    let level = Level::new();
    let across = Half::new(&kernels[0].folded(extent.width()));
    let first = to.x0 - across.radius() as i64 - from.x0;
    let length = width.next_multiple_of(TOGETHER) + 2 * across.radius();
    let mut rows = Scratch::of(0.0, width * from.height());
    let batches = rows.par_chunks_mut(width * LANES).zip(samples.par_chunks(stride * LANES));
    batches.for_each_init(Across::default, |lanes, (rows, samples)| {
        if stop() {
            return;
        }
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            let known = lanes.gather(simd, samples, stride, first, length);
            for x in (0..width).step_by(TOGETHER) {
                let means = across.means(simd, &lanes.run, &known, x + across.radius());
                put(&transposed(simd, &means), rows, width, x);
            }
        }));
    });
    let down = Half::new(&kernels[1].folded(extent.height()));
    let batch = (2 * down.radius()).clamp(BATCH[0], BATCH[1]).next_multiple_of(TOGETHER);
    out.par_chunks_mut(width * batch).enumerate().for_each_init(Down::default, |lanes, (index, out)| {
        let top = to.y0 + (index * batch) as i64 - down.radius() as i64 - from.y0;
        let height = (out.len() / width).next_multiple_of(TOGETHER);
        let under = top..top + (height + 2 * down.radius()) as i64;
        let wide = Down::width(&under);
        dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
            for start in (0..width).step_by(wide) {
                if stop() {
                    return;
                }
                lanes.gather(&rows, width, start..width.min(start + wide), under.clone());
                for (y, out) in (0..).step_by(TOGETHER).zip(out.chunks_mut(width * TOGETHER)) {
                    for ((run, known), x) in lanes.blocks().zip((start..).step_by(LANES)) {
                        put(&down.means(simd, run, known, y + down.radius()), out, width, x);
                    }
                }
            }
        }));
    });
}

/// Writes columns of rows, which are `width` long, from column `x` on, as far as there are any.
#[inline(always)]
fn put(columns: &[[f32; LANES]; LANES], rows: &mut [f32], width: usize, x: usize) {
    for (row, columns) in rows.chunks_mut(width).zip(columns) {
        let row = &mut row[x..];
        if let Some(row) = row.first_chunk_mut() {
            *row = *columns;
        } else {
            row.copy_from_slice(&columns[..row.len()]);
        }
    }
}
