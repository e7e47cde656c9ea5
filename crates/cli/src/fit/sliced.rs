//! The colors in which a picture has the colors of a painting, wherever they are: the sliced Wasserstein distance of both
//! clouds of pixels in OKLab (Rabin, Peyré, Delon, Bernot 2011, *Wasserstein barycenter and its application to texture
//! mixing*), and a pull to the colors before, by L-BFGS-B (Byrd, Lu, Nocedal, Zhu 1995).
//!
//! Projected on a direction, both clouds are sorted, and the kth number of one belongs to the kth of the other. The cost is
//! the mean of √(d² + ε²) of their differences d, over 64 directions, and κ·Σ ½(mᵢ + 1/K)·|Cᵢ − Cᵢ⁰|².

use super::lab::Lab;
use super::picture::{Weighed, evenly};
use basin::{BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction, Executor, FirstOrderState};
use basin::{Gradient, Lbfgs};
use rayon::prelude::*;
use std::convert::Infallible;

/// Directions on which clouds are projected.
const DIRECTIONS: usize = 64;
/// Most pixels of each cloud.
const SAMPLES: usize = 8000;
/// Difference below which the cost is a parabola, in OKLab.
const ROUND: f64 = 2e-3;
/// Most steps: later ones change no color that one sees.
const STEPS: u64 = 150;

/// Returns the colors in which the pixels of a picture are distributed as `target`, in OKLab, with a pull `keep` to those
/// before.
pub(super) fn fit(picture: &Weighed, target: &[[f64; 3]], before: &[[f64; 3]], keep: f64, lab: Lab) -> Vec<[f64; 3]> {
    let picture = picture.sampled(SAMPLES);
    let directions = directions();
    let wanted: Vec<Vec<f64>> = directions.iter().map(|direction| slice(direction, target, picture.pixels())).collect();
    let colors = picture.colors as f64;
    let pulls = picture.shares().into_iter().map(|share| 0.5 * keep * (share + 1.0 / colors)).collect();
    let numbers = 3 * picture.colors;
    let problem = Problem {
        wanted,
        directions,
        lab,
        pulls,
        before: before.to_vec(),
        ends: [vec![0.0; numbers], vec![1.0; numbers]],
        picture,
    };
    let start: Vec<f64> = before.iter().flatten().map(|v| v.clamp(0.0, 1.0)).collect();
    let run = Executor::new(problem, Lbfgs::new(), FirstOrderState::new(start)).max_iter(STEPS).run();
    match run {
        Ok(found) => found.param().chunks_exact(3).map(|color| [color[0], color[1], color[2]]).collect(),
        // Nothing that it asks for fails, and a search that ends early says so otherwise.
        Err(_) => before.to_vec(),
    }
}

/// Returns the distance of a picture in some colors from `target`, both in OKLab: the mean over all directions.
pub(super) fn distance(picture: &Weighed, target: &[[f64; 3]], colors: &[[f64; 3]], lab: Lab) -> f64 {
    let picture = picture.sampled(SAMPLES);
    let seen: Vec<[f64; 3]> = (0..picture.pixels()).map(|pixel| lab.lab(picture.mixed(pixel, colors))).collect();
    let off = |direction: &[f64; 3]| {
        let own = slice(direction, &seen, seen.len());
        let wanted = slice(direction, target, seen.len());
        own.iter().zip(wanted).map(|(own, wanted)| (own - wanted).abs()).sum::<f64>() / seen.len().max(1) as f64
    };
    directions().iter().map(off).sum::<f64>() / DIRECTIONS as f64
}

/// Returns sorted projections of colors on a direction, so many of them.
fn slice(direction: &[f64; 3], colors: &[[f64; 3]], count: usize) -> Vec<f64> {
    let mut all: Vec<f64> = colors.iter().map(|color| dot(*direction, *color)).collect();
    all.sort_unstable_by(f64::total_cmp);
    (0..count).map(|k| all[((k as f64 + 0.5) / count as f64 * all.len() as f64) as usize]).collect()
}

/// Returns pixels for [`fit`]: displayed colors in OKLab, evenly from all over a painting.
pub(super) fn cloud(painting: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let lab = Lab::of(trochoid::WorkingSpace::Srgb);
    evenly(painting.len(), 4 * SAMPLES).into_iter().map(|pixel| lab.lab(painting[pixel].map(f64::from))).collect()
}

/// Returns directions that are evenly apart on half a sphere: a spiral by the golden angle.
fn directions() -> Vec<[f64; 3]> {
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |index: usize| {
        let height = (index as f64 + 0.5) / DIRECTIONS as f64;
        let (sin, cos) = libm::sincos(turn * index as f64);
        let radius = libm::sqrt(1.0 - height * height);
        [height, radius * cos, radius * sin]
    };
    (0..DIRECTIONS).map(direction).collect()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

struct Problem {
    picture: Weighed,
    /// Sorted projections of the painting, by direction.
    wanted: Vec<Vec<f64>>,
    directions: Vec<[f64; 3]>,
    lab: Lab,
    /// Factors of the squared distances from the colors before.
    pulls: Vec<f64>,
    before: Vec<[f64; 3]>,
    /// Least and greatest numbers.
    ends: [Vec<f64>; 2],
}

impl Problem {
    fn evaluate(&self, numbers: &[f64]) -> (f64, Vec<f64>) {
        let colors: Vec<[f64; 3]> = numbers.chunks_exact(3).map(|color| [color[0], color[1], color[2]]).collect();
        let count = self.picture.pixels();
        let seen: Vec<([f64; 3], [[f64; 3]; 3])> =
            (0..count).into_par_iter().map(|pixel| self.lab.with_slopes(self.picture.mixed(pixel, &colors))).collect();
        let all = (DIRECTIONS * count) as f64;
        // By direction: its cost, and the derivative of each pixel's. All sums are taken in one order.
        let slices: Vec<(f64, Vec<f64>)> = self
            .directions
            .par_iter()
            .zip(&self.wanted)
            .map(|(direction, wanted)| {
                let mut sorted: Vec<(f64, u32)> =
                    seen.iter().zip(0..).map(|((lab, _), pixel)| (dot(*direction, *lab), pixel)).collect();
                sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let (mut cost, mut by) = (0.0, vec![0.0; count]);
                for ((at, pixel), wanted) in sorted.into_iter().zip(wanted) {
                    let off = at - wanted;
                    let length = libm::sqrt(off * off + ROUND * ROUND);
                    cost += length;
                    by[pixel as usize] = off / length / all;
                }
                (cost, by)
            })
            .collect();
        let by_pixel: Vec<[f64; 3]> = (0..count)
            .into_par_iter()
            .map(|pixel| {
                let mut by_lab = [0.0; 3];
                for ((_, by), direction) in slices.iter().zip(&self.directions) {
                    (0..3).for_each(|c| by_lab[c] += by[pixel] * direction[c]);
                }
                let slopes = &seen[pixel].1;
                [0, 1, 2].map(|j| (0..3).map(|i| by_lab[i] * slopes[i][j]).sum())
            })
            .collect();
        let mut cost = slices.iter().map(|(cost, _)| cost).sum::<f64>() / all;
        let mut gradient = vec![0.0; numbers.len()];
        for (pixel, by) in by_pixel.iter().enumerate() {
            for (slope, weight) in gradient.chunks_exact_mut(3).zip(self.picture.of(pixel)) {
                slope.iter_mut().zip(by).for_each(|(slope, by)| *slope += f64::from(*weight) * by);
            }
        }
        for (i, slope) in gradient.chunks_exact_mut(3).enumerate() {
            for c in 0..3 {
                let off = colors[i][c] - self.before[i][c];
                cost += self.pulls[i] * off * off;
                slope[c] += 2.0 * self.pulls[i] * off;
            }
        }
        (cost, gradient)
    }
}

impl Constraints for Problem {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        let [low, high] = &self.ends;
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(low), Some(high)))
    }
}

impl CostFunction for Problem {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Infallible;

    fn cost(&self, at: &Vec<f64>) -> Result<f64, Infallible> {
        Ok(self.evaluate(at).0)
    }
}

impl Gradient for Problem {
    type Gradient = Vec<f64>;

    fn gradient(&self, at: &Vec<f64>) -> Result<Vec<f64>, Infallible> {
        Ok(self.evaluate(at).1)
    }

    fn cost_and_gradient(&self, at: &Vec<f64>) -> Result<(f64, Vec<f64>), Infallible> {
        Ok(self.evaluate(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::WorkingSpace;

    /// A picture of soft weights over three colors.
    fn picture() -> Weighed {
        let weights: Vec<f32> = (0..2000)
            .flat_map(|i| {
                let (a, b) = ((i as f32 * 0.618).fract(), (i as f32 * 0.414).fract());
                [a * b, a * (1.0 - b), 1.0 - a]
            })
            .collect();
        Weighed { colors: 3, rest: vec![[0.0; 3]; 2000], weights }
    }

    #[test]
    fn the_colors_of_a_recolored_picture_are_found_again() {
        let (picture, truth) = (picture(), [[0.1, 0.2, 0.45], [0.85, 0.5, 0.3], [0.95, 0.9, 0.7]]);
        let painting: Vec<[f32; 3]> =
            (0..picture.pixels()).map(|pixel| picture.mixed(pixel, &truth).map(|v| v as f32)).collect();
        let lab = Lab::of(WorkingSpace::Srgb);
        let before = [[0.2, 0.25, 0.3], [0.7, 0.6, 0.5], [0.9, 0.9, 0.9]];
        let found = fit(&picture, &cloud(&painting), &before, 0.0, lab);
        for (found, truth) in found.iter().flatten().zip(truth.iter().flatten()) {
            assert!((found - truth).abs() < 0.02, "{found} for {truth}");
        }
        let kept = fit(&picture, &cloud(&painting), &before, 1e4, lab);
        assert!(kept.iter().flatten().zip(before.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-3));
        // One thread, the same bits.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let alone = pool.map(|pool| pool.install(|| fit(&picture, &cloud(&painting), &before, 0.0, lab)));
        assert_eq!(alone.ok(), Some(found));
    }

    #[test]
    fn slopes_are_those_of_small_steps() {
        let picture = picture();
        let target = vec![[0.4, 0.05, 0.02], [0.7, -0.03, 0.1], [0.9, 0.0, 0.0]];
        let directions = directions();
        let wanted: Vec<Vec<f64>> =
            directions.iter().map(|direction| slice(direction, &target, picture.pixels())).collect();
        let problem = Problem {
            wanted,
            directions,
            lab: Lab::of(WorkingSpace::Srgb),
            pulls: vec![0.1, 0.2, 0.3],
            before: vec![[0.3; 3]; 3],
            ends: [vec![0.0; 9], vec![1.0; 9]],
            picture,
        };
        let at = [0.2, 0.3, 0.5, 0.7, 0.6, 0.4, 0.9, 0.8, 0.85];
        let (_, gradient) = problem.evaluate(&at);
        for number in 0..9 {
            let moved = |by: f64| {
                let mut at = at;
                at[number] += by;
                problem.evaluate(&at).0
            };
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((slope - gradient[number]).abs() < 1e-5, "{number}: {slope}, {}", gradient[number]);
        }
    }
}
