//! Weights of pixels over a palette, block by block, as [`Decomposer::weights`](crate::Decomposer::weights) computes those
//! of one, in vectors.

use crate::decompose::{Decomposer, ROUNDING};
use crate::lattice::LANES;
use trochoid_memory::Scratch;
use trochoid_weights::BLOCK;

/// A number for each pixel of a block.
type Lane<T> = [T; BLOCK];

/// Added to a smaller whole number ≥ 0, 2⁵² makes it the lowest bits.
const WHOLE: f64 = (1_u64 << 52) as f64;

/// What is known of the pixels of a block; its memory is used again.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    points: [Lane<f64>; 3],
    /// Simplices, and barycentric coordinates in them.
    simplices: Lane<usize>,
    parts: [Lane<f64>; 4],
    /// Nodes of the lattice between which weights are interpolated, and their shares.
    nodes: [Lane<u32>; 4],
    shares: [Lane<f64>; 4],
    /// Weights by color; those that fill the last piece are 0.
    pub(crate) weights: Scratch<Lane<f64>>,
}

impl Block {
    /// Makes room for the weights of some colors.
    pub(crate) fn new(colors: usize) -> Self {
        Self {
            points: [[0.0; BLOCK]; 3],
            simplices: [0; BLOCK],
            parts: [[0.0; BLOCK]; 4],
            nodes: [[0; BLOCK]; 4],
            shares: [[0.0; BLOCK]; 4],
            weights: Scratch::of([0.0; BLOCK], colors.next_multiple_of(LANES)),
        }
    }

    /// Computes the weights of up to a block of colors. `near` is the simplex of a similar color, where the search starts;
    /// it does not change the result.
    #[inline(always)]
    pub(crate) fn weigh(&mut self, decomposer: &Decomposer, colors: &[[f32; 3]], near: &mut usize) {
        for (x, color) in colors.iter().enumerate() {
            let point = decomposer.frame.of(color.map(f64::from));
            self.points.iter_mut().zip(point).for_each(|(own, coordinate)| own[x] = coordinate);
        }
        self.place(decomposer, colors.len(), near);
        match decomposer.frame.dimension() {
            0 => self.split::<0>(decomposer.lattice.cuts),
            1 => self.split::<1>(decomposer.lattice.cuts),
            2 => self.split::<2>(decomposer.lattice.cuts),
            _ => self.split::<3>(decomposer.lattice.cuts),
        }
        self.gather(decomposer);
    }

    /// Finds the simplices and the coordinates in them.
    #[inline(always)]
    fn place(&mut self, decomposer: &Decomposer, count: usize, near: &mut usize) {
        let simplex = &decomposer.simplices[*near];
        self.simplices = [*near; BLOCK];
        let mut inside = [true; BLOCK];
        let [a, b, c] = &self.points;
        for (corner, parts) in self.parts.iter_mut().enumerate() {
            for x in 0..BLOCK {
                parts[x] = simplex.coordinate(corner, [a[x], b[x], c[x]]);
            }
        }
        for parts in &self.parts[..simplex.corners.len()] {
            inside.iter_mut().zip(parts).for_each(|(inside, part)| *inside &= *part > ROUNDING);
        }
        for x in (0..count).filter(|x| !inside[*x]) {
            let Some((simplex, parts)) = decomposer.found(self.points.each_ref().map(|own| own[x]), *near) else {
                continue;
            };
            (0..4).for_each(|corner| self.parts[corner][x] = parts[corner]);
            (self.simplices[x], *near) = (simplex, simplex);
        }
    }

    /// Finds the nodes around each pixel, in `D` dimensions, and their shares.
    #[inline(always)]
    fn split<const D: usize>(&mut self, cuts: usize) {
        let cuts = cuts as f64;
        let Self { parts: [p, q, r, s], nodes: [node_0, node_1, node_2, node_3], shares, .. } = self;
        let [share_0, share_1, share_2, share_3] = shares;
        for x in 0..BLOCK {
            let parts = [p[x].max(0.0), q[x].max(0.0), r[x].max(0.0), s[x].max(0.0)];
            let whole = 1.0 / (parts[0] + parts[1] + parts[2] + parts[3]);
            // Cumulative coordinates stand at the end, so that the last is always counted by one.
            let (mut node, mut fractions) = ([0.0; 3], [0.0; 3]);
            let (mut left, mut most) = (1.0, cuts - 1.0);
            for at in 0..D {
                left -= parts[at] * whole;
                let coordinate = cuts * left.clamp(0.0, 1.0);
                most = most.min(floor(coordinate));
                node[3 - D + at] = most;
                fractions[3 - D + at] = (coordinate - most).clamp(0.0, 1.0);
            }
            let ([a, b, c], [fa, fb, fc]) = (node, fractions);
            // How many fractions go before each: the larger ones and, of equal ones, the first.
            let (ab, ac, bc) = (one(fa >= fb), one(fa >= fc), one(fb >= fc));
            let before = [2.0 - ab - ac, 1.0 + ab - bc, ac + bc];
            let (high, low) = (fa.max(fb), fa.min(fb));
            let (most, middle, least) = (high.max(fc), low.max(high.min(fc)), low.min(fc));
            share_0[x] = 1.0 - most;
            share_1[x] = most - middle;
            share_2[x] = middle - least;
            share_3[x] = least;
            // Steps to the next node along each coordinate that there is.
            let steps = [one(D > 2) * (a + 1.0) * (a + 2.0) * 0.5, one(D > 1) * (b + 1.0), one(D > 0)];
            let first = a * (a + 1.0) * (a + 2.0) / 6.0 + b * (b + 1.0) * 0.5 + c;
            let after = |count: f64| {
                let [taken_a, taken_b, taken_c] =
                    [one(before[0] < count), one(before[1] < count), one(before[2] < count)];
                first + taken_a * steps[0] + taken_b * steps[1] + taken_c * steps[2]
            };
            node_0[x] = index(first);
            node_1[x] = index(after(1.0));
            node_2[x] = index(after(2.0));
            node_3[x] = index(after(3.0));
        }
    }

    /// Mixes the weights at the nodes.
    #[inline(always)]
    fn gather(&mut self, decomposer: &Decomposer) {
        let lattice = &decomposer.lattice;
        for x in 0..BLOCK {
            let first = self.simplices[x] * lattice.nodes;
            let row =
                |at: usize| &lattice.rows[(first + self.nodes[at][x] as usize) * lattice.pieces..][..lattice.pieces];
            let (p, q, r, s) = (row(0), row(1), row(2), row(3));
            let shares = [self.shares[0][x], self.shares[1][x], self.shares[2][x], self.shares[3][x]];
            for (piece, weights) in self.weights.chunks_exact_mut(LANES).enumerate() {
                let (p, q, r, s) = (&p[piece], &q[piece], &r[piece], &s[piece]);
                let mut mixed = [0.0; LANES];
                for lane in 0..LANES {
                    mixed[lane] = shares[0] * p[lane] + shares[1] * q[lane] + shares[2] * r[lane] + shares[3] * s[lane];
                }
                for (weights, mixed) in weights.iter_mut().zip(mixed) {
                    weights[x] = mixed;
                }
            }
        }
    }
}

#[inline(always)]
fn one(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}

#[inline(always)]
fn index(node: f64) -> u32 {
    (node + WHOLE).to_bits() as u32
}

/// Returns the whole part of a number from 0 to 2⁵¹, without the function of processors that lack the instruction.
#[inline(always)]
fn floor(value: f64) -> f64 {
    let near = (value + WHOLE) - WHOLE;
    near - if near > value { 1.0 } else { 0.0 }
}
