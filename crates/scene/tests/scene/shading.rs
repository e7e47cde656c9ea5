//! Tests of the fast forms of shading against their references.

use glam::{DVec3, Vec3};
use trochoid_scene::shading::{blinn, facing, facings, fresnel, lambert};

/// Returns deterministic directions, some of them degenerate.
fn directions(seed: u64, count: usize) -> Vec<DVec3> {
    let mut state = seed;
    let mut unit = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let direction = |index: usize| if index % 50 == 49 { DVec3::ZERO } else { DVec3::new(unit(), unit(), unit()) };
    (0..count).map(direction).map(|v| v.as_vec3().try_normalize().unwrap_or(Vec3::ZERO).as_dvec3()).collect()
}

struct Columns([Vec<f32>; 3]);

impl Columns {
    fn new(vectors: &[DVec3]) -> Self {
        Self([0, 1, 2].map(|axis| vectors.iter().map(|vector| vector[axis] as f32).collect()))
    }

    fn all(&self) -> [&[f32]; 3] {
        [&self.0[0], &self.0[1], &self.0[2]]
    }
}

const COUNT: usize = 2000;

fn worst(fast: &[f32], exact: impl Fn(usize) -> f64) -> f64 {
    let error = |(index, &value): (usize, &f32)| {
        assert!((0.0..=1.0).contains(&value), "{value}");
        (f64::from(value) - exact(index)).abs()
    };
    fast.iter().enumerate().map(error).fold(0.0, f64::max)
}

#[test]
fn lambert_fast_is_the_reference() {
    let (n, l) = (directions(1, COUNT), directions(2, COUNT));
    for power in [1.0, 2.0, 3.5] {
        let mut out = vec![0.0; COUNT];
        lambert::fill(Columns::new(&n).all(), Columns::new(&l).all(), power as f32, &mut out);
        let worst = worst(&out, |index| lambert::reference(n[index], l[index], power));
        assert!(worst < 1e-6, "power {power}: {worst:e}");
    }
    assert_eq!(lambert::reference(DVec3::Y, DVec3::Y, 1.0), 1.0);
    assert_eq!(lambert::reference(DVec3::Y, DVec3::NEG_Y, 1.0), 0.0);
    assert_eq!(lambert::reference(DVec3::ZERO, DVec3::X, 2.0), 0.25);
}

#[test]
fn facings_have_the_bits_of_single_ones() {
    let (mut n, v) = (directions(8, COUNT), directions(9, COUNT));
    let hostile = [f64::NAN, f64::INFINITY, -0.0, 1e-300, 1e-45, 1e38];
    n.iter_mut().step_by(7).enumerate().for_each(|(index, normal)| normal[index % 3] = hostile[index % 6]);
    let mut out = vec![f64::NAN; COUNT];
    facings(Columns::new(&n).all(), Columns::new(&v).all(), &mut out);
    for (index, (normal, view)) in n.iter().zip(&v).enumerate() {
        let [normal, view] = [normal, view].map(|vector| vector.as_vec3().as_dvec3());
        assert_eq!(out[index].to_bits(), facing(normal, view).to_bits(), "{normal} {view}");
    }
    assert!(out.iter().filter(|facing| **facing > 0.0).count() > COUNT / 3);
}

#[test]
fn blinn_fast_is_the_reference() {
    let (n, l, v) = (directions(3, COUNT), directions(4, COUNT), directions(5, COUNT));
    let variances: Vec<f32> = (0..COUNT).map(|index| (index % 7) as f32 * 0.01).collect();
    for model in [blinn::Model::Half, blinn::Model::Reflection] {
        for exponent in [0.0, 1.0, 60.0] {
            let mut out = vec![0.0; COUNT];
            let (n_columns, l_columns, v_columns) = (Columns::new(&n), Columns::new(&l), Columns::new(&v));
            blinn::fill(
                n_columns.all(),
                l_columns.all(),
                v_columns.all(),
                exponent as f32,
                &variances,
                model,
                &mut out,
            );
            let exact = |index: usize| {
                blinn::reference(n[index], l[index], v[index], exponent, f64::from(variances[index]), model)
            };
            // At exponent 0 the lobe jumps where a cosine changes its sign; random directions do not hit that.
            let worst = worst(&out, exact);
            assert!(worst < 1e-5, "{model:?} {exponent}: {worst:e}");
        }
    }
}

#[test]
fn sharp_highlights_keep_their_precision() {
    // Half vector 1e-3 rad off the normal at s = 1e6: exp(−½).
    let half = DVec3::new(libm::sin(1e-3), libm::cos(1e-3), 0.0);
    let exact = blinn::reference(DVec3::Y, half, half, 1e6, 0.0, blinn::Model::Half);
    assert!((exact - (-0.5_f64).exp()).abs() < 1e-6, "{exact}");
    let (n, h) = (Columns::new(&[DVec3::Y]), Columns::new(&[half]));
    let mut out = [0.0];
    blinn::fill(n.all(), h.all(), h.all(), 1e6, &[], blinn::Model::Half, &mut out);
    // f32 directions are themselves off by 6e-8, 6e-5 of this angle.
    assert!((f64::from(out[0]) - exact).abs() < 1e-4, "{}", out[0]);
}

#[test]
fn blinn_edges() {
    let lobe = |l: DVec3, v: DVec3, s: f64| blinn::reference(DVec3::Y, l, v, s, 0.0, blinn::Model::Half);
    assert_eq!(lobe(DVec3::Y, DVec3::Y, 1e6), 1.0);
    assert_eq!(lobe(DVec3::NEG_Y, DVec3::NEG_Y, 1.0), 0.0);
    assert_eq!(lobe(DVec3::X, DVec3::NEG_X, 1.0), 0.0);
    let mirrored = DVec3::new(0.6, 0.8, 0.0);
    let view = DVec3::new(-0.6, 0.8, 0.0);
    assert!((blinn::reference(DVec3::Y, mirrored, view, 1e4, 0.0, blinn::Model::Reflection) - 1.0).abs() < 1e-9);
    // Variance widens the lobe: 1/s' = 1/s + v/2.
    assert!((blinn::widened(100.0, 0.02, blinn::Model::Half) - 50.0).abs() < 1e-12);
}

#[test]
fn schlick_fast_is_the_reference() {
    let (n, l, v) = (directions(6, COUNT), directions(7, COUNT), directions(8, COUNT));
    for cosine in [fresnel::Cosine::View, fresnel::Cosine::Half] {
        let mut out = vec![0.0; COUNT];
        let (n_columns, l_columns, v_columns) = (Columns::new(&n), Columns::new(&l), Columns::new(&v));
        fresnel::fill(n_columns.all(), l_columns.all(), v_columns.all(), 1.333, cosine, &mut out);
        let worst = worst(&out, |index| fresnel::reference(n[index], l[index], v[index], 1.333, cosine));
        // The half vector of nearly opposite directions has few significant digits.
        assert!(worst < 2e-5, "{cosine:?}: {worst:e}");
    }
    assert_eq!(fresnel::schlick(1.0, 1.5), fresnel::normal_reflectance(1.5));
    assert_eq!(fresnel::schlick(-3.0, 1.5), 1.0);
    assert_eq!(fresnel::schlick(0.3, 1.0), 0.7_f64.powi(5));
}
