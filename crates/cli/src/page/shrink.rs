//! Recipes of fewer pixels: means over areas, which keep weights ≥ 0 and their sum.

use super::weights::Weights;
use rayon::prelude::*;
use trochoid::Window;

/// Returns the size of a picture that is at most this wide.
pub(super) fn size(of: [usize; 2], width: Option<u32>) -> [usize; 2] {
    match width.map(|width| width as usize).filter(|width| *width < of[0]) {
        Some(width) => [width, ((of[1] as f64 * width as f64 / of[0] as f64).round() as usize).max(1)],
        None => of,
    }
}

/// Shrinks a recipe to a size.
pub(super) fn shrink(recipe: Weights, to: [usize; 2]) -> Weights {
    let from = [recipe.window.width(), recipe.window.height()];
    if from == to {
        return recipe;
    }
    let [columns, rows] = [0, 1].map(|axis| spans(from[axis], to[axis]));
    let plane = |plane: &Vec<f32>| -> Vec<f32> {
        let across: Vec<f64> = plane
            .chunks_exact(from[0])
            .flat_map(|row| columns.iter().map(|span| mean(span, |x| f64::from(row[x]))))
            .collect();
        let pixel = |span: &Span, x: usize| mean(span, |y| across[y * to[0] + x]) as f32;
        rows.iter().flat_map(|span| (0..to[0]).map(move |x| pixel(span, x))).collect()
    };
    let weights = recipe.weights.par_iter().map(plane).collect();
    Weights { window: Window::sized(to[0] as u32, to[1] as u32), weights, ..recipe }
}

/// Old pixels under a new one: the first, and the share of each.
struct Span {
    first: usize,
    shares: Vec<f64>,
}

fn spans(from: usize, to: usize) -> Vec<Span> {
    let ratio = from as f64 / to as f64;
    let span = |at: usize| {
        let (start, end) = (at as f64 * ratio, ((at + 1) as f64 * ratio).min(from as f64));
        let first = (start as usize).min(from - 1);
        let last = (end.ceil() as usize).clamp(first + 1, from);
        let covers = |old: usize| (end.min(old as f64 + 1.0) - start.max(old as f64)).max(0.0);
        let covered: Vec<f64> = (first..last).map(covers).collect();
        let sum: f64 = covered.iter().sum();
        Span { first, shares: covered.iter().map(|share| share / sum).collect() }
    };
    (0..to).map(span).collect()
}

fn mean(span: &Span, value: impl Fn(usize) -> f64) -> f64 {
    span.shares.iter().enumerate().map(|(index, share)| share * value(span.first + index)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::WorkingSpace;

    #[test]
    fn sizes_keep_their_shape_and_never_grow() {
        assert_eq!(size([1920, 1080], Some(960)), [960, 540]);
        assert_eq!(size([1000, 1], Some(10)), [10, 1]);
        assert_eq!(size([640, 360], Some(960)), [640, 360]);
        assert_eq!(size([640, 360], None), [640, 360]);
    }

    #[test]
    fn pixels_are_means_over_their_areas() {
        let recipe = Weights {
            names: vec!["a".into(), "b".into()],
            colors: vec![[0.0; 3], [1.0; 3]],
            space: WorkingSpace::Srgb,
            window: Window::sized(3, 2),
            weights: vec![vec![0.0, 1.0, 0.5, 1.0, 0.0, 0.5], vec![1.0, 0.0, 0.5, 0.0, 1.0, 0.5]],
        };
        let small = shrink(recipe.clone(), [2, 1]);
        // The middle column is shared by both pixels.
        assert_eq!(small.window, Window::sized(2, 1));
        assert_eq!(small.weights, [[0.5, 0.5], [0.5, 0.5]]);
        let narrow = shrink(recipe.clone(), [1, 2]);
        assert_eq!(narrow.weights, [[0.5, 0.5], [0.5, 0.5]]);
        assert_eq!(shrink(recipe.clone(), [3, 2]), recipe);
    }
}
