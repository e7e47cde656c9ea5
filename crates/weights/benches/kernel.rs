//! Cost of separable filters: a mask of 1920 × 1080, with small and large kernels.

#![allow(missing_docs, reason = "a benchmark")]

use divan::Bencher;
use trochoid_image::Window;
use trochoid_weights::kernel::{Kernel, Shape, filter};

fn main() {
    divan::main();
}

/// Filters across by one Gaussian and down by another.
#[divan::bench(args = [[1.5, 1.5], [10.0, 10.0], [0.0, 240.0], [240.0, 0.0]])]
fn gaussian(bencher: Bencher<'_, '_>, sizes: [f64; 2]) {
    let window = Window::sized(1920, 1080);
    let image: Vec<f32> = (0..window.area()).map(|i| (i as f32 * 0.37).sin()).collect();
    let kernels = sizes.map(|size| Kernel::new(Shape::Gaussian, size));
    let mut out = vec![0.0; image.len()];
    bencher.bench_local(|| filter([&kernels[0], &kernels[1]], window, &image, window, window, &|| false, &mut out));
}
