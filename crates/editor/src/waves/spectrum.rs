//! The waves of a sea: whether crests fold, amplitudes over lengths, and directions.

use super::sea::Sea;
use crate::document::edit::count;
use crate::document::{Path, Sheet};
use crate::format::thousands;
use crate::theme::ink;
use egui::{Color32, RichText, Ui};
use egui_plot::{Plot, PlotPoints, Points};
use serde_json::Value;
use trochoid::Spectrum;

/// Most waves that a plot draws: more cannot be told apart.
const MOST: usize = 2000;

/// Says whether crests fold over.
pub(super) fn folding_ui(ui: &mut Ui, spectrum: &Spectrum) {
    let (text, color) = match spectrum.unfolded {
        margin if margin.is_infinite() => ("Crests never fold over.".into(), ui.visuals().text_color()),
        margin if margin >= 1.0 => (
            format!("Crests do not fold over, up to {margin:.2} times the current sharpness."),
            ui.visuals().text_color(),
        ),
        margin => (
            format!("Crests fold over: they would not at {margin:.2} times the sharpness."),
            ui.visuals().warn_fg_color,
        ),
    };
    ui.label(RichText::new(text).color(color));
}

/// Draws amplitudes over lengths, and directions.
pub(super) fn spectrum_ui(ui: &mut Ui, spectrum: &Spectrum, sheet: &Sheet, sea: &Sea<'_>) {
    ui.label(RichText::new(format!("{}: amplitude over length", counted(spectrum.waves.len()))).strong());
    let body = sea.node.and_then(|node| sheet.get(&Path::node(&node.name)));
    let listed = |list: &str| body.and_then(|body| body.get(list)).and_then(Value::as_array).map_or(0, Vec::len);
    let random = spectrum.lengths.map_or(0, |lengths| lengths.count);
    if let Some(text) =
        parts(spectrum.waves.len(), random, listed("waves"), listed("groups")).filter(|_| body.is_some())
    {
        ui.weak(text);
    }
    let step = spectrum.waves.len().div_ceil(MOST).max(1);
    let stems: Vec<[f64; 2]> =
        spectrum.waves.iter().step_by(step).map(|wave| [wave.wavelength.log10(), wave.amplitude.abs()]).collect();
    let plot = Plot::new("spectrum").height(crate::plots::height(ui, 150.0)).include_y(0.0);
    let color = ink(Color32::from_rgb(0x3f, 0xb5, 0xb0), ui.visuals());
    crate::plots::logarithmic(plot, "m, crest to crest", "m").show(ui, |plot| {
        plot.points(Points::new("", PlotPoints::from(stems)).stems(0.0).radius(1.5).color(color));
    });
    ui.label(RichText::new("Directions of travel").strong());
    let rose: Vec<[f64; 2]> = spectrum
        .waves
        .iter()
        .step_by(step)
        .map(|wave| {
            let (sin, cos) = wave.direction.to_radians().sin_cos();
            [cos * wave.amplitude.abs(), -sin * wave.amplitude.abs()]
        })
        .collect();
    let reach = rose.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    let side = crate::plots::side(ui, 180.0);
    let plot = Plot::new("rose").width(side).height(side).data_aspect(1.0);
    let color = ink(Color32::from_rgb(0x5c, 0x9d, 0xdc), ui.visuals());
    crate::plots::above(plot, "along X: amplitude in m", "along Z, m")
        .include_x(-reach)
        .include_x(reach)
        .include_y(-reach)
        .include_y(reach)
        .show(ui, |plot| {
            plot.points(Points::new("", PlotPoints::from(rose)).radius(1.5).color(color));
        });
}

fn counted(waves: usize) -> String {
    let noun = if waves == 1 { "wave" } else { "waves" };
    format!("{} {noun}", thousands(waves as u64))
}

/// Describes the sources of a sea's waves, unless all are random.
fn parts(all: usize, random: usize, by_hand: usize, groups: usize) -> Option<String> {
    let of_groups = all.checked_sub(random + by_hand)?;
    let mut parts = Vec::new();
    if random > 0 {
        parts.push(format!("{} random", thousands(random as u64)));
    }
    if by_hand > 0 {
        parts.push(format!("{} set by hand", thousands(by_hand as u64)));
    }
    if of_groups > 0 {
        let groups = count(groups, "group");
        parts.push(format!("{} of {groups}", thousands(of_groups as u64)));
    }
    (parts.len() > 1).then(|| parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_names_waves_that_are_not_random() {
        assert_eq!(parts(300, 300, 0, 0), None);
        assert_eq!(parts(1, 0, 1, 0), None);
        assert_eq!(parts(754, 300, 4, 1).as_deref(), Some("300 random, 4 set by hand, 450 of 1 group"));
        assert_eq!(parts(750, 300, 0, 2).as_deref(), Some("300 random, 450 of 2 groups"));
    }
}
