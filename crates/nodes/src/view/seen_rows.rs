//! What the samples around a block see, row by row, to find edges between them.

use super::Neighborhood;
use fearless_simd::{Level, Simd, dispatch};
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Minimum depth, in meters.
pub(super) const NEAREST: f64 = 1e-6;

/// Data seen by a sample: the surface's index, −1 for the sky, and 1/depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SeenSample {
    pub(super) surface: f64,
    pub(super) w: f64,
}

impl SeenSample {
    #[inline(always)]
    pub(super) fn new(surface: f64, depth: f64) -> Self {
        // Planes behind an orthographic camera have no value of 1/depth.
        Self { surface, w: if surface < 0.0 { 0.0 } else { 1.0 / depth.max(NEAREST) } }
    }

    /// Returns the position in the Render's list; the sky comes last.
    pub(super) fn rank(self) -> f64 {
        if self.surface < 0.0 { f64::INFINITY } else { self.surface }
    }

    /// Whether a sample may be parted from its neighbor: they see different `objects`, or the jump of 1/depth between
    /// them is above its share `depth_step`.
    #[inline(always)]
    pub(super) fn jumps(self, other: Self, objects: bool, depth_step: f64) -> bool {
        // 1/depth is a number.
        let least = if self.w < other.w { self.w } else { other.w };
        (objects & (self.surface != other.surface)) | ((self.w - other.w).abs() > depth_step * least)
    }
}

/// What the samples of a window see.
pub(super) struct SeenRows {
    window: Window,
    surfaces: Scratch<f64>,
    w: Scratch<f64>,
}

/// Number of pairs that are tested for jumps together.
const TOGETHER: usize = 16;

impl SeenRows {
    /// Returns what the samples of a window see; beyond the image, the nearest pixel repeats. `group` maps each surface
    /// to the one that it counts as.
    pub(super) fn new(around: &Neighborhood<'_>, depths: &[f32], window: Window, group: impl Fn(f32) -> f64) -> Self {
        let mut seen = Self { window, surfaces: Scratch::new(), w: Scratch::of(0.0, window.area()) };
        seen.surfaces.reserve(window.area());
        let (surfaces, mut spare) = (around.surfaces(), Scratch::new());
        // Neighbors mostly see the same surface.
        let mut last = (f32::NAN, 0.0);
        for (y, w) in (window.y0..window.y1).zip(seen.w.chunks_exact_mut(window.width().max(1))) {
            let row = around.row(&surfaces, y, window.x0..window.x1, &mut spare);
            seen.surfaces.extend(row.iter().map(|surface| {
                if *surface != last.0 {
                    last = (*surface, group(*surface));
                }
                last.1
            }));
            let row = around.row(depths, y, window.x0..window.x1, &mut spare);
            let surfaces = &seen.surfaces[seen.surfaces.len() - w.len()..];
            dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
                for ((w, surface), depth) in w.iter_mut().zip(surfaces).zip(row) {
                    *w = SeenSample::new(*surface, f64::from(*depth)).w;
                }
            }));
        }
        seen
    }

    fn index(&self, x: i64, y: i64) -> usize {
        (y - self.window.y0) as usize * self.window.width() + (x - self.window.x0) as usize
    }

    /// Returns what a sample within the window sees.
    #[inline]
    pub(super) fn at(&self, x: i64, y: i64) -> SeenSample {
        let index = self.index(x, y);
        SeenSample { surface: self.surfaces[index], w: self.w[index] }
    }

    /// Visits the samples of a window that [jump](SeenSample::jumps) to the one a step away.
    pub(super) fn visit_jumps(
        &self,
        window: Window,
        (dx, dy): (i64, i64),
        objects: bool,
        depth_step: f64,
        mut visit: impl FnMut(i64, i64),
    ) {
        for y in window.y0..window.y1 {
            for x in (window.x0..window.x1).step_by(TOGETHER) {
                let count = TOGETHER.min((window.x1 - x) as usize);
                let samples = |index: usize| (&self.surfaces[index..][..count], &self.w[index..][..count]);
                let (a, b) = (samples(self.index(x, y)), samples(self.index(x + dx, y + dy)));
                let any = dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
                    any_jumps(a, b, objects, depth_step)
                }));
                if !any {
                    continue;
                }
                for x in x..x + count as i64 {
                    if self.at(x, y).jumps(self.at(x + dx, y + dy), objects, depth_step) {
                        visit(x, y);
                    }
                }
            }
        }
    }
}

/// Whether any sample jumps to its neighbor, from the surfaces and the 1/depth of both.
#[inline(always)]
fn any_jumps(a: (&[f64], &[f64]), b: (&[f64], &[f64]), objects: bool, depth_step: f64) -> bool {
    let mut any = false;
    for ((surface, w), (other_surface, other_w)) in a.0.iter().zip(a.1).zip(b.0.iter().zip(b.1)) {
        let (a, b) = (SeenSample { surface: *surface, w: *w }, SeenSample { surface: *other_surface, w: *other_w });
        any |= a.jumps(b, objects, depth_step);
    }
    any
}
