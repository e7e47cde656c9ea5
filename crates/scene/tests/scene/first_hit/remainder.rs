//! Tests of bounds of the distance of seas from polynomials.

use super::{part, projector};
use trochoid_scene::inside::first_hit::{LONG_POINTS, POINTS, Remainders, SIDE, SeaFootprints, nodes};
use trochoid_scene::inside::{carried, heading};
use trochoid_scene::{DVec3, Projector, SeaSurface};
use trochoid_sea::{ExplicitWave, Sea, Wave};

/// Returns the factors of N Chebyshev points at a place.
fn factors<const N: usize>(at: f64) -> [f64; N] {
    let points = nodes::<N>();
    std::array::from_fn(|own| {
        (0..N).filter(|other| *other != own).map(|other| (at - points[other]) / (points[own] - points[other])).product()
    })
}

/// Returns how far a sea carries a rest point, given from the middle of a square.
fn moved(sea: &SeaSurface, projector: &Projector, rest: [f64; 2]) -> DVec3 {
    carried(sea, projector, rest).0 - DVec3::new(rest[0], sea.level(), rest[1])
}

/// Returns what the polynomial through N points a side makes of it.
fn interpolated<const N: usize>(displaced: impl Fn([f64; 2]) -> DVec3, [s, t]: [f64; 2]) -> DVec3 {
    let (points, by_s, by_t) = (nodes::<N>(), factors::<N>(s), factors::<N>(t));
    let mut sum = DVec3::ZERO;
    for (s, by_s) in points.into_iter().zip(by_s) {
        for (t, by_t) in points.into_iter().zip(by_t) {
            sum += by_s * by_t * displaced([s, t]);
        }
    }
    sum
}

/// Waves at random, by falling wavelength.
fn random_waves(case: u32, count: u32) -> Vec<Wave> {
    let mut waves: Vec<Wave> = (0..count)
        .map(|index| {
            let pick = |by: f64| part(97 * case + index, by);
            let wave = ExplicitWave {
                wavelength: libm::exp(5.0 * pick(0.618) - 1.0),
                amplitude: if index == 2 { 0.0 } else { pick(0.414) },
                direction: 6.3 * pick(0.732),
                sharpness: 1.5 * pick(0.31),
                phase: 6.3 * pick(0.21),
                speed: None,
            };
            Wave::try_from(wave).expect("valid")
        })
        .collect();
    waves.sort_by(|a, b| b.wavelength.total_cmp(&a.wavelength));
    waves
}

fn surface(waves: &[Wave]) -> SeaSurface {
    SeaSurface::new(&Sea::new(waves.to_vec()), 3.0, 0.4)
}

/// Returns the theorem's bound 4M·ρ⁻ⁿ/(1 − 1/ρ) for a wave of size 1 under a constant footprint and n points, with `turned`
/// radians from the middle to the end: the best of very many ellipses.
fn theorem(turned: f64, points: usize) -> f64 {
    let of = |step: i32| {
        let rho = libm::exp(0.002 * f64::from(step));
        let exponent = turned * (rho - 1.0 / rho) / 2.0 - points as f64 * libm::log(rho);
        4.0 * libm::exp(exponent) / (1.0 - 1.0 / rho)
    };
    (1..4000).map(of).fold(f64::INFINITY, f64::min)
}

#[test]
fn kept_waves_are_bounded_by_the_theorem_and_lost_ones_by_their_size() {
    let (mut kept, mut lost, mut loosest) = (0, 0, 0.0_f64);
    let (mut nearest, mut steepest) = ([0.0_f64; 2], 0.0_f64);
    for case in 0..1200_u32 {
        // Under a constant footprint, the theorem's largest value on an ellipse is known.
        let case = 7 * case + 5;
        let wave = random_waves(case, 1);
        let (sea, projector) = (surface(&wave), projector(case, [0.0, 0.0]));
        let remainders = Remainders::new(&sea, &projector);
        let half = libm::exp(5.0 * part(case, 0.83) - 3.5);
        let bound = remainders.of(false, 3.0, half, 3.0 + 2.0 * half);
        let print = SeaFootprints::new(&sea, &projector).change(3.0).0;
        let (k, [x, z]) = (wave[0].wave_number(), heading(&projector));
        let [along, across] =
            [wave[0].direction[0] * x + wave[0].direction[1] * z, wave[0].direction[1] * x - wave[0].direction[0] * z];
        let share = libm::exp(-k * k * print * print / 8.0);
        let amplitudes =
            [wave[0].horizontal * along, wave[0].amplitude, wave[0].horizontal * across].map(|size| size.abs() * share);
        let rest = |[s, t]: [f64; 2]| remainders.rest([3.0 + half * s, half * t]);
        let of = |at: [f64; 2]| moved(&sea, &projector, rest(at));
        let off = |at: [f64; 2]| {
            let found = if bound.waves > 0 { interpolated::<SIDE>(of, at) } else { DVec3::ZERO };
            found - of(at)
        };
        let mut worst = [0.0_f64; 3];
        for pick in 0..40 {
            let end = |by: f64| libm::cos(std::f64::consts::PI * part(pick, by));
            let at = [end(0.618), end(0.414)];
            // Differences lose digits.
            let (step, loss) = (1e-4, 1e-9);
            let turn = (off([at[0] + step, at[1]]) - off([at[0] - step, at[1]])).length() / (2.0 * step);
            let most = bound.turn_at(at[0]);
            if at[0].abs() < 1.0 - 2.0 * step && k * half < 30.0 {
                assert!(turn <= 1.001 * most + loss, "case {case} at {at:?}: {turn:e} above {most:e}");
                steepest = steepest.max((turn - loss) / most);
            }
            let off = off(at);
            let own = [off.x * x + off.z * z, off.y, off.z * x - off.x * z];
            for (worst, off) in worst.iter_mut().zip(own) {
                *worst = worst.max(off.abs());
            }
        }
        for axis in 0..3 {
            assert!(worst[axis] <= bound.off[axis] + 1e-13, "case {case}: {worst:?} above {:?}", bound.off);
            // A millionth is left of a lost wave.
            if amplitudes[axis] < 1e-10 {
                continue;
            }
            let share = worst[axis] / bound.off[axis];
            if bound.waves == 0 {
                nearest[1] = nearest[1].max(share);
                lost += 1;
                continue;
            }
            // What interpolation along v leaves is enlarged by that along u: at least by 1, at most by 2.4.
            let least = [along, across].map(|way| theorem(k * way.abs() * half, SIDE));
            let least = amplitudes[axis] * (least[0] + least[1]);
            assert!(bound.off[axis] >= least * (1.0 - 1e-9), "case {case}: {:e} below {least:e}", bound.off[axis]);
            if least > 1e-10 && least < 0.1 * amplitudes[axis] {
                nearest[0] = nearest[0].max(share);
                loosest = loosest.max(bound.off[axis] / least);
                kept += 1;
            }
        }
    }
    assert!(steepest > 0.1, "derivatives are at {steepest} of their bound");
    assert!(kept > 300 && lost > 100, "{kept} kept, {lost} lost");
    assert!(
        nearest[0] > 0.02 && nearest[1] > 0.1 && loosest < 8.0,
        "{nearest:?} of the bounds, {loosest} of the theorem"
    );
}

#[test]
fn polynomials_are_as_close_to_the_sea_as_their_remainder_says() {
    let (mut looked_at, mut nearest, mut with_long, mut lost) = (0, 0.0_f64, 0, 0);
    for case in 0..240_u32 {
        let waves = random_waves(case, [1, 3, 9, 20][case as usize % 4]);
        let (sea, projector) = (surface(&waves), projector(case, [0.0, 0.0]));
        let remainders = Remainders::new(&sea, &projector);
        let ahead = libm::exp(6.0 * part(case, 0.57)) - 3.0;
        let half = libm::exp(5.0 * part(case, 0.83) - 3.5);
        let has_kink = |kink: f64| (kink - ahead).abs() < half;
        if SeaFootprints::new(&sea, &projector).kinks().into_iter().any(has_kink) {
            continue;
        }
        let is_square = case % 3 > 0;
        let bound = remainders.of(is_square, ahead, half, ahead.abs() + 2.0 * half);
        let rest = |[s, t]: [f64; 2]| remainders.rest([ahead + half * s, half * t]);
        let (long, short) = (surface(&waves[..bound.long]), surface(&waves[bound.long..bound.waves]));
        let of = |sea: &SeaSurface, at: [f64; 2]| moved(sea, &projector, rest(at));
        with_long += usize::from(bound.long > 0);
        lost += usize::from(bound.waves < waves.len());
        for pick in 0..4 {
            let at = [2.0 * part(pick, 0.618) - 1.0, 2.0 * part(pick, 0.414) - 1.0];
            let found = if is_square {
                interpolated::<LONG_POINTS>(|at| of(&long, at), at) + interpolated::<POINTS>(|at| of(&short, at), at)
            } else {
                interpolated::<SIDE>(|at| of(&short, at), at)
            };
            let off = found - of(&sea, at);
            let [x, z] = heading(&projector);
            let own = [off.x * x + off.z * z, off.y, off.z * x - off.x * z];
            for (off, bound) in own.map(f64::abs).into_iter().zip(bound.off) {
                assert!(off <= bound + 1e-13, "case {case}: {off:e} above {bound:e}");
                nearest = nearest.max((off - 1e-13) / bound);
            }
        }
        looked_at += 1;
    }
    assert!(looked_at > 150 && with_long > 30 && lost > 10, "{looked_at}, {with_long} with long waves, {lost} lost");
    assert!(0.1 < nearest, "the nearest is at {nearest} of its bound");
}
