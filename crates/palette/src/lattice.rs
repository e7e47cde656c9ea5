//! Weights at the nodes of a lattice in each simplex of a palette, and between them.
//!
//! A simplex is cut into as many parts along each edge (Freudenthal), so that at a node each corner has a whole number of
//! parts. What is left of all parts after the first corner, the first two and so on are the node's cumulative coordinates,
//! which fall.

use crate::simplex::{Simplex, solve};
use crate::vector::{Point, add, dot, scale, sub};

/// Cuts along an edge of a simplex.
const CUTS: usize = 16;
/// Numbers in a piece of a row.
pub(crate) const LANES: usize = 4;

/// Weights of the colors of a palette at the nodes of its simplices.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    /// Cuts along each edge: 1 without softness.
    pub(crate) cuts: usize,
    /// Number of nodes of a simplex.
    pub(crate) nodes: usize,
    /// Number of pieces in the row of a node.
    pub(crate) pieces: usize,
    /// Weights by simplex, node and color. A row of colors ends with zeros.
    pub(crate) rows: Vec<[f64; LANES]>,
}

impl Lattice {
    /// Computes the weights at the nodes of simplices that have these facets as their boundary.
    pub(crate) fn new(
        points: &[Point],
        heights: &[f64],
        simplices: &[Simplex],
        boundary: &[Vec<usize>],
        softness: f64,
    ) -> Self {
        let corners = simplices.first().map_or(1, |simplex| simplex.corners.len());
        let cuts = if softness > 0.0 && corners > 1 { CUTS } else { 1 };
        let places = places(corners, cuts);
        let pieces = points.len().div_ceil(LANES);
        let mut rows = vec![[0.0; LANES]; simplices.len() * places.len() * pieces];
        let nodes = simplices.iter().flat_map(|simplex| places.iter().map(move |parts| (simplex, parts)));
        for (row, (simplex, parts)) in rows.chunks_mut(pieces).zip(nodes) {
            let mut plain = vec![0.0; points.len()];
            simplex.corners.iter().zip(parts).for_each(|(corner, part)| plain[*corner] = *part as f64 / cuts as f64);
            let used: Vec<usize> =
                simplex.corners.iter().zip(parts).filter(|(_, part)| **part > 0).map(|(c, _)| *c).collect();
            // On the surface of the hull, only the colors of the facet mix.
            let is_outer = cuts == 1 || boundary.iter().any(|facet| used.iter().all(|corner| facet.contains(corner)));
            let weights = if is_outer { plain } else { gibbs(points, heights, softness, &plain) };
            row.as_flattened_mut().iter_mut().zip(weights).for_each(|(own, weight)| *own = weight);
        }
        Self { cuts, nodes: places.len(), pieces, rows }
    }

    /// Interpolates in a simplex of some dimensions at a point with these barycentric coordinates.
    pub(crate) fn interpolate(&self, simplex: usize, dimension: usize, coordinates: [f64; 4], weights: &mut [f64]) {
        let parts = coordinates.map(|part| part.max(0.0));
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
        order[..dimension].sort_by(|a, b| fractions[*b].total_cmp(&fractions[*a]));
        weights.fill(0.0);
        let mut before = 1.0;
        for step in 0..=dimension {
            let after = if step < dimension { fractions[order[step]] } else { 0.0 };
            let row = &self.rows[(simplex * self.nodes + place(&node[..dimension])) * self.pieces..][..self.pieces];
            let row = row.as_flattened().iter();
            weights.iter_mut().zip(row).for_each(|(weight, at_node)| *weight += (before - after) * at_node);
            if step < dimension {
                node[order[step]] += 1;
            }
            before = after;
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
