//! Tells which patches may hold seeds, many at once: most hold none. Cells, keys and points are those of `seeds`, bit for
//! bit.

use super::seeds::{Patch, placed};
use super::{Corner, LANES, Layer, pixels};
use fearless_simd::{Level, Simd, dispatch};
use trochoid_field::random::{draw, key};
use trochoid_memory::Scratch;

/// Numbers of patches side by side.
type Lanes = [f64; LANES];

/// A row of patches.
#[derive(Default)]
pub(crate) struct Row {
    above: Corners,
    below: Corners,
    /// Of each patch, the input `size`.
    sizes: Scratch<f64>,
    /// Side of the patches, and the factor by which depths differ at an edge.
    side: f64,
    step: f64,
}

/// The corners along one side of a row of patches.
#[derive(Default)]
struct Corners {
    rests: [Scratch<f64>; 3],
    parts: Scratch<f64>,
    depths: Scratch<f64>,
}

/// Patches side by side: what decides whether they hold seeds.
struct Patches {
    /// Bounding boxes of the corners, by axis.
    low: [Lanes; 2],
    high: [Lanes; 2],
    areas: Lanes,
    tags: [i64; LANES],
    /// 1 if no edge lies between the corners, otherwise 0.
    placed: [u64; LANES],
}

/// Cells of a level along an axis: the first, and 1 if there is one more, otherwise 0.
#[derive(Clone, Copy)]
struct Span {
    first: Lanes,
    more: [u64; LANES],
}

/// Adding this to a whole number leaves it in the last bits.
const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// Cells beyond are left to `seeds`.
const FAR: f64 = (1u64 << 50) as f64;

impl Row {
    /// Starts with the corners above the first row of patches, which have this side; the memory stays.
    pub(crate) fn begin(&mut self, side: f64, step: f64, corners: impl Iterator<Item = Corner>) {
        (self.side, self.step) = (side, step);
        self.below.fill(corners);
    }

    /// Goes on to the next row, given the corners below it, and the input `size` of each patch.
    pub(crate) fn next(&mut self, corners: impl Iterator<Item = Corner>, sizes: impl Iterator<Item = f64>) {
        std::mem::swap(&mut self.above, &mut self.below);
        self.below.fill(corners);
        self.sizes.clear();
        self.sizes.extend(sizes.chain([1.0; LANES]));
    }

    /// Returns the input `size` of a patch.
    pub(crate) fn size(&self, patch: usize) -> f64 {
        self.sizes[patch]
    }

    /// Returns a patch, unless an edge lies between its corners.
    pub(crate) fn patch(&self, patch: usize) -> Option<Patch> {
        let (above, below) = (&self.above, &self.below);
        let corners = [above.corner(patch), above.corner(patch + 1), below.corner(patch), below.corner(patch + 1)];
        placed(corners, self.side, self.step)
    }

    /// Lists patches that may hold seeds of layers, and all that do, with the number of the layer.
    pub(crate) fn scan<'l>(&self, layers: impl Iterator<Item = &'l Layer> + Clone, found: &mut Vec<(usize, usize)>) {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for start in (0..self.sizes.len() - LANES).step_by(LANES) {
                let patches = Patches::between([&self.above, &self.below], start, self.side, self.step);
                let sizes = group(&self.sizes, start);
                for (number, layer) in layers.clone().enumerate() {
                    let mut bits = patches.seeded(layer, sizes);
                    while bits != 0 {
                        found.push((start + bits.trailing_zeros() as usize, number));
                        bits &= bits - 1;
                    }
                }
            }
        }));
    }
}

impl Corners {
    fn fill(&mut self, corners: impl Iterator<Item = Corner>) {
        let Self { rests: [x, y, z], parts, depths } = self;
        for numbers in [&mut *x, y, z, parts, depths] {
            numbers.clear();
        }
        // The last group is filled up with patches that have no surface in common.
        let none = Corner { rest: [0.0; 3], part: f64::NAN, depth: 0.0 };
        for Corner { rest, part, depth } in corners.chain([none; LANES]) {
            x.push(rest[0]);
            y.push(rest[1]);
            z.push(rest[2]);
            parts.push(part);
            depths.push(depth);
        }
    }

    fn corner(&self, index: usize) -> Corner {
        let rest = self.rests.each_ref().map(|numbers| numbers[index]);
        Corner { rest, part: self.parts[index], depth: self.depths[index] }
    }
}

#[inline(always)]
fn group(numbers: &[f64], start: usize) -> Lanes {
    let mut group = [0.0; LANES];
    group.copy_from_slice(&numbers[start..start + LANES]);
    group
}

impl Patches {
    /// Returns the patches from number `start` on, given the corners above and below them, as `placed` does.
    #[inline(always)]
    fn between([above, below]: [&Corners; 2], start: usize, side: f64, step: f64) -> Self {
        let zero = [0.0; LANES];
        let mut patches = Self { low: [zero; 2], high: [zero; 2], areas: zero, tags: [0; LANES], placed: [0; LANES] };
        let (mut rests, mut parts, mut depths) = ([[zero; 3]; 4], [zero; 4], [zero; 4]);
        for (corner, (row, start)) in
            [(above, start), (above, start + 1), (below, start), (below, start + 1)].into_iter().enumerate()
        {
            for (rests, row) in rests[corner].iter_mut().zip(&row.rests) {
                *rests = group(row, start);
            }
            (parts[corner], depths[corner]) = (group(&row.parts, start), group(&row.depths, start));
        }
        let [a, b, c, d] = rests;
        for lane in 0..LANES {
            let [near, far] = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| {
                of(of(depths[0][lane], depths[1][lane]), of(depths[2][lane], depths[3][lane]))
            });
            let part = parts[0][lane];
            let same = u64::from(part == parts[1][lane])
                & u64::from(part == parts[2][lane])
                & u64::from(part == parts[3][lane]);
            patches.placed[lane] = same & (1 - u64::from(far > near * step));
            let p = [d[0][lane] - a[0][lane], d[1][lane] - a[1][lane], d[2][lane] - a[2][lane]];
            let q = [c[0][lane] - b[0][lane], c[1][lane] - b[1][lane], c[2][lane] - b[2][lane]];
            let x = (p[1] * q[2] - p[2] * q[1]).abs();
            let y = (p[2] * q[0] - p[0] * q[2]).abs();
            let z = (p[0] * q[1] - p[1] * q[0]).abs();
            let is_y = (y >= x) & (y >= z);
            let is_z = !is_y & (z > x);
            let is_x = !is_y & !is_z;
            for axis in 0..2 {
                let kept = |corner: &[Lanes; 3]| {
                    let [x, y, z] = [corner[0][lane], corner[1][lane], corner[2][lane]];
                    if axis == 0 {
                        if is_x { y } else { x }
                    } else if is_z {
                        y
                    } else {
                        z
                    }
                };
                let (a, b, c, d) = (kept(&a), kept(&b), kept(&c), kept(&d));
                patches.low[axis][lane] = a.min(b).min(c.min(d));
                patches.high[axis][lane] = a.max(b).max(c.max(d));
            }
            patches.areas[lane] = if is_y {
                y
            } else if is_z {
                z
            } else {
                x
            } / (2.0 * side * side);
            let axis = if is_y {
                1
            } else if is_z {
                2
            } else {
                0
            };
            patches.tags[lane] = axis + if part < 0.0 { 3 } else { 0 };
        }
        patches
    }

    /// Returns which patches may hold seeds of a layer, one bit each, where the input `size` has the given values.
    #[inline(always)]
    fn seeded(&self, layer: &Layer, sizes: Lanes) -> u8 {
        let Self { low, high, areas, tags, placed } = *self;
        let (mut lower, mut scale) = ([0; LANES], [0.0; LANES]);
        let (mut regular, mut many) = ([0; LANES], [0; LANES]);
        let mut spans = [Span { first: [0.0; LANES], more: [0; LANES] }; 2];
        for lane in 0..LANES {
            let cell = areas[lane] * pixels(layer, sizes[lane]);
            regular[lane] = placed[lane] & u64::from(cell > 1e-30) & u64::from(cell < 1e30);
            // Half the exponent, rounded down.
            lower[lane] = ((cell.to_bits() >> 52).wrapping_add(1) >> 1) as i64 - 512;
            scale[lane] = f64::from_bits(((1023 - lower[lane]) as u64) << 52);
        }
        for axis in 0..2 {
            for lane in 0..LANES {
                let first = (low[axis][lane] * scale[lane]).floor();
                let last = (high[axis][lane] * scale[lane]).floor();
                let is_near = u64::from(first > -FAR) & u64::from(last < FAR) & u64::from(last - first <= 1.0);
                many[lane] |= 1 - is_near;
                spans[axis].first[lane] = first;
                spans[axis].more[lane] = u64::from(last > first);
            }
        }
        let mut held = many;
        for up in 0..2 {
            if up == 1 {
                spans = spans.map(|span| span.halved());
                for scale in &mut scale {
                    *scale *= 0.5;
                }
            }
            let mut grids = [0; LANES];
            for lane in 0..LANES {
                grids[lane] = key(layer.key, (lower[lane] + up) * 8 + tags[lane]);
            }
            let [more_across, more_down] = [spans[0].any_more(), spans[1].any_more()];
            for across in 0..=u64::from(more_across) {
                for down in 0..=u64::from(more_down) {
                    let inside = inside([low, high], spans, [across, down], grids, scale);
                    for lane in 0..LANES {
                        held[lane] |= inside[lane];
                    }
                }
            }
        }
        let mut bits = 0;
        for lane in 0..LANES {
            bits |= ((held[lane] & regular[lane]) as u8) << lane;
        }
        bits
    }
}

impl Span {
    /// Returns the cells of the upper level that contain these.
    #[inline(always)]
    fn halved(mut self) -> Self {
        for lane in 0..LANES {
            let first = (0.5 * self.first[lane]).floor();
            // One more lies in another cell if the first is odd.
            self.more[lane] &= u64::from(2.0 * first < self.first[lane]);
            self.first[lane] = first;
        }
        self
    }

    #[inline(always)]
    fn any_more(&self) -> bool {
        let mut any = 0;
        for more in self.more {
            any |= more;
        }
        any != 0
    }
}

/// Returns 1 for each patch in whose bounding box the point of a cell lies, counted from the first cell, otherwise 0.
#[inline(always)]
fn inside(
    [low, high]: [[Lanes; 2]; 2],
    spans: [Span; 2],
    cell: [u64; 2],
    grids: [u64; LANES],
    scale: Lanes,
) -> [u64; LANES] {
    let mut inside = [0; LANES];
    for lane in 0..LANES {
        let [i, j] = [spans[0].first[lane] + cell[0] as f64, spans[1].first[lane] + cell[1] as f64];
        let known = u64::from(cell[0] <= spans[0].more[lane]) & u64::from(cell[1] <= spans[1].more[lane]);
        let key = key(key(grids[lane], whole(i)), whole(j));
        // The scale is a power of 2, so a comparison of cells is one of points.
        let [x, y] = [i + draw(key, 0), j + draw(key, 1)];
        let across = u64::from(x >= low[0][lane] * scale[lane]) & u64::from(x <= high[0][lane] * scale[lane]);
        let down = u64::from(y >= low[1][lane] * scale[lane]) & u64::from(y <= high[1][lane] * scale[lane]);
        inside[lane] = known & across & down;
    }
    inside
}

#[inline(always)]
fn whole(x: f64) -> i64 {
    ((x + WHOLE).to_bits() as i64).wrapping_sub(WHOLE.to_bits() as i64)
}
