//! Pixels near those whose further samples are taken.

use super::places::make_room;
use super::shared::UnsharedPixels;
use crate::planning::schedule::Reach;
use trochoid_image::Window;

/// Pixels around those whose samples are taken. They keep their memory.
#[derive(Default)]
pub(super) struct Masks {
    pub(super) all: Vec<Mask>,
    /// Number of those of the current sample.
    pub(super) used: usize,
    row: Vec<bool>,
}

#[derive(Default)]
pub(super) struct Mask {
    pub(super) margin: Reach,
    window: Window,
    pub(super) is_near: Vec<bool>,
    /// Indices of the pixels in the window.
    pub(super) indices: Vec<usize>,
}

impl Masks {
    /// Finds the pixels of a window that are at most `margin` away from some pixels; returns the index of the mask.
    pub(super) fn near(&mut self, pixels: &[[i64; 2]], margin: Reach, window: Window) -> usize {
        let known = self.all[..self.used].iter().position(|mask| mask.margin == margin && mask.window == window);
        known.unwrap_or_else(|| {
            if self.used == self.all.len() {
                self.all.push(Mask::default());
            }
            self.used += 1;
            self.all[self.used - 1].find(pixels, margin, window, &mut self.row);
            self.used - 1
        })
    }
}

impl Mask {
    fn find(&mut self, pixels: &[[i64; 2]], margin: Reach, window: Window, row: &mut Vec<bool>) {
        let (width, height) = (window.width(), window.height());
        let (across, down) = (margin.0 as i64, margin.1 as i64);
        (self.margin, self.window) = (margin, window);
        self.is_near.clear();
        self.is_near.resize(window.area(), false);
        for pixels in pixels.chunk_by(|a, b| a[1] == b[1]) {
            row.clear();
            row.resize(width, false);
            for [x, _] in pixels {
                let [from, to] =
                    [x - across, x + across + 1].map(|x| (x.clamp(window.x0, window.x1) - window.x0) as usize);
                row[from..to].fill(true);
            }
            let y = pixels[0][1] - window.y0;
            let [from, to] = [y - down, y + down + 1].map(|y| y.clamp(0, height as i64) as usize);
            for to in self.is_near[from * width..to * width].chunks_exact_mut(width.max(1)) {
                to.iter_mut().zip(&*row).for_each(|(to, from)| *to |= from);
            }
        }
        self.indices.clear();
        make_room(&mut self.indices, window.area());
        for (start, near) in (0..).step_by(width.max(1)).zip(self.is_near.chunks_exact(width.max(1))) {
            let mut x = 0;
            // Pixels that are near mostly follow one another.
            for run in near.chunk_by(|a, b| a == b) {
                if run[0] {
                    self.indices.extend(start + x..start + x + run.len());
                }
                x += run.len();
            }
        }
    }

    /// Lists the pixels.
    pub(super) fn pixels(&self) -> UnsharedPixels {
        UnsharedPixels::at(self.window, self.indices.iter().copied().collect())
    }

    /// Lists the pixels that are not in another mask of the same window.
    pub(super) fn pixels_without(&self, other: &Self) -> UnsharedPixels {
        let indices = self.indices.iter().copied().filter(|index| !other.is_near[*index]);
        UnsharedPixels::at(self.window, indices.collect())
    }
}
