//! The timeline: scrubbing and playback, marks on cached frames, and the range to render.

use crate::actions::Action;
use crate::document::sheet::FAR;
use crate::document::{Edit, Path};
use crate::field::Number;
use crate::state::State;
use egui::{Align2, Color32, FontId, Rect, Sense, Stroke, Ui, pos2, vec2};

/// State of the timeline that no other panel shares.
#[derive(Default)]
pub(crate) struct Timeline {
    /// End of the range being dragged: `false` for the first frame, `true` for the last.
    end: Option<bool>,
}

/// Width of a button, in points.
const BUTTON: f32 = 26.0;
/// Height of the strip of frames, in points; all of the row has it, so that everything stands on one line.
const STRIP: f32 = 30.0;

/// Draws the timeline.
pub(crate) fn timeline_ui(timeline: &mut Timeline, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.set_min_height(STRIP);
        let (first, last) = state.range;
        let mut button = |ui: &mut Ui, text: &str, name: &str, action: Action| {
            // A constant width, so that nothing beside the button moves.
            let button = egui::Button::new(text).min_size(vec2(BUTTON, 0.0));
            let response = ui.add(button).on_hover_text(name);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, name));
            if response.clicked() {
                actions.push(action);
            }
        };
        button(ui, "⏮", "First frame (Home)", Action::Frame(first));
        button(ui, "◀", "Previous frame (←)", Action::Frame(state.frame - 1));
        match state.playing {
            true => button(ui, "⏸", "Stop (Space)", Action::Play(false)),
            false => button(ui, "▶", "Play (Space)", Action::Play(true)),
        }
        button(ui, "▶|", "Next frame (→)", Action::Frame(state.frame + 1));
        button(ui, "⏭", "Last frame (End)", Action::Frame(last));
        let frame_ui = |ui: &mut Ui, frame: i64, (low, high): (i64, i64), help: &str| {
            let number = Number::new(frame as f64).whole().speed(0.2).range(low as f64, high as f64).ui(ui);
            number.response.clone().on_hover_text(help);
            number.value().map(|frame| frame as i64)
        };
        let mut onion = state.look.onion;
        let toggle = ui.toggle_value(&mut onion, "Onion");
        if toggle.on_hover_text("Mix the frames before and after over the picture (Shift+O)").clicked() {
            actions.push(Action::Onion(onion));
        }
        if let Some(frame) = frame_ui(ui, state.frame, (-FAR, FAR), "Frame") {
            actions.push(Action::Frame(frame));
        }
        let width = (ui.available_width() - 170.0 - RATE).max(80.0);
        strip_ui(timeline, ui, state, width, actions);
        if let Some(from) = frame_ui(ui, first, (-FAR, FAR), "First frame of the range (I)") {
            actions.push(Action::Range(from, last.max(from)));
        }
        if let Some(to) = frame_ui(ui, last, (first, FAR.max(first)), "Last frame of the range (O)") {
            actions.push(Action::Range(first, to));
        }
        rate_ui(ui, state);
        let fps = Number::rate(state.sheet().frames.2).suffix(" fps").ui(ui);
        fps.response.clone().on_hover_text("Frames per second of the document");
        let path = Path::default().to("frames").to("fps");
        fps.edit(actions, |fps| Edit::set(path, &serde_json::json!(fps)).merging("fps"));
    });
}

/// Width of the measured frame rate, in points; reserved even if nothing plays.
const RATE: f32 = 52.0;

/// Draws the measured frame rate, before the document's.
fn rate_ui(ui: &mut Ui, state: &State) {
    let size = vec2(RATE - ui.spacing().item_spacing.x, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.set_min_width(size.x);
        let Some(rate) = state.evaluated.rate.filter(|_| state.playing) else { return };
        let slow = rate < 0.95 * state.sheet().frames.2;
        let color = if slow { ui.visuals().warn_fg_color } else { ui.visuals().text_color() };
        let text = if rate < 9.95 { format!("{rate:.1} of") } else { format!("{rate:.0} of") };
        ui.label(egui::RichText::new(text).color(color))
            .on_hover_text("Measured frame rate; playback shows every frame");
    });
}

/// Returns the first and last frame of the strip, which covers the document's frames, the range, and the current frame.
fn shown(state: &State) -> (i64, i64) {
    let (first, last, _) = state.sheet().frames;
    (first.min(state.range.0).min(state.frame), last.max(state.range.1).max(state.frame))
}

/// Draws the strip of frames and handles its input.
fn strip_ui(timeline: &mut Timeline, ui: &mut Ui, state: &State, width: f32, actions: &mut Vec<Action>) {
    let (low, high) = shown(state);
    // A still has a single frame, in the middle.
    let is_still = high == low;
    let span = (high - low).max(1) as f64;
    let (rect, response) = ui.allocate_exact_size(vec2(width, STRIP), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::slider(true, state.frame as f64, "Timeline"));
    ui.ctx().accesskit_node_builder(response.id, |builder| {
        builder.set_min_numeric_value(low as f64);
        builder.set_max_numeric_value(high as f64);
    });
    let bar = rect.shrink2(vec2(8.0, 0.0));
    let from = if is_still { bar.center().x } else { bar.left() };
    let x = |frame: f64| from + bar.width() * ((frame - low as f64) / span) as f32;
    let frame_at = |x: f32| low + (f64::from((x - from) / bar.width()) * span).round() as i64;
    let painter = ui.painter_at(rect);
    let visuals = ui.visuals();
    painter.rect_filled(rect, 3.0, visuals.extreme_bg_color);
    let ends = match is_still {
        true => [bar.left(), bar.right()],
        false => [x(state.range.0 as f64), x(state.range.1 as f64)],
    };
    let range = Rect::from_x_y_ranges(ends[0]..=ends[1], rect.y_range());
    painter.rect_filled(range, 2.0, crate::theme::range(visuals));
    let half = (0.5 * bar.width() / span as f32).max(0.5);
    for frame in state.evaluated.frames.keys() {
        let center = x(*frame as f64);
        let mark = Rect::from_min_max(pos2(center - half, rect.bottom() - 4.0), pos2(center + half, rect.bottom()));
        painter.rect_filled(mark, 0.0, Color32::from_rgb(0x5f, 0xb8, 0x72));
    }
    let ink = crate::theme::ink(Color32::from_rgb(0xe8, 0xb0, 0x4a), visuals);
    for frame in state.key_frames().into_iter().filter(|frame| (low as f64..=high as f64).contains(frame)) {
        let (at, y) = (x(frame), rect.bottom() - 8.0);
        let corners = [pos2(at, y - 3.5), pos2(at + 3.5, y), pos2(at, y + 3.5), pos2(at - 3.5, y)];
        painter.add(egui::Shape::convex_polygon(corners.into(), ink, Stroke::NONE));
    }
    // Marks as dense as their labels are legible.
    let least = f64::from(56.0 * span as f32 / bar.width());
    let step = [1, 2, 5, 10, 12, 20, 24, 50, 100, 200, 500, 1000, 5000, 10_000, 100_000, 1_000_000];
    let step = step.into_iter().find(|step| *step as f64 >= least).unwrap_or(span as i64);
    let mut mark = low.div_euclid(step) * step;
    while mark <= high {
        if mark >= low {
            let at = x(mark as f64);
            painter.line_segment(
                [pos2(at, rect.top()), pos2(at, rect.top() + 5.0)],
                Stroke::new(1.0, visuals.weak_text_color()),
            );
            // Beside the brackets instead of under them.
            let (shift, align) = match mark {
                _ if is_still => (4.0, Align2::LEFT_TOP),
                mark if mark == state.range.0 => (4.0, Align2::LEFT_TOP),
                mark if mark == state.range.1 => (-4.0, Align2::RIGHT_TOP),
                _ => (0.0, Align2::CENTER_TOP),
            };
            painter.text(
                pos2(at + shift, rect.top() + 6.0),
                align,
                mark.to_string(),
                FontId::proportional(10.0),
                visuals.text_color(),
            );
        }
        mark += step;
    }
    let bracket = Stroke::new(2.0, Color32::from_rgb(0xe8, 0xb0, 0x4a));
    for (at, side) in ends.into_iter().zip([1.0, -1.0]) {
        painter.line_segment([pos2(at, rect.top()), pos2(at, rect.bottom())], bracket);
        for y in [rect.top() + 1.0, rect.bottom() - 1.0] {
            painter.line_segment([pos2(at, y), pos2(at + 4.0 * side, y)], bracket);
        }
    }
    let now = x(state.frame as f64);
    painter
        .line_segment([pos2(now, rect.top()), pos2(now, rect.bottom())], Stroke::new(2.0, visuals.strong_text_color()));
    let Some(pointer) = response.interact_pointer_pos() else {
        timeline.end = None;
        if response.hovered() {
            response.on_hover_text("Drag to scrub. Drag a bracket to change the range.");
        }
        return;
    };
    if response.drag_started() || response.clicked() {
        let origin = ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer);
        let near = |at: f32| (at - origin.x).abs() < 5.0;
        // The playhead takes precedence over the brackets.
        timeline.end = match () {
            () if near(now) && !response.clicked() => None,
            () if near(ends[0]) => Some(false),
            () if near(ends[1]) => Some(true),
            () => None,
        };
    }
    let frame = frame_at(pointer.x).clamp(low, high);
    match timeline.end.filter(|_| !response.clicked()) {
        Some(false) => actions.push(Action::Range(frame.min(state.range.1), state.range.1)),
        Some(true) => actions.push(Action::Range(state.range.0, frame.max(state.range.0))),
        None if frame != state.frame => actions.push(Action::Frame(frame)),
        None => {}
    }
}
