//! Adds bursts to fields, tile by tile: the cost is proportional to the area that they cover.

use std::f32::consts::{PI, TAU};

use fearless_simd::{Level, Simd, dispatch, f32x16, prelude::*};
use rayon::prelude::*;

use crate::kernel::sincos_turns;

use super::field::moved;
use super::{Combine, Shape};

/// Size of a tile in cells: the data of a thread stay in the nearest cache.
const TILE_COLUMNS: usize = 64;
const TILE_ROWS: usize = 32;
const TILE: usize = TILE_COLUMNS * TILE_ROWS;
const LANES: usize = 16;
/// Number of drift fields: weight, cosine and sine along, cosine and sine across.
pub(crate) const DRIFTS: usize = 5;
/// Number of turns beyond which an angle has no precision left.
const MOST_TURNS: f32 = 1_048_576.0;
const LANE: [f32; LANES] = [0., 1., 2., 3., 4., 5., 6., 7., 8., 9., 10., 11., 12., 13., 14., 15.];

/// Values below this count as 0; decaying values would otherwise become subnormal numbers, which are slow.
pub(crate) const FLUSH: f32 = 1e-30;

/// 1 + cos(π√(1−v)) = v²·q(v): the coefficients of q, minimax on 0…1, v²·q to 1.8e-8.
const PROFILE: [f32; 5] = [1.233_706_1, 0.616_794_7, 0.132_064_37, 0.015_862_306, 0.001_572_572_8];
/// cos 1 and sin 1: the printed profile is cos(d + 1).
const COS_1: f32 = 0.540_302_3;
const SIN_1: f32 = 0.841_470_96;

/// One burst at one time, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stamp {
    /// Position.
    pub(crate) place: [f64; 2],
    /// Coefficients of x², 2xz, z² in the square of the distance, which is 1 where the profile ends.
    pub(crate) form: [f32; 3],
    /// Factor of the profile.
    pub(crate) factor: f32,
    /// Half the sides of the box that it touches.
    pub(crate) reach: [f64; 2],
    pub(crate) drift: Option<DriftStamp>,
}

/// What a burst adds to drift coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DriftStamp {
    pub(crate) heading: [f32; 2],
    /// Inverse radii along and across, in 1/cells.
    pub(crate) inverse: [f32; 2],
    /// Turns per cell.
    pub(crate) turns: f32,
    /// Distance that the burst has come, and its lane, in turns.
    pub(crate) along: f32,
    pub(crate) lane: f32,
    pub(crate) lag: f32,
    /// Square of the distance in cells over which the lag is rounded off.
    pub(crate) soft: f32,
    pub(crate) weight: f32,
}

/// How a step adds to the rift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RiftStep {
    pub(crate) combine: Combine,
    /// Distance, in cells.
    pub(crate) distance: f32,
    /// Amount that is added for each cell of d − m.
    pub(crate) gain: f32,
    /// Share of the sum that is left.
    pub(crate) left: f32,
}

/// How a step adds to drift coordinates: the amount that it adds, the share of the previous sum that is left, and the
/// share that each unit of weight renews.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DriftStep {
    pub(crate) gain: f32,
    pub(crate) left: f32,
    pub(crate) renewal: f32,
}

/// Bins of bursts, kept from step to step to reuse their memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Splat {
    starts: Vec<u32>,
    members: Vec<u32>,
    boxes: Vec<[u32; 4]>,
}

impl Splat {
    pub(crate) fn bytes(&self) -> usize {
        (self.starts.capacity() + self.members.capacity()) * size_of::<u32>()
            + self.boxes.capacity() * size_of::<[u32; 4]>()
    }
}

/// Fields of a step; empty fields are not touched.
#[derive(Default)]
pub(crate) struct StepFields<'a> {
    /// Forces, or velocities that bursts change.
    pub(crate) force: &'a mut [f32],
    /// Heights that then move by these velocities.
    pub(crate) height: &'a mut [f32],
    pub(crate) rift: &'a mut [f32],
    /// Weight, and the two phases.
    pub(crate) drift: [&'a mut [f32]; DRIFTS],
}

/// How bursts change the fields of a step.
#[derive(Clone, Copy)]
pub(crate) struct Gains {
    /// Factor of what is added to forces.
    pub(crate) force: f32,
    pub(crate) rift: Option<RiftStep>,
    pub(crate) drift: Option<DriftStep>,
}

/// Scratch buffers of one tile.
struct Tile {
    force: [f32; TILE],
    /// The sum of d − m, or the least m².
    rift: [f32; TILE],
    drift: [[f32; TILE]; DRIFTS],
}

/// Position of a tile.
#[derive(Clone, Copy)]
struct TilePlace {
    column: usize,
    row: usize,
    rows: usize,
}

impl Splat {
    /// Adds bursts to the fields of a grid, in each cell in the order of the bursts.
    pub(crate) fn add(
        &mut self,
        stamps: &[Stamp],
        shape: Shape,
        [columns, rows]: [usize; 2],
        gains: Gains,
        fields: StepFields<'_>,
    ) {
        let across = columns.div_ceil(TILE_COLUMNS);
        self.bin(stamps, across, [columns, rows]);
        // Far away the printed profile is constant; bursts add the difference from it within their radius.
        let far = match shape {
            Shape::Intended => 0.0,
            Shape::Literal => -f64::from(COS_1) * stamps.iter().map(|stamp| f64::from(stamp.factor)).sum::<f64>(),
        };
        let level = Level::new();
        let StepFields { force, height, rift, drift } = fields;
        let band = columns * TILE_ROWS;
        let mut bands: Vec<StepFields<'_>> = Vec::with_capacity(rows.div_ceil(TILE_ROWS));
        let mut rifts = rift.chunks_mut(band);
        let mut drifts = drift.map(|values| values.chunks_mut(band));
        let (mut forces, mut heights) = (force.chunks_mut(band), height.chunks_mut(band));
        for _ in 0..rows.div_ceil(TILE_ROWS) {
            bands.push(StepFields {
                force: forces.next().unwrap_or_default(),
                height: heights.next().unwrap_or_default(),
                rift: rifts.next().unwrap_or_default(),
                drift: drifts.each_mut().map(|values| values.next().unwrap_or_default()),
            });
        }
        let this = &*self;
        bands.into_par_iter().enumerate().for_each(|(index, mut band)| {
            let mut tile = Tile { force: [0.0; TILE], rift: [0.0; TILE], drift: [[0.0; TILE]; DRIFTS] };
            let row = index * TILE_ROWS;
            for tile_column in 0..across {
                let bin = index * across + tile_column;
                let members = &this.members[this.starts[bin] as usize..this.starts[bin + 1] as usize];
                let place = TilePlace { column: tile_column * TILE_COLUMNS, row, rows: (rows - row).min(TILE_ROWS) };
                let step = Step { stamps, members, shape, base: far as f32, gains };
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                    step.tile(simd, place, columns, &mut tile, &mut band);
                }));
            }
        });
    }

    /// Sorts bursts into the tiles that they touch, in their own order.
    fn bin(&mut self, stamps: &[Stamp], across: usize, [columns, rows]: [usize; 2]) {
        let down = rows.div_ceil(TILE_ROWS);
        self.starts.clear();
        self.starts.resize(across * down + 1, 0);
        self.boxes.clear();
        for stamp in stamps {
            let range = |axis: usize, cells: usize, tile: usize| {
                let low = (stamp.place[axis] - stamp.reach[axis]).ceil().max(0.0);
                let high = (stamp.place[axis] + stamp.reach[axis]).floor().min(cells as f64 - 1.0);
                // An empty range if no tile is touched.
                if low <= high { [low as u32 / tile as u32, high as u32 / tile as u32 + 1] } else { [0, 0] }
            };
            let ([x0, x1], [y0, y1]) = (range(0, columns, TILE_COLUMNS), range(1, rows, TILE_ROWS));
            for y in y0..y1 {
                for x in x0..x1 {
                    self.starts[(y as usize) * across + x as usize + 1] += 1;
                }
            }
            self.boxes.push([x0, x1, y0, y1]);
        }
        for bin in 0..across * down {
            self.starts[bin + 1] += self.starts[bin];
        }
        self.members.clear();
        self.members.resize(self.starts[across * down] as usize, 0);
        for (index, &[x0, x1, y0, y1]) in self.boxes.iter().enumerate() {
            for y in y0..y1 {
                for x in x0..x1 {
                    let next = &mut self.starts[y as usize * across + x as usize];
                    self.members[*next as usize] = index as u32;
                    *next += 1;
                }
            }
        }
        // Each start has moved to its bin's end, which is the next bin's start.
        self.starts.rotate_right(1);
        self.starts[0] = 0;
    }
}

/// Inputs of one tile.
#[derive(Clone, Copy)]
struct Step<'a> {
    stamps: &'a [Stamp],
    members: &'a [u32],
    shape: Shape,
    /// Amount that is added everywhere.
    base: f32,
    gains: Gains,
}

/// What the kernel adds to forces, if anything.
const INTENDED: u8 = 1;
const LITERAL: u8 = 2;
/// How the kernel treats rifts, if at all.
const NONE: u8 = 0;
const SUM: u8 = 1;
const NEAREST: u8 = 2;

impl Step<'_> {
    #[inline(always)]
    fn tile<S: Simd>(&self, simd: S, place: TilePlace, columns: usize, tile: &mut Tile, band: &mut StepFields<'_>) {
        if !self.members.is_empty() {
            tile.force.fill(self.base);
            let rift = match self.gains.rift {
                None => NONE,
                Some(RiftStep { combine: Combine::Sum, .. }) => {
                    tile.rift.fill(0.0);
                    SUM
                }
                Some(RiftStep { combine: Combine::Nearest, distance, .. }) => {
                    tile.rift.fill(distance * distance);
                    NEAREST
                }
            };
            let shape = (!band.force.is_empty()).then_some(self.shape);
            match (shape, rift) {
                (None, NONE) => {}
                (None, SUM) => self.stamp::<S, NONE, SUM>(simd, place, tile),
                (None, _) => self.stamp::<S, NONE, NEAREST>(simd, place, tile),
                (Some(Shape::Intended), NONE) => self.stamp::<S, INTENDED, NONE>(simd, place, tile),
                (Some(Shape::Intended), SUM) => self.stamp::<S, INTENDED, SUM>(simd, place, tile),
                (Some(Shape::Intended), _) => self.stamp::<S, INTENDED, NEAREST>(simd, place, tile),
                (Some(Shape::Literal), NONE) => self.stamp::<S, LITERAL, NONE>(simd, place, tile),
                (Some(Shape::Literal), SUM) => self.stamp::<S, LITERAL, SUM>(simd, place, tile),
                (Some(Shape::Literal), _) => self.stamp::<S, LITERAL, NEAREST>(simd, place, tile),
            }
            if self.gains.drift.is_some() {
                tile.drift.iter_mut().for_each(|values| values.fill(0.0));
                self.drifts(simd, place, tile);
            }
        }
        self.store(place, columns, tile, band);
    }

    /// Returns the rows and vectors of the tile that a burst touches, and its position in the tile.
    #[inline(always)]
    fn window(stamp: &Stamp, place: TilePlace) -> ([usize; 2], [usize; 2], [f32; 2]) {
        let x = stamp.place[0] - place.column as f64;
        let z = stamp.place[1] - place.row as f64;
        let bound = |value: f64, limit: usize| value.clamp(0.0, limit as f64) as usize;
        let rows =
            [bound((z - stamp.reach[1]).ceil(), place.rows), bound((z + stamp.reach[1]).floor() + 1.0, place.rows)];
        let first = bound((x - stamp.reach[0]).ceil(), TILE_COLUMNS);
        let last = bound((x + stamp.reach[0]).floor() + 1.0, TILE_COLUMNS);
        (rows, [first / LANES, last.div_ceil(LANES)], [x as f32, z as f32])
    }

    #[inline(always)]
    fn stamp<S: Simd, const SHAPE: u8, const RIFT: u8>(&self, simd: S, place: TilePlace, tile: &mut Tile) {
        let lane = f32x16::from_slice(simd, &LANE);
        let zero = f32x16::splat(simd, 0.0);
        let distance = self.gains.rift.map_or(0.0, |rift| rift.distance);
        for &member in self.members {
            let stamp = &self.stamps[member as usize];
            let (rows, vectors, [x, z]) = Self::window(stamp, place);
            let [a, b, c] = stamp.form;
            for vector in vectors[0]..vectors[1] {
                let dx = lane + ((vector * LANES) as f32 - x);
                let (adx, dx2) = (dx * a, dx * dx);
                for row in rows[0]..rows[1] {
                    let dz = row as f32 - z;
                    let at = row * TILE_COLUMNS + vector * LANES;
                    if SHAPE != NONE {
                        // v = 1 − |(u−x)/r|², 0 beyond the radius.
                        let v = ((adx + (b + b) * dz) * dx) * -1.0 + (1.0 - c * dz * dz);
                        let v = v.max(zero);
                        let profile = if SHAPE == LITERAL {
                            // cos(d + 1) + cos 1 with d = π√(1−v), so that it is 0 at the radius.
                            let (sin, cos) = sincos_turns((v * -1.0 + 1.0).max(zero).sqrt() * (PI / TAU));
                            let within = cos * COS_1 - sin * SIN_1 + COS_1;
                            v.simd_gt(zero).select(within, zero)
                        } else {
                            let mut q = v * PROFILE[4] + PROFILE[3];
                            q = q * v + PROFILE[2];
                            q = q * v + PROFILE[1];
                            q = q * v + PROFILE[0];
                            (v * v) * q
                        };
                        let force = &mut tile.force[at..at + LANES];
                        (f32x16::from_slice(simd, force) + profile * stamp.factor).store_slice(force);
                    }
                    if RIFT != NONE {
                        let square = dx2 + dz * dz;
                        let rift = &mut tile.rift[at..at + LANES];
                        let before = f32x16::from_slice(simd, rift);
                        let after = if RIFT == SUM {
                            before + (square.sqrt() * -1.0 + distance).max(zero)
                        } else {
                            before.min(square)
                        };
                        after.store_slice(rift);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn drifts<S: Simd>(&self, simd: S, place: TilePlace, tile: &mut Tile) {
        let lane = f32x16::from_slice(simd, &LANE);
        let zero = f32x16::splat(simd, 0.0);
        // Not a closure, which would be compiled without the instruction set, with a call for every operation.
        #[inline(always)]
        fn angle<S: Simd>(turns: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
            sincos_turns(turns.max(f32x16::splat(turns.simd, -MOST_TURNS)).min(f32x16::splat(turns.simd, MOST_TURNS)))
        }
        for &member in self.members {
            let stamp = &self.stamps[member as usize];
            let Some(drift) = &stamp.drift else { continue };
            let (rows, vectors, [x, z]) = Self::window(stamp, place);
            let [cos, sin] = drift.heading;
            for vector in vectors[0]..vectors[1] {
                let dx = lane + ((vector * LANES) as f32 - x);
                for row in rows[0]..rows[1] {
                    let dz = row as f32 - z;
                    let at = row * TILE_COLUMNS + vector * LANES;
                    let along = dx * cos + dz * sin;
                    let across = dx * -sin + dz * cos;
                    let (p, q) = (along * drift.inverse[0], across * drift.inverse[1]);
                    let left = ((p * p + q * q) * -1.0 + 1.0).max(zero);
                    let weight = (left * left) * drift.weight;
                    let swept = (across * across + drift.soft).sqrt() * drift.lag;
                    let (along_sin, along_cos) = angle((along - swept) * drift.turns + drift.along);
                    let (across_sin, across_cos) = angle(across * drift.turns + drift.lane);
                    let sums =
                        [weight, weight * along_cos, weight * along_sin, weight * across_cos, weight * across_sin];
                    for (values, sum) in tile.drift.iter_mut().zip(sums) {
                        let values = &mut values[at..at + LANES];
                        (f32x16::from_slice(simd, values) + sum).store_slice(values);
                    }
                }
            }
        }
    }

    /// Adds the tile's sums to the fields.
    #[inline(always)]
    fn store(&self, place: TilePlace, columns: usize, tile: &Tile, band: &mut StepFields<'_>) {
        let touched = !self.members.is_empty();
        let width = (columns - place.column).min(TILE_COLUMNS);
        for row in 0..place.rows {
            let at = row * columns + place.column;
            let sums = row * TILE_COLUMNS..row * TILE_COLUMNS + width;
            if band.force.is_empty() {
                // Only trails are simulated.
            } else if touched {
                for (force, &sum) in band.force[at..at + width].iter_mut().zip(&tile.force[sums.clone()]) {
                    *force += self.gains.force * sum;
                }
            } else if self.base != 0.0 {
                band.force[at..at + width].iter_mut().for_each(|force| *force += self.gains.force * self.base);
            }
            if !band.height.is_empty() {
                for (height, velocity) in band.height[at..at + width].iter_mut().zip(&band.force[at..at + width]) {
                    *height = moved(*height, *velocity);
                }
            }
            if let Some(rift) = self.gains.rift {
                let values = band.rift[at..at + width].iter_mut().zip(&tile.rift[sums.clone()]);
                match rift.combine {
                    _ if !touched => values.for_each(|(value, _)| *value = flushed(*value * rift.left)),
                    Combine::Sum => {
                        values.for_each(|(value, &sum)| *value = flushed(*value * rift.left + rift.gain * sum));
                    }
                    Combine::Nearest => values.for_each(|(value, &square)| {
                        let near = rift.distance - square.sqrt();
                        *value = flushed(*value * rift.left + rift.gain * near);
                    }),
                }
            }
            if let Some(drift) = self.gains.drift {
                for (field, added) in band.drift.iter_mut().zip(&tile.drift) {
                    let values = field[at..at + width].iter_mut().zip(&added[sums.clone()]);
                    if touched {
                        values.zip(&tile.drift[0][sums.clone()]).for_each(|((value, &sum), &weight)| {
                            let kept = 1.0 / (1.0 + drift.renewal * weight);
                            *value = flushed((*value * drift.left + drift.gain * sum) * kept);
                        });
                    } else {
                        values.for_each(|(value, _)| *value = flushed(*value * drift.left));
                    }
                }
            }
        }
    }
}

#[inline(always)]
pub(crate) fn flushed(value: f32) -> f32 {
    if value.abs() < FLUSH { 0.0 } else { value }
}
