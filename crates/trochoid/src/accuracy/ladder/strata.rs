//! Draws one pixel in each of equal parts of a picture, part by part in ever smaller parts.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Equal parts of a rectangle, with one point in each.
///
/// Parts are halved all at once. Each point stays, in one half of its part; in the other half, a new point is drawn
/// evenly. A point that was drawn evenly in the whole is even in the half that it lies in, so after each step every
/// part has one even point, independent of all others; and the points of a step are the first ones of all later steps.
#[derive(Clone, Debug)]
pub(super) struct Strata {
    /// Width and height of the rectangle, which is halved across its longer side.
    extent: [f64; 2],
    random: Pcg64,
    parts: Vec<Part>,
}

/// A part of the unit square, and its point.
#[derive(Clone, Copy, Debug)]
struct Part {
    start: [f64; 2],
    size: [f64; 2],
    point: [f64; 2],
}

impl Strata {
    /// Makes one part with one point.
    pub(super) fn new(extent: [usize; 2], seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let (start, size) = ([0.0; 2], [1.0; 2]);
        let point = draw(&mut random, start, size);
        Self { extent: extent.map(|side| side as f64), random, parts: vec![Part { start, size, point }] }
    }

    /// Returns the number of parts: a power of 2.
    pub(super) fn count(&self) -> usize {
        self.parts.len()
    }

    /// Halves every part. New points come after all others.
    pub(super) fn halve(&mut self) {
        let mut new = Vec::with_capacity(self.parts.len());
        for part in &mut self.parts {
            let along = usize::from(part.size[1] * self.extent[1] > part.size[0] * self.extent[0]);
            part.size[along] *= 0.5;
            let middle = part.start[along] + part.size[along];
            let mut other = *part;
            // Halves of powers of 2 are exact, so that each point lies in exactly one of them.
            let empty = if part.point[along] < middle { &mut other } else { &mut *part };
            empty.start[along] = middle;
            other.point = draw(&mut self.random, other.start, other.size);
            new.push(other);
        }
        self.parts.append(&mut new);
    }

    /// Returns the cells of a grid in which the points lie, in the order in which they were drawn.
    pub(super) fn cells(&self) -> impl Iterator<Item = [usize; 2]> {
        self.parts.iter().map(|part| {
            let cell = |along: usize| {
                let all = self.extent[along];
                (part.point[along] * all).min((all - 1.0).max(0.0)) as usize
            };
            [cell(0), cell(1)]
        })
    }
}

/// Draws a point evenly.
fn draw(random: &mut Pcg64, start: [f64; 2], size: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|along| start[along] + size[along] * ((random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_every_step_has_one_point_and_points_stay() {
        let mut strata = Strata::new([64, 32], 5);
        let mut before: Vec<[usize; 2]> = Vec::new();
        // Parts of 64 × 32 cells: 2 × 1, 4 × 1, 4 × 2, 8 × 2, … up to single cells.
        for step in 0..=11_u32 {
            let cells: Vec<[usize; 2]> = strata.cells().collect();
            assert_eq!((cells.len(), &cells[..before.len()]), (1 << step, &before[..]));
            let across = if step == 0 { 1 } else { 2 << (step / 2) };
            let down = (1 << step) / across;
            let mut seen = vec![0; across * down];
            for [x, y] in &cells {
                seen[y * down / 32 * across + x * across / 64] += 1;
            }
            assert!(seen.iter().all(|count| *count == 1), "step {step}: {seen:?}");
            before = cells;
            strata.halve();
        }
        let other: Vec<_> = Strata::new([64, 32], 6).cells().collect();
        assert_ne!(other, before[..1]);
    }

    #[test]
    fn points_of_each_part_are_even() {
        // 4 parts of a row of 8 cells: each part draws its 2 cells equally often, and independently of the next part.
        let mut counts = [0_u32; 8];
        let mut both = 0;
        for seed in 0..4000 {
            let mut strata = Strata::new([8, 1], seed);
            strata.halve();
            strata.halve();
            let mut cells: Vec<usize> = strata.cells().map(|cell| cell[0]).collect();
            cells.sort_unstable();
            cells.iter().for_each(|cell| counts[*cell] += 1);
            both += u32::from(cells[0] == 0 && cells[1] == 2);
        }
        // 2000 are expected; 5 standard deviations are 158. Of both, 1000 and 137.
        assert!(counts.iter().all(|count| count.abs_diff(2000) < 158), "{counts:?}");
        assert!(u32::abs_diff(both, 1000) < 137, "{both}");
    }

    #[test]
    fn rows_are_cut_along_their_length() {
        let mut strata = Strata::new([96, 0], 1);
        (0..3).for_each(|_| strata.halve());
        let mut cells: Vec<[usize; 2]> = strata.cells().collect();
        cells.sort_unstable();
        let parts: Vec<usize> = cells.iter().map(|cell| cell[0] * 8 / 96).collect();
        assert_eq!(parts, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert!(cells.iter().all(|cell| cell[1] == 0));
    }
}
