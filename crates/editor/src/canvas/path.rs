//! The bar above the graph of a group: the path to it, whose parts lead back.

use crate::actions::Action;
use crate::document::group::Within;
use crate::state::State;
use egui::{Frame, Margin, Rect, RichText, Sense, Stroke, Ui, UiBuilder, WidgetInfo, WidgetType, pos2, vec2};

/// Height of the bar, in points.
const HEIGHT: f32 = 28.0;

/// Draws the path of the entered use in the upper part of an area, and returns the rest; at the top of the document, the
/// whole area.
pub(super) fn path_ui(ui: &mut Ui, area: Rect, state: &State, actions: &mut Vec<Action>) -> Rect {
    let Some(within) = &state.sheet().within else { return area };
    let bar = Rect::from_min_size(area.min, vec2(area.width(), HEIGHT.min(area.height())));
    ui.painter().rect_filled(bar, 0.0, ui.visuals().faint_bg_color);
    let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    ui.painter().line_segment([bar.left_bottom(), bar.right_bottom()], line);
    // What is under the bar is not reached through it.
    ui.interact(bar, ui.id().with("path"), Sense::click_and_drag());
    let mut ui = ui.new_child(UiBuilder::new().id_salt("path of the group").max_rect(bar));
    ui.shrink_clip_rect(bar);
    Frame::new().inner_margin(Margin::symmetric(8, 3)).show(&mut ui, |ui| {
        ui.horizontal_centered(|ui| parts_ui(ui, state, within, actions));
    });
    Rect::from_min_max(pos2(area.left(), bar.bottom()), area.max)
}

fn parts_ui(ui: &mut Ui, state: &State, within: &Within, actions: &mut Vec<Action>) {
    let title = state.session.title();
    let title = title.strip_suffix(".json").unwrap_or(&title);
    let mut part = |ui: &mut Ui, text: String, depth: usize| {
        let button = ui.button(text.as_str()).on_hover_text("Go back to what is around the group (Esc)");
        button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Back to {text}")));
        if button.clicked() {
            actions.push(Action::Enter(state.scope[..depth].to_vec()));
        }
        ui.weak(">");
    };
    part(ui, title.into(), 0);
    let (last, before) = within.uses.split_last().map_or((None, &[][..]), |(last, before)| (Some(last), before));
    for (depth, (name, group)) in before.iter().enumerate() {
        part(ui, called(name, group), depth + 1);
    }
    if let Some((name, group)) = last {
        ui.label(RichText::new(called(name, group)).strong());
    }
    ui.add_space(8.0);
    let used = match within.count {
        1 => "used once".into(),
        count => format!("used {count} times"),
    };
    match &within.file {
        Some(file) => {
            let told = ui.weak(format!("{used}, from {file}"));
            told.on_hover_text(
                "The group belongs to another file, which this document includes: it can be looked at here.",
            );
            let button = ui.button("Make local");
            if button.on_hover_text("Copy the group into this document, to change it here").clicked() {
                actions.push(Action::MakeLocal);
            }
        }
        None => {
            let told = ui.weak(used);
            told.on_hover_text("What you change here changes in all uses of the group.");
        }
    }
}

/// Returns a use as it is called, with its group if that has another name.
fn called(name: &str, group: &str) -> String {
    if name == group { name.into() } else { format!("{name}: {group}") }
}
