//! The surface above a line, seen from the side: crests are sharp where waves move the water toward them.

use crate::field::Number;
use crate::format::measure;
use crate::theme::ink;
use egui::{Color32, RichText, Ui, WidgetInfo, WidgetType};
use egui_plot::{HLine, Line, Plot, PlotPoint, PlotPoints};
use trochoid::{Profile, ProfileLine, ProfilePoint};

/// Number of points of a profile: as many as a wide panel has pixels.
const POINTS: usize = 512;

/// Which line the panel shows. Nothing of it is part of the document.
pub(super) struct Section {
    /// Whether lengths and heights have the same scale.
    equal: bool,
    /// Angle from the direction of travel, degrees.
    turned: f64,
    /// World x and z of the middle, if it was set.
    through: Option<[f64; 2]>,
    /// Length in meters, if it was set.
    length: Option<f64>,
}

impl Default for Section {
    fn default() -> Self {
        Self { equal: false, turned: 0.0, through: None, length: None }
    }
}

impl Section {
    /// Returns the line in a sea that travels in this direction, in degrees.
    pub(super) fn line(&self, direction: f64) -> ProfileLine {
        ProfileLine { through: self.through, direction: direction + self.turned, length: self.length, points: POINTS }
    }
}

/// Returns the pieces of a surface that are turned over, each with the points around it.
fn folds(points: &[ProfilePoint]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces = Vec::new();
    let mut rest = points;
    while let Some(first) = rest.iter().position(|point| point.folded) {
        let count = rest[first..].iter().take_while(|point| point.folded).count();
        let end = (first + count + 1).min(rest.len());
        pieces.push(rest[first.saturating_sub(1)..end].iter().map(place).collect());
        rest = &rest[first + count..];
    }
    pieces
}

fn place(point: &ProfilePoint) -> [f64; 2] {
    [point.along, point.height]
}

/// Describes a profile to those who cannot see it.
fn spoken(points: &[ProfilePoint]) -> String {
    let heights = points.iter().map(|point| point.height);
    let (low, high) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)));
    format!("Profile, heights from {} to {} m", measure(low), measure(high))
}

/// Height that the profile takes with its fields, about.
pub(super) const HEIGHT: f32 = 200.0;

/// Draws the profile, and the fields that choose its line.
pub(super) fn profile_ui(section: &mut Section, ui: &mut Ui, profile: &Profile, title: &str, is_late: bool) {
    ui.label(RichText::new(title).strong());
    line_ui(section, ui, profile);
    let surface: Vec<[f64; 2]> = profile.points.iter().map(place).collect();
    if surface.len() < 2 {
        ui.weak("The line misses the sea: set x and z to a place on it.");
        return;
    }
    let folds = folds(&profile.points);
    let (water, turned) = (ink(Color32::from_rgb(0x3f, 0xb5, 0xb0), ui.visuals()), ui.visuals().warn_fg_color);
    let water = if is_late { water.gamma_multiply(0.5) } else { water };
    let weak = ui.visuals().weak_text_color();
    let is_folded = !folds.is_empty();
    let mut plot = Plot::new(("profile", section.equal)).height(crate::plots::height(ui, 130.0));
    if section.equal {
        plot = plot.data_aspect(1.0);
    }
    let shown = crate::plots::even(plot, "m along the line", "m").show(ui, |plot| {
        plot.hline(HLine::new("", 0.0).color(weak).width(0.5));
        plot.line(Line::new("", PlotPoints::from(surface)).color(water).width(1.8));
        for piece in folds {
            plot.line(Line::new("", PlotPoints::from(piece)).color(turned).width(2.5));
        }
        let [origin, unit] = [[0.0, 0.0], [1.0, 1.0]].map(|[x, y]| plot.screen_from_plot(PlotPoint::new(x, y)));
        (origin.y - unit.y) / (unit.x - origin.x)
    });
    shown.response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, spoken(&profile.points)));
    let scale = f64::from(shown.inner);
    if !section.equal && scale.is_finite() && !(0.95..1.05).contains(&scale) {
        let scaled = if scale > 1.0 { format!("{scale:.1} times as large as") } else { format!("{scale:.2} of") };
        ui.weak(format!("Heights are drawn {scaled} lengths."));
    }
    if is_folded {
        ui.label(RichText::new("The marked part is turned over: crests fold there.").color(turned));
    }
}

fn line_ui(section: &mut Section, ui: &mut Ui, profile: &Profile) {
    // No edits of the document: the panel keeps them.
    ui.horizontal_wrapped(|ui| {
        let help = "Draw lengths and heights in the same scale, as waves are";
        ui.toggle_value(&mut section.equal, "Equal axes").on_hover_text(help);
        let [mut x, mut z] = profile.through;
        let fields = [("x ", &mut x, "World x of the middle of the line"), ("z ", &mut z, "World z of the middle")];
        for (prefix, value, help) in fields {
            let told = Number::new(*value).decimals(2).speed(0.1).prefix(prefix).suffix(" m").ui(ui);
            if let Some((given, _)) = told.given {
                *value = given;
                section.through = None;
            }
            told.response.on_hover_text(help);
        }
        if [x, z] != profile.through {
            section.through = Some([x, z]);
        }
        let told = Number::new(section.turned).range(-360.0, 360.0).speed(1.0).suffix("°").ui(ui);
        if let Some((given, _)) = told.given {
            section.turned = given;
        }
        told.response.on_hover_text("Angle from this direction: 90 goes across");
        let told = Number::new(profile.length).range(1e-3, 1e6).decimals(1).suffix(" m long").ui(ui);
        if let Some((given, _)) = told.given {
            section.length = Some(given);
        }
        told.response.on_hover_text("Length of the line");
        let is_set = section.through.is_some() || section.length.is_some() || section.turned != 0.0;
        if ui.add_enabled(is_set, egui::Button::new("Reset")).on_hover_text("Back to the line by itself").clicked() {
            *section = Section { equal: section.equal, ..Section::default() };
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_turned_over_is_drawn_in_pieces_that_reach_their_neighbors() {
        let points: Vec<ProfilePoint> = [false, false, true, true, false, false, true]
            .into_iter()
            .enumerate()
            .map(|(index, folded)| ProfilePoint { along: index as f64, height: 0.0, folded })
            .collect();
        let ends = |piece: &Vec<[f64; 2]>| [piece[0][0], piece[piece.len() - 1][0]];
        assert_eq!(folds(&points).iter().map(ends).collect::<Vec<_>>(), [[1.0, 4.0], [5.0, 6.0]]);
        assert!(folds(&points[..2]).is_empty());
    }
}
