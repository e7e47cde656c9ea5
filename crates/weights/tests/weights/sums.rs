//! Tests of weights from outside that are made to sum to 1.

use trochoid_weights::sums::{is_off, part, sums};

#[test]
fn parts_sum_to_one_and_exact_partitions_stay() {
    let planes: [&[f32]; 3] = [&[0.25, 0.0, 0.3, 1e-45], &[0.5, 0.0, 0.3, 0.0], &[0.25, 0.0, 0.4, 1.0]];
    let sums = sums(&planes);
    assert_eq!(sums[..2], [1.0, 0.0]);
    for (x, sum) in sums.iter().enumerate() {
        let parts = planes.map(|plane| part(plane[x], *sum, 3));
        assert!((parts.iter().sum::<f64>() - 1.0).abs() <= 6.0 * f64::EPSILON, "{parts:?}");
    }
    assert_eq!(planes.map(|plane| part(plane[0], sums[0], 3)), [0.25, 0.5, 0.25]);
    assert!(!is_off(1.0009) && is_off(1.0011) && is_off(0.0) && is_off(f64::NAN));
}
