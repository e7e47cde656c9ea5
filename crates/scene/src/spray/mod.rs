//! Drops of spray, painted as brush stamps and hidden by nearer surfaces.
//!
//! ```
//! use trochoid_image::Format;
//! use trochoid_scene::spray::{Brush, Dabs, Droplet, Stamp};
//! use trochoid_scene::{Camera, DVec3, Projection};
//!
//! let camera = Camera {
//!     position: DVec3::new(0.0, 0.0, 10.0),
//!     target: DVec3::ZERO,
//!     roll: 0.0,
//!     projection: Projection::Perspective { fov: 0.7 },
//! };
//! let format = Format::new(64, 36, 1)?;
//! let drop = Droplet {
//!     position: [0.0; 3], velocity: [0.0; 3], radius: 0.5, share: 1.0, age: 0.5, strength: 1.0, shape: 0,
//! };
//! let brush = Brush { stamp: Stamp::Disc, ..Brush::default() };
//! let dabs = Dabs::new(&camera.projector(format), &[drop], &brush)?;
//! assert!(dabs.at([32.0, 18.0], f64::INFINITY).alpha > 0.2);
//! assert_eq!(dabs.at([32.0, 18.0], 5.0).alpha, 0.0, "something is in front of it");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod dab;
mod stamp;

pub use dab::{Brush, SpraySample};
pub use stamp::Stamp;
pub use trochoid_sea::spray::Droplet;

use crate::Projector;
use dab::{Dab, LANES, SprayLanes};
use fearless_simd::{Level, Simd, dispatch};
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Side of a bin in pixels.
const BIN: i64 = 32;
/// Most entries of all bins, so that their memory is known before it is allocated.
pub const MAX_ENTRIES: usize = 1 << 24;

/// Stamps cover so much of the picture that their bins would exceed [`MAX_ENTRIES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMuchSpray(pub usize);

impl std::fmt::Display for TooMuchSpray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "the stamps of all drops touch {} bins of {BIN} × {BIN} pixels, more than {MAX_ENTRIES}: make \"radius\", \
             \"growth\", \"stretch\" or the number of drops smaller, or move the camera away",
            self.0
        )
    }
}

impl std::error::Error for TooMuchSpray {}

/// The stamps of one picture.
#[derive(Clone, Debug)]
pub struct Dabs {
    brush: Brush,
    dabs: Vec<Dab>,
    /// Columns and rows of bins over the picture.
    bins: [i64; 2],
    /// Start of each bin's entries; one more entry than there are bins.
    starts: Vec<u32>,
    /// Indices of stamps bin by bin; within a bin in the order of the drops.
    entries: Vec<u32>,
}

/// Output planes of a window; `None` where not wanted.
#[derive(Debug, Default)]
pub struct Planes<'a> {
    /// Coverage (alpha).
    pub alpha: Option<&'a mut [f32]>,
    /// Planar depth of the nearest drop, in meters.
    pub depth: Option<&'a mut [f32]>,
    /// Mean age of the drops.
    pub age: Option<&'a mut [f32]>,
    /// Total weight of the drops in that mean: the sum of their alphas.
    pub weight: Option<&'a mut [f32]>,
}

impl Dabs {
    /// Makes the stamps of the drops that lie in the picture.
    ///
    /// # Errors
    /// The stamps cover too much.
    pub fn new(projector: &Projector, drops: &[Droplet], brush: &Brush) -> Result<Self, TooMuchSpray> {
        let bins = projector.size.map(|side| (side as i64).div_euclid(BIN) + 1);
        let dabs: Vec<Dab> = drops
            .iter()
            .filter_map(|drop| Dab::new(projector, drop, brush))
            .filter(|dab| reach(dab, bins).is_some())
            .collect();
        let mut starts = vec![0_u32; (bins[0] * bins[1]) as usize + 1];
        let mut total = 0_usize;
        for dab in &dabs {
            total += met(dab, bins).count();
        }
        if total > MAX_ENTRIES {
            return Err(TooMuchSpray(total));
        }
        for bin in dabs.iter().flat_map(|dab| met(dab, bins)) {
            starts[bin + 1] += 1;
        }
        for bin in 1..starts.len() {
            starts[bin] += starts[bin - 1];
        }
        let (mut next, mut entries) = (starts.clone(), vec![0; total]);
        for (index, dab) in dabs.iter().enumerate() {
            for bin in met(dab, bins) {
                entries[next[bin] as usize] = index as u32;
                next[bin] += 1;
            }
        }
        Ok(Self { brush: *brush, dabs, bins, starts, entries })
    }

    /// Returns the number of stamps in the picture.
    pub fn len(&self) -> usize {
        self.dabs.len()
    }

    /// Returns whether no drop is in the picture.
    pub fn is_empty(&self) -> bool {
        self.dabs.is_empty()
    }

    /// Returns the number of bytes held.
    pub fn bytes(&self) -> usize {
        self.dabs.len() * size_of::<Dab>() + (self.starts.len() + self.entries.len()) * 4
    }

    /// Returns what a position in the picture shows in front of a surface at a planar depth, straight from the
    /// formula.
    pub fn at(&self, place: [f64; 2], surface: f64) -> SpraySample {
        let mut sum = SpraySample::NONE;
        for dab in &self.dabs {
            sum.add(dab, dab.alpha(place, surface, &self.brush));
        }
        sum.done()
    }

    /// Does the same, with the same bits, at one sample of every pixel of a window, at `offset` in its pixel and in
    /// front of the surfaces at the depths of `surface`.
    pub fn fill(&self, window: Window, offset: [f64; 2], surface: &[f32], planes: Planes<'_>) {
        self.fill_unless(window, offset, surface, planes, &|| false);
    }

    /// Does the same, but asks at every stamp whether to stop; if so, the planes hold no useful values.
    pub fn fill_unless(
        &self,
        window: Window,
        offset: [f64; 2],
        surface: &[f32],
        planes: Planes<'_>,
        stop: &dyn Fn() -> bool,
    ) {
        let [columns, rows] = self.bins;
        let bin = |at: i64, count: i64| at.div_euclid(BIN).clamp(0, count - 1);
        if window.is_empty() {
            return;
        }
        let Planes { mut alpha, mut depth, mut age, mut weight } = planes;
        // Bins at the picture's border also cover everything beyond it.
        let edge = |index: i64, count: i64, low: i64, high: i64| {
            (if index == 0 { low } else { index * BIN }, if index == count - 1 { high } else { (index + 1) * BIN })
        };
        let mut sums = Scratch::new();
        for row in bin(window.y0, rows)..=bin(window.y1 - 1, rows) {
            for column in bin(window.x0, columns)..=bin(window.x1 - 1, columns) {
                let (x0, x1) = edge(column, columns, window.x0, window.x1);
                let (y0, y1) = edge(row, rows, window.y0, window.y1);
                let within = window.intersect(Window::new(x0, y0, x1, y1));
                let bin = (row * columns + column) as usize;
                let entries = &self.entries[self.starts[bin] as usize..self.starts[bin + 1] as usize];
                let across = within.width().div_ceil(LANES);
                sums.clear();
                sums.resize(across * within.height(), SprayLanes::NONE);
                dispatch!(Level::new(), simd => simd.vectorize(
                    #[inline(always)]
                    || self.fill_bin(entries, [within, window], offset, surface, stop, &mut sums)
                ));
                for (sums, y) in sums.chunks_exact(across.max(1)).zip(within.y0..) {
                    let start = (y - window.y0) as usize * window.width() + (within.x0 - window.x0) as usize;
                    let write = |plane: &mut Option<&mut [f32]>, value: fn(&SpraySample) -> f64| {
                        let Some(plane) = plane else { return };
                        let out = &mut plane[start..start + within.width()];
                        if entries.is_empty() {
                            out.fill(value(&SpraySample::NONE.done()) as f32);
                            return;
                        }
                        for (out, sums) in out.chunks_mut(LANES).zip(sums) {
                            for (lane, out) in out.iter_mut().enumerate() {
                                *out = value(&sums.at(lane).done()) as f32;
                            }
                        }
                    };
                    write(&mut alpha, |sum| sum.alpha);
                    write(&mut depth, |sum| sum.depth);
                    write(&mut age, |sum| sum.age);
                    write(&mut weight, |sum| sum.weight);
                }
            }
        }
    }

    /// Does the same at one sample of each of these pixels, in the order of the planes.
    pub fn fill_pixels_unless(
        &self,
        pixels: &[[i64; 2]],
        offset: [f64; 2],
        surface: &[f32],
        mut planes: Planes<'_>,
        stop: &dyn Fn() -> bool,
    ) {
        let [columns, rows] = self.bins;
        let bin = |at: i64, count: i64| at.div_euclid(BIN).clamp(0, count - 1);
        // The stamps that may touch a row of a bin: pixels mostly follow one another.
        let (mut near, mut known): (Scratch<&Dab>, _) = (Scratch::new(), None);
        for (index, &[x, y]) in pixels.iter().enumerate() {
            if index % 1024 == 0 && stop() {
                return;
            }
            let bin = (bin(y, rows) * columns + bin(x, columns)) as usize;
            let place = [x as f64 + offset[0], y as f64 + offset[1]];
            if known.replace((bin, y)) != Some((bin, y)) {
                let entries = &self.entries[self.starts[bin] as usize..self.starts[bin + 1] as usize];
                let dabs = entries.iter().map(|entry| &self.dabs[*entry as usize]);
                near.clear();
                near.extend(dabs.filter(|dab| dab.may_meet_row(place[1])));
            }
            let mut sum = SpraySample::NONE;
            for dab in &near {
                if dab.may_meet_column(place[0]) {
                    sum.add(dab, dab.alpha(place, f64::from(surface[index]), &self.brush));
                }
            }
            let sum = sum.done();
            for (plane, value) in [
                (&mut planes.alpha, sum.alpha),
                (&mut planes.depth, sum.depth),
                (&mut planes.age, sum.age),
                (&mut planes.weight, sum.weight),
            ] {
                if let Some(plane) = plane {
                    plane[index] = value as f32;
                }
            }
        }
    }

    #[inline(always)]
    fn fill_bin(
        &self,
        entries: &[u32],
        [within, window]: [Window; 2],
        offset: [f64; 2],
        surface: &[f32],
        stop: &dyn Fn() -> bool,
        sums: &mut [SprayLanes],
    ) {
        let across = within.width().div_ceil(LANES);
        let lanes: [f64; LANES] = std::array::from_fn(|lane| lane as f64);
        for &entry in entries {
            if stop() {
                return;
            }
            let dab = &self.dabs[entry as usize];
            let [left, top, right, bottom] = dab.bounds;
            let first = |edge: f64, offset: f64, least: i64| ((edge - offset).floor().max(least as f64)) as i64;
            let end = |edge: f64, offset: f64, most: i64| ((edge - offset).ceil().min((most - 1) as f64)) as i64 + 1;
            let columns = first(left, offset[0], within.x0)..end(right, offset[0], within.x1);
            if columns.is_empty() {
                continue;
            }
            let group = |x: i64| (x - within.x0) as usize / LANES;
            let groups = group(columns.start)..group(columns.end - 1) + 1;
            for y in first(top, offset[1], within.y0)..end(bottom, offset[1], within.y1) {
                let start = (y - window.y0) as usize * window.width() + (within.x0 - window.x0) as usize;
                let surface = &surface[start..start + within.width()];
                let sums = &mut sums[(y - within.y0) as usize * across..][..across];
                // Groups of samples; a stamp does not cover those of a group that lie outside of its bounds.
                for (group, sum) in sums[groups.clone()].iter_mut().enumerate() {
                    let first = (groups.start + group) * LANES;
                    let of_group = &surface[first..within.width().min(first + LANES)];
                    let mut surfaces = [f64::NEG_INFINITY; LANES];
                    for (to, from) in surfaces.iter_mut().zip(of_group) {
                        *to = f64::from(*from);
                    }
                    let left = (within.x0 + first as i64) as f64;
                    let x = lanes.map(|lane| left + lane + offset[0]);
                    sum.add(dab, dab.alphas(x, y as f64 + offset[1], surfaces, &self.brush));
                }
            }
        }
    }
}

/// Returns the first and last column and row of bins that a stamp may touch; `None` if it lies outside of the
/// picture.
fn reach(dab: &Dab, bins: [i64; 2]) -> Option<[[i64; 2]; 2]> {
    let [left, top, right, bottom] = dab.bounds;
    let along = |from: f64, to: f64, count: i64| {
        let end = (count * BIN) as f64;
        // One more pixel on each side, since a sample may lie on its pixel's edge.
        let (from, to) = (from - 1.0, to + 1.0);
        (from < end && to >= 0.0).then(|| {
            let [from, to] = [from.max(0.0), to.min(end - 1.0)].map(|edge| edge as i64 / BIN);
            [from, to]
        })
    };
    Some([along(left, right, bins[0])?, along(top, bottom, bins[1])?])
}

/// Returns the bins that a stamp may touch.
fn met(dab: &Dab, bins: [i64; 2]) -> impl Iterator<Item = usize> {
    let [[left, right], [top, bottom]] = reach(dab, bins).unwrap_or([[0, -1], [0, -1]]);
    (top..=bottom).flat_map(move |row| (left..=right).map(move |column| (row * bins[0] + column) as usize))
}
