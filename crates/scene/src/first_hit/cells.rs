//! The cells of a sea that a camera may see.

use super::bernstein::{Net, SIDE, interpolated, nodes};
use super::footprints::Footprints;
use super::region::{Axes, Region};
use super::remainder::{Remainder, remainder};
use crate::boxes::Tree;
use crate::{Projector, SeaSurface};
use glam::DVec3;
use rayon::prelude::*;
use trochoid_sea::{ColumnFactors, FramedSea, RowFactors};

/// Remainder at which a cell is small enough, relative to the footprint.
const FINE: f64 = 1e-4;
/// Factors by which a cell's side may grow from one band to the next, and by which it shrinks until it is small enough.
const GROWTH: f64 = 1.25;
const SHRINKAGE: f64 = 0.88;
/// Least half side of a cell, relative to 1 m + the distance from the camera: below it, rounding prevails.
const LEAST: f64 = 1e-9;
/// Most cells, and most bands of cells; a sea that needs more is searched ray by ray.
const MOST_CELLS: usize = 400_000;
const MOST_BANDS: usize = 20_000;

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

/// Cells of equal size, side by side across the heading.
struct Band {
    middle: f64,
    half: f64,
    first: f64,
    count: usize,
    remainder: Remainder,
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
    /// Divides the part of a sea that a camera may see, on all threads or on this one alone.
    ///
    /// # Errors
    /// There are none, or too many; or `stop` said that the result is no longer needed.
    pub(crate) fn new(
        sea: &SeaSurface,
        projector: &Projector,
        on_all_threads: bool,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, NoCells> {
        let axes = Axes::new(sea, projector);
        let region = Region::new(sea, projector, &axes);
        let footprints = Footprints::new(sea, projector);
        let waves = FramedSea::new(&sea.frame, [axes.eye.x, axes.eye.z], axes.heading);
        let bands = bands(sea, &waves, &footprints, &region, stop)?;
        let offsets = nodes();
        let of_band = |band: &Band| {
            if stop() {
                return Err(NoCells::Stopped);
            }
            let rows = waves.rows(&offsets.map(|node| {
                let u = band.middle + band.half * node;
                (u, libm::sqrt(footprints.square(u)))
            }));
            let columns = waves.columns(&offsets.map(|node| band.half * node));
            let make = |index: usize| {
                let v = band.first + 2.0 * band.half * index as f64;
                Cell::new(&waves, &rows, &columns, [band.middle, v], band.half, band.remainder)
            };
            Ok((0..band.count).map(make).filter(|cell| !region.misses(cell.bounds())).collect())
        };
        let cells: Result<Vec<Vec<Cell>>, NoCells> = if on_all_threads {
            bands.par_iter().map(of_band).collect()
        } else {
            bands.iter().map(of_band).collect()
        };
        let cells: Vec<Cell> = cells?.into_iter().flatten().collect();
        let tree = Tree::new(&cells.iter().map(Cell::bounds).collect::<Vec<_>>()).ok_or(NoCells::Unseen)?;
        Ok(Self { axes, region, footprints, waves, cells, tree })
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
        let offsets = nodes().map(|node| half * node);
        let rows = self.waves.rows(&offsets.map(|offset| {
            let u = middle[0] + offset;
            (u, libm::sqrt(self.footprints.square(u)))
        }));
        Some(Cell::new(&self.waves, &rows, &self.waves.columns(&offsets), middle, half, remainder))
    }
}

/// Divides what is seen into bands from near to far.
fn bands(
    sea: &SeaSurface,
    waves: &FramedSea,
    footprints: &Footprints,
    region: &Region,
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
        let remainder = loop {
            let middle = from + half;
            let remainder = remainder(waves, footprints, middle, half, middle.abs() + half + sea.drift);
            let fine = FINE * libm::sqrt(footprints.square(middle));
            let least = half <= LEAST * (1.0 + middle.abs());
            if remainder.off.iter().all(|off| *off <= fine) || least {
                break remainder;
            }
            half *= SHRINKAGE;
        };
        let to = if half >= limit / 2.0 { from + limit } else { from + 2.0 * half };
        let middle = (from + to) / 2.0;
        if let Some([left, right]) = region.across([from - sea.drift, to + sea.drift]) {
            let (left, right) = (left - sea.drift, right + sea.drift);
            let count = ((right - left) / (2.0 * half)).ceil().max(1.0);
            cells += count as usize;
            if cells > MOST_CELLS {
                return Err(NoCells::TooMany);
            }
            let first = (left + right) / 2.0 - half * (count - 1.0);
            bands.push(Band { middle, half, first, count: count as usize, remainder });
        }
        from = to;
    }
    Ok(bands)
}

impl Cell {
    fn new(
        waves: &FramedSea,
        rows: &RowFactors,
        columns: &ColumnFactors,
        middle: [f64; 2],
        half: f64,
        remainder: Remainder,
    ) -> Self {
        let mut points = [[0.0; 3]; SIDE * SIDE];
        waves.square(rows, columns, middle[1], &mut points);
        let offsets = nodes();
        let nets: [Net; 3] = std::array::from_fn(|axis| {
            interpolated(&std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let resting = [half * offsets[i], 0.0, half * offsets[j]][axis];
                    points[SIDE * i + j][axis] + resting
                })
            }))
        });
        let center = DVec3::from(nets.each_ref().map(|net| net[SIDE / 2][SIDE / 2]));
        let mut remainder = remainder;
        let patch = std::array::from_fn(|axis| {
            let mut largest = 0.0_f64;
            let net = nets[axis].map(|row| {
                row.map(|value| {
                    let moved = value - center[axis];
                    largest = largest.max((moved - f64::from(moved as f32)).abs());
                    moved as f32
                })
            });
            // A patch moves by no more than its coefficients.
            remainder.off[axis] += largest;
            net
        });
        let [u, v] = middle;
        Self { middle, half, base: DVec3::new(u, 0.0, v) + center, patch, remainder }
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

    /// Returns the components along some directions, relative to an origin.
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
}
