//! Tests of random spectra: their sizes, their directions, and which knobs they refuse.

use std::f64::consts::TAU;
use trochoid_sea::{Convention, Dispersion, GRAVITY, GerstnerSpectrum, MAX_WAVES, Sea, Wave};

fn spectrum() -> GerstnerSpectrum {
    GerstnerSpectrum { count: 4000, height: 4.0, sharpness: 0.7, seed: 7, ..GerstnerSpectrum::default() }
}

fn waves(spectrum: GerstnerSpectrum) -> Vec<Wave> {
    spectrum.waves().expect("valid knobs")
}

#[test]
fn height_is_four_times_the_rms() {
    for count in [1, 10, 4000] {
        let sea = Sea::new(waves(GerstnerSpectrum { count, ..spectrum() }));
        assert!((4.0 * sea.height_rms() - 4.0).abs() < 1e-12);
    }
}

#[test]
fn wavelength_is_the_mean_and_spread_the_deviation_of_the_logarithm() {
    let waves = waves(spectrum());
    let n = waves.len() as f64;
    let mean = waves.iter().map(|wave| wave.wavelength).sum::<f64>() / n;
    assert!((mean - 20.0).abs() < 0.6, "{mean}");
    let logs: Vec<f64> = waves.iter().map(|wave| wave.wavelength.ln()).collect();
    let center = logs.iter().sum::<f64>() / n;
    let deviation = (logs.iter().map(|log| (log - center).powi(2)).sum::<f64>() / n).sqrt();
    assert!((deviation - 0.5).abs() < 0.02, "{deviation}");
}

#[test]
fn directions_spread_around_the_azimuth() {
    let waves = waves(GerstnerSpectrum { direction: 1.0, direction_spread: 0.2, ..spectrum() });
    let azimuths: Vec<f64> = waves.iter().map(|wave| wave.direction[1].atan2(wave.direction[0])).collect();
    let mean = azimuths.iter().sum::<f64>() / azimuths.len() as f64;
    assert!((mean - 1.0).abs() < 0.01, "{mean}");
}

#[test]
fn more_waves_do_not_reshuffle_the_earlier_ones() {
    let (few, many) = (waves(GerstnerSpectrum { count: 10, ..spectrum() }), waves(spectrum()));
    for (a, b) in few.iter().zip(&many) {
        assert_eq!((a.wavelength, a.direction, a.phase), (b.wavelength, b.direction, b.phase));
    }
}

#[test]
fn seeds_make_different_seas() {
    let other = waves(GerstnerSpectrum { seed: 8, ..spectrum() });
    assert!(waves(spectrum()).iter().zip(&other).all(|(a, b)| a.phase != b.phase));
}

#[test]
fn sharpness_is_the_compression_of_the_sharpest_crests() {
    let sum =
        |count: usize| -> f64 { waves(GerstnerSpectrum { count, ..spectrum() }).iter().map(Wave::compression).sum() };
    // Few waves can meet, and then add up to the sharpness: they do not fold below 1.
    for count in 1..=3 {
        assert!((sum(count) - 0.7).abs() < 1e-12);
    }
    let squares: f64 = waves(spectrum()).iter().map(|wave| wave.compression().powi(2) / 2.0).sum();
    assert!((2.5 * squares.sqrt() - 0.7).abs() < 1e-12);
}

#[test]
fn dispersions_follow_their_formulas() {
    let first = |dispersion| waves(GerstnerSpectrum { count: 1, dispersion, ..spectrum() })[0];
    let deep = first(Dispersion::Deep);
    assert!((deep.angular_frequency.powi(2) - GRAVITY * deep.wave_number()).abs() < 1e-12);
    let speed = first(Dispersion::Speed(3.0));
    assert!((speed.angular_frequency / speed.wave_number() - 3.0).abs() < 1e-12);
    assert!((first(Dispersion::Period(4.0)).angular_frequency - TAU / 4.0).abs() < 1e-12);
}

#[test]
fn the_thesis_convention_keeps_printed_signs_and_weights() {
    let waves = waves(GerstnerSpectrum { count: 5, convention: Convention::Thesis, ..spectrum() });
    for wave in waves {
        // ω·s·a with a = (height/2)·L/mean; x += D₀·d is a negative horizontal amplitude here.
        assert!((wave.amplitude - 0.7 * 2.0 * wave.wavelength / 20.0 / 5.0).abs() < 1e-12);
        assert_eq!(wave.horizontal, -wave.amplitude);
    }
}

#[test]
fn knobs_outside_their_range_are_refused_by_name() {
    let refuse = |spectrum: GerstnerSpectrum| spectrum.waves().expect_err("refused").to_string();
    assert!(refuse(GerstnerSpectrum { wavelength: 0.0, ..spectrum() }).contains("wavelength 0"));
    assert!(refuse(GerstnerSpectrum { height: f64::NAN, ..spectrum() }).contains("height NaN"));
    assert!(refuse(GerstnerSpectrum { count: MAX_WAVES + 1, ..spectrum() }).contains("100001 waves"));
    assert!(refuse(GerstnerSpectrum { dispersion: Dispersion::Period(0.0), ..spectrum() }).contains("period"));
    assert!(waves(GerstnerSpectrum { count: 0, ..spectrum() }).is_empty());
    assert!(waves(GerstnerSpectrum { height: 0.0, ..spectrum() }).iter().all(|wave| wave.horizontal == 0.0));
}
