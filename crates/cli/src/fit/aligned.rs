//! The colors in which a picture is nearest to a painting pixel by pixel: bounded least squares, channel by channel.
//!
//! (WᵀW/N + κ·diag m)·C = Wᵀ(T − R)/N + κ·diag m·C⁰ with 0 ≤ C ≤ 1: the weights W, the painting T, what is fixed R, the
//! mean weights m, the colors before C⁰.

use super::picture::Weighed;

/// Most sweeps over all colors, and the step that ends them.
const SWEEPS: usize = 20_000;
const LAST: f64 = 1e-9;
/// Pull of colors without any weight.
const LEAST: f64 = 1e-7;

/// Returns the colors nearest to `target`, pixel by pixel in the working space, with a pull `keep` to those before.
pub(super) fn fit(picture: &Weighed, target: &[[f64; 3]], before: &[[f64; 3]], keep: f64) -> Vec<[f64; 3]> {
    let (count, colors) = (picture.pixels() as f64, picture.colors);
    let mut normal = vec![0.0; colors * colors];
    let mut sides = vec![[0.0; 3]; colors];
    for (pixel, target) in target.iter().enumerate() {
        let weights = picture.of(pixel);
        let wanted: [f64; 3] = [0, 1, 2].map(|c| target[c] - f64::from(picture.rest[pixel][c]));
        for (i, own) in weights.iter().enumerate().filter(|(_, own)| **own > 0.0) {
            let own = f64::from(*own) / count;
            let row = &mut normal[i * colors..][..colors];
            row.iter_mut().zip(weights).for_each(|(sum, other)| *sum += own * f64::from(*other));
            (0..3).for_each(|c| sides[i][c] += own * wanted[c]);
        }
    }
    for (i, share) in picture.shares().into_iter().enumerate() {
        let pull = keep * share + LEAST;
        normal[i * colors + i] += pull;
        (0..3).for_each(|c| sides[i][c] += pull * before[i][c]);
    }
    // One color after another goes to where it is best, which nears the only minimum.
    let mut found = before.to_vec();
    for _ in 0..SWEEPS {
        let mut moved = 0.0_f64;
        for i in 0..colors {
            let row = &normal[i * colors..][..colors];
            for c in 0..3 {
                let others: f64 = row.iter().zip(&found).map(|(entry, color)| entry * color[c]).sum();
                let best = (found[i][c] + (sides[i][c] - others) / row[i]).clamp(0.0, 1.0);
                moved = moved.max((best - found[i][c]).abs());
                found[i][c] = best;
            }
        }
        if moved < LAST {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_of_a_painting_that_they_mix_are_found_and_others_stay_in_range() {
        let truth = [[0.1, 0.2, 0.3], [0.9, 0.5, 0.4], [0.3, 0.8, 0.6]];
        let weights: Vec<f32> = (0..300)
            .flat_map(|i| {
                let (a, b) = ((i as f32 * 0.618).fract(), (i as f32 * 0.414).fract());
                [a * b, a * (1.0 - b), (1.0 - a) * 0.5]
            })
            .collect();
        let rest: Vec<[f32; 3]> = weights.chunks(3).map(|w| [(1.0 - w[0] - w[1] - w[2]) * 0.5; 3]).collect();
        let picture = Weighed { colors: 3, weights, rest };
        let painting: Vec<[f64; 3]> = (0..300).map(|pixel| picture.mixed(pixel, &truth)).collect();
        let found = fit(&picture, &painting, &[[0.5; 3]; 3], 0.0);
        for (found, truth) in found.iter().flatten().zip(truth.iter().flatten()) {
            assert!((found - truth).abs() < 1e-4, "{found} for {truth}");
        }
        let beyond: Vec<[f64; 3]> = painting.iter().map(|color| color.map(|v| 3.0 * v - 1.0)).collect();
        assert!(fit(&picture, &beyond, &truth, 0.0).iter().flatten().all(|v| (0.0..=1.0).contains(v)));
        // A strong pull keeps what was.
        let kept = fit(&picture, &beyond, &truth, 1e6);
        assert!(kept.iter().flatten().zip(truth.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-4));
    }
}
