//! The cells of a sea that a camera may see.

use super::bernstein::{DEGREE, Net, SIDE, interpolated, nodes, off};
use super::footprints::Footprints;
use super::region::{Axes, Region};
use super::remainder::{Remainder, remainder};
use super::search::HALVINGS;
use crate::boxes::Tree;
use crate::{Projector, SeaSurface};
use fearless_simd::Level;
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
/// Least half side of a cell, relative to 1 m + the distance from the camera: below it, rounding prevails.
const LEAST: f64 = 1e-9;
/// Most cells, and most bands of cells; a sea that needs more is unclear.
const MOST_CELLS: usize = 400_000;
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

/// Number of cells along each side of the squares of a band.
const PARTS: usize = 3;

/// Squares of equal size, side by side across the heading.
struct Band {
    middle: f64,
    half: f64,
    /// Middle of the first square, and their number.
    first: f64,
    count: usize,
    /// Remainder of a whole square, and of its cells in each of its rows.
    coarse: Remainder,
    fine: [Remainder; PARTS],
}

/// The cells of a sea for one camera.
#[derive(Debug)]
pub(crate) struct SeaCells {
    pub(super) axes: Axes,
    pub(super) region: Region,
    pub(super) footprints: Footprints,
    pub(super) waves: FramedSea,
    pub(super) cells: Vec<Cell>,
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
        let pixels = projector.size[0] * projector.size[1];
        let fine = FINE.into_iter().find(|(most, _)| pixels <= *most).map(|(_, fine)| fine);
        let bands = |fine: f64| bands(sea, &waves, &footprints, &region, fine, stop);
        let bands = match fine.map(bands) {
            None | Some(Err(NoCells::TooMany)) => bands(COARSE)?,
            Some(bands) => bands?,
        };
        let of_band = |band: &Band| {
            if stop() {
                return Err(NoCells::Stopped);
            }
            let middle = |index: usize| band.first + 2.0 * band.half * index as f64;
            let middles: Vec<f64> = (0..band.count).map(middle).collect();
            // Most squares are carried out of sight, which the middles of some and larger ones show at a lower price.
            let middles = near(&waves, &footprints, &region, band, middles);
            let whole = Cell::row(&waves, &footprints, band.middle, &middles, band.half, band.coarse);
            let seen = whole.iter().filter(|cell| !region.misses(cell.bounds()));
            let size = 2.0 * band.half / PARTS as f64;
            let places =
                |middle: f64| (0..PARTS).map(move |part| middle + size * (part as f64 - (PARTS - 1) as f64 / 2.0));
            let across: Vec<f64> = seen.flat_map(|cell| places(cell.middle[1])).collect();
            let along = places(band.middle).zip(band.fine);
            let cells =
                along.flat_map(|(along, fine)| Cell::row(&waves, &footprints, along, &across, size / 2.0, fine));
            Ok(cells.filter(|cell| !region.misses(cell.bounds())).collect())
        };
        let cells: Result<Vec<Vec<Cell>>, NoCells> = bands.par_iter().map(of_band).collect();
        let cells: Vec<Cell> = cells?.into_iter().flatten().collect();
        let tree = Tree::new(&cells.iter().map(Cell::bounds).collect::<Vec<_>>()).ok_or(NoCells::Unseen)?;
        Ok(Self { axes, region, footprints, waves, cells, tree, level: Level::new() })
    }

    /// Returns a smaller cell around a rest point, or `None` where its remainder would not be smaller because of
    /// rounding.
    pub(super) fn smaller(&self, middle: [f64; 2], half: f64, than: &Remainder) -> Option<Cell> {
        // A kink of the footprints between cells is never within one, unless by rounding.
        let away = libm::hypot(middle[0], middle[1]) + half;
        let remainder = remainder(&self.waves, &self.footprints, middle[0], half, away);
        if remainder.off.iter().zip(than.off).all(|(off, than)| *off > 0.5 * than) {
            return None;
        }
        Cell::row(&self.waves, &self.footprints, middle[0], &[middle[1]], half, remainder).pop()
    }
}

/// Returns the middles of those squares of a band that may be carried into sight, from where their middles are.
fn near(waves: &FramedSea, footprints: &Footprints, region: &Region, band: &Band, middles: Vec<f64>) -> Vec<f64> {
    let rows = waves.rows(&[(band.middle, libm::sqrt(footprints.square(band.middle)))], waves.waves().len());
    let mut points = vec![[0.0; 3]; middles.len()];
    waves.squares(&rows, &waves.columns(&[0.0]), &middles, &mut points);
    let Remainder { spread, off, .. } = band.coarse;
    let reach = DVec3::new(band.half, 0.0, band.half) + DVec3::from(spread) + DVec3::from(off);
    let may_be_seen = |(across, point): (&f64, &[f64; 3])| {
        let point = DVec3::new(band.middle, 0.0, *across) + DVec3::from(*point);
        !region.misses([point - reach, point + reach])
    };
    let seen: Vec<bool> = middles.iter().zip(&points).map(may_be_seen).collect();
    middles.into_iter().zip(seen).filter_map(|(middle, is)| is.then_some(middle)).collect()
}

/// Divides what is seen into bands from near to far; remainders of their cells are at most `fine`, relative to the
/// footprint.
fn bands(
    sea: &SeaSurface,
    waves: &FramedSea,
    footprints: &Footprints,
    region: &Region,
    fine: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Band>, NoCells> {
    let [near, far] = region.along().ok_or(NoCells::Unseen)?;
    let (mut from, end) = (near - sea.drift, far + sea.drift);
    let kinks = footprints.kinks();
    let (mut bands, mut cells) = (Vec::new(), 0);
    let mut half = (end - from) / 2.0;
    while from < end {
        if stop() {
            return Err(NoCells::Stopped);
        }
        if bands.len() == MOST_BANDS {
            return Err(NoCells::TooMany);
        }
        let kink = kinks.iter().copied().find(|kink| *kink > from + LEAST * (1.0 + from.abs()));
        let limit = kink.map_or(end, |kink| kink.min(end)) - from;
        half = (half * GROWTH).min(limit / 2.0);
        let cell = |half: f64, part: usize| {
            let size = half / PARTS as f64;
            let middle = from + size * (2 * part + 1) as f64;
            let away = middle.abs() + half + sea.drift;
            (remainder(waves, footprints, middle, size, away), middle)
        };
        let parts = loop {
            // The nearest cells have the smallest footprints, or the last ones for a camera that looks away.
            let sizes = [0, PARTS - 1].map(|part| {
                let (remainder, middle) = cell(half, part);
                let enough = fine * libm::sqrt(footprints.square(middle));
                let size = |axis: usize| remainder.off[axis] / enough.max(ROUNDED * remainder.rounding[axis]);
                // NaN where a wave grows without limit.
                [0, 1, 2].map(|axis| if size(axis).is_nan() { f64::INFINITY } else { size(axis) })
            });
            let largest = sizes.as_flattened().iter().copied().fold(0.0, f64::max);
            if largest <= 1.0 || half <= LEAST * (1.0 + from.abs()) {
                break std::array::from_fn(|part| cell(half, part).0);
            }
            // Remainders grow about as this power of the size.
            half *= libm::pow(largest, -1.0 / SIDE as f64).clamp(LEAST_SHRINKAGE, SHRINKAGE);
        };
        let to = if half >= limit / 2.0 { from + limit } else { from + 2.0 * half };
        let middle = (from + to) / 2.0;
        if let Some([left, right]) = region.across([from - sea.drift, to + sea.drift]) {
            let (left, right) = (left - sea.drift, right + sea.drift);
            let count = ((right - left) / (2.0 * half)).ceil().max(1.0);
            cells += count as usize;
            if cells > MOST_CELLS / PARTS {
                return Err(NoCells::TooMany);
            }
            let first = (left + right) / 2.0 - half * (count - 1.0);
            let coarse = remainder(waves, footprints, middle, half, middle.abs() + half + sea.drift);
            bands.push(Band { middle, half, first, count: count as usize, coarse, fine: parts });
        }
        from = to;
    }
    Ok(bands)
}

impl Cell {
    /// Makes cells of equal size side by side.
    fn row(
        waves: &FramedSea,
        footprints: &Footprints,
        middle: f64,
        middles: &[f64],
        half: f64,
        remainder: Remainder,
    ) -> Vec<Self> {
        let offsets = nodes().map(|node| half * node);
        let rows = waves.rows(
            &offsets.map(|offset| (middle + offset, libm::sqrt(footprints.square(middle + offset)))),
            remainder.waves,
        );
        let mut points = vec![[0.0; 3]; SIDE * SIDE * middles.len()];
        waves.squares(&rows, &waves.columns(&offsets), middles, &mut points);
        let cells = middles.iter().zip(points.chunks_exact(SIDE * SIDE));
        cells.map(|(across, points)| Self::new(points, [middle, *across], half, remainder)).collect()
    }

    fn new(points: &[[f64; 3]], middle: [f64; 2], half: f64, mut remainder: Remainder) -> Self {
        let offsets = nodes();
        // Coefficients relative to a point within the cell are small, and so is their rounding.
        let center = points[SIDE * SIDE / 2];
        let patch = std::array::from_fn(|axis| {
            let values: Net = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let resting = [half * offsets[i], 0.0, half * offsets[j]][axis];
                    (points[SIDE * i + j][axis] - center[axis]) + resting
                })
            });
            let net = interpolated(&values);
            let mut largest = 0.0_f64;
            let rounded = net.map(|row| {
                row.map(|value| {
                    largest = largest.max((value - f64::from(value as f32)).abs());
                    value as f32
                })
            });
            // A patch moves by no more than its coefficients, and its derivatives by the degree times as much, or by
            // the square of the degree times its own distance (Markov's inequality).
            let (degree, off) = (DEGREE as f64, off(&net, &values));
            let size = net.as_flattened().iter().fold(0.0_f64, |size, value| size.max(value.abs()));
            remainder.off[axis] += largest + off + HALVED * size;
            remainder.turn += degree * largest + degree * degree * off;
            rounded
        });
        let [u, v] = middle;
        Self { middle, half, base: DVec3::new(u, 0.0, v) + DVec3::from(center), patch, remainder }
    }

    /// Returns the least box that contains the cell's part of the sea.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        for axis in 0..3 {
            let values = self.patch[axis].as_flattened();
            let least = values.iter().copied().fold(f32::INFINITY, f32::min);
            let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
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

    /// Returns the components along some directions, relative to an origin.
    #[inline(always)]
    pub(super) fn seen_along(&self, origin: DVec3, ways: [DVec3; 3]) -> [Net; 3] {
        let base = self.base - origin;
        ways.map(|way| {
            let start = base.dot(way);
            let [x, y, z] = &self.patch;
            std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let [x, y, z] = [x[i][j], y[i][j], z[i][j]].map(f64::from);
                    start + (x * way.x + y * way.y + z * way.z)
                })
            })
        })
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
