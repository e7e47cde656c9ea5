//! Colored areas behind nodes, with titles or notes.

use super::Canvas;
use super::drag::{Gesture, Hold};
use super::plan::Plan;
use crate::actions::Action;
use crate::document::sheet::Backdrop;
use crate::document::{Edit, Point, Sheet, decor};
use crate::theme::TINTS;
use egui::{Color32, CursorIcon, FontId, Id, Key, PointerButton, Pos2, Rect, Sense, Stroke, StrokeKind, TextEdit, Ui};
use egui::{WidgetInfo, WidgetType, pos2, vec2};
use std::collections::BTreeSet;

/// Height of the title.
const TITLE: f32 = 26.0;
/// The least width and height.
const LEAST: f32 = 60.0;
/// What is free around nodes in front of it.
const FREE: f32 = 28.0;

/// A backdrop that is given another text.
pub(super) struct Writing {
    name: String,
    text: String,
}

/// The area of a backdrop.
pub(super) fn area(body: &Backdrop) -> Rect {
    Rect::from_min_size(pos2(body.at[0], body.at[1]), body.size.into())
}

/// A backdrop as it is while it is held.
pub(super) fn held(body: &Backdrop, hold: &Hold) -> Backdrop {
    let mut body = body.clone();
    let by: Point = hold.by.into();
    for (axis, by) in by.into_iter().enumerate() {
        if hold.corner {
            body.size[axis] = (body.size[axis] + by).max(LEAST);
        } else {
            body.at[axis] += by;
        }
    }
    body
}

/// A new backdrop behind nodes that cover this much.
pub(super) fn behind(sheet: &Sheet, nodes: Rect) -> Edit {
    let nodes = nodes.expand(FREE);
    let body = Backdrop {
        at: [nodes.left().round(), (nodes.top() - TITLE).round()],
        size: [nodes.width().round(), (nodes.height() + TITLE).round()],
        text: "Backdrop".into(),
        tint: sheet.backdrops.len() % TINTS.len(),
    };
    decor::framed("Add a backdrop", &decor::free_backdrop(sheet), &body)
}

/// The first line, which is what a backdrop is called.
fn title(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

impl Canvas {
    /// Draws the backdrops, and takes what is done to them.
    pub(super) fn backdrops_ui(&mut self, plan: &Plan, ui: &mut Ui, actions: &mut Vec<Action>) {
        // The smaller ones lie on the larger ones.
        let mut names: Vec<&String> = plan.sheet.backdrops.keys().collect();
        names.sort_by(|a, b| {
            let size = |name: &String| area(&plan.sheet.backdrops[name]).area();
            size(b).total_cmp(&size(a))
        });
        for name in names {
            let body = &plan.sheet.backdrops[name];
            let body = match &self.gesture {
                Gesture::Backdrop(hold) if hold.name == *name => held(body, hold),
                _ => body.clone(),
            };
            let seen = self.view.area(area(&body));
            if seen.intersects(self.view.rect) {
                self.backdrop_ui(plan, ui, name, &body, seen);
            }
        }
        self.writing_ui(plan, ui, actions);
    }

    fn backdrop_ui(&mut self, plan: &Plan, ui: &mut Ui, name: &str, body: &Backdrop, seen: Rect) {
        let zoom = self.view.zoom;
        let [r, g, b] = TINTS[body.tint % TINTS.len()];
        let tint = Color32::from_rgb(r, g, b);
        let painter = ui.painter();
        let corner = 6.0 * zoom.min(1.5);
        let height = (TITLE * zoom).clamp(6.0, 40.0).min(seen.height());
        let bar = Rect::from_min_size(seen.min, vec2(seen.width(), height));
        painter.rect_filled(seen, corner, tint.gamma_multiply(if ui.visuals().dark_mode { 0.32 } else { 0.22 }));
        painter.rect_stroke(seen, corner, Stroke::new(1.0, tint.gamma_multiply(0.8)), StrokeKind::Inside);
        let size = (14.0 * zoom).max(9.0);
        let writing = self.writing.as_ref().is_some_and(|writing| writing.name == name);
        if seen.width() > 40.0 && !writing {
            let color = ui.visuals().strong_text_color();
            let text = painter.layout(body.text.clone(), FontId::proportional(size), color, seen.width() - 16.0);
            let clipped = painter.with_clip_rect(seen.intersect(painter.clip_rect()));
            clipped.galley(seen.min + vec2(8.0 * zoom.max(0.6), 5.0 * zoom), text, color);
        }
        let id = ui.id().with(("backdrop", name));
        let grip = ui.interact(bar, id, Sense::click_and_drag()).on_hover_cursor(CursorIcon::Grab);
        grip.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Backdrop {}", title(&body.text))));
        let corner = Rect::from_min_max(seen.max - vec2(14.0, 14.0), seen.max);
        let resize = ui.interact(corner, id.with("corner"), Sense::drag()).on_hover_cursor(CursorIcon::ResizeNwSe);
        resize.widget_info(|| {
            WidgetInfo::labeled(WidgetType::Button, true, format!("Size of backdrop {}", title(&body.text)))
        });
        let line = Stroke::new(1.5, tint.lerp_to_gamma(ui.visuals().text_color(), 0.4));
        for inset in [4.0, 8.0] {
            ui.painter().line_segment([seen.max - vec2(inset, 3.0), seen.max - vec2(3.0, inset)], line);
        }
        let origin = ui.input(|input| input.pointer.press_origin()).map(|at| self.view.canvas(at));
        let by_corner = resize.drag_started_by(PointerButton::Primary);
        let taken =
            matches!(self.gesture, Gesture::Idle) && (by_corner || grip.drag_started_by(PointerButton::Primary));
        if let Some(start) = origin.filter(|_| taken) {
            let area = area(body);
            let nodes: BTreeSet<usize> =
                (0..plan.boxes.len()).filter(|node| area.contains_rect(plan.boxes[*node])).collect();
            self.gesture =
                Gesture::Backdrop(Hold { name: name.into(), corner: by_corner, start, by: vec2(0.0, 0.0), nodes });
        }
        if grip.double_clicked() {
            self.write(name, body);
        }
        if grip.secondary_clicked() {
            self.open_menu(ui, super::menu::About::Backdrop(name.into()));
        }
    }

    /// Asks for another text of a backdrop.
    pub(super) fn write(&mut self, name: &str, body: &Backdrop) {
        self.writing = Some(Writing { name: name.into(), text: body.text.clone() });
    }

    fn writing_ui(&mut self, plan: &Plan, ui: &mut Ui, actions: &mut Vec<Action>) {
        let Some(mut writing) = self.writing.take() else { return };
        let Some(body) = plan.sheet.backdrops.get(&writing.name) else { return };
        let seen = self.view.area(area(body));
        let id = Id::new("backdrop text");
        let at: Pos2 = seen.min.max(self.view.rect.min);
        let lines = writing.text.lines().count().max(1) as f32 + 1.0;
        let place = Rect::from_min_size(at, vec2(seen.width().max(160.0), 20.0 * lines + 8.0));
        let field = TextEdit::multiline(&mut writing.text).id(id).desired_rows(1);
        let field = ui.put(place, field).on_hover_text("Ctrl+Enter when done, Esc to leave it as it was.");
        field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Text of the backdrop"));
        if !field.has_focus() && !field.lost_focus() {
            field.request_focus();
        }
        let (escape, done) = ui
            .input(|input| (input.key_pressed(Key::Escape), input.modifiers.command && input.key_pressed(Key::Enter)));
        if escape {
            return;
        }
        if done || field.lost_focus() {
            let text = writing.text.trim().to_string();
            if text != body.text {
                let body = Backdrop { text, ..body.clone() };
                actions.push(Action::Edit(decor::framed("Write on a backdrop", &writing.name, &body)));
                actions.push(Action::Seal);
            }
            return;
        }
        self.writing = Some(writing);
    }
}
