//! What a simulated sea reaches, and how it behaves in the long run.

use super::sea::Sea;
use crate::actions::Action;
use crate::document::{Edit, Path};
use crate::field::Gesture;
use crate::format::{measure, number};
use crate::state::State;
use egui::{Color32, RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints, Points, Polygon};
use serde_json::json;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use trochoid::{CheckedGraph, FrameTimes, Reached, Stability, stability_of};

/// The analysis of a sea at a revision.
pub(super) type Analysis = Option<(String, u64, StabilityResult)>;

pub(super) enum StabilityResult {
    Waiting(Receiver<Option<Box<Stability>>>),
    Here(Option<Box<Stability>>),
}

/// Says what heights and rift reach over the frames, which thresholds and bands need.
pub(super) fn reached_ui(ui: &mut Ui, reached: &Reached, times: FrameTimes) {
    let Reached { until, heights: [low, high], rift } = reached;
    let over = if *until < times.last() {
        format!("in the first {} of {} s", number(*until), number(times.last()))
    } else if times.count <= 1 {
        "at the only frame".into()
    } else {
        "over all frames".into()
    };
    ui.label(format!("Heights {} to {} m, rift up to {}, {over}.", measure(*low), measure(*high), measure(*rift)))
        .on_hover_text("Thresholds and bands of masks lie between these values");
}

/// Draws the verdict on a toon sea, its figures, and its point on the stability map.
pub(super) fn stability_ui(
    analysis: &mut Analysis,
    ui: &mut Ui,
    state: &State,
    sea: &Sea<'_>,
    graph: &Arc<CheckedGraph>,
    actions: &mut Vec<Action>,
) {
    let revision = state.session.revision();
    if let Some((_, _, found @ StabilityResult::Waiting(_))) = analysis
        && let StabilityResult::Waiting(inbox) = found
    {
        match inbox.try_recv() {
            Ok(stability) => *found = StabilityResult::Here(stability),
            Err(TryRecvError::Disconnected) => *found = StabilityResult::Here(None),
            Err(TryRecvError::Empty) => {}
        }
    }
    let current = matches!(&*analysis, Some((name, known, _)) if (name, *known) == (&sea.name, revision));
    let busy = matches!(&*analysis, Some((.., StabilityResult::Waiting(_))));
    let button = egui::Button::new(if current { "Analyze again" } else { "Analyze stability" });
    let help = "Predict and measure the long-term behavior of the sea (takes a few seconds)";
    ui.horizontal(|ui| {
        if ui.add_enabled(!busy, button).on_hover_text(help).clicked()
            && let Some(id) = graph.find(&sea.name)
        {
            let (sender, inbox) = channel();
            let (graph, frame, context) = (graph.clone(), state.frame, ui.ctx().clone());
            std::thread::spawn(move || {
                // The panel may be gone by then.
                let _ = sender.send(stability_of(&graph, id, frame).map(Box::new));
                context.request_repaint();
            });
            *analysis = Some((sea.name.clone(), revision, StabilityResult::Waiting(inbox)));
        }
        if busy {
            ui.spinner();
        }
    });
    let Some((.., StabilityResult::Here(Some(stability)))) = analysis else { return };
    if !current {
        ui.weak("Analyzed before the last change of the document:");
    }
    ui.label(RichText::new(format!("Verdict: {}", stability.verdict.name())).strong());
    for sentence in &stability.explanation {
        ui.add(egui::Label::new(sentence).wrap());
    }
    if let Some(map) = &stability.map {
        let region: Vec<[f64; 2]> = map.region.clone();
        let [across, up] = map.axes;
        let side = crate::plots::side(ui, 200.0);
        let plot = Plot::new("stability").width(side).height(side).data_aspect(1.0);
        let shown = crate::plots::even(plot, across, up).show(ui, |plot| {
            plot.polygon(
                Polygon::new("stable", PlotPoints::from(region))
                    .fill_color(Color32::from_rgb(0x5f, 0xb8, 0x72).gamma_multiply(0.35)),
            );
            let axes = [
                [[map.ranges[0][0], 0.0], [map.ranges[0][1], 0.0]],
                [[0.0, map.ranges[1][0]], [0.0, map.ranges[1][1]]],
            ];
            for axis in axes {
                plot.line(Line::new("", PlotPoints::from(axis.to_vec())).color(Color32::from_gray(0x70)));
            }
            plot.points(
                Points::new("this sea", PlotPoints::from(vec![map.point]))
                    .radius(5.0)
                    .color(Color32::from_rgb(0xe8, 0xb0, 0x4a)),
            );
            plot.pointer_coordinate()
        });
        if let (Some(gesture), Some(at), Some(node)) = (Gesture::double_click(&shown.response), shown.inner, sea.node) {
            let path = Path::node(&node.name);
            let round = |value: f64| json!((value * 1e4).round() / 1e4);
            let edit = Edit::set(path.to(across), &round(at.x)).then(Edit::set(path.to(up), &round(at.y)));
            gesture.edit(edit, actions);
        }
        ui.weak(format!("{} Double-click to move the sea there.", map.note));
    }
    egui::Grid::new("figures").num_columns(3).striped(true).show(ui, |ui| {
        ui.strong("");
        ui.strong("predicted");
        ui.strong("measured");
        ui.end_row();
        for figure in &stability.figures {
            let unit = if figure.unit.is_empty() { String::new() } else { format!(", {}", figure.unit) };
            ui.label(format!("{}{unit}", figure.name)).on_hover_text(&figure.note);
            let cell = |value: Option<f64>| value.map_or_else(|| "—".into(), number);
            ui.label(cell(figure.predicted));
            let color = match figure.holds() {
                Some(false) => crate::theme::error(ui.visuals()),
                _ => ui.visuals().text_color(),
            };
            ui.label(RichText::new(cell(figure.measured)).color(color));
            ui.end_row();
        }
    });
}
