//! Finds palettes that enclose a cloud of colors.

use crate::Cloud;
use crate::corner::{Data, Merges, descend, merge};
use crate::grid::{Gridded, snap};
use crate::mesh::Mesh;
use crate::order::{names, order};
use crate::together::{Fit, fewer, together};
use crate::vector::{Point, length, mean, sub};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trochoid_weights::Hull;

/// Most colors of a palette.
const MOST: usize = 12;
/// Number of corners up to which the hull is simplified once for all runs.
const START: usize = 24;
/// Runs that merge corners by chance, beside the one that always takes the best.
const RUNS: u64 = 8;
/// Volume up to which a palette is the default, relative to that of the pixels' hull: palettes of fewer colors are loud.
const QUIET: f64 = 2.5;

/// A palette that encloses every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Enclosing {
    /// Colors as displayed, from 0 to 1, the darkest first.
    pub colors: Vec<[f64; 3]>,
    /// A name for each color, by its lightness and hue.
    pub names: Vec<String>,
    /// Parts into which the grid of the colors divides a step of 8 bits: 1, 16 or 256.
    pub units: u32,
    /// Volume of the hull, relative to that of the pixels' hull; 1 if that has none.
    pub volume: f64,
    /// Distance of each color from the nearest pixel, in steps of 8 bits.
    pub distances: Vec<f64>,
}

impl Enclosing {
    /// Returns how pixels lie outside of the palette's hull: those of a larger cloud than it was made for.
    #[must_use]
    pub fn outside(&self, cloud: &Cloud) -> Outside {
        let points: Vec<Point> = self.colors.iter().map(|color| color.map(|v| 255.0 * v)).collect();
        Outside::of(&points, cloud)
    }
}

/// Pixels outside of a hull.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outside {
    /// Number of pixels outside.
    pub pixels: u64,
    /// Largest distance of a pixel from the hull, in steps of 8 bits.
    pub largest: f64,
    /// Root mean square of the distances of all pixels, in steps of 8 bits.
    pub rms: f64,
}

impl Outside {
    fn of(points: &[Point], cloud: &Cloud) -> Self {
        let hull = Hull::new(&points.iter().map(|point| point.map(|v| v as f32)).collect::<Vec<_>>());
        let mut all = Self::default();
        let mut squares = 0.0;
        for (color, count) in cloud.colors() {
            let distance = hull.signed_distance(color.map(f64::from));
            // Corners are exact in f32, on any of the grids.
            if distance > 1e-9 {
                all.pixels += u64::from(count);
                all.largest = all.largest.max(distance);
                squares += distance * distance * f64::from(count);
            }
        }
        all.rms = (squares / cloud.pixels().max(1) as f64).sqrt();
        all
    }
}

/// A palette of fewer colors than any that was found to enclose every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Short {
    /// Colors as displayed, from 0 to 1, the darkest first, in whole steps of 8 bits.
    pub colors: Vec<[f64; 3]>,
    /// Share of the pixels that lie outside.
    pub outside: f64,
    /// Largest distance of a pixel from the hull, in steps of 8 bits.
    pub largest: f64,
    /// Root mean square of the distances of all pixels, in steps of 8 bits.
    pub rms: f64,
}

/// Palettes of a cloud.
#[derive(Clone, Debug, PartialEq)]
pub struct Extraction {
    /// Number of different colors of the pixels, each rounded to 8 bits.
    pub distinct: usize,
    /// Number of corners of their hull.
    pub corners: usize,
    /// Palettes that enclose every pixel, of up to 12 colors, by their number of colors: each in a smaller hull than those
    /// of fewer colors.
    pub enclosing: Vec<Enclosing>,
    /// Palettes of fewer colors than these, by their number of colors.
    pub short: Vec<Short>,
}

impl Extraction {
    /// Returns the palette to take if nobody asks for a number of colors: the one of the fewest colors whose hull has at
    /// most 2.5 times the volume of the pixels' hull, in whole steps of 8 bits if there is one; or else the one of the
    /// least volume.
    #[must_use]
    pub fn usual(&self) -> Option<&Enclosing> {
        let quiet = || self.enclosing.iter().filter(|palette| palette.volume <= QUIET);
        let whole = quiet().find(|palette| palette.units == 1);
        whole.or_else(|| quiet().next()).or_else(|| self.enclosing.iter().min_by(|a, b| a.volume.total_cmp(&b.volume)))
    }

    /// Returns the palette of a number of colors that encloses every pixel.
    #[must_use]
    pub fn of(&self, colors: usize) -> Option<&Enclosing> {
        self.enclosing.iter().find(|palette| palette.colors.len() == colors)
    }
}

/// Finds palettes of a cloud. The same cloud has the same palettes; without pixels, it has none.
///
/// The hull of the colors is simplified by merging joined corners, always by a corner that still encloses them, in
/// several runs from 24 corners on; then all corners are moved at once, by a sequence of linear programs; and they are
/// rounded to a grid. Each palette that is returned was counted to have no color outside, in whole numbers.
///
/// ```
/// use trochoid_palette::{Cloud, extract};
/// let mut cloud = Cloud::new();
/// for step in 0..=20 {
///     cloud.add([10 + step, 20 + 2 * step, 30]);
/// }
/// let found = extract(&cloud);
/// assert_eq!(found.usual().map(|palette| palette.colors.len()), Some(2));
/// ```
#[must_use]
pub fn extract(cloud: &Cloud) -> Extraction {
    let distinct = cloud.colors().count();
    let extremes = cloud.extremes();
    let hull = Hull::new(&extremes.iter().map(|color| color.map(|v| v as f32)).collect::<Vec<_>>());
    let corners: Vec<Point> = hull.vertices().iter().map(|color| color.map(f64::from)).collect();
    let found = |enclosing, short| Extraction { distinct, corners: corners.len(), enclosing, short };
    match hull.dimension() {
        None => found(Vec::new(), Vec::new()),
        Some(0 | 1) => found(vec![flat(&corners, &extremes)], Vec::new()),
        Some(2) if corners.len() <= MOST => found(vec![flat(&corners, &extremes)], Vec::new()),
        dimension => {
            // A planar cloud gets a thickness, since palettes of few colors are not in its plane.
            let around = if dimension == Some(2) { thickened(&corners, 1.0) } else { corners.clone() };
            let Some(solid) = Solid::new(&around, &extremes) else { return found(Vec::new(), Vec::new()) };
            let (enclosing, short) = solid.palettes(cloud);
            found(enclosing, short)
        }
    }
}

/// Returns points with others around them, along each axis.
fn thickened(points: &[Point], by: f64) -> Vec<Point> {
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

fn shown(points: &[Point]) -> Vec<[f64; 3]> {
    points.iter().map(|point| point.map(|v| v / 255.0)).collect()
}

/// Makes a palette of points, in steps of 8 bits.
fn enclosing(points: &[Point], units: i64, volume: f64, extremes: &[Point]) -> Enclosing {
    let colors = shown(points);
    let way = order(&colors);
    let colors: Vec<[f64; 3]> = way.iter().map(|index| colors[*index]).collect();
    let distance = |index: &usize| {
        let nearest = extremes.iter().map(|color| length(sub(*color, points[*index])));
        nearest.fold(f64::INFINITY, f64::min)
    };
    let distances = way.iter().map(distance).collect();
    Enclosing { names: names(&colors), colors, units: units as u32, volume, distances }
}

/// Makes the palette of a cloud without volume: the corners of its hull.
fn flat(corners: &[Point], extremes: &[Point]) -> Enclosing {
    enclosing(corners, 1, 1.0, extremes)
}

/// Numbers drawn by a seed (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014).
struct Draws(u64);

impl Draws {
    /// Returns a number from 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A cloud whose hull has a volume.
struct Solid<'c> {
    data: Data,
    hull: Mesh,
    extremes: &'c [Point],
}

/// Hulls that enclose all colors, by their number of corners.
type Hulls = BTreeMap<usize, Mesh>;

fn note(hulls: &mut Hulls, mesh: Mesh) {
    let count = mesh.count();
    if hulls.get(&count).is_none_or(|known| mesh.volume < known.volume) {
        hulls.insert(count, mesh);
    }
}

impl<'c> Solid<'c> {
    fn new(corners: &[Point], extremes: &'c [Point]) -> Option<Self> {
        let hull = Mesh::new(corners)?;
        let data = Data { inside: mean(&hull.corners), corners: hull.corners.clone() };
        Some(Self { data, hull, extremes })
    }

    fn palettes(&self, cloud: &Cloud) -> (Vec<Enclosing>, Vec<Short>) {
        let mut hulls = self.merged();
        let beyond = self.fewer(&mut hulls);
        let rounded: Vec<Option<Enclosing>> = hulls
            .range(..=MOST)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(_, hull)| self.rounded(hull, cloud))
            .collect();
        let mut found: Vec<Enclosing> = rounded.into_iter().flatten().collect();
        // More colors are of no use in a larger hull.
        let mut least = f64::INFINITY;
        found.retain(|palette| {
            let is_smaller = palette.volume < least;
            least = least.min(palette.volume);
            is_smaller
        });
        let least = found.first().map_or(MOST + 1, |palette| palette.colors.len());
        let short = beyond.iter().filter(|(count, _)| **count < least).rev().take(2);
        let mut short: Vec<Short> = short.filter_map(|(_, fit)| self.short(fit, cloud)).collect();
        short.reverse();
        (found, short)
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
            while mesh.count() > 4 {
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
        hulls
    }

    /// Goes on to fewer corners than merging reaches; returns the hulls that do not enclose all colors.
    fn fewer(&self, hulls: &mut Hulls) -> BTreeMap<usize, Fit> {
        let mut beyond: BTreeMap<usize, Fit> = BTreeMap::new();
        let Some(first) = hulls.keys().next().copied() else { return beyond };
        let mut count = first.max(5);
        while count > 4 {
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
    fn rounded(&self, hull: &Mesh, cloud: &Cloud) -> Option<Enclosing> {
        let mut best: Option<(f64, Gridded)> = None;
        let consider = |best: &mut Option<(f64, Gridded)>, points: &[Point], units: i64| {
            let Some(gridded) = Gridded::round(points, units) else { return };
            let Some(mesh) = Mesh::new(&gridded.points()) else { return };
            let is_better = best.as_ref().is_none_or(|(volume, _)| mesh.volume < *volume);
            let corners = || self.data.corners.iter().map(|corner| corner.map(|v| v as u8));
            if is_better && gridded.corners.len() == hull.count() && gridded.outside(corners()) == Some(0) {
                *best = Some((mesh.volume, gridded));
            }
        };
        let volume = self.hull.volume;
        // Where rounding finds no room, a little more is enclosed.
        for margin in [0.0, 0.5, 1.0, 2.0] {
            let data = self.around(margin);
            let fit = together(&hull.corners, &data, volume, 30, 4.0).filter(Fit::encloses);
            let plain = (margin == 0.0).then_some(hull);
            for mesh in fit.iter().map(|fit| &fit.mesh).chain(plain) {
                if let Some(snapped) = snap(mesh, &self.data, 1.0) {
                    consider(&mut best, &snapped, 1);
                }
                consider(&mut best, &mesh.corners, 1);
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
            let fit = together(&hull.corners, &data, volume, 40, 4.0);
            for mesh in fit.iter().map(|fit| &fit.mesh).chain([hull]) {
                if margin == 0.0
                    && let Some(snapped) = snap(mesh, &self.data, 1.0 / units as f64)
                {
                    consider(&mut best, &snapped, units);
                }
                consider(&mut best, &mesh.corners, units);
            }
        }
        let (volume, gridded) = best?;
        // The claim is counted on all colors.
        (gridded.outside(cloud.enclosed()) == Some(0))
            .then(|| enclosing(&gridded.points(), gridded.units, volume / self.hull.volume, self.extremes))
    }

    /// Returns the colors with others around them.
    fn around(&self, margin: f64) -> Data {
        if margin == 0.0 {
            return self.data.clone();
        }
        let corners = Mesh::new(&thickened(&self.data.corners, margin));
        corners.map_or_else(|| self.data.clone(), |mesh| Data { corners: mesh.corners, inside: self.data.inside })
    }

    /// Judges a hull that does not enclose all colors, on all pixels.
    fn short(&self, fit: &Fit, cloud: &Cloud) -> Option<Short> {
        let points: Vec<Point> = fit.mesh.corners.iter().map(|point| point.map(f64::round)).collect();
        let outside = Outside::of(&points, cloud);
        let colors = shown(&points);
        let colors = order(&colors).into_iter().map(|index| colors[index]).collect();
        let share = outside.pixels as f64 / cloud.pixels().max(1) as f64;
        Some(Short { colors, outside: share, largest: outside.largest, rms: outside.rms })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::add;

    /// A cloud of mixes of some colors, with weights drawn by a seed.
    fn mixes(corners: &[[u8; 3]], count: usize, seed: u64) -> Cloud {
        let mut draws = Draws(seed);
        let mut cloud = Cloud::new();
        corners.iter().for_each(|corner| cloud.add(*corner));
        for _ in 0..count {
            let weights: Vec<f64> = corners.iter().map(|_| -libm::log(draws.next().max(1e-9))).collect();
            let sum: f64 = weights.iter().sum();
            let mixed = corners
                .iter()
                .zip(&weights)
                .fold([0.0; 3], |mixed, (corner, weight)| add(mixed, corner.map(|v| f64::from(v) * weight / sum)));
            cloud.add_between(mixed);
        }
        cloud
    }

    /// Tests that no color of a cloud lies outside of a palette, by the distances of the exact hull.
    fn encloses(palette: &Enclosing, cloud: &Cloud) {
        let scaled = |color: &[f64; 3]| color.map(|v| (v * 255.0) as f32);
        let hull = Hull::new(&palette.colors.iter().map(scaled).collect::<Vec<_>>());
        for color in cloud.enclosed() {
            let distance = hull.signed_distance(color.map(f64::from));
            assert!(distance <= 1e-4, "{color:?} lies {distance} outside of {palette:?}");
        }
    }

    #[test]
    fn mixes_of_some_colors_have_a_palette_of_as_many() {
        for (seed, corners) in [
            vec![[10, 20, 30], [240, 30, 20], [30, 220, 60], [40, 60, 250]],
            vec![[20, 38, 46], [201, 143, 90], [45, 63, 82], [240, 207, 142], [255, 255, 240]],
            vec![[0, 0, 0], [250, 20, 20], [250, 240, 20], [20, 200, 240], [240, 240, 255], [60, 20, 120]],
        ]
        .into_iter()
        .enumerate()
        {
            let cloud = mixes(&corners, 4000, seed as u64);
            let found = extract(&cloud);
            assert!(found.enclosing[0].colors.len() <= corners.len(), "{found:?}");
            assert!(found.usual().is_some_and(|usual| usual.volume <= QUIET));
            for palette in &found.enclosing {
                encloses(palette, &cloud);
                assert_eq!(
                    (palette.names.len(), palette.distances.len()),
                    (palette.colors.len(), palette.colors.len())
                );
                assert!(palette.colors.iter().flatten().all(|v| (0.0..=1.0).contains(v)));
                assert!(palette.volume > 0.999, "{palette:?}");
            }
            assert!(found.enclosing.windows(2).all(|pair| pair[0].colors.len() < pair[1].colors.len()));
        }
    }

    #[test]
    fn the_same_cloud_has_the_same_palettes() {
        let corners = [[20, 38, 46], [201, 143, 90], [45, 63, 82], [240, 207, 142], [255, 255, 240], [90, 0, 60]];
        let found = || extract(&mixes(&corners, 2000, 5));
        assert_eq!(found(), found());
    }

    #[test]
    fn clouds_without_volume_have_the_corners_of_their_hulls() {
        let of = |colors: &[[u8; 3]]| {
            let mut cloud = Cloud::new();
            colors.iter().for_each(|color| cloud.add(*color));
            extract(&cloud)
        };
        assert_eq!(of(&[]).usual(), None);
        let one = of(&[[7, 8, 9], [7, 8, 9]]);
        assert_eq!(
            (one.distinct, one.usual().map(|palette| palette.colors.clone())),
            (1, Some(vec![[7, 8, 9].map(|v| f64::from(v) / 255.0)]))
        );
        let grays: Vec<[u8; 3]> = (3..=250).map(|v| [v; 3]).collect();
        assert_eq!(of(&grays).usual().map(|palette| palette.names.clone()), Some(vec!["black".into(), "white".into()]));
        let plane: Vec<[u8; 3]> = (0..50).flat_map(|x| (0..40).map(move |y| [x, y, 7])).collect();
        assert_eq!(of(&plane).usual().map(|palette| palette.colors.len()), Some(4));
        // A disc has more corners than a palette has colors, so it gets a thickness.
        let disc = (0..=60).flat_map(|x| (0..=60).map(move |y| [x, y, 30])).collect::<Vec<[u8; 3]>>();
        let disc: Vec<[u8; 3]> = disc
            .into_iter()
            .filter(|[x, y, _]| (f64::from(*x) - 30.0).powi(2) + (f64::from(*y) - 30.0).powi(2) <= 900.0)
            .collect();
        let found = of(&disc);
        assert!(found.usual().is_some_and(|palette| palette.colors.len() <= 8), "{found:?}");
    }

    #[test]
    fn noise_has_the_corners_of_the_cube() {
        let mut draws = Draws(9);
        let mut cloud = Cloud::new();
        for _ in 0..200_000 {
            cloud.add([(); 3].map(|()| (256.0 * draws.next()) as u8));
        }
        let found = extract(&cloud);
        let usual = found.usual().expect("the cube encloses everything");
        assert!(usual.colors.len() <= 8 && usual.volume < 1.2, "{usual:?}");
        encloses(usual, &cloud);
        assert!(found.short.iter().all(|short| short.outside > 0.0 && short.largest >= short.rms));
    }
}
