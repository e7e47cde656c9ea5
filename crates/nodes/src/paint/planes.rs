//! Access to the planes of a connection around a block. Beyond a window the values of its border repeat.

use fearless_simd::{Level, Simd, dispatch};
use trochoid_graph::Connection;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Returns the index of a pixel within a window, or that of the nearest pixel if it lies outside.
#[inline(always)]
pub(crate) fn index(window: Window, x: i64, y: i64) -> usize {
    let column = x.clamp(window.x0, window.x1 - 1) - window.x0;
    let row = y.clamp(window.y0, window.y1 - 1) - window.y0;
    row as usize * window.width() + column as usize
}

/// Returns a sample of a connection, as far as the connection has the channel.
#[inline(always)]
pub(crate) fn sample(connection: Option<&Connection<'_>>, channel: usize, x: i64, y: i64) -> Option<f64> {
    let connection = connection?;
    let plane = (*connection.planes.get(channel)?)?;
    Some(f64::from(plane[index(connection.window, x, y)]))
}

/// Returns the samples of a plane with this window from column `x0` up to `x1`, in row `y`. Beyond the window they are
/// copied to `own`.
#[inline(always)]
pub(crate) fn row<'r>(
    plane: &'r [f32],
    window: Window,
    [x0, x1]: [i64; 2],
    y: i64,
    own: &'r mut Vec<f32>,
) -> &'r [f32] {
    if window.x0 <= x0 && x1 <= window.x1 {
        return &plane[index(window, x0, y)..][..(x1 - x0) as usize];
    }
    own.clear();
    own.extend((x0..x1).map(|x| plane[index(window, x, y)]));
    own
}

/// Returns of each channel of an image whether it differs from 0 anywhere in a window.
pub(crate) fn used(level: Level, image: &Connection<'_>, channels: usize, window: Window) -> Scratch<bool> {
    let mut used = Scratch::of(false, channels);
    dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
        for (channel, used) in used.iter_mut().enumerate() {
            *used = !is_zero(image, channel, window);
        }
    }));
    used
}

/// Whether a channel of an image is 0 all over a window.
#[inline(always)]
fn is_zero(image: &Connection<'_>, channel: usize, window: Window) -> bool {
    let Some(Some(plane)) = image.planes.get(channel) else { return true };
    let x0 = window.x0.clamp(image.window.x0, image.window.x1 - 1);
    let x1 = window.x1.clamp(x0 + 1, image.window.x1);
    // A closure would not be compiled for the vectors of the caller.
    for y in window.y0..window.y1 {
        let row = &plane[index(image.window, x0, y)..][..(x1 - x0) as usize];
        // Without leaving early, rows are compared as vectors.
        if row.iter().fold(0, |bits, value| bits | value.to_bits()) << 1 != 0 {
            return false;
        }
    }
    true
}
