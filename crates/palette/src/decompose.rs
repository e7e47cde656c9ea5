//! Weights of colors over a palette.
//!
//! Weights are a function of the color alone, so the same color has the same weights in every picture and every frame:
//!
//! ω(p) = argmin Σ ωᵢhᵢ + T Σ ωᵢ ln ωᵢ, with Σω = 1 and ΣωC = p, hence ωᵢ ∝ exp((λ·Cᵢ − hᵢ)/T),
//!
//! with the heights hᵢ = |Cᵢ − C̄|²/range², the softness T, and the multipliers λ. For T → 0 that is the Delaunay
//! triangulation of the palette. It is evaluated at the nodes of a lattice: each simplex of that triangulation is cut 16
//! times along its edges (Freudenthal), and between the nodes weights are interpolated linearly, which keeps their sum,
//! their signs, and the color that they mix. The lattice is the definition.

use crate::block::Block;
use crate::lattice::Lattice;
use crate::simplex::{Frame, Simplex, nearest, nearest_of_triangle, triangulate};
use crate::vector::{Point, add, dot, mean, scale, sub};
use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;
use trochoid_weights::{Apportioner, BLOCK, Storing};

/// Pixels that are taken apart in one piece.
const SLICE: usize = 4096;
/// How far outside of a simplex a point may lie by rounding, in barycentric coordinates.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A palette onto which pictures are taken apart.
///
/// ```
/// use trochoid_palette::Decomposer;
/// let inks = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let inks = Decomposer::new(&inks, 0.2).ok_or("no colors")?;
/// let weights = inks.weights([0.25, 0.25, 0.25]);
/// assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12 && weights.iter().all(|weight| *weight >= 0.0));
/// assert!((weights[1] - 0.25).abs() < 1e-9);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug)]
pub struct Decomposer {
    colors: Vec<Point>,
    pub(crate) frame: Frame,
    /// Coordinates of the colors in the frame.
    points: Vec<Point>,
    pub(crate) simplices: Vec<Simplex>,
    /// Facets of the hull, in coordinates of the frame: triangles, or segments and points that repeat corners.
    facets: Vec<[Point; 3]>,
    pub(crate) lattice: Lattice,
}

/// Most colors onto which a picture is taken apart.
pub const MOST_COLORS: usize = 24;

impl Decomposer {
    /// Prepares a palette of displayed colors, with a softness from 0, for few colors a pixel and sharp changes, to 1.
    /// `None` without colors, with more than 24, or if a number is not finite.
    #[must_use]
    pub fn new(colors: &[[f64; 3]], softness: f64) -> Option<Self> {
        let is_sound = (1..=MOST_COLORS).contains(&colors.len()) && softness.is_finite() && softness >= 0.0;
        if !is_sound || colors.iter().flatten().any(|v| !v.is_finite()) {
            return None;
        }
        let frame = Frame::new(colors);
        let points: Vec<Point> = colors.iter().map(|color| frame.of(*color)).collect();
        let center = mean(colors);
        let range = (0..3).map(|c| {
            let channel = colors.iter().map(|color| color[c]);
            channel.clone().fold(f64::NEG_INFINITY, f64::max) - channel.fold(f64::INFINITY, f64::min)
        });
        let range = range.fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        let heights: Vec<f64> =
            colors.iter().map(|color| dot(sub(*color, center), sub(*color, center)) / (range * range)).collect();
        let simplices = triangulate(&points, &heights, frame.dimension());
        let boundary = boundary(&simplices);
        let lattice = Lattice::new(&points, &heights, &simplices, &boundary, softness);
        let facet = |corners: &Vec<usize>| {
            let last = corners.len().checked_sub(1)?;
            Some([0, 1, 2].map(|at| points[corners[last.min(at)]]))
        };
        let facets = boundary.iter().filter_map(facet).collect();
        Some(Self { colors: colors.to_vec(), frame, points, simplices, facets, lattice })
    }

    /// Returns the colors of the palette.
    #[must_use]
    pub fn colors(&self) -> &[[f64; 3]] {
        &self.colors
    }

    /// Returns the weights of a displayed color, which are ≥ 0 and sum to 1. Those of a color outside of the hull are
    /// those of its nearest point.
    #[must_use]
    pub fn weights(&self, color: [f64; 3]) -> Vec<f64> {
        let point = self.frame.of(color);
        let Some((simplex, parts)) = self.found(point, 0) else { return nearest(&self.points, point) };
        let mut weights = vec![0.0; self.colors.len()];
        self.lattice.interpolate(simplex, self.frame.dimension(), parts, &mut weights);
        weights
    }

    /// Returns the weights of displayed colors as they are stored, a plane for each color of the palette. They are the
    /// same however the colors are divided into slices, and with any number of threads. Also returns the largest weight
    /// that storing moved from some colors to others at a pixel.
    ///
    /// ```
    /// use trochoid_palette::Decomposer;
    /// use trochoid_weights::Storing;
    /// let gray = Decomposer::new(&[[0.0; 3], [1.0; 3]], 0.0).ok_or("no colors")?;
    /// let (planes, moved) = gray.planes(&[[0.25; 3], [1.0; 3]], Storing::Float);
    /// assert_eq!((&planes[0][..], &planes[1][..], moved), (&[0.75, 0.0][..], &[0.25, 1.0][..], 0.0));
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub fn planes(&self, colors: &[[f32; 3]], storing: Storing) -> (Vec<Vec<f32>>, f64) {
        let mut planes = vec![vec![0.0; colors.len()]; self.colors.len()];
        let mut slices: Vec<Vec<&mut [f32]>> = colors.chunks(SLICE).map(|_| Vec::new()).collect();
        for plane in &mut planes {
            slices.iter_mut().zip(plane.chunks_mut(SLICE)).for_each(|(slice, part)| slice.push(part));
        }
        let parts = slices.into_par_iter().zip(colors.par_chunks(SLICE));
        let moved = parts.map(|(mut slice, colors)| self.fill(colors, storing, &mut slice)).reduce(|| 0.0, f64::max);
        (planes, moved)
    }

    /// Does the same on one thread, into a slice of each plane. Returns the largest weight that storing moved.
    pub fn fill(&self, colors: &[[f32; 3]], storing: Storing, planes: &mut [&mut [f32]]) -> f64 {
        let level = Level::new();
        let (mut near, mut block, mut apportioner) = (0, Block::new(self.colors.len()), Apportioner::new(storing));
        let mut moved = 0.0_f64;
        for (run, colors) in colors.chunks(BLOCK).enumerate() {
            if self.simplices.is_empty() {
                colors.iter().enumerate().for_each(|(x, color)| {
                    let weights = self.weights(color.map(f64::from));
                    block.weights.iter_mut().zip(weights).for_each(|(own, weight)| own[x] = weight);
                });
            } else {
                dispatch!(level, simd => simd.vectorize(#[inline(always)] || block.weigh(self, colors, &mut near)));
            }
            moved = moved.max(apportioner.block(&mut block.weights[..self.colors.len()]));
            for (plane, weights) in planes.iter_mut().zip(&block.weights) {
                let plane = plane[run * BLOCK..].iter_mut().zip(&weights[..colors.len()]);
                plane.for_each(|(stored, weight)| *stored = *weight as f32);
            }
        }
        moved
    }

    /// Returns the simplex in which a point lies, and its coordinates. The search starts at the simplex of a similar color,
    /// which does not change the result.
    pub(crate) fn found(&self, point: Point, near: usize) -> Option<(usize, [f64; 4])> {
        // A point well inside of a simplex is in no other one.
        let known = self.simplices.get(near).map(|simplex| (simplex, simplex.coordinates(point)));
        let known = known.filter(|(simplex, parts)| simplex.least_of(parts) > ROUNDING);
        known.map(|(_, parts)| (near, parts)).or_else(|| self.searched(point))
    }

    /// Returns the simplex in which a point or its nearest one in the hull lies, and that one's coordinates.
    #[cold]
    fn searched(&self, point: Point) -> Option<(usize, [f64; 4])> {
        let (mut simplex, least) = self.located(point)?;
        let mut at = point;
        if least < -ROUNDING {
            at = self.onto(point);
            simplex = self.located(at).map_or(simplex, |(simplex, _)| simplex);
        }
        Some((simplex, self.simplices[simplex].coordinates(at)))
    }

    /// Returns the nearest point of the hull to one outside.
    fn onto(&self, point: Point) -> Point {
        let foot = |facet: &[Point; 3]| {
            let weights = nearest_of_triangle(*facet, point);
            facet.iter().zip(weights).fold([0.0; 3], |sum, (corner, weight)| add(sum, scale(*corner, weight)))
        };
        let distance = |foot: &Point| dot(sub(*foot, point), sub(*foot, point));
        let feet = self.facets.iter().map(foot);
        feet.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(self.points[0])
    }

    /// Returns the simplex whose least barycentric coordinate of a point is the greatest, and that coordinate.
    fn located(&self, point: Point) -> Option<(usize, f64)> {
        let all = self
            .simplices
            .iter()
            .enumerate()
            .map(|(index, simplex)| (index, simplex.least_of(&simplex.coordinates(point))));
        // Of equal ones the first, so that all points of a shared side have the same.
        all.reduce(|best, next| if next.1 > best.1 { next } else { best })
    }
}

/// Returns the facets of the hull: sides of simplices that belong to one simplex only.
fn boundary(simplices: &[Simplex]) -> Vec<Vec<usize>> {
    let sides = |simplex: &Simplex| {
        let without = |left_out: usize| {
            let kept = simplex.corners.iter().enumerate().filter(move |(index, _)| *index != left_out);
            kept.map(|(_, corner)| *corner).collect::<Vec<_>>()
        };
        (0..simplex.corners.len()).map(without).collect::<Vec<_>>()
    };
    let all: Vec<Vec<usize>> = simplices.iter().flat_map(sides).collect();
    all.iter().filter(|side| all.iter().filter(|other| other == side).count() == 1).cloned().collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    const INKS: [[f64; 3]; 7] = [
        [0.04, 0.05, 0.12],
        [0.9, 0.2, 0.15],
        [0.2, 0.55, 0.3],
        [0.1, 0.3, 0.8],
        [0.95, 0.9, 0.4],
        [0.98, 0.97, 0.93],
        [0.45, 0.4, 0.38],
    ];

    fn draws() -> impl FnMut() -> f64 {
        let mut state = 7_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    fn mixed(colors: &[[f64; 3]], weights: &[f64]) -> Point {
        colors.iter().zip(weights).fold([0.0; 3], |sum, (color, weight)| add(sum, scale(*color, *weight)))
    }

    #[test]
    fn colors_of_the_hull_are_mixed_again() {
        let mut draw = draws();
        for softness in [0.0, 0.05, 0.2, 1.0] {
            for count in [1, 2, 3, 4, 5, 7] {
                let inks = &INKS[..count];
                let decomposer = Decomposer::new(inks, softness).unwrap();
                for _ in 0..300 {
                    let parts: Vec<f64> = inks.iter().map(|_| -libm::log(draw().max(1e-12))).collect();
                    let sum: f64 = parts.iter().sum();
                    let color = mixed(inks, &parts.iter().map(|part| part / sum).collect::<Vec<_>>());
                    let weights = decomposer.weights(color);
                    assert!(weights.iter().all(|weight| *weight >= 0.0), "{weights:?}");
                    assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                    let off = crate::vector::length(sub(mixed(inks, &weights), color));
                    assert!(off < 1e-6, "{count} colors, softness {softness}: {color:?} off by {off}");
                    let stored: Vec<f64> = Storing::Float.round(&weights).into_iter().map(f64::from).collect();
                    let off = crate::vector::length(sub(mixed(inks, &stored), color));
                    assert!(off < 0.001 / 255.0, "stored, {count} colors: {color:?} off by {off}");
                }
            }
        }
    }

    #[test]
    fn colors_outside_go_to_the_nearest_point() {
        let decomposer = Decomposer::new(&INKS, 0.2).unwrap();
        let mut draw = draws();
        for _ in 0..300 {
            let color = [(); 3].map(|()| 3.0 * draw() - 1.0);
            let weights = decomposer.weights(color);
            let found = mixed(&INKS, &weights);
            let expected = mixed(&INKS, &nearest(&INKS, color));
            let inside = crate::vector::length(sub(expected, color)) < 1e-9;
            assert!(inside || crate::vector::length(sub(found, expected)) < 1e-6, "{color:?}: {found:?}, {expected:?}");
            assert!(weights.iter().all(|weight| *weight >= 0.0));
        }
    }

    #[test]
    fn softness_spreads_weights_and_sharpness_keeps_four() {
        let gray = [0.5, 0.45, 0.42];
        let count = |softness: f64| {
            Decomposer::new(&INKS, softness)
                .unwrap()
                .weights(gray)
                .iter()
                .filter(|weight| **weight > 1.0 / 255.0)
                .count()
        };
        assert!(count(0.0) <= 4 && count(1.0) > 4, "{} {}", count(0.0), count(1.0));
    }

    #[test]
    fn weights_have_no_jumps() {
        for softness in [0.0, 0.2] {
            let decomposer = Decomposer::new(&INKS, softness).unwrap();
            let mut draw = draws();
            for _ in 0..5000 {
                let color = [(); 3].map(|()| 1.4 * draw() - 0.2);
                let near = color.map(|channel| channel + 1e-6 * (2.0 * draw() - 1.0));
                let (a, b) = (decomposer.weights(color), decomposer.weights(near));
                let change: f64 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
                assert!(change < 1e-3, "{color:?}: {change}");
            }
        }
    }

    #[test]
    fn what_is_no_palette_is_refused() {
        assert!(Decomposer::new(&[], 0.2).is_none());
        assert!(Decomposer::new(&[[f64::NAN; 3]], 0.2).is_none());
        assert!(Decomposer::new(&[[0.5; 3]; 25], 0.2).is_none());
        assert!(Decomposer::new(&[[0.5; 3]], f64::NAN).is_none());
        // Colors that occur twice share nothing: the first has it all.
        let twice = Decomposer::new(&[[0.1; 3], [0.9; 3], [0.9; 3]], 0.0).unwrap();
        assert!((twice.weights([0.9; 3]).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn planes_are_the_weights_however_pixels_are_divided() {
        let mut draw = draws();
        // Similar colors beside each other, and some outside.
        let mut at = [0.5; 3];
        let mut color = || {
            at = at.map(|v| (v + 0.2 * (draw() - 0.5)).clamp(-0.1, 1.1));
            at.map(|v| v as f32)
        };
        let colors: Vec<[f32; 3]> = (0..3 * SLICE + 77).map(|_| color()).collect();
        for count in [1, 2, 3, 4, 7] {
            let decomposer = Decomposer::new(&INKS[..count], 0.2).unwrap();
            let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let (planes, moved) = pool(1).install(|| decomposer.planes(&colors, Storing::Float));
            assert_eq!(pool(3).install(|| decomposer.planes(&colors, Storing::Float)), (planes.clone(), moved));
            assert!(moved <= Storing::Float.error(count, 1.0), "{moved}");
            for (from, to) in [(0, 100), (1, 4097), (5000, 5001), (SLICE, colors.len())] {
                let (part, _) = decomposer.planes(&colors[from..to], Storing::Float);
                assert!(part.iter().zip(&planes).all(|(part, plane)| *part == plane[from..to]), "{count}: {from}");
            }
            for index in (0..colors.len()).step_by(37) {
                let alone = Storing::Float.round(&decomposer.weights(colors[index].map(f64::from)));
                assert!(alone.iter().zip(&planes).all(|(weight, plane)| *weight == plane[index]), "{count}: {index}");
            }
        }
        assert_eq!(Decomposer::new(&INKS, 0.2).unwrap().planes(&[], Storing::Half), (vec![Vec::new(); 7], 0.0));
    }
}
