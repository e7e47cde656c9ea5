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

use crate::simplex::{Frame, Simplex, nearest, nearest_of_triangle, solve, triangulate};
use crate::vector::{Point, add, dot, mean, scale, sub};
use rayon::prelude::*;
use trochoid_weights::{Apportioner, BLOCK, Storing};

/// Cuts along an edge of a simplex.
const CUTS: usize = 16;
/// Pixels that are taken apart in one piece.
const SLICE: usize = 4096;
/// How far outside of a simplex a point may lie by rounding, in barycentric coordinates.
const ROUNDING: f64 = 1e-9;

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
    frame: Frame,
    /// Coordinates of the colors in the frame.
    points: Vec<Point>,
    simplices: Vec<Simplex>,
    /// Facets of the hull, in coordinates of the frame: triangles, or segments and points that repeat corners.
    facets: Vec<[Point; 3]>,
    /// Cuts along each edge: 1 without softness.
    cuts: usize,
    /// Weights at the nodes, by simplex, node and color.
    nodes: Vec<f64>,
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
        let cuts = if softness > 0.0 && frame.dimension() > 0 { CUTS } else { 1 };
        let mut found =
            Self { colors: colors.to_vec(), frame, points, simplices, facets: Vec::new(), cuts, nodes: Vec::new() };
        let boundary = found.boundary();
        let facet = |corners: &Vec<usize>| {
            let last = corners.len().checked_sub(1)?;
            Some([0, 1, 2].map(|at| found.points[corners[last.min(at)]]))
        };
        found.facets = boundary.iter().filter_map(facet).collect();
        let nodes = found.simplices.iter().flat_map(|simplex| {
            places(simplex.corners.len(), cuts).into_iter().map(|parts| (simplex, parts)).collect::<Vec<_>>()
        });
        let weights = nodes.flat_map(|(simplex, parts)| {
            let mut plain = vec![0.0; colors.len()];
            simplex.corners.iter().zip(&parts).for_each(|(corner, part)| plain[*corner] = *part as f64 / cuts as f64);
            let used: Vec<usize> =
                simplex.corners.iter().zip(&parts).filter(|(_, part)| **part > 0).map(|(c, _)| *c).collect();
            // On the surface of the hull, only the colors of the facet mix.
            let is_outer = cuts == 1 || boundary.iter().any(|facet| used.iter().all(|corner| facet.contains(corner)));
            if is_outer { plain } else { gibbs(&found.points, &heights, softness, &plain) }
        });
        found.nodes = weights.collect();
        Some(found)
    }

    /// Returns the facets of the hull: sides of simplices that belong to one simplex only.
    fn boundary(&self) -> Vec<Vec<usize>> {
        let sides = |simplex: &Simplex| {
            let without = |left_out: usize| {
                let kept = simplex.corners.iter().enumerate().filter(move |(index, _)| *index != left_out);
                kept.map(|(_, corner)| *corner).collect::<Vec<_>>()
            };
            (0..simplex.corners.len()).map(without).collect::<Vec<_>>()
        };
        let all: Vec<Vec<usize>> = self.simplices.iter().flat_map(sides).collect();
        all.iter().filter(|side| all.iter().filter(|other| other == side).count() == 1).cloned().collect()
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
        let mut weights = vec![0.0; self.colors.len()];
        self.weigh(color, &mut 0, &mut weights);
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
        let count = self.colors.len();
        let (mut near, mut weights, mut blocks) = (0, vec![0.0; count], vec![[0.0; BLOCK]; count]);
        let mut apportioner = Apportioner::new(storing);
        let mut moved = 0.0_f64;
        for (run, colors) in colors.chunks(BLOCK).enumerate() {
            for (pixel, color) in colors.iter().enumerate() {
                self.weigh(color.map(f64::from), &mut near, &mut weights);
                blocks.iter_mut().zip(&weights).for_each(|(block, weight)| block[pixel] = *weight);
            }
            moved = moved.max(apportioner.block(&mut blocks));
            for (plane, block) in planes.iter_mut().zip(&blocks) {
                let plane = plane[run * BLOCK..].iter_mut().zip(&block[..colors.len()]);
                plane.for_each(|(stored, weight)| *stored = *weight as f32);
            }
        }
        moved
    }

    /// Computes the weights of a displayed color. `near` is the simplex of a similar color, where the search starts; it
    /// does not change the result.
    fn weigh(&self, color: [f64; 3], near: &mut usize, weights: &mut [f64]) {
        let point = self.frame.of(color);
        // A point well inside of a simplex is in no other one.
        let known = self.simplices.get(*near).map(|simplex| (simplex, simplex.coordinates(point)));
        let known = known.filter(|(simplex, parts)| simplex.least_of(parts) > ROUNDING);
        match known.map(|(_, parts)| (*near, parts)).or_else(|| self.searched(point)) {
            Some((simplex, parts)) => {
                *near = simplex;
                self.interpolate(simplex, parts, weights);
            }
            None => weights.copy_from_slice(&nearest(&self.points, point)),
        }
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

    /// Interpolates in a simplex at a point with these barycentric coordinates.
    fn interpolate(&self, index: usize, coordinates: [f64; 4], weights: &mut [f64]) {
        let parts = coordinates.map(|part| part.max(0.0));
        let dimension = self.simplices[index].corners.len() - 1;
        let whole = 1.0 / parts.iter().sum::<f64>();
        // Cumulative coordinates fall from the number of cuts to 0; of each, the whole part and the fraction.
        let (mut node, mut fractions) = ([0; 3], [0.0; 3]);
        let (mut left, mut most) = (1.0, self.cuts as u32 - 1);
        for at in 0..dimension {
            left -= parts[at] * whole;
            let coordinate = self.cuts as f64 * left.clamp(0.0, 1.0);
            most = most.min(coordinate as u32);
            node[at] = most as usize;
            fractions[at] = (coordinate - f64::from(most)).clamp(0.0, 1.0);
        }
        // The largest fraction first; of equal ones, the first goes first, so that coordinates keep falling.
        let mut order = [0, 1, 2];
        for (a, b) in [(0, 1), (1, 2), (0, 1)] {
            if b < dimension && fractions[order[b]] > fractions[order[a]] {
                order.swap(a, b);
            }
        }
        let count = self.colors.len();
        let first = index * places_count(dimension + 1, self.cuts);
        // Shares of up to four nodes; those that there are not have none.
        let (mut shares, mut nodes) = ([0.0; 4], [&self.nodes[first * count..][..count]; 4]);
        let mut before = 1.0;
        for step in 0..=dimension {
            let after = if step < dimension { fractions[order[step]] } else { 0.0 };
            shares[step] = before - after;
            if shares[step] > 0.0 {
                nodes[step] = &self.nodes[(first + place(&node[..dimension])) * count..][..count];
            }
            if step < dimension {
                node[order[step]] += 1;
            }
            before = after;
        }
        let [a, b, c, d] = nodes;
        for ((((weight, a), b), c), d) in weights.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *weight = shares[0] * a + shares[1] * b + shares[2] * c + shares[3] * d;
        }
    }
}

/// Returns the number of nodes of a simplex.
fn places_count(corners: usize, cuts: usize) -> usize {
    match corners {
        1 => 1,
        2 => cuts + 1,
        3 => (cuts + 1) * (cuts + 2) / 2,
        _ => (cuts + 1) * (cuts + 2) * (cuts + 3) / 6,
    }
}

/// Returns the index of a node by its falling cumulative coordinates.
fn place(cumulative: &[usize]) -> usize {
    match *cumulative {
        [a] => a,
        [a, b] => a * (a + 1) / 2 + b,
        [a, b, c] => a * (a + 1) * (a + 2) / 6 + b * (b + 1) / 2 + c,
        _ => 0,
    }
}

/// Returns the parts of each corner, of `cuts`, at each node of a simplex, in the order of [`place`].
fn places(corners: usize, cuts: usize) -> Vec<Vec<usize>> {
    let mut nodes = vec![Vec::new(); places_count(corners, cuts)];
    let mut put = |cumulative: &[usize]| {
        let ends = std::iter::once(cuts).chain(cumulative.iter().copied());
        let parts = ends.zip(cumulative.iter().copied().chain([0])).map(|(from, to)| from - to);
        nodes[place(cumulative)] = parts.collect();
    };
    match corners {
        1 => put(&[]),
        2 => (0..=cuts).for_each(|a| put(&[a])),
        3 => (0..=cuts).for_each(|a| (0..=a).for_each(|b| put(&[a, b]))),
        _ => (0..=cuts).for_each(|a| (0..=a).for_each(|b| (0..=b).for_each(|c| put(&[a, b, c])))),
    }
    nodes
}

/// Returns the weights of greatest entropy, by the heights, that mix the same point as `plain`: Newton's method for the
/// multipliers, whose function is convex.
fn gibbs(points: &[Point], heights: &[f64], softness: f64, plain: &[f64]) -> Vec<f64> {
    let target = points.iter().zip(plain).fold([0.0; 3], |sum, (point, weight)| add(sum, scale(*point, *weight)));
    let offsets: Vec<Point> = points.iter().map(|point| sub(*point, target)).collect();
    // The function's value, and the weights.
    let at = |multipliers: Point| {
        let exponents: Vec<f64> = offsets
            .iter()
            .zip(heights)
            .map(|(offset, height)| (dot(multipliers, *offset) - height) / softness)
            .collect();
        let most = exponents.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let parts: Vec<f64> = exponents.iter().map(|exponent| libm::exp(exponent - most)).collect();
        let sum: f64 = parts.iter().sum();
        (softness * (most + libm::log(sum)), parts.into_iter().map(|part| part / sum).collect::<Vec<f64>>())
    };
    let mut multipliers = [0.0; 3];
    let (mut value, mut weights) = at(multipliers);
    for _ in 0..80 {
        let gradient = offsets.iter().zip(&weights).fold([0.0; 3], |sum, (offset, w)| add(sum, scale(*offset, *w)));
        if dot(gradient, gradient) < 1e-26 {
            break;
        }
        let row = |i: usize| {
            let entry = |j: usize| {
                let moment: f64 = offsets.iter().zip(&weights).map(|(offset, w)| w * offset[i] * offset[j]).sum();
                (moment - gradient[i] * gradient[j]) / softness + if i == j { 1e-12 } else { 0.0 }
            };
            vec![entry(0), entry(1), entry(2), -gradient[i]]
        };
        let Some(step) = solve((0..3).map(row).collect()) else { break };
        let step = [step[0], step[1], step[2]];
        let slope = dot(gradient, step);
        let mut share = 1.0;
        for _ in 0..40 {
            let next = add(multipliers, scale(step, share));
            let (lower, found) = at(next);
            if lower <= value + 1e-4 * share * slope + 1e-15 {
                (multipliers, value, weights) = (next, lower, found);
                break;
            }
            share *= 0.5;
        }
    }
    weights
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
