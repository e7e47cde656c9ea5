//! How many waves there are of each length, amplitude and steepness.

use crate::format::thousands;
use crate::theme::ink;
use egui::{Color32, RichText, Ui};
use egui_plot::{Bar, BarChart, Line, Plot, PlotPoints};
use std::f64::consts::TAU;
use trochoid::{Harmonic, LengthDistribution, Spectrum};

/// Number of bars.
const BARS: usize = 32;
/// Share of the waves beyond which the longest ones are only counted: they would squeeze all others together.
const SHOWN: f64 = 0.99;

/// What is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Counted {
    #[default]
    Lengths,
    Amplitudes,
    Steepness,
}

impl Counted {
    const ALL: [(Self, &str, &str); 3] = [
        (Self::Lengths, "Lengths", "Distances from crest to crest"),
        (Self::Amplitudes, "Amplitudes", "Heights of the waves above the rest level, each by itself"),
        (Self::Steepness, "Steepness", "Amplitude times 2π over the length: the steepest slope of each wave"),
    ];

    fn of(self, wave: &Harmonic) -> f64 {
        match self {
            Self::Lengths => wave.wavelength,
            Self::Amplitudes => wave.amplitude.abs(),
            Self::Steepness => wave.amplitude.abs() * TAU / wave.wavelength,
        }
    }

    fn axis(self) -> &'static str {
        match self {
            Self::Lengths => "m, crest to crest",
            Self::Amplitudes => "m",
            Self::Steepness => "steepest slope",
        }
    }
}

/// Numbers of values in equal steps from 0.
#[derive(Clone, Debug, PartialEq)]
struct Histogram {
    step: f64,
    counts: Vec<u64>,
    /// Number of values beyond the last step.
    beyond: usize,
}

impl Histogram {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let last = values.len().saturating_sub(1);
        let widest = values.get((SHOWN * last as f64).ceil() as usize).copied().unwrap_or(0.0);
        // The greatest value is within the last bar.
        let step = if widest > 0.0 { widest * (1.0 + 1e-9) / BARS as f64 } else { 1.0 };
        let mut counts = vec![0; BARS];
        let mut beyond = 0;
        for value in values {
            match counts.get_mut((value / step) as usize) {
                Some(count) => *count += 1,
                None => beyond += 1,
            }
        }
        Self { step, counts, beyond }
    }
}

/// Returns the share of waves per meter at a wavelength; `None` if all have one length.
fn density(lengths: &LengthDistribution, wavelength: f64) -> Option<f64> {
    let LengthDistribution { mean, spread, .. } = *lengths;
    if spread <= 0.0 || wavelength <= 0.0 {
        return None;
    }
    // The mean of a log-normal is exp(μ + σ²/2): μ = ln(mean) − σ²/2.
    let off = (wavelength / mean).ln() / spread + spread / 2.0;
    Some((-off * off / 2.0).exp() / (wavelength * spread * TAU.sqrt()))
}

/// Draws the histogram; for lengths, with the curve from which they are drawn at random.
pub(super) fn histogram_ui(counted: &mut Counted, ui: &mut Ui, spectrum: &Spectrum) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Number of waves").strong());
        for (what, name, help) in Counted::ALL {
            if ui.selectable_label(*counted == what, name).on_hover_text(help).clicked() {
                *counted = what;
            }
        }
    });
    let found = Histogram::of(spectrum.waves.iter().map(|wave| counted.of(wave)).collect());
    let Histogram { step, counts, beyond } = &found;
    let bar = |(index, count): (usize, &u64)| Bar::new((index as f64 + 0.5) * step, *count as f64).width(0.94 * step);
    let bars: Vec<Bar> = counts.iter().enumerate().map(bar).collect();
    let end = BARS as f64 * step;
    let curve: Option<Vec<[f64; 2]>> = spectrum.lengths.filter(|_| *counted == Counted::Lengths).and_then(|lengths| {
        let at = |index: u32| end * f64::from(index) / 200.0;
        (1..=200).map(|index| Some([at(index), density(&lengths, at(index))? * step * lengths.count as f64])).collect()
    });
    let blue = ink(Color32::from_rgb(0x5c, 0x9d, 0xdc), ui.visuals());
    let gold = ink(Color32::from_rgb(0xe8, 0xb0, 0x4a), ui.visuals());
    let has_curve = curve.is_some();
    let plot =
        Plot::new(("histogram", *counted as u8)).height(crate::plots::height(ui, 140.0)).include_y(0.0).include_x(0.0);
    crate::plots::even(plot, counted.axis(), "waves").show(ui, |plot| {
        plot.bar_chart(BarChart::new("", bars).color(blue.gamma_multiply(0.8)));
        if let Some(curve) = curve {
            plot.line(Line::new("", PlotPoints::from(curve)).color(gold).width(1.8));
        }
    });
    let mut notes = Vec::new();
    if has_curve {
        notes.push("The curve is the log-normal one of wavelength and spread.".to_string());
    }
    if *beyond > 0 {
        let waves = if *beyond == 1 { "wave is" } else { "waves are" };
        notes.push(format!("{} {waves} beyond the right end.", thousands(*beyond as u64)));
    }
    if !notes.is_empty() {
        ui.weak(notes.join(" "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_once() {
        let found = Histogram::of((1..=1000).map(f64::from).collect());
        assert_eq!(found.counts.iter().sum::<u64>() as usize + found.beyond, 1000);
        assert_eq!(found.beyond, 9, "the longest hundredth is only counted");
        assert!(found.counts.iter().all(|count| (29..=33).contains(count)), "{found:?}");
        // One wave, none, and waves without height.
        assert_eq!(Histogram::of(vec![7.0]).counts[BARS - 1], 1);
        assert_eq!(Histogram::of(Vec::new()).counts.iter().sum::<u64>(), 0);
        assert_eq!(Histogram::of(vec![0.0; 3]).counts[0], 3);
    }

    #[test]
    fn the_curve_holds_all_waves_and_their_mean() {
        let lengths = LengthDistribution { count: 1, mean: 20.0, spread: 0.5 };
        let step = 0.01;
        let at = |index: u32| (f64::from(index) + 0.5) * step;
        let density = |index: u32| density(&lengths, at(index)).unwrap();
        let sum = |of: &dyn Fn(u32) -> f64| (0..40_000).map(|index| step * of(index)).sum::<f64>();
        assert!((sum(&density) - 1.0).abs() < 1e-4);
        assert!((sum(&|index| at(index) * density(index)) - 20.0).abs() < 1e-2);
        assert_eq!(super::density(&LengthDistribution { spread: 0.0, ..lengths }, 20.0), None);
    }
}
