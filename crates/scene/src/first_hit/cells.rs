//! The cells of a sea that a camera may see.

use super::bernstein::{DEGREE, Net, SIDE, bent_bases_at, interpolated, larger, nodes, off};
use super::footprints::Footprints;
use super::near::PatchPoint;
use super::region::{Axes, Region};
use super::remainder::{CELL, Remainder, SQUARE, remainder, spread};
use super::search::HALVINGS;
use super::sizes::WaveSizes;
use super::squares::{PARTS, POINTS, Squares};
use crate::boxes::Tree;
use crate::{Projector, SeaSurface};
use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;
use rayon::prelude::*;
use trochoid_sea::FramedSea;

/// Remainders at which a cell is small enough, relative to the footprint, for pictures with up to some number of pixels.
/// Finer cells cost more once, but rays near contours need smaller ones of their own less often, which cost most.
const FINE: [(f64, f64); 2] = [(262_144.0, 3e-6), (1_048_576.0, 1e-5)];
/// The same for all others, and for seas that need too many cells otherwise.
const COARSE: f64 = 1e-4;
/// Remainder at which a cell is small enough, relative to what rounding leaves of it.
const ROUNDED: f64 = 2.0;
/// Factors by which a cell's side may grow from one band to the next, and by which it shrinks until it is small enough.
const GROWTH: f64 = 1.25;
const SHRINKAGE: f64 = 0.97;
const LEAST_SHRINKAGE: f64 = 0.5;
/// Share of the remainder that is due to the cells themselves, not to the squares from which they are made.
const OWN: f64 = 0.9;
/// Least half side of a cell, relative to 1 m + the distance from the camera: below it, rounding prevails.
const LEAST: f64 = 1e-9;
/// Most squares of cells, and most bands of squares; a sea that needs more is unclear.
const MOST_SQUARES: usize = 40_000;
const MOST_BANDS: usize = 4000;

/// Rounding error of a part of a patch in a ray's coordinates, relative to the patch's coefficients: each halving rounds
/// eight times, and a component along a direction five times, values up to four times as large.
const HALVED: f64 = 4.0 * (8 * HALVINGS + 5) as f64 * f64::EPSILON;

/// A square of rest points, as a patch.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Rest point at its middle: u, v.
    pub(super) middle: [f64; 2],
    pub(super) half: f64,
    /// Point from which the patch is measured: u, height, v.
    base: DVec3,
    /// Coefficients of the components, relative to the base.
    patch: [[[f32; SIDE]; SIDE]; 3],
    pub(super) remainder: Remainder,
}

/// Squares of equal size, side by side across the heading.
struct Band {
    middle: f64,
    half: f64,
    /// Middle of the first square, and their number.
    first: f64,
    count: usize,
    /// Remainder of a whole square, and of its cells in each of its rows.
    whole: Remainder,
    cells: [Remainder; PARTS],
}

/// The cells of a band that the view may see, and their boxes.
type CellsOfBand = (Vec<Cell>, Vec<[DVec3; 2]>);

/// The cells of a sea for one camera.
#[derive(Debug)]
pub(crate) struct SeaCells {
    pub(super) axes: Axes,
    pub(super) region: Region,
    pub(super) footprints: Footprints,
    pub(super) waves: FramedSea,
    sizes: WaveSizes,
    /// They lie where they were made: moving them takes longer than finding them.
    cells: Vec<Vec<Cell>>,
    /// Where each cell lies.
    places: Vec<[u32; 2]>,
    pub(super) tree: Tree,
    /// Instructions that the machine has.
    pub(super) level: Level,
}

/// Why there are no cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoCells {
    /// The camera sees nothing of the sea.
    Unseen,
    /// There would be too many.
    TooMany,
    /// They are no longer needed.
    Stopped,
}

impl SeaCells {
    /// Divides the part of a sea that a camera may see, on all threads.
    ///
    /// # Errors
    /// There are none, or too many; or `stop` said that the result is no longer needed.
    pub(crate) fn new(
        sea: &SeaSurface,
        projector: &Projector,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, NoCells> {
        let axes = Axes::new(sea, projector);
        let region = Region::new(sea, projector, &axes);
        let footprints = Footprints::new(sea, projector);
        let waves = FramedSea::new(&sea.frame, [axes.eye.x, axes.eye.z], axes.heading);
        let sizes = WaveSizes::new(&waves);
        let pixels = projector.size[0] * projector.size[1];
        let fine = FINE.into_iter().find(|(most, _)| pixels <= *most).map(|(_, fine)| fine);
        let bands = |fine: f64| bands(sea, &sizes, &footprints, &region, fine, stop);
        let bands = match fine.map(bands) {
            None | Some(Err(NoCells::TooMany)) => bands(COARSE)?,
            Some(bands) => bands?,
        };
        let level = Level::new();
        let of_band = |band: &Band| {
            if stop() {
                return Err(NoCells::Stopped);
            }
            let squares = Squares::new(&waves, &footprints, band.middle, band.half, &band.whole);
            let half = band.half / PARTS as f64;
            let seen = seen(&waves, &footprints, &region, band);
            let most = seen.len() * PARTS * PARTS;
            let (mut cells, mut bounds) = (Vec::with_capacity(most), Vec::with_capacity(most));
            for across in seen {
                let displacements = squares.displacements(across);
                dispatch!(level, simd => simd.vectorize(
                    #[inline(always)]
                    || for (row, remainder) in band.cells.iter().enumerate() {
                        let remainder = remainder.with(&displacements.rounding);
                        for column in 0..PARTS {
                            let place = |middle: f64, part: usize| middle + half * ((2 * part + 1) as f64 - PARTS as f64);
                            let middle = [place(band.middle, row), place(across, column)];
                            let cell = Cell::new(&displacements.of_cell([row, column]), middle, half, remainder);
                            let own = cell.bounds();
                            if !region.misses(own) {
                                cells.push(cell);
                                bounds.push(own);
                            }
                        }
                    }
                ));
            }
            Ok((cells, bounds))
        };
        let of_bands: Result<Vec<CellsOfBand>, NoCells> = bands.par_iter().map(of_band).collect();
        let (cells, bounds): (Vec<_>, Vec<_>) = of_bands?.into_iter().unzip();
        let places_of =
            |(band, cells): (usize, &Vec<Cell>)| (0..cells.len()).map(move |cell| [band as u32, cell as u32]);
        let places = cells.iter().enumerate().flat_map(places_of).collect();
        let tree = Tree::new(&bounds.concat()).ok_or(NoCells::Unseen)?;
        Ok(Self { axes, region, footprints, waves, sizes, cells, places, tree, level })
    }

    /// Returns how many cells there are.
    pub(super) fn count(&self) -> usize {
        self.places.len()
    }

    /// Returns a cell by its number in the tree.
    pub(super) fn cell(&self, number: usize) -> &Cell {
        let [band, cell] = self.places[number];
        &self.cells[band as usize][cell as usize]
    }

    /// Returns a smaller cell around a rest point, or `None` where its remainder would not be smaller because of
    /// rounding.
    pub(super) fn smaller(&self, middle: [f64; 2], half: f64, than: &Remainder) -> Option<Cell> {
        // A kink of the footprints between cells is never within one, unless by rounding.
        let away = libm::hypot(middle[0], middle[1]) + half;
        let remainder = remainder(&self.sizes, &self.footprints, &CELL, middle[0], half, away);
        if remainder.off.iter().zip(than.off).all(|(off, than)| *off > 0.5 * than) {
            return None;
        }
        Some(Cell::alone(&self.waves, &self.footprints, middle, half, remainder))
    }
}

/// Number of points along each side of a square from which it is told whether waves may carry it into sight.
const LOOKS: usize = 3;

/// Returns the middles of those squares of a band that waves may carry into sight.
fn seen(waves: &FramedSea, footprints: &Footprints, region: &Region, band: &Band) -> Vec<f64> {
    let middles: Vec<f64> = (0..band.count).map(|index| band.first + 2.0 * band.half * index as f64).collect();
    let half = band.half / LOOKS as f64;
    let offsets: [f64; LOOKS] = std::array::from_fn(|part| half * ((2 * part + 1) as f64 - LOOKS as f64));
    let places = offsets.map(|offset| (band.middle + offset, libm::sqrt(footprints.square(band.middle + offset))));
    let all = 0..waves.waves().len();
    let rows = waves.rows(&places, all.clone());
    let mut points = vec![[0.0; 3]; LOOKS * LOOKS * middles.len()];
    waves.squares(&rows, &waves.columns(&offsets, all), &middles, &mut points);
    let away = band.middle.abs() + band.half;
    let reaches = places
        .map(|(along, _)| DVec3::new(half, 0.0, half) + DVec3::from(spread(waves, footprints, along, half, away)));
    let may_be_seen = |(across, points): (&f64, &[[f64; 3]])| {
        points.iter().enumerate().any(|(index, point)| {
            let (row, column) = (index / LOOKS, index % LOOKS);
            let point = DVec3::new(places[row].0, 0.0, across + offsets[column]) + DVec3::from(*point);
            !region.misses([point - reaches[row], point + reaches[row]])
        })
    };
    let seen = middles.iter().zip(points.chunks_exact(LOOKS * LOOKS)).map(may_be_seen);
    middles.iter().zip(seen).filter_map(|(middle, is)| is.then_some(*middle)).collect()
}

/// Divides what is seen into bands from near to far; remainders of their cells are at most `fine`, relative to the
/// footprint.
fn bands(
    sea: &SeaSurface,
    waves: &WaveSizes,
    footprints: &Footprints,
    region: &Region,
    fine: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Band>, NoCells> {
    let [near, far] = region.along().ok_or(NoCells::Unseen)?;
    let (mut from, end) = (near - sea.drift, far + sea.drift);
    let kinks = footprints.kinks();
    let (mut bands, mut squares) = (Vec::new(), 0);
    // The largest that may be small enough, wherever the next kink is.
    let mut largest = end - from;
    while from < end {
        if stop() {
            return Err(NoCells::Stopped);
        }
        if bands.len() == MOST_BANDS {
            return Err(NoCells::TooMany);
        }
        let kink = kinks.iter().copied().find(|kink| *kink > from + LEAST * (1.0 + from.abs()));
        let limit = kink.map_or(end, |kink| kink.min(end)) - from;
        let mut half = largest.min(limit / 2.0);
        let away = |half: f64| (from + half).abs() + half + sea.drift;
        let whole = |half: f64| remainder(waves, footprints, &SQUARE, from + half, half, away(half));
        let cell = |half: f64, part: usize| {
            let size = half / PARTS as f64;
            let middle = from + size * (2 * part + 1) as f64;
            (remainder(waves, footprints, &CELL, middle, size, away(half)), middle)
        };
        let (whole, cells) = loop {
            let square = whole(half);
            // The nearest cells have the smallest footprints, or the last ones for a camera that looks away.
            let ends = [cell(half, 0), cell(half, PARTS - 1)];
            let sizes = ends.map(|(own, middle)| {
                let all = own.with(&square);
                let enough = fine * libm::sqrt(footprints.square(middle));
                let limits = all.rounding.map(|rounding| enough.max(ROUNDED * rounding));
                [own.relative_to(limits), all.relative_to(limits)]
            });
            let [own, all] = [0, 1].map(|which| sizes[0][which].max(sizes[1][which]));
            if all <= 1.0 || half <= LEAST * (1.0 + from.abs()) {
                let cells = std::array::from_fn(|part| match part {
                    0 => ends[0].0,
                    part if part == PARTS - 1 => ends[1].0,
                    part => cell(half, part).0,
                });
                break (square, cells.map(|cell| cell.with(&square)));
            }
            // Remainders grow about as these powers of the size.
            let by_cells = libm::pow(own / OWN, -1.0 / SIDE as f64);
            let by_square = libm::pow((all - own) / (1.0 - OWN), -1.0 / POINTS as f64);
            half *= by_cells.min(by_square).clamp(LEAST_SHRINKAGE, SHRINKAGE);
        };
        let to = if half >= limit / 2.0 { from + limit } else { from + 2.0 * half };
        if half < largest.min(limit / 2.0) {
            largest = half;
        }
        largest *= GROWTH;
        let middle = (from + to) / 2.0;
        if let Some([left, right]) = region.across([from - sea.drift, to + sea.drift]) {
            let (left, right) = (left - sea.drift, right + sea.drift);
            let count = ((right - left) / (2.0 * half)).ceil().max(1.0);
            squares += count as usize;
            if squares > MOST_SQUARES {
                return Err(NoCells::TooMany);
            }
            let first = (left + right) / 2.0 - half * (count - 1.0);
            bands.push(Band { middle, half, first, count: count as usize, whole, cells });
        }
        from = to;
    }
    Ok(bands)
}

impl Cell {
    /// Makes a cell from sums of its own.
    fn alone(waves: &FramedSea, footprints: &Footprints, middle: [f64; 2], half: f64, remainder: Remainder) -> Self {
        let offsets = nodes::<SIDE>().map(|node| half * node);
        let places = offsets.map(|offset| (middle[0] + offset, libm::sqrt(footprints.square(middle[0] + offset))));
        let mut points = [[0.0; 3]; SIDE * SIDE];
        let own = 0..remainder.waves;
        let rows = waves.rows(&places, own.clone());
        waves.squares(&rows, &waves.columns(&offsets, own), &[middle[1]], &mut points);
        Self::new(&points, middle, half, remainder)
    }

    #[inline(always)]
    fn new(points: &[[f64; 3]; SIDE * SIDE], middle: [f64; 2], half: f64, mut remainder: Remainder) -> Self {
        let offsets = nodes::<SIDE>();
        // Coefficients relative to a point within the cell are small, and so is their rounding.
        let center = points[SIDE * SIDE / 2];
        let mut patch = [[[0.0_f32; SIDE]; SIDE]; 3];
        // Loops, because closures of arrays are functions of their own, without the instructions of this one.
        for (axis, patch) in patch.iter_mut().enumerate() {
            let mut values: Net = [[0.0; SIDE]; SIDE];
            for (i, values) in values.iter_mut().enumerate() {
                for (j, value) in values.iter_mut().enumerate() {
                    let resting = [half * offsets[i], 0.0, half * offsets[j]][axis];
                    *value = (points[SIDE * i + j][axis] - center[axis]) + resting;
                }
            }
            let net = interpolated(&values);
            let (mut largest, mut size, mut all) = (0.0_f64, 0.0_f64, 0.0);
            for (rounded, row) in patch.iter_mut().zip(&net) {
                for (rounded, value) in rounded.iter_mut().zip(row) {
                    *rounded = *value as f32;
                    largest = larger(largest, (value - f64::from(*rounded)).abs());
                    size = larger(size, value.abs());
                    all += value;
                }
            }
            // A patch moves by no more than its coefficients, and its derivatives by the degree times as much, or by
            // the square of the degree times its own distance (Markov's inequality).
            let (degree, off) = (DEGREE as f64, if all.is_finite() { off() * size } else { f64::INFINITY });
            remainder.off[axis] += largest + off + HALVED * size;
            remainder.turn += degree * largest + degree * degree * off;
            remainder.even += degree * largest;
        }
        let [u, v] = middle;
        Self { middle, half, base: DVec3::new(u, 0.0, v) + DVec3::from(center), patch, remainder }
    }

    /// Returns the least box that contains the cell's part of the sea.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        for axis in 0..3 {
            let values = self.patch[axis].as_flattened();
            // Not by `f32::min`: see `bernstein::range`.
            let least = values.iter().fold(f32::INFINITY, |least, value| if *value < least { *value } else { least });
            let most = values.iter().fold(f32::NEG_INFINITY, |most, value| if *value > most { *value } else { most });
            let off = self.remainder.off[axis];
            (low[axis], high[axis]) =
                (self.base[axis] + f64::from(least) - off, self.base[axis] + f64::from(most) + off);
        }
        [low, high]
    }

    /// Returns how far the sea may lie from the patch, along a direction.
    #[inline(always)]
    pub(super) fn slack(&self, way: DVec3) -> f64 {
        way.abs().dot(DVec3::from(self.remainder.off))
    }

    /// Returns the component along a direction, relative to an origin.
    #[inline(always)]
    pub(super) fn seen_along(&self, origin: DVec3, way: DVec3) -> Net {
        let start = (self.base - origin).dot(way);
        let [x, y, z] = &self.patch;
        let (x, y, z) = (x.as_flattened(), y.as_flattened(), z.as_flattened());
        let mut net = [[0.0; SIDE]; SIDE];
        for (value, ((x, y), z)) in net.as_flattened_mut().iter_mut().zip(x.iter().zip(y).zip(z)) {
            *value = start + (f64::from(*x) * way.x + f64::from(*y) * way.y + f64::from(*z) * way.z);
        }
        net
    }

    /// Returns the patch and its derivatives at a place in the unit square.
    pub(super) fn patch_at(&self, level: Level, [s, t]: [f64; 2]) -> PatchPoint {
        let (by_s, by_t) = (bent_bases_at(s), bent_bases_at(t));
        // Rows by each derivative along s.
        let mut rows = [[[0.0; SIDE]; 3]; 3];
        dispatch!(level, simd => simd.vectorize(
            #[inline(always)]
            || for (rows, patch) in rows.iter_mut().zip(&self.patch) {
                for (order, row) in rows.iter_mut().enumerate() {
                    for (factor, values) in by_s[order].iter().zip(patch) {
                        for (sum, value) in row.iter_mut().zip(values) {
                            *sum += factor * f64::from(*value);
                        }
                    }
                }
            }
        ));
        let of = |order_s: usize, order_t: usize| {
            let sum = |axis: usize| -> f64 {
                let row: &[f64; SIDE] = &rows[axis][order_s];
                row.iter().zip(by_t[order_t]).map(|(value, factor)| value * factor).sum()
            };
            DVec3::new(sum(0), sum(1), sum(2))
        };
        let side = 2.0 * self.half;
        PatchPoint {
            point: self.base + of(0, 0),
            by: [of(1, 0) / side, of(0, 1) / side],
            bend: (of(2, 0) + of(0, 2)) / (side * side),
        }
    }

    /// Returns the rest point at a place in the unit square.
    pub(super) fn rest(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        [self.middle[0] + self.half * (2.0 * s - 1.0), self.middle[1] + self.half * (2.0 * t - 1.0)]
    }

    /// Returns the place in the unit square of a rest point, as a point in the axes of the cells.
    pub(super) fn place(&self, rest: DVec3) -> [f64; 2] {
        [(rest.x, self.middle[0]), (rest.z, self.middle[1])].map(|(at, middle)| 0.5 + 0.5 * (at - middle) / self.half)
    }
}
