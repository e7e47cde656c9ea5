//! Tests of fold parameters: eigenvalues, the exact infimum of det J, the predicted share.

use trochoid_sea::{ExplicitWave, FoldOptions, GerstnerSpectrum, Sea, Wave};

fn wave(direction: f64, sharpness: f64, phase: f64) -> Wave {
    let wave = ExplicitWave { wavelength: 10.0, amplitude: 0.5, direction, sharpness, phase, speed: None };
    Wave::try_from(wave).expect("valid")
}

#[test]
fn the_infimum_is_attained_where_all_crests_meet() {
    // Crests of all three meet at the origin: det J = det(I − Qm) = (1−λ₁)(1−λ₂) there.
    let sea = Sea::new(vec![wave(0.0, 0.4, 0.0), wave(1.0, 0.3, 0.0), wave(2.5, 0.2, 0.0)]);
    let folding = sea.folding(FoldOptions::default());
    let crest = sea.at(0.0).evaluate([0.0, 0.0], 0.0).jacobian();
    assert!(folding.proved());
    assert!((folding.jacobian_infimum() - crest).abs() < 1e-12);
    assert!((folding.q_sum - 0.9).abs() < 1e-12);
    assert!(folding.jacobian_min >= crest - 1e-6 && folding.folded_share == 0.0);
}

#[test]
fn one_wave_folds_from_sharpness_one_on() {
    let folding = |sharpness: f64| {
        Sea::new(vec![wave(0.3, sharpness, 0.0)])
            .folding(FoldOptions { tolerated_share: 0.0, ..FoldOptions::default() })
    };
    assert!(folding(0.99).folded_share == 0.0 && folding(0.99).proved());
    let sharp = folding(2.0);
    // cos θ > ½ over a third of the wave.
    assert!((sharp.folded_share - 1.0 / 3.0).abs() < 0.02, "{}", sharp.folded_share);
    assert!((sharp.unfolded_scale - 0.5).abs() < 1e-3, "{}", sharp.unfolded_scale);
    assert_eq!(folding(0.0).unfolded_scale, f64::INFINITY);
}

#[test]
fn the_scale_makes_the_share_tolerable() {
    let spectrum = GerstnerSpectrum { count: 200, height: 4.0, sharpness: 2.5, ..GerstnerSpectrum::default() };
    let options = FoldOptions { samples: 2000, tolerated_share: 0.01, ..FoldOptions::default() };
    let sea = |sharpness| Sea::new(GerstnerSpectrum { sharpness, ..spectrum }.waves().expect("valid"));
    let folding = sea(2.5).folding(options);
    assert!(folding.folded_share > 0.03 && folding.lambda[0] > 1.0 && !folding.proved());
    let gentler = sea(2.5 * folding.unfolded_scale * 0.999).folding(options);
    assert!(gentler.folded_share <= 0.01);
}

#[test]
fn no_waves_do_not_fold() {
    let folding = Sea::default().folding(FoldOptions::default());
    assert_eq!((folding.lambda, folding.folded_share, folding.jacobian_min), ([0.0; 2], 0.0, 1.0));
}
