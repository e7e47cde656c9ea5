//! Colored areas behind nodes (backdrops), including notes, and the field that edits their text or an output's name.

use super::Canvas;
use super::drag::{Gesture, Hold};
use super::plan::Plan;
use crate::actions::Action;
use crate::document::sheet::Backdrop;
use crate::document::{Edit, Point, Sheet, decor, output};
use crate::theme::TINTS;
use egui::{Color32, CursorIcon, FontId, Id, Key, PointerButton, Pos2, Rect, Sense, Stroke, StrokeKind, TextEdit, Ui};
use egui::{KeyboardShortcut, Modifiers, WidgetInfo, WidgetType, pos2, vec2};
use std::collections::BTreeSet;

/// Height of the title bar.
const TITLE: f32 = 26.0;
/// Minimum width and height.
const LEAST: f32 = 60.0;
/// Margin between the backdrop's edge and the nodes on it.
const FREE: f32 = 28.0;

/// Initial text of a new backdrop.
pub(super) const BACKDROP: &str = "Backdrop";
/// Initial text of a new note.
pub(super) const NOTE: &str = "Note";
/// Index into [`TINTS`] of a new note's color.
const YELLOW: usize = 6;

/// Item whose text is being edited.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Subject {
    /// Backdrop with this name.
    Backdrop(String),
    /// Output with this name.
    Output(String),
}

/// Text being edited, not yet applied.
pub(super) struct TextDraft {
    subject: Subject,
    text: String,
    /// Whether to select all of the text, so that typing replaces it.
    fresh: bool,
}

/// Returns the area of a backdrop.
pub(super) fn area(body: &Backdrop) -> Rect {
    Rect::from_min_size(pos2(body.at[0], body.at[1]), body.size.into())
}

/// Returns the backdrop as it looks during a drag.
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

/// Adds a backdrop behind nodes that cover this area; also returns its name.
pub(super) fn behind(sheet: &Sheet, mut nodes: Rect) -> (Edit, String) {
    // Output names are drawn below their nodes.
    nodes.max.y += super::mark::REACH + 8.0 - FREE;
    let nodes = nodes.expand(FREE);
    let body = Backdrop {
        at: [nodes.left().round(), (nodes.top() - TITLE).round()],
        size: [nodes.width().round(), (nodes.height() + TITLE).round()],
        text: BACKDROP.into(),
        tint: sheet.backdrops.len() % TINTS.len(),
    };
    let name = decor::free_backdrop(sheet);
    (decor::framed("Add a backdrop", &name, &body), name)
}

/// Adds a note near a place of the canvas: a backdrop with nothing on it. Also returns its name.
pub(super) fn note(sheet: &Sheet, at: Pos2) -> (Edit, String) {
    let size = vec2(180.0, 90.0);
    let mut boxes = super::place::boxes(sheet, &mut super::place::GraphLayout::default());
    boxes.extend(sheet.backdrops.values().map(area));
    let at = super::place::nearest(Rect::from_center_size(at, size), &boxes).min;
    let body = Backdrop { at: [at.x.round(), at.y.round()], size: size.into(), text: NOTE.into(), tint: YELLOW };
    let name = decor::free_backdrop(sheet);
    (decor::framed("Add a note", &name, &body), name)
}

/// Returns the first line, used as the backdrop's title.
fn title(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

impl Canvas {
    /// Draws the backdrops and handles their input. The text field is drawn later, above the nodes.
    pub(super) fn backdrops_ui(&mut self, plan: &Plan, ui: &mut Ui) {
        // Smaller backdrops are drawn over larger ones.
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
        let writing = self.writing.as_ref().is_some_and(|writing| writing.subject == Subject::Backdrop(name.into()));
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
            self.write(Subject::Backdrop(name.into()), &body.text, false);
        }
        if grip.secondary_clicked() {
            self.open_menu(ui, super::menu::MenuTarget::Backdrop(name.into()));
        }
    }

    /// Starts editing a text; `fresh` selects all of it, so that typing replaces it.
    pub(super) fn write(&mut self, subject: Subject, text: &str, fresh: bool) {
        self.writing = Some(TextDraft { subject, text: text.into(), fresh });
    }

    /// Draws the text field.
    pub(super) fn writing_ui(&mut self, plan: &Plan, ui: &mut Ui, actions: &mut Vec<Action>) {
        let Some(mut writing) = self.writing.take() else { return };
        let one_line = matches!(writing.subject, Subject::Output(_));
        let Some(place) = self.writing_place(plan, &writing) else { return };
        let id = Id::new("canvas text");
        let field = match one_line {
            true => TextEdit::singleline(&mut writing.text),
            false => TextEdit::multiline(&mut writing.text)
                .desired_rows(1)
                .return_key(KeyboardShortcut::new(Modifiers::SHIFT, Key::Enter)),
        };
        let help = if one_line { "Enter to apply" } else { "Enter when done, Shift+Enter for another line" };
        let field = ui.put(place, field.id(id)).on_hover_text(format!("{help}, Esc to cancel."));
        let called = if one_line { "Name of the output" } else { "Text of the backdrop" };
        field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, called));
        if !field.has_focus() && !field.lost_focus() {
            field.request_focus();
        }
        if std::mem::take(&mut writing.fresh) {
            let mut state = egui::text_edit::TextEditState::load(ui.ctx(), id).unwrap_or_default();
            let [start, end] = [0, writing.text.chars().count()].map(egui::text::CCursor::new);
            state.cursor.set_char_range(Some(egui::text::CCursorRange::two(start, end)));
            state.store(ui.ctx(), id);
        }
        let (escape, done) =
            ui.input(|input| (input.key_pressed(Key::Escape), !input.modifiers.shift && input.key_pressed(Key::Enter)));
        if escape {
            return;
        }
        if done || field.lost_focus() {
            actions.extend(written(plan, &writing));
            return;
        }
        self.writing = Some(writing);
    }

    /// Returns the place of the text field on the screen.
    fn writing_place(&self, plan: &Plan, writing: &TextDraft) -> Option<Rect> {
        let seen = match &writing.subject {
            Subject::Backdrop(name) => self.view.area(area(plan.sheet.backdrops.get(name)?)),
            Subject::Output(name) => {
                let (node, _) = plan.sheet.source(&output::find(&plan.sheet, name)?.source)?;
                let at = plan.boxes[node].center_bottom() + vec2(-80.0, 16.0);
                self.view.area(Rect::from_min_size(at, vec2(160.0, 20.0)))
            }
        };
        let at: Pos2 = seen.min.max(self.view.rect.min);
        let rows = writing.text.split('\n').count() as f32;
        Some(Rect::from_min_size(at, vec2(seen.width().max(160.0), 20.0 * rows + 8.0)))
    }
}

/// Returns the actions that apply an edited text.
fn written(plan: &Plan, writing: &TextDraft) -> Vec<Action> {
    let text = writing.text.trim().to_string();
    match &writing.subject {
        Subject::Backdrop(name) => match plan.sheet.backdrops.get(name) {
            Some(body) if body.text.trim() != text => {
                let body = Backdrop { text, ..body.clone() };
                vec![Action::Edit(decor::reframed("Write on a backdrop", &plan.sheet, name, &body)), Action::Seal]
            }
            _ => Vec::new(),
        },
        Subject::Output(name) if text == *name => Vec::new(),
        Subject::Output(name) => match output::wrong_name(&plan.sheet, &text) {
            Some(why) => vec![Action::Notice(why.to_string())],
            None => vec![Action::Edit(output::renamed(name, &text)), Action::Seal, Action::Output(Some(text))],
        },
    }
}
