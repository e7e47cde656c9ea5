//! The report panel: timings, nodes left out, and the accuracy of alternative settings.

use crate::actions::Action;
use crate::evaluate::lens::OUTPUT;
use crate::format::{bytes, seconds, thousands};
use crate::state::State;
use egui::{Color32, Grid, Rect, RichText, ScrollArea, Sense, Ui, vec2};
use egui_plot::{Legend, Line, Plot, PlotPoints, Points};
use std::sync::mpsc::{Receiver, channel};
use trochoid::accuracy::{Effort, LadderRequest, Request, TargetError, climb};
use trochoid::{Format, FormatError, Loaded, NodeReport, Settings, Silent, State as Became, Tolerance};

/// State of the panel that no other panel shares.
#[derive(Default)]
pub(crate) struct Report {
    measuring: Option<Receiver<Measurement>>,
    measured: Option<Measurement>,
}

/// Measured accuracy and time of settings.
struct Measurement {
    revision: u64,
    outcome: Result<Vec<Step>, Unmeasured>,
}

/// Why the settings cannot be measured.
#[derive(Debug, thiserror::Error)]
enum Unmeasured {
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error(transparent)]
    Climb(#[from] TargetError),
    #[error("no error of this picture can be certified: a pass that it depends on has no error bound")]
    NoBound,
}

/// Measurement of one setting.
struct Step {
    name: String,
    /// Seconds, and the largest certified error as displayed, over pixels without ambiguous samples that were looked at.
    seconds: f64,
    error: f64,
}

/// Draws the report.
pub(crate) fn report_ui(report: &mut Report, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        ui.collapsing(RichText::new("Times").strong(), |ui| times_ui(ui, state, actions));
        egui::CollapsingHeader::new(RichText::new("Nodes").strong())
            .default_open(true)
            .show(ui, |ui| nodes_ui(ui, state, actions));
        ui.collapsing(RichText::new("Left out").strong(), |ui| left_out_ui(ui, state, actions));
        ui.collapsing(RichText::new("Error against time").strong(), |ui| accuracy_ui(report, ui, state));
    });
}

fn times_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    if let Some(told) = state.graphics.told() {
        ui.weak(told);
    }
    let past = &state.evaluated.past;
    if past.is_empty() {
        ui.weak("Nothing has been evaluated yet.");
        return;
    }
    let line = |of: fn(&crate::state::PastEvaluation) -> f64| {
        let points: Vec<[f64; 2]> =
            past.iter().enumerate().map(|(index, past)| [index as f64, 1000.0 * of(past)]).collect();
        PlotPoints::from(points)
    };
    // A line has two ends.
    if past.len() > 1 {
        let plot = Plot::new("times").height(120.0).show_x(false).legend(Legend::default()).include_y(0.0);
        crate::plots::even(plot, "evaluations, the last at the right", "ms").show(ui, |plot| {
            plot.line(Line::new("total", line(|past| past.seconds[1])));
            plot.line(Line::new("preparation", line(|past| past.seconds[0])));
        });
    }
    Grid::new("past").num_columns(4).striped(true).show(ui, |ui| {
        for past in past.iter().rev().take(8) {
            if ui.link(&past.node).clicked() {
                actions.push(Action::Look(past.node.clone(), 0));
            }
            ui.label(format!("frame {}", past.frame));
            let size = if past.shrunk > 1 { format!(", 1/{} size", past.shrunk) } else { String::new() };
            ui.label(format!("{}{size}", seconds(past.seconds[1])));
            match past.exits {
                Some(exits) => ui.label(format!("{} outside the palette", thousands(exits))),
                None => ui.weak("no color"),
            };
            ui.end_row();
        }
    });
}

fn sorted(state: &State) -> Vec<&NodeReport> {
    let mut nodes: Vec<&NodeReport> = state.evaluated.nodes.values().collect();
    nodes.sort_by(|a, b| b.seconds.total_cmp(&a.seconds).then_with(|| a.name.cmp(&b.name)));
    nodes
}

/// Draws one bar per node, longest first.
fn nodes_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let nodes = sorted(state);
    let longest = nodes.first().map_or(0.0, |node| node.seconds);
    if longest == 0.0 {
        ui.weak("Nothing has been evaluated yet.");
        return;
    }
    // Names and times stand beside the bars.
    let room = (ui.available_width() - 200.0).clamp(110.0, 420.0);
    Grid::new("nodes").num_columns(3).striped(true).show(ui, |ui| {
        for node in nodes.iter().filter(|node| node.seconds > 0.002 * longest).take(40) {
            if ui.link(&node.name).on_hover_text(node.ty).clicked() {
                actions.push(Action::Visit(node.name.clone()));
            }
            let (rect, response) = ui.allocate_exact_size(vec2(room, 12.0), Sense::hover());
            let width = rect.width() * (node.seconds / longest) as f32;
            let color = match node.estimated {
                true => Color32::from_rgb(0x5c, 0x9d, 0xdc).gamma_multiply(0.6),
                false => Color32::from_rgb(0x5c, 0x9d, 0xdc),
            };
            ui.painter().rect_filled(Rect::from_min_size(rect.min, vec2(width, rect.height())), 2.0, color);
            response.on_hover_text(format!(
                "{} on all threads together{}\n{} samples\n{}{}",
                seconds(node.seconds),
                if node.estimated { ", its share of the fused program" } else { "" },
                thousands(node.pixels),
                bytes(node.bytes),
                if node.repaired > 0 {
                    let first = node.first_repaired.as_ref().map_or(String::new(), |first| {
                        format!(", the first at {}, {}: {}", first.pixel[0], first.pixel[1], first.cause)
                    });
                    format!("\n{} illegal values replaced{first}", thousands(node.repaired))
                } else {
                    String::new()
                },
            ));
            ui.label(seconds(node.seconds));
            ui.end_row();
        }
    });
}

fn left_out_ui(ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    let mut any = false;
    Grid::new("left out").num_columns(2).striped(true).show(ui, |ui| {
        for node in &state.sheet().nodes {
            let Some(report) = state.report(node) else { continue };
            let Became::LeftOut(why) = &report.state else { continue };
            any = true;
            if ui.link(&node.name).clicked() {
                actions.push(Action::Select([node.name.clone()].into()));
            }
            ui.label(why.to_string());
            ui.end_row();
        }
    });
    if !any {
        ui.weak("Everything that the picture depends on was evaluated.");
    }
}

/// Draws the accuracy measurement of the viewed graph, started on request because it takes a while.
fn accuracy_ui(report: &mut Report, ui: &mut Ui, state: &State) {
    if let Some(measured) = report.measuring.as_ref().and_then(|inbox| inbox.try_recv().ok()) {
        report.measured = Some(measured);
        report.measuring = None;
    }
    ui.horizontal(|ui| {
        let result = state.evaluated.result.as_ref().filter(|_| report.measuring.is_none());
        let button = egui::Button::new("Measure");
        let help = "Certifies pixels of the picture in the viewer with each setting of accuracy, at a quarter of its size, for about \
                    20 seconds; `trochoid report` makes the whole page.";
        if ui.add_enabled(result.is_some(), button).on_hover_text(help).clicked()
            && let Some(result) = result
        {
            report.measuring = Some(measure(result, state.session.revision(), ui.ctx().clone()));
        }
        if report.measuring.is_some() {
            ui.spinner();
            ui.weak("Measuring …");
        }
    });
    let Some(measured) = &report.measured else { return };
    if measured.revision != state.session.revision() {
        ui.weak("Measured before the last change of the document:");
    }
    match &measured.outcome {
        Err(error) => {
            ui.label(RichText::new(error.to_string()).color(crate::theme::error(ui.visuals())));
        }
        Ok(steps) => {
            let points: Vec<[f64; 2]> =
                steps.iter().map(|step| [step.seconds.max(1e-6).log10(), step.error.max(1e-12).log10()]).collect();
            let ten = |mark: egui_plot::GridMark, _: &std::ops::RangeInclusive<f64>| format!("1e{:.0}", mark.value);
            Plot::new("accuracy")
                .height(160.0)
                .x_axis_label("seconds")
                .y_axis_label("certified error")
                .x_axis_formatter(ten)
                .y_axis_formatter(ten)
                .show(ui, |plot| {
                    plot.line(Line::new("", PlotPoints::from(points.clone())));
                    plot.points(Points::new("", PlotPoints::from(points)).radius(4.0));
                });
            Grid::new("steps").num_columns(3).striped(true).show(ui, |ui| {
                for step in steps {
                    ui.label(&step.name);
                    ui.label(seconds(step.seconds));
                    ui.label(format!("≤ {:.1e}", step.error));
                    ui.end_row();
                }
            });
        }
    }
}

fn measure(result: &crate::evaluate::Result, revision: u64, context: egui::Context) -> Receiver<Measurement> {
    let (sender, inbox) = channel();
    let result = result.clone();
    std::thread::spawn(move || {
        let outcome = ladder(&result);
        // The window may be closed by then.
        let _ = sender.send(Measurement { revision, outcome });
        context.request_repaint();
    });
    inbox
}

/// Factor by which the measured picture is smaller.
const SHRINK: u32 = 4;

/// Seconds in which it is measured.
const SECONDS: f64 = 20.0;

/// Measures every accuracy setting, coarsest first.
fn ladder(result: &crate::evaluate::Result) -> Result<Vec<Step>, Unmeasured> {
    let (lens, subject) = (&result.lens, &result.subject);
    let whole = lens.graph.format();
    let side = |side: u32| side.div_ceil(SHRINK);
    let format = Format::new(side(whole.width()), side(whole.height()), whole.samples())?;
    let load = |set: &[String]| {
        let Loaded { graph, warnings } = trochoid::parse(&subject.name, &lens.text, &subject.folder, set)?;
        Ok(Loaded { graph: graph.with_access(subject.access.clone()), warnings })
    };
    let request = Request {
        outputs: &[OUTPUT],
        frame: result.frame,
        tolerance: Tolerance::Exact,
        settings: &Settings::default(),
    };
    let asked = LadderRequest {
        request,
        format: Some(format.sampled_like(whole)),
        effort: Effort::Within(SECONDS),
        seed: 1,
        tolerances: &[],
    };
    let ladder = climb(&load, &asked, &Silent)?;
    let methods = ladder.rungs.iter().filter(|rung| rung.is_method);
    let steps = methods.filter_map(|rung| {
        let largest = rung.certified.as_ref()?.clear_max?;
        Some(Step {
            name: if rung.set.is_empty() { "current settings".into() } else { rung.set.join(", ") },
            seconds: rung.times.median(),
            error: largest.size.display,
        })
    });
    let steps: Vec<Step> = steps.collect();
    if steps.is_empty() {
        return Err(Unmeasured::NoBound);
    }
    Ok(steps)
}
