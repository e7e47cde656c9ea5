//! Division of a part into chunks.

use trochoid_image::Window;

use crate::{Compression, Levels, Storage};

/// Chunks of a part: blocks of whole rows, or tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    /// Data window of the part.
    pub(super) window: Window,
    /// Width of a chunk in pixels; chunks of the last column may be narrower.
    pub(super) width: usize,
    /// Height of a chunk in pixels; chunks of the last row may be lower.
    pub(super) height: usize,
    /// Whether chunks are tiles, which have a column, a row and a level.
    pub(super) tiled: bool,
    /// Number of chunks of all levels together.
    pub(super) chunks: u64,
}

impl Layout {
    pub(super) fn new(window: Window, storage: &Storage, compression: Compression, round_up: bool) -> Self {
        let (full_width, full_height) = (window.width() as u64, window.height() as u64);
        if let Storage::Tiled { width, height, levels } = *storage {
            let along = |size: u64, tile: u32| -> Vec<u64> {
                level_sizes(size, round_up).map(|size| size.div_ceil(u64::from(tile))).collect()
            };
            let (across, down) = (along(full_width, width), along(full_height, height));
            let chunks = match levels {
                Levels::One => across[0].saturating_mul(down[0]),
                Levels::Mip => {
                    // The shorter direction stays at one pixel while the longer one still shrinks.
                    let at = |counts: &[u64], level: usize| counts.get(level).copied().unwrap_or(1);
                    (0..across.len().max(down.len())).fold(0, |sum: u64, level| {
                        sum.saturating_add(at(&across, level).saturating_mul(at(&down, level)))
                    })
                }
                Levels::Rip => across.iter().sum::<u64>().saturating_mul(down.iter().sum()),
            };
            return Self { window, width: width as usize, height: height as usize, tiled: true, chunks };
        }
        let height = rows_per_chunk(compression);
        Self { window, width: window.width(), height, tiled: false, chunks: full_height.div_ceil(height as u64) }
    }

    /// Returns the number of columns of chunks, at full resolution.
    pub(super) fn columns(&self) -> usize {
        self.window.width().div_ceil(self.width)
    }

    /// Returns the number of rows of chunks, at full resolution.
    pub(super) fn bands(&self) -> usize {
        self.window.height().div_ceil(self.height)
    }

    /// Returns the window of chunk (`column`, `band`) at full resolution, relative to the corner of the data window.
    pub(super) fn rectangle(&self, column: usize, band: usize) -> Window {
        let (x, y) = ((column * self.width) as i64, (band * self.height) as i64);
        let whole = Window::new(0, 0, self.window.width() as i64, self.window.height() as i64);
        Window::new(x, y, x + self.width as i64, y + self.height as i64).intersect(whole)
    }

    /// Returns the window of a row of chunks in the picture; empty if there is no such row.
    pub(super) fn band(&self, band: usize) -> Window {
        let y0 = self.window.y0 + self.height.saturating_mul(band).min(self.window.height()) as i64;
        let y1 = self.window.y1.min(y0.saturating_add(self.height as i64));
        Window { y0, y1, ..self.window }
    }

    /// Returns the number of samples per channel in the largest chunk.
    pub(super) fn largest(&self) -> u64 {
        (self.width.min(self.window.width()) as u64) * (self.height.min(self.window.height()) as u64)
    }
}

/// Returns the sizes of all levels, halved down to one pixel.
fn level_sizes(size: u64, round_up: bool) -> impl Iterator<Item = u64> {
    let halve = move |&size: &u64| (size > 1).then(|| if round_up { size.div_ceil(2) } else { size / 2 });
    std::iter::successors(Some(size), halve)
}

fn rows_per_chunk(compression: Compression) -> usize {
    match compression {
        Compression::Zip | Compression::Pxr24 => 16,
        Compression::Piz | Compression::B44 | Compression::B44a | Compression::Dwaa | Compression::Htj2k32 => 32,
        Compression::Dwab | Compression::Htj2k256 | Compression::Lj2k => 256,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiled(width: u32, height: u32, levels: Levels, up: bool) -> u64 {
        let storage = Storage::Tiled { width: 2, height: 2, levels };
        Layout::new(Window::sized(width, height), &storage, Compression::Zip, up).chunks
    }

    #[test]
    fn chunks_are_counted_like_the_format_does() {
        assert_eq!(tiled(5, 3, Levels::One, false), 6);
        // 5 × 3, 2 × 1, 1 × 1
        assert_eq!(tiled(5, 3, Levels::Mip, false), 6 + 1 + 1);
        // 5 × 3, 3 × 2, 2 × 1, 1 × 1
        assert_eq!(tiled(5, 3, Levels::Mip, true), 6 + 2 + 1 + 1);
        // widths 5, 2, 1 have 3, 1, 1 columns; heights 3, 1 have 2, 1 rows
        assert_eq!(tiled(5, 3, Levels::Rip, false), 5 * 3);
        let rows = Layout::new(Window::new(-3, -7, 2, 30), &Storage::Scanline, Compression::Zip, false);
        assert_eq!((rows.chunks, rows.bands(), rows.columns()), (3, 3, 1));
        assert_eq!(rows.rectangle(0, 2), Window::new(0, 32, 5, 37));
    }

    #[test]
    fn absurd_sizes_do_not_overflow() {
        let side = i32::MAX as u32 / 2;
        assert!(tiled(side, side, Levels::Rip, true) > 1 << 58);
    }
}
