//! Paints strokes over a part of a block, from the top down: groups of pixels that count are added up, others are left out.

use super::canvas::ViewPlanes;
use super::found::BlockStrokes;
use super::groups::{Counted, GROUPS, Outlines, Spot};
use super::planes::{self, index};
use super::{Brush, Ground, LANES};
use trochoid_graph::Connection;
use trochoid_image::Window;
use trochoid_memory::{Scratch, prefetch};

/// Number of strokes whose outlines are computed before they are painted.
const TOGETHER: usize = 32;

/// Numbers of a group of pixels, in a line of the cache.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Lanes([f64; LANES]);

/// A part of a block that is being painted.
#[derive(Default)]
pub(crate) struct Painting {
    pub(crate) counted: Counted,
    /// Of every channel in which a stroke or the image differs from 0, its place among the sums.
    slots: Scratch<Option<usize>>,
    /// Number of sums of a group of pixels, with the first.
    depth: usize,
    /// What the groups of pixels see, row by row.
    ground: Scratch<Ground>,
    /// Of each group, the fraction of the image that is still visible, and the weighted sums of the strokes' values.
    sums: Scratch<Lanes>,
    outlines: Outlines,
    /// Values of a stroke, by place among the sums.
    values: Scratch<(usize, f64)>,
    /// A row of a plane that ends within the part.
    own: Scratch<f32>,
}

impl Painting {
    /// Prepares the sums of the channels that are used, and what the pixels see, for the groups that count.
    #[inline(always)]
    pub(crate) fn prime(&mut self, is_used: &[bool], view: &ViewPlanes<'_>) {
        self.slots.clear();
        self.depth = 1;
        for is_used in is_used {
            self.slots.push(is_used.then_some(self.depth));
            self.depth += usize::from(*is_used);
        }
        let (part, depth) = (self.counted.part(), self.depth);
        let groups = part.height() * GROUPS;
        // What does not count keeps what it had in other parts.
        self.sums.resize(groups * depth, Lanes([0.0; LANES]));
        self.ground.resize(groups, Ground { parts: [-1.0; LANES], depths: [f32::INFINITY; LANES] });
        for row in self.counted.rows() {
            let ground = &mut self.ground[row * GROUPS..][..GROUPS];
            view.lay([part.x0, part.x1], part.y0 + row as i64, &mut self.own, ground);
            for group in self.counted.groups(row) {
                let sums = &mut self.sums[(row * GROUPS + group) * depth..][..depth];
                sums.fill(Lanes([0.0; LANES]));
                sums[0] = Lanes([1.0; LANES]);
            }
        }
    }

    /// Paints strokes, the top one first, on samples that are shifted against those they were found for.
    #[inline(always)]
    pub(crate) fn paint(&mut self, spots: &[Spot], strokes: &BlockStrokes, shift: [f64; 2]) {
        for spots in spots.chunks(TOGETHER) {
            for spot in spots {
                strokes.prefetch(spot.stroke);
            }
            self.outlines.clear();
            for spot in spots {
                let brush = &strokes.brushes[spot.stroke as usize];
                self.outlines.push(*spot, brush, brush.seen_from(shift), &self.counted);
                strokes.prefetch_values(spot.stroke);
            }
            self.outlines.list(&self.counted);
            for (number, spot) in spots.iter().enumerate() {
                self.values.clear();
                let mut is_finite = true;
                for (channel, value) in strokes.values(spot.stroke) {
                    if let Some(slot) = self.slots[*channel] {
                        self.values.push((slot, *value));
                        is_finite &= value.is_finite();
                    }
                }
                let brush = strokes.brushes[spot.stroke as usize];
                if is_finite { self.add::<true>(number, brush) } else { self.add::<false>(number, brush) }
            }
        }
    }

    /// Adds the stroke with this number among those whose groups are listed.
    #[inline(always)]
    fn add<const IS_FINITE: bool>(&mut self, number: usize, brush: Brush) {
        let depth = self.depth;
        for (place, rows, row) in self.outlines.of(number) {
            let covers = brush.cover(rows, row, place % GROUPS * LANES, self.ground[place]);
            let sums = &mut self.sums[place * depth..][..depth];
            let weights = shared(&mut sums[0].0, covers);
            for (slot, value) in &*self.values {
                let sums = &mut sums[*slot].0;
                *sums = weighted::<IS_FINITE>(*sums, weights, *value);
            }
        }
    }

    /// Lays the strokes over a channel of an image, and writes the groups that count to the block's plane.
    #[inline(always)]
    pub(crate) fn finish(&mut self, channel: usize, image: &Connection<'_>, block: Window, plane: &mut [f32]) {
        let under = image.planes.get(channel).copied().flatten();
        let part = self.counted.part();
        for row in self.counted.rows() {
            let (y, columns) = (part.y0 + row as i64, [part.x0, part.x1]);
            let out = &mut plane[index(block, part.x0, y)..][..part.width()];
            let Some(slot) = self.slots[channel] else {
                out.fill(0.0);
                continue;
            };
            let own = under.map_or(&[][..], |plane| planes::row(plane, image.window, columns, y, &mut self.own));
            let later = index(image.window, part.x0, y + 2);
            for group in self.counted.groups(row) {
                prefetch(under.unwrap_or_default(), later + group * LANES);
                let sums = &self.sums[(row * GROUPS + group) * self.depth..][..self.depth];
                let columns = group * LANES..part.width().min((group + 1) * LANES);
                let mixed = mixed(sums[0].0, sums[slot].0, padded(own, columns.start));
                out[columns.clone()].copy_from_slice(&mixed[..columns.len()]);
            }
        }
    }
}

/// Returns the weights of a stroke at a group of pixels, and takes them from what is left.
#[inline(always)]
fn shared(all: &mut [f64; LANES], covers: [f32; LANES]) -> [f64; LANES] {
    let (mut left, mut weights) = (*all, [0.0; LANES]);
    for lane in 0..LANES {
        weights[lane] = f64::from(covers[lane]) * left[lane];
        left[lane] -= weights[lane];
    }
    *all = left;
    weights
}

/// Returns sums with the value of a stroke added. 0 times infinity counts as 0.
#[inline(always)]
fn weighted<const IS_FINITE: bool>(mut sums: [f64; LANES], weights: [f64; LANES], value: f64) -> [f64; LANES] {
    for lane in 0..LANES {
        let counts = IS_FINITE || weights[lane] > 0.0;
        sums[lane] += if counts { weights[lane] * value } else { 0.0 };
    }
    sums
}

/// Returns the pixels of an image under what strokes add up to.
#[inline(always)]
fn mixed(left: [f64; LANES], sums: [f64; LANES], own: [f32; LANES]) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    for lane in 0..LANES {
        let sum = sums[lane] + if left[lane] > 0.0 { left[lane] * f64::from(own[lane]) } else { 0.0 };
        // +∞ and −∞ have no mean: keep the image.
        out[lane] = if sum.is_nan() { own[lane] } else { sum as f32 };
    }
    out
}

/// Returns a group of samples of a row; behind the row's end, 0.
#[inline(always)]
pub(super) fn padded(row: &[f32], start: usize) -> [f32; LANES] {
    let rest = row.get(start..).unwrap_or_default();
    if let Some(all) = rest.first_chunk() {
        return *all;
    }
    let mut all = [0.0; LANES];
    for (all, sample) in all.iter_mut().zip(rest) {
        *all = *sample;
    }
    all
}
