//! Weights as a function of color, for exports as 3D LUTs.
//!
//! If the weights of a picture depend on the color of the pixel alone, then so does the repainted picture, and other
//! programs can repaint with a table of colors. That holds for pictures that were decomposed, not for most renders.

use super::weights::Weights;
use trochoid::{Window, WorkingSpace};
use trochoid_palette::Decomposer;

/// Colors along an edge of the lattice.
const SIDE: usize = 33;
/// Pixels that are looked at.
const SAMPLES: usize = 500;
/// By how much the weights of a pixel may differ, as the share of the pixel that another mix makes up: weights of 16-bit
/// floats change as much where colors are close to each other.
const TOLERANCE: f64 = 0.1;
/// Share of the samples that must agree.
const MOST: f64 = 0.99;

/// Returns the weights of a lattice of displayed colors, red first, if the picture's weights are such a function.
pub(super) fn of(recipe: &Weights) -> Option<Weights> {
    if recipe.space != WorkingSpace::Srgb {
        return None;
    }
    // First the softness that `decompose` has by default.
    let softness = [0.2, 0.0, 0.1].into_iter().chain((3..=10).map(|tenths| f64::from(tenths) / 10.0));
    let decomposer = softness
        .filter_map(|softness| Decomposer::new(&recipe.colors, softness))
        .find(|decomposer| agrees(decomposer, recipe))?;
    let step = |index: usize| (index % SIDE) as f64 / (SIDE - 1) as f64;
    let nodes: Vec<Vec<f64>> = (0..SIDE.pow(3))
        .map(|node| decomposer.weights([step(node), step(node / SIDE), step(node / SIDE / SIDE)]))
        .collect();
    let plane = |color: usize| nodes.iter().map(|weights| weights[color] as f32).collect();
    let weights = (0..recipe.names.len()).map(plane).collect();
    let window = Window::sized((SIDE * SIDE) as u32, SIDE as u32);
    Some(Weights { names: recipe.names.clone(), colors: recipe.colors.clone(), space: recipe.space, window, weights })
}

fn agrees(decomposer: &Decomposer, recipe: &Weights) -> bool {
    let area = recipe.window.area();
    let samples: Vec<usize> = (0..area).step_by(area.div_ceil(SAMPLES)).collect();
    let agreeing = samples.iter().filter(|at| {
        let weights: Vec<f64> = recipe.weights.iter().map(|plane| f64::from(plane[**at])).collect();
        let mixed =
            [0, 1, 2].map(|c| weights.iter().zip(&recipe.colors).map(|(weight, color)| weight * color[c]).sum());
        let expected = decomposer.weights(mixed);
        weights.iter().zip(&expected).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0 <= TOLERANCE
    });
    agreeing.count() as f64 >= MOST * samples.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(weights: Vec<Vec<f32>>) -> Weights {
        Weights {
            names: ["black", "gray", "white"].map(String::from).into(),
            colors: vec![[0.0; 3], [0.5; 3], [1.0; 3]],
            space: WorkingSpace::Srgb,
            window: Window::sized(weights[0].len() as u32, 1),
            weights,
        }
    }

    #[test]
    fn decomposed_pictures_have_one_and_others_have_not() {
        let decomposer = Decomposer::new(&[[0.0; 3], [0.5; 3], [1.0; 3]], 0.5).unwrap();
        let pixels: Vec<Vec<f64>> = (0..101).map(|at| decomposer.weights([f64::from(at) / 100.0; 3])).collect();
        let decomposed = (0..3).map(|color| pixels.iter().map(|weights| weights[color] as f32).collect()).collect();
        let lattice = of(&recipe(decomposed)).unwrap();
        assert_eq!(lattice.window.area(), SIDE.pow(3));
        // Red is first: the second node is a mix of little red.
        assert!(lattice.weights[0][0] > 0.99 && lattice.weights[0][1] < lattice.weights[0][0]);
        assert!(lattice.weights[2][SIDE.pow(3) - 1] > 0.99);
        // The same gray of two mixes.
        let mixed = recipe(vec![vec![0.5, 0.0], vec![0.0, 1.0], vec![0.5, 0.0]]);
        assert!(of(&mixed).is_none());
        assert!(
            of(&Weights { space: WorkingSpace::LinearSrgb, ..recipe(vec![vec![1.0], vec![0.0], vec![0.0]]) }).is_none()
        );
    }
}
