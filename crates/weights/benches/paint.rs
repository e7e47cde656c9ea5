//! Painting a picture in memory from the weights of 24 colors: `cargo bench -p trochoid-weights --bench paint`.

use divan::Bencher;
use half::f16;
use rayon::prelude::*;
use trochoid_weights::{Storing, paint};

const AREA: usize = 1920 * 1080;
const COLORS: usize = 24;
/// Pixels that one thread paints in a row.
const STRIP: usize = 16 * 1920;

fn main() {
    divan::main();
}

/// Returns weights of which each pixel has `mixed` above 0, plane by plane.
fn planes(mixed: usize) -> Vec<Vec<f32>> {
    let mut planes = vec![vec![0.0; AREA]; COLORS];
    let mut state = 7_u64;
    let mut draw = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / (1_u64 << 24) as f64
    };
    for pixel in 0..AREA {
        let mut weights = vec![0.0; COLORS];
        // Neighbors mix the same colors, as in pictures.
        let first = pixel / 5000 * 7;
        (0..mixed).for_each(|index| weights[(first + index) % COLORS] = draw() + 1e-3);
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        let stored = Storing::Half.round(&weights);
        planes.iter_mut().zip(stored).for_each(|(plane, weight)| plane[pixel] = weight);
    }
    planes
}

fn painted<S: trochoid_weights::StoredSample>(bencher: Bencher<'_, '_>, planes: &[Vec<S>]) {
    let colors: Vec<[f64; 3]> = (0..COLORS).map(|i| [0, 1, 2].map(|c| ((i * 5 + c * 7) % 11) as f64 / 10.0)).collect();
    let mut out = [(); 3].map(|()| vec![0.0_f32; AREA]);
    bencher.bench_local(|| {
        let [r, g, b] = out.each_mut().map(|channel| channel.par_chunks_mut(STRIP));
        r.zip(g).zip(b).enumerate().for_each(|(index, ((r, g), b))| {
            let start = index * STRIP;
            let rows: Vec<&[S]> = planes.iter().map(|plane| &plane[start..start + r.len()]).collect();
            assert_eq!(paint(&rows, &colors, None, [r, g, b]), Ok(()));
        });
    });
}

#[divan::bench(args = [4, 8, 24])]
fn halves(bencher: Bencher<'_, '_>, mixed: usize) {
    let planes: Vec<Vec<u16>> = planes(mixed)
        .iter()
        .map(|plane| plane.iter().map(|weight| f16::from_f32(*weight).to_bits()).collect())
        .collect();
    painted(bencher, &planes);
}

#[divan::bench(args = [4, 24])]
fn floats(bencher: Bencher<'_, '_>, mixed: usize) {
    painted(bencher, &planes(mixed));
}
