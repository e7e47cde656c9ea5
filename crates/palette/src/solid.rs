//! Palettes of clouds whose hull has a volume.

use crate::Cloud;
use crate::corner::{Data, Merges, descend, merge};
use crate::found::{Enclosing, Outside, Palette, Short};
use crate::grid::{Gridded, snap};
use crate::mesh::Mesh;
use crate::order::{names, order};
use crate::together::{Fit, fewer, together};
use crate::vector::{Point, mean};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trochoid_weights::Hull;

/// Most colors of a palette, beside prior ones.
pub(crate) const MOST: usize = 12;
/// Number of corners up to which the hull is simplified once for all runs.
const START: usize = 24;
/// Runs that merge corners by chance, beside the one that always takes the best.
const RUNS: u64 = 8;

/// Numbers drawn by a seed (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014).
pub(crate) struct Draws(pub(crate) u64);

impl Draws {
    /// Returns a number from 0 to 1.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Returns points with others around them, along each axis.
pub(crate) fn thickened(points: &[Point], by: f64) -> Vec<Point> {
    let mut all = Vec::with_capacity(6 * points.len());
    for point in points {
        for c in 0..3 {
            for step in [-by, by] {
                let mut near = *point;
                near[c] = (near[c] + step).clamp(0.0, 255.0);
                all.push(near);
            }
        }
    }
    all
}

/// A cloud whose hull, with that of the prior colors, has a volume.
pub(crate) struct Solid<'c> {
    data: Data,
    hull: Mesh,
    /// How far a pixel may lie outside, in steps of 8 bits.
    within: f64,
    /// Names of the prior colors.
    names: &'c [String],
    cloud: &'c Cloud,
    extremes: &'c [Point],
    /// Corners of the hull of the pixels alone.
    corners: Vec<[u8; 3]>,
}

/// Hulls that enclose all colors, by their number of corners beside prior ones.
type Hulls = BTreeMap<usize, Mesh>;

fn note(hulls: &mut Hulls, mesh: Mesh) {
    let count = mesh.count();
    if hulls.get(&count).is_none_or(|known| mesh.volume < known.volume) {
        hulls.insert(count, mesh);
    }
}

impl<'c> Solid<'c> {
    /// Prepares a cloud with these extreme colors. `around` are the corners of its hull, perhaps with a thickness; no
    /// pixel may lie farther outside of a palette than `within`, in steps of 8 bits; and `prior` colors are in each
    /// palette, as points, with their names.
    pub(crate) fn new(
        cloud: &'c Cloud,
        extremes: &'c [Point],
        around: &[Point],
        within: f64,
        (prior, names): (&[Point], &'c [String]),
    ) -> Option<Self> {
        let hull = Mesh::new(around, prior)?;
        let data = Data {
            corners: hull.corners.clone(),
            inside: mean(&hull.corners),
            prior: prior.to_vec(),
            is_nearest: false,
        };
        let corners = around.iter().map(|corner| corner.map(|v| v as u8)).collect();
        Some(Self { data, hull, within, names, cloud, extremes, corners })
    }

    /// Returns the palettes that enclose all colors, and those of fewer colors that do not.
    pub(crate) fn palettes(&self) -> (Vec<Enclosing>, Vec<Short>) {
        let mut hulls = self.merged();
        let beyond = self.fewer(&mut hulls);
        let rounded: Vec<Option<Enclosing>> =
            hulls.range(..=MOST).collect::<Vec<_>>().into_par_iter().map(|(_, hull)| self.rounded(hull)).collect();
        let mut found: Vec<Enclosing> = rounded.into_iter().flatten().collect();
        // More colors are of no use in a larger hull.
        let mut least = f64::INFINITY;
        found.retain(|palette| {
            let is_smaller = palette.volume < least;
            least = least.min(palette.volume);
            is_smaller
        });
        let least = found.first().map_or(MOST + 1, |found| found.count() - self.data.prior.len());
        let near: Vec<&Fit> = beyond.range(..least).map(|(_, fit)| fit).filter(|_| self.within > 0.0).collect();
        let near: Vec<Option<Enclosing>> = near.into_par_iter().map(|fit| self.near(fit)).collect();
        found.splice(0..0, near.into_iter().flatten());
        let short = beyond.iter().filter(|(count, _)| **count < least).rev().take(2);
        let mut short: Vec<Short> = short.map(|(_, fit)| self.short(fit)).collect();
        short.reverse();
        (found, short)
    }

    /// Returns the least number of corners beside the prior ones that can span space.
    fn least(&self) -> usize {
        4_usize.saturating_sub(self.data.prior.len())
    }

    /// Merges corners in several runs.
    fn merged(&self) -> Hulls {
        let mut known = Merges::default();
        let mut start = self.hull.clone();
        while start.count() > START {
            match merge(&start, &self.data, &mut known, 0.0) {
                Some(merged) => start = merged,
                None => break,
            }
        }
        let run = |run: u64| {
            let mut draws = Draws(run);
            let (mut known, mut hulls, mut mesh) = (Merges::default(), Hulls::new(), start.clone());
            if mesh.count() <= MOST + 4 {
                note(&mut hulls, mesh.clone());
            }
            while mesh.count() > self.least() {
                let chance = if run == 0 { 0.0 } else { draws.next() };
                let Some(merged) = merge(&mesh, &self.data, &mut known, chance) else { break };
                mesh = merged;
                if mesh.count() <= 14 {
                    mesh = descend(mesh, &self.data, if run == 0 { 6 } else { 3 });
                }
                if mesh.count() <= MOST + 4 {
                    note(&mut hulls, mesh.clone());
                }
            }
            hulls
        };
        let runs: Vec<Hulls> = (0..=RUNS).into_par_iter().map(run).collect();
        let mut hulls = Hulls::new();
        runs.into_iter().flatten().for_each(|(_, mesh)| note(&mut hulls, mesh));
        // The corners of a box always enclose.
        if hulls.keys().next().is_none_or(|least| *least > 8) {
            let ends = |c: usize| {
                let channel = self.data.corners.iter().map(|corner| corner[c]);
                [channel.clone().fold(255.0, f64::min).floor(), channel.fold(0.0, f64::max).ceil()]
            };
            let ends = [0, 1, 2].map(ends);
            let corner = |index: usize| [0, 1, 2].map(|c| ends[c][index >> c & 1]);
            if let Some(mesh) = self.data.hull(&(0..8).map(corner).collect::<Vec<_>>()) {
                note(&mut hulls, mesh);
            }
        }
        hulls
    }

    /// Goes on to fewer corners than merging reaches; returns the hulls that do not enclose all colors.
    fn fewer(&self, hulls: &mut Hulls) -> BTreeMap<usize, Fit> {
        let mut beyond: BTreeMap<usize, Fit> = BTreeMap::new();
        let Some(first) = hulls.keys().next().copied() else { return beyond };
        let mut count = first.max(self.least() + 1);
        while count > self.least() {
            let Some(from) = hulls.get(&count).or_else(|| beyond.get(&count).map(|fit| &fit.mesh)) else { break };
            let Some(fit) = fewer(from, &self.data, self.hull.volume) else { break };
            let is_enclosing = fit.encloses() && hulls.contains_key(&count);
            count -= 1;
            if is_enclosing {
                note(hulls, fit.mesh);
            } else if !hulls.contains_key(&count) {
                beyond.insert(count, fit);
            }
        }
        beyond
    }

    /// Rounds a hull to a grid, as coarse as one that still encloses all colors can be.
    fn rounded(&self, hull: &Mesh) -> Option<Enclosing> {
        let mut best: Option<(f64, Gridded)> = None;
        let consider = |best: &mut Option<(f64, Gridded)>, points: &[Point], units: i64| {
            let Some(gridded) = Gridded::round(points, &self.data.prior, units) else { return };
            let Some(mesh) = self.data.hull(&gridded.points()[self.data.prior.len()..]) else { return };
            let is_better = best.as_ref().is_none_or(|(volume, _)| mesh.volume < *volume);
            if is_better && mesh.count() == hull.count() && gridded.outside(self.corners.iter().copied()) == Some(0) {
                *best = Some((mesh.volume, gridded));
            }
        };
        let volume = self.hull.volume;
        let own = hull.own();
        // Where rounding finds no room, a little more is enclosed.
        for margin in [0.0, 0.5, 1.0, 2.0] {
            let data = self.around(margin);
            let fit = together(&own, &data, volume, 30, 4.0).filter(Fit::encloses).map(|fit| fit.mesh.own());
            let plain = (margin == 0.0).then(|| own.clone());
            for points in fit.iter().chain(&plain) {
                if let Some(snapped) = snap(points, &self.data, 1.0) {
                    consider(&mut best, &snapped, 1);
                }
                consider(&mut best, points, 1);
            }
            if best.is_some() {
                break;
            }
        }
        for (units, margin) in [(16, 0.0), (16, 0.1), (256, 0.01), (256, 0.03), (256, 0.1), (256, 0.3)] {
            if best.is_some() {
                break;
            }
            let data = self.around(margin);
            let fit = together(&own, &data, volume, 40, 4.0).map(|fit| fit.mesh.own());
            for points in fit.iter().chain([&own]) {
                if margin == 0.0
                    && let Some(snapped) = snap(points, &self.data, 1.0 / units as f64)
                {
                    consider(&mut best, &snapped, units);
                }
                consider(&mut best, points, units);
            }
        }
        let (volume, gridded) = best?;
        // The claim is counted on all colors.
        (gridded.outside(self.cloud.enclosed()) == Some(0)).then(|| {
            let palette = self.palette(&gridded.points(), gridded.units as u32);
            Enclosing::new(palette, volume / self.hull.volume, self.extremes, Outside::default())
        })
    }

    /// Moves the corners of a hull that does not enclose all colors to where the farthest of these is nearest; `None` if it
    /// is farther than allowed.
    fn near(&self, fit: &Fit) -> Option<Enclosing> {
        let data = Data { is_nearest: true, ..self.data.clone() };
        let fit = together(&fit.mesh.own(), &data, self.hull.volume, 60, 6.0)?;
        let volume = fit.mesh.volume / self.hull.volume;
        [1, 16, 256].into_iter().find_map(|units| {
            let gridded = Gridded::round(&fit.mesh.own(), &self.data.prior, units)?;
            let palette = self.palette(&gridded.points(), units as u32);
            palette.is_near(self.extremes, self.within).then(|| {
                let outside = palette.outside(self.cloud);
                Enclosing::new(palette, volume, self.extremes, outside)
            })
        })
    }

    /// Returns the colors with others around them.
    fn around(&self, margin: f64) -> Data {
        if margin == 0.0 {
            return self.data.clone();
        }
        let thick = Mesh::new(&thickened(&self.data.corners, margin), &[]);
        thick.map_or_else(|| self.data.clone(), |mesh| Data { corners: mesh.corners, ..self.data.clone() })
    }

    /// Orders and names points, of which the prior ones come first.
    fn palette(&self, points: &[Point], units: u32) -> Palette {
        let mut colors: Vec<[f64; 3]> = points.iter().map(|point| point.map(|v| v / 255.0)).collect();
        let added = colors.split_off(self.names.len());
        colors.extend(order(&added).into_iter().map(|index| added[index]));
        Palette { names: names(&colors, self.names), colors, units }
    }

    /// Judges a hull that does not enclose all colors, on all pixels.
    fn short(&self, fit: &Fit) -> Short {
        let own = fit.mesh.own().into_iter().map(|point| point.map(f64::round));
        let points: Vec<Point> = self.data.prior.iter().copied().chain(own).collect();
        let hull = Hull::new(&points.iter().map(|point| point.map(|v| v as f32)).collect::<Vec<_>>());
        let outside = Outside::of(&hull, self.cloud);
        let share = outside.pixels as f64 / self.cloud.pixels().max(1) as f64;
        Short { colors: self.palette(&points, 1).colors, share, outside }
    }
}
