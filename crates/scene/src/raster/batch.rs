//! Triangles that are set up side by side, in vectors: most of them see no sample, and which do is not predictable.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use trochoid_image::Window;

use crate::edges::{NARROW, NarrowEdges, WIDE};
use crate::project::ScreenVertex;

/// Most samples within a triangle's bounds that are looked at one by one.
const FEW: i32 = 16;
/// Triangles smaller than this in each direction have edge functions in f64.
const FLOAT: i32 = 1 << 24;

/// Where the samples of a pixel are.
#[derive(Clone, Copy)]
pub(super) struct SampleGrid {
    /// Least and greatest position within the pixel, horizontally and vertically.
    pub(super) outer: [[i32; 2]; 2],
    /// Distance between samples along an axis, as a power of two; 0 if they are not evenly spaced.
    pub(super) apart: u32,
    /// Size of a pixel, as a power of two.
    pub(super) bits: u32,
}

/// Triangles that wait until there are enough of them. Lanes beyond the last one hold any.
pub(super) struct Batch {
    count: usize,
    /// Packed numbers.
    pub(super) numbers: [u64; WIDE],
    /// Corners.
    x: [[i32; WIDE]; 3],
    y: [[i32; WIDE]; 3],
    keys: [[f32; WIDE]; 3],
    /// Which triangles may cover a sample; which of these are smaller than [`NARROW`]; which have few samples within their
    /// bounds.
    pub(super) seen: u32,
    pub(super) small: u32,
    pub(super) few: u32,
    /// Least and greatest coordinate of each, by axis, and the first and last pixel of which some sample may lie between.
    low: [[i32; WIDE]; 2],
    high: [[i32; WIDE]; 2],
    first: [[i32; WIDE]; 2],
    last: [[i32; WIDE]; 2],
    /// Where the functions of small ones start.
    from: [[i32; WIDE]; 2],
    pub(super) edges: NarrowEdges,
}

impl Default for Batch {
    fn default() -> Self {
        let (none, nowhere) = ([0; WIDE], [[0; WIDE]; 2]);
        Self {
            count: 0,
            numbers: [0; WIDE],
            x: [none; 3],
            y: [none; 3],
            keys: [[0.0; WIDE]; 3],
            seen: 0,
            small: 0,
            few: 0,
            low: nowhere,
            high: nowhere,
            first: nowhere,
            last: nowhere,
            from: nowhere,
            edges: NarrowEdges::default(),
        }
    }
}

impl Batch {
    /// Returns whether there may be no room for two more.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.count > WIDE - 2
    }

    #[inline(always)]
    pub(super) fn push(&mut self, corners: [ScreenVertex; 3], number: u64) {
        let lane = self.count;
        self.count += 1;
        self.numbers[lane] = number;
        for corner in 0..3 {
            let ScreenVertex { x, y, key } = corners[corner];
            (self.x[corner][lane], self.y[corner][lane], self.keys[corner][lane]) = (x, y, key);
        }
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// Finds out which triangles may cover samples of `part`, and makes the edge functions of small ones.
    #[inline(always)]
    pub(super) fn set_up(&mut self, grid: SampleGrid, part: Window) {
        let SampleGrid { outer, apart, bits } = grid;
        let up = (1 << bits) - 1;
        let part = [[part.x0 as i32, part.x1 as i32 - 1], [part.y0 as i32, part.y1 as i32 - 1]];
        let mut missed = [0; WIDE];
        for (axis, at) in [self.x, self.y].into_iter().enumerate() {
            let ([least, greatest], [from, to]) = (outer[axis], part[axis]);
            let (mut low, mut high) = ([0; WIDE], [0; WIDE]);
            let (mut first, mut last, mut start) = ([0; WIDE], [0; WIDE], [0; WIDE]);
            for lane in 0..WIDE {
                low[lane] = at[0][lane].min(at[1][lane]).min(at[2][lane]);
                high[lane] = at[0][lane].max(at[1][lane]).max(at[2][lane]);
                // No sample lies between.
                let row = |at: i32| (at - least) >> apart;
                let is_between = row(high[lane]) == row(low[lane] - 1);
                first[lane] = ((low[lane] - greatest + up) >> bits).max(from);
                last[lane] = ((high[lane] - least) >> bits).min(to);
                start[lane] = low[lane] & !up;
                missed[lane] |= i32::from(is_between) | i32::from(first[lane] > last[lane]);
            }
            (self.low[axis], self.high[axis], self.from[axis]) = (low, high, start);
            (self.first[axis], self.last[axis]) = (first, last);
        }
        let flat = self.edges.set_up(self.x, self.y, self.keys, self.from);
        let (low, high) = (self.low, self.high);
        let (mut small, mut few) = ([0; WIDE], [0; WIDE]);
        for lane in 0..WIDE {
            let (width, height) = (high[0][lane] - low[0][lane], high[1][lane] - low[1][lane]);
            let is_small = i32::from(width.max(height) < NARROW) & i32::from(bits <= 12);
            let within = ((width >> bits) + 1).wrapping_mul((height >> apart) + 1);
            small[lane] = is_small;
            few[lane] = is_small & i32::from(apart > 0) & i32::from(within <= FEW);
            missed[lane] |= is_small & flat[lane];
        }
        let bits_of =
            |lanes: [i32; WIDE]| lanes.iter().enumerate().fold(0, |all, (lane, is_one)| all | (*is_one as u32) << lane);
        self.seen = !bits_of(missed) & ((1 << self.count) - 1);
        (self.small, self.few) = (bits_of(small), bits_of(few));
    }

    /// Returns the first and last pixel in which a triangle may cover samples, by axis.
    #[inline(always)]
    pub(super) fn pixels(&self, lane: usize) -> [[i32; 2]; 2] {
        [0, 1].map(|axis| [self.first[axis][lane], self.last[axis][lane]])
    }

    /// Returns the least and greatest coordinate of a triangle along an axis.
    #[inline(always)]
    pub(super) fn bounds(&self, lane: usize, axis: usize) -> [i32; 2] {
        [self.low[axis][lane], self.high[axis][lane]]
    }

    /// Returns where the functions of a small triangle start.
    #[inline(always)]
    pub(super) fn from(&self, lane: usize) -> [i32; 2] {
        [self.from[0][lane], self.from[1][lane]]
    }

    /// Returns whether the edge functions of a triangle are exact in f64.
    #[inline(always)]
    pub(super) fn fits_floats(&self, lane: usize, bits: u32) -> bool {
        let size = |axis: usize| self.high[axis][lane] - self.low[axis][lane];
        size(0).max(size(1)) < FLOAT && bits <= 12
    }

    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [ScreenVertex; 3] {
        [0, 1, 2].map(|corner| ScreenVertex {
            x: self.x[corner][lane],
            y: self.y[corner][lane],
            key: self.keys[corner][lane],
        })
    }
}
