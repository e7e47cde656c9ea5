//! Tests of kernels and of separable filtering.

use trochoid_image::Window;
use trochoid_weights::Hull;
use trochoid_weights::inside::{folded, kernel_of, weights};
use trochoid_weights::kernel::{Kernel, Shape, filter};

/// 1 as a multiple of the smallest weight.
const ONE: f64 = 16_777_216.0;

fn sum(kernel: &Kernel) -> f64 {
    weights(kernel).iter().map(|w| f64::from(*w)).sum()
}

#[test]
fn kernels_are_partitions() {
    for shape in [Shape::Gaussian, Shape::Box] {
        for size in [0.0, 1e-9, 0.1, 0.5, 1.0, 1.5, 2.75, 10.0, 333.3, 5000.0] {
            let kernel = Kernel::new(shape, size);
            assert_eq!(sum(&kernel), 1.0, "{shape:?} {size}");
            let found = weights(&kernel);
            assert!(found.iter().all(|w| *w >= 0.0 && (f64::from(*w) * ONE).fract() == 0.0));
            assert!(found.iter().eq(found.iter().rev()), "{shape:?} {size} is symmetric");
            assert!((found.len() / 2) as i64 <= shape.radius(size));
            let truth = shape.reference(size);
            let cut = (truth.len() - found.len()) / 2;
            for ((k, truth), found) in truth.iter().skip(cut).zip(found) {
                // The center takes what the sides leave of 1.
                let slack = if *k == 0 { 3.0 } else { 1.0 };
                assert!((truth - f64::from(*found)).abs() <= slack / ONE, "{shape:?} {size} at {k}");
            }
            for length in [1, 2, 3, 7, 100, 100_000] {
                let folded = folded(&kernel, length);
                assert_eq!(sum(&folded), 1.0);
                let count = weights(&folded).len();
                assert!(count / 2 < length.max(1) && count % 2 == 1);
            }
        }
    }
    assert_eq!(weights(&Kernel::new(Shape::Box, 1.0)).len(), 3);
    assert_eq!(weights(&Kernel::new(Shape::Box, 0.5)), [0.25, 0.5, 0.25]);
}

/// A few pixels of extreme values.
fn hostile(width: usize, height: usize) -> Vec<f32> {
    let values = [0.0, 1.0, f32::MAX, f32::MIN_POSITIVE, 1e-45, 3.0e38, 0.1, 1.0 + f32::EPSILON];
    (0..width * height).map(|i| values[(i * 7 + i / 3) % values.len()]).collect()
}

#[test]
fn results_stay_between_the_values_and_constants_are_kept() {
    let window = Window::sized(23, 9);
    let image = hostile(23, 9);
    for (shape, size) in [(Shape::Gaussian, 0.7), (Shape::Gaussian, 40.0), (Shape::Box, 2.5), (Shape::Box, 99.0)] {
        let kernel = Kernel::new(shape, size);
        let mut out = vec![f32::NAN; image.len()];
        filter([&kernel, &kernel], window, &image, window, window, &|| false, &mut out);
        let radius = shape.radius(size);
        for (index, value) in out.iter().enumerate() {
            let (x, y) = ((index % 23) as i64, (index / 23) as i64);
            let near = |at: i64, end: i64| (at - radius).max(0)..(at + radius + 1).min(end);
            let seen: Vec<f32> = near(y, 9)
                .flat_map(|y| near(x, 23).map(move |x| (x, y)))
                .map(|(x, y)| image[(y * 23 + x) as usize])
                .collect();
            let (low, high) = seen.iter().fold((f32::MAX, 0.0f32), |(low, high), v| (low.min(*v), high.max(*v)));
            assert!((low..=high).contains(value), "{shape:?} {size}: {value} of {low}..={high}");
        }
        for constant in [0.1, f32::MAX, 1e-45, 0.0, -7.3] {
            let image = vec![constant; image.len()];
            filter([&kernel, &kernel], window, &image, window, window, &|| false, &mut out);
            assert!(out.iter().all(|v| v.to_bits() == constant.to_bits()), "{shape:?} {size} of {constant}");
        }
    }
}

#[test]
fn parts_have_the_bits_of_the_whole() {
    let whole = Window::sized(40, 11);
    let image: Vec<f32> = (0..40 * 11).map(|i| (i as f32 * 0.37).sin()).collect();
    for (shape, size) in [(Shape::Gaussian, 1.3), (Shape::Box, 6.25), (Shape::Gaussian, 30.0)] {
        let (kernel, radius) = (Kernel::new(shape, size), shape.radius(size));
        let mut expected = vec![0.0; image.len()];
        filter([&kernel, &kernel], whole, &image, whole, whole, &|| false, &mut expected);
        for to in [Window::new(0, 0, 1, 1), Window::new(3, 2, 29, 3), Window::new(17, 5, 40, 11)] {
            let from = Window::new(to.x0 - radius, to.y0 - radius, to.x1 + radius, to.y1 + radius).intersect(whole);
            let part = |window: Window, image: &[f32]| -> Vec<f32> {
                let at = |x: i64, y: i64| image[(y * 40 + x) as usize];
                (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| at(x, y))).collect()
            };
            let mut found = vec![0.0; to.area()];
            filter([&kernel, &kernel], from, &part(from, &image), whole, to, &|| false, &mut found);
            assert_eq!(found, part(to, &expected), "{shape:?} {size} over {to}");
        }
    }
}

/// Returns the sums of one row or column after another, in the order of the kernel, straight from the definition.
fn plain([across, down]: [&Kernel; 2], [width, height]: [usize; 2], image: &[f32]) -> Vec<f32> {
    let sum = |kernel: &Kernel, length: usize, center: usize, at: &dyn Fn(usize) -> f32| {
        let kernel = weights(&folded(kernel, length)).to_vec();
        let place = |k: usize| (center as i64 + k as i64 - (kernel.len() / 2) as i64).clamp(0, length as i64 - 1);
        let used = kernel.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        let sum = used.fold(0.0, |sum, (k, weight)| sum + f64::from(*weight) * f64::from(at(place(k) as usize)));
        if sum.is_nan() { at(center) } else { sum as f32 }
    };
    let rows: Vec<f32> = (0..width * height)
        .map(|index| sum(across, width, index % width, &|x| image[index / width * width + x]))
        .collect();
    (0..width * height).map(|index| sum(down, height, index / width, &|y| rows[y * width + index % width])).collect()
}

#[test]
fn all_bits_are_those_of_plain_sums() {
    let hostile = [f32::INFINITY, -f32::INFINITY, f32::NAN, f32::MAX, -0.0, 1e-45];
    // Weights between which some are 0, and fewer of them than rows that are summed together.
    let holes = kernel_of(vec![0.25, 0.0, 0.125, 0.25, 0.125, 0.0, 0.25]);
    let kernels = [0.0, 0.4, 1.0, 3.7, 40.0].map(|size| Kernel::new(Shape::Gaussian, size));
    for size in [[1, 1], [7, 3], [16, 5], [17, 33], [40, 70]] {
        let area = size[0] * size[1];
        let smooth: Vec<f32> = (0..area).map(|index| (index as f32 * 0.37).sin()).collect();
        let rough: Vec<f32> =
            (0..area).map(|index| if index % 11 == 3 { hostile[index / 11 % 6] } else { smooth[index] }).collect();
        let window = Window::sized(size[0] as u32, size[1] as u32);
        for across in kernels.iter().chain([&holes]) {
            for down in kernels.iter().chain([&holes]) {
                for image in [&smooth, &rough] {
                    let mut out = vec![0.0; area];
                    filter([across, down], window, image, window, window, &|| false, &mut out);
                    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
                    assert_eq!(bits(&out), bits(&plain([across, down], size, image)), "{size:?} {across:?} {down:?}");
                }
            }
        }
    }
}

#[test]
fn bits_are_those_of_plain_sums_where_the_order_decides() {
    // Multiples of ¼ ulp of an f32, and numbers too small to change one of these in f64 alone, but not together.
    let unit = 2f32.powi(-23);
    let kernels = [vec![0.25, 0.125, 0.25, 0.125, 0.25], vec![0.125, 0.25, 0.25, 0.25, 0.125]].map(kernel_of);
    let size = [160, 40];
    let window = Window::sized(size[0] as u32, size[1] as u32);
    let mut random = 1u32;
    let mut next = |count: u32| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 16) % count
    };
    let mut differ = 0;
    for signs in [[1.0, 1.0], [1.0, -1.0]] {
        let mut number = || match next(3) {
            0 => 2f32.powi(-52) * (1.0 + next(3) as f32) * signs[next(2) as usize],
            _ => 1.0 + unit * next(4) as f32,
        };
        let image: Vec<f32> = (0..size[0] * size[1]).map(|_| number()).collect();
        for kernel in &kernels {
            let mut out = vec![0.0; image.len()];
            filter([kernel, kernel], window, &image, window, window, &|| false, &mut out);
            let expected = plain([kernel, kernel], size, &image);
            assert!(out.iter().zip(&expected).all(|(out, expected)| out.to_bits() == expected.to_bits()));
            // Across, sums of pairs would give other numbers.
            let weights = weights(kernel).iter().map(|weight| f64::from(*weight)).collect::<Vec<_>>();
            for row in image.chunks(size[0]) {
                differ += row
                    .windows(5)
                    .filter(|row| {
                        let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|index| f64::from(row[index]));
                        let pairs = weights[2] * c + weights[1] * (b + d) + weights[0] * (a + e);
                        let ordered = weights[0] * a + weights[1] * b + weights[2] * c;
                        (ordered + weights[3] * d + weights[4] * e) as f32 != pairs as f32
                    })
                    .count();
            }
        }
    }
    assert!(differ > 20, "{differ}");
}

#[test]
fn infinities_spread_and_opposite_ones_keep_the_center() {
    let window = Window::sized(5, 1);
    let kernel = Kernel::new(Shape::Box, 1.0);
    let inf = f32::INFINITY;
    let mut out = [0.0; 5];
    filter([&kernel, &kernel], window, &[1.0, 2.0, inf, 4.0, -inf], window, window, &|| false, &mut out);
    assert_eq!(out[1..], [inf, inf, 4.0, -inf]);
}

#[test]
fn a_negative_lobe_is_noticed() {
    let mut lobed = weights(&Kernel::new(Shape::Gaussian, 1.0)).to_vec();
    let (last, center) = (lobed.len() - 1, lobed.len() / 2);
    lobed[center] += lobed[0] + lobed[last] + 0.25;
    (lobed[0], lobed[last]) = (-0.125, -0.125);
    let kernel = kernel_of(lobed);
    assert_eq!(sum(&kernel), 1.0);
    let window = Window::sized(16, 4);
    let image: Vec<f32> = (0..64).map(|i| if i % 16 < 8 { 0.0 } else { 1.0 }).collect();
    let mut out = vec![0.0; 64];
    filter([&kernel, &kernel], window, &image, window, window, &|| false, &mut out);
    let hull = Hull::new(&[[0.0; 3], [1.0; 3]]);
    let (exits, worst) = hull.exits(&out, &out, &out, hull.margin(2));
    assert!(exits > 0 && worst > 0.05, "{exits} pixels, by {worst}");
}
