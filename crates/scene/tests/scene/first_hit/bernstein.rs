//! Tests of polynomials in Bézier form.

use trochoid_scene::inside::first_hit::{
    Net, SIDE, bent_bases_at, evaluate, interpolated, nodes, off, part, range, range_by_all_instructions, split,
};

fn some(net: impl Fn(f64, f64) -> f64) -> Net {
    nodes::<SIDE>().map(|s| nodes::<SIDE>().map(|t| net(0.5 + 0.5 * s, 0.5 + 0.5 * t)))
}

#[test]
fn polynomials_are_found_from_their_values_within_the_rounding() {
    for case in 0..50 {
        let part = |by: f64| (f64::from(case) * by).fract() - 0.5;
        let of = |s: f64, t: f64| {
            1.0 + part(0.618) * s + part(0.414) * t * t + part(0.732) * libm::pow(s, 8.0) * libm::pow(t, 7.0)
        };
        let values = some(of);
        let net = interpolated(&values);
        let largest = net.as_flattened().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let rounding = off() * largest;
        assert!(rounding < 1e-8, "{rounding:e}");
        for i in 0..=20 {
            let at = [f64::from(i) / 20.0, (f64::from(i) * 0.37).fract()];
            let (value, _) = evaluate(&net, at);
            assert!((value - of(at[0], at[1])).abs() <= rounding, "{at:?}: {value}");
        }
        let step = 1e-6;
        let (value, slopes) = evaluate(&net, [0.3, 0.7]);
        assert!((value - of(0.3, 0.7)).abs() <= rounding);
        let slope = [of(0.3 + step, 0.7) - of(0.3 - step, 0.7), of(0.3, 0.7 + step) - of(0.3, 0.7 - step)];
        assert!((0..2).all(|axis| (slopes[axis] - slope[axis] / (2.0 * step)).abs() < 1e-8));
    }
}

#[test]
fn what_interpolation_rounds_is_bounded_by_how_much_it_may_enlarge() {
    // The sizes of each coefficient over all values that are 1 at one point.
    let mut sizes = [[0.0; SIDE]; SIDE];
    for point in 0..SIDE * SIDE {
        let mut values = [[0.0; SIDE]; SIDE];
        values.as_flattened_mut()[point] = 1.0;
        for (size, value) in sizes.as_flattened_mut().iter_mut().zip(interpolated(&values).as_flattened()) {
            *size += value.abs();
        }
    }
    let [_, most] = range(&sizes);
    assert!(most > 5e4, "{most}");
    // Lebesgue's constant on both sides; two sums of nine products, and their factors.
    let expected = 2.3 * 2.3 * 20.0 * f64::EPSILON * most;
    assert!(expected < off() && off() < 2.0 * expected, "{:e} instead of {expected:e}", off());
    // Hostile values: signs at random.
    for case in 0..200_u32 {
        let sign = |i: usize, j: usize| {
            if (f64::from(case) * 0.618 + 0.37 * (9 * i + j) as f64).fract() < 0.5 { 1.0 } else { -1.0 }
        };
        let values: Net = std::array::from_fn(|i| std::array::from_fn(|j| sign(i, j)));
        let net = interpolated(&values);
        let largest = net.as_flattened().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (i, s) in nodes::<SIDE>().into_iter().enumerate() {
            for (j, t) in nodes::<SIDE>().into_iter().enumerate() {
                let (value, _) = evaluate(&net, [0.5 + 0.5 * s, 0.5 + 0.5 * t]);
                assert!((value - values[i][j]).abs() <= off() * largest, "{value} at {i}, {j}");
            }
        }
    }
}

#[test]
fn bases_and_their_derivatives_make_those_of_polynomials() {
    let net = interpolated(&some(|s, _| s * s * s - 0.4 * libm::pow(s, 8.0)));
    let sum = |basis: &[f64; SIDE]| basis.iter().zip(net).map(|(factor, row)| factor * row[0]).sum::<f64>();
    for index in 0..=10 {
        let s = f64::from(index) / 10.0;
        let expected = [
            s * s * s - 0.4 * libm::pow(s, 8.0),
            3.0 * s * s - 3.2 * libm::pow(s, 7.0),
            6.0 * s - 22.4 * libm::pow(s, 6.0),
        ];
        for (basis, expected) in bent_bases_at(s).iter().zip(expected) {
            assert!((sum(basis) - expected).abs() < 1e-10, "at {s}: {} {expected}", sum(basis));
        }
    }
}

#[test]
fn ranges_are_the_same_with_all_instructions_of_the_machine() {
    let part = |case: u32, by: f64| (f64::from(case) * by + 0.3).fract() - 0.5;
    for case in 0..2000 {
        let net: Net = std::array::from_fn(|i| {
            std::array::from_fn(|j| part(case * 100 + (SIDE * i + j) as u32, 0.618_033_988_749))
        });
        let all = net.as_flattened().iter();
        let expected = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [if *value < low { *value } else { low }, if *value > high { *value } else { high }]
        });
        let found = range_by_all_instructions(&net);
        assert_eq!(found, range(&net), "{net:?}");
        assert_eq!(found, expected, "{net:?}");
    }
}

#[test]
fn halves_and_parts_are_the_same_polynomial() {
    let net = interpolated(&some(|s, t| s * s * s - 0.4 * t + s * t * t));
    let same = |piece: &Net, start: [f64; 2], size: [f64; 2]| {
        for at in [[0.2, 0.9], [1.0, 0.5], [0.0, 0.3]] {
            let whole = [0, 1].map(|axis| start[axis] + size[axis] * at[axis]);
            let ((a, _), (b, _)) = (evaluate(piece, at), evaluate(&net, whole));
            assert!((a - b).abs() < 1e-12, "{a} {b}");
            let [least, most] = range(piece);
            assert!(least <= a + 1e-12 && a <= most + 1e-12);
        }
    };
    for along_s in [true, false] {
        let size = if along_s { [0.5, 1.0] } else { [1.0, 0.5] };
        let upper = if along_s { [0.5, 0.0] } else { [0.0, 0.5] };
        for takes_low in [true, false] {
            let mut left = net;
            let taken = split(&mut left, along_s, takes_low);
            let [low, high] = if takes_low { [taken, left] } else { [left, taken] };
            same(&low, [0.0; 2], size);
            same(&high, upper, size);
        }
    }
    for (start, size) in [([0.25, 0.5], [0.125, 0.5]), ([0.0, 0.75], [1.0, 0.25]), ([0.0; 2], [1.0; 2])] {
        same(&part(&net, start, size), start, size);
    }
}
