//! The pixel inspector: the value of a pixel, and the control colors it is mixed from.

use super::origin::origin;
use crate::actions::{Action, Pane};
use crate::document::swatches::SwatchKey;
use crate::evaluate::{Blamed, Origin, Result, Share, blame};
use crate::format::{number, percent, thousands};
use crate::state::State;
use crate::transform::Transform;
use egui::{Align, Button, Color32, Layout, Pos2, Rect, RichText, ScrollArea, Sense, Stroke, StrokeKind, Ui, vec2};
use trochoid::{Kind, WorkingSpace};

/// Number of weights listed individually; the remaining small ones are summed.
const ROWS: usize = 24;

/// Converts a color of the working space for display.
pub(super) fn swatch(space: WorkingSpace, color: [f64; 3]) -> Color32 {
    let [r, g, b] = space.to_display(color).map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
}

/// Returns the pixel of a result at a place in fractions of the picture; `None` outside the evaluated part.
pub(super) fn pixel(result: &Result, at: Pos2) -> Option<[i64; 2]> {
    if !(0.0..1.0).contains(&at.x) || !(0.0..1.0).contains(&at.y) {
        return None;
    }
    let window = result.window;
    let [x, y] = blame::pixel([at.x, at.y], [result.format.width(), result.format.height()]);
    ((window.x0..window.x1).contains(&x) && (window.y0..window.y1).contains(&y)).then_some([x, y])
}

/// Returns the pixel coordinates in the document's full-resolution picture.
pub(super) fn named(result: &Result, at: Pos2) -> [i64; 2] {
    let format = result.lens.graph.format();
    blame::pixel([at.x, at.y], [format.width(), format.height()])
}

/// Returns the channel values of a pixel.
pub(super) fn values(result: &Result, [x, y]: [i64; 2]) -> Vec<f64> {
    result.picture.planes.iter().map(|plane| f64::from(plane.nearest(x, y))).collect()
}

/// Returns the color of a pixel as displayed.
pub(super) fn displayed(result: &Result, [x, y]: [i64; 2]) -> Option<Color32> {
    let window = result.window;
    let index = (y - window.y0) as usize * result.screen.size[0] + (x - window.x0) as usize;
    let pixel = result.screen.pixels.get(4 * index..4 * index + 3)?;
    Some(Color32::from_rgb(pixel[0], pixel[1], pixel[2]))
}

/// Returns the color that is taken from a pixel: what is displayed, but as sRGB whatever the viewer makes of it.
pub(super) fn picked(result: &Result, pixel: [i64; 2]) -> Option<Color32> {
    match values(result, pixel)[..] {
        [r, g, b] if result.picture.kind == Kind::Color && result.display.transform != Transform::Srgb => {
            Some(swatch(result.lens.graph.space(), [r, g, b]))
        }
        _ => displayed(result, pixel),
    }
}

/// Formats up to `most` values with their significant digits.
pub(super) fn written(values: &[f64], most: usize) -> String {
    let mut text: Vec<String> = values.iter().take(most).map(|value| number(*value)).collect();
    if values.len() > most {
        text.push("…".into());
    }
    text.join("  ")
}

/// Draws a color square.
pub(super) fn swatch_ui(ui: &mut Ui, color: Color32, side: f32) {
    let (rect, _) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, color);
    let rim = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    ui.painter().rect_stroke(rect, 2.0, rim, StrokeKind::Inside);
}

/// Draws the inspector for a pixel.
pub(super) fn inspector_ui(ui: &mut Ui, state: &State, result: &Result, at: Pos2, actions: &mut Vec<Action>) {
    let picture = &result.picture;
    let found = pixel(result, at);
    ui.horizontal(|ui| {
        let place = named(result, at);
        ui.strong(format!("Pixel {}, {}", place[0], place[1]));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.add(Button::new("×").small().frame(false)).on_hover_text("Close the inspector (Esc)").clicked() {
                actions.push(Action::Pick(None));
            }
        });
    });
    let Some(place) = found else {
        ui.weak("Outside the evaluated region.");
        return;
    };
    let values = values(result, place);
    ui.horizontal(|ui| {
        if let Some(color) = displayed(result, place).filter(|_| picture.kind == Kind::Color) {
            swatch_ui(ui, color, 14.0);
        }
        ui.add(egui::Label::new(RichText::new(written(&values, 4)).monospace()).truncate());
    });
    ui.add(egui::Label::new(RichText::new(kind(result)).weak()).wrap());
    if let Some(guarantee) = picture.guarantee {
        let (exits, pixels) = (picture.audit.hull_exits, picture.audit.pixels);
        let text = format!("Guarantee: {}\n{} of {} outside", guarantee.name(), thousands(exits), thousands(pixels));
        let color = if exits > 0 { crate::theme::error(ui.visuals()) } else { ui.visuals().weak_text_color() };
        ui.label(RichText::new(text).color(color))
            .on_hover_text("Pixels of this picture that are not a convex combination of its control colors");
    }
    if picture.kind != Kind::Color {
        return;
    }
    ui.separator();
    match &state.evaluated.blame {
        Some(blamed) => {
            // The previous pixel's answer stays, dimmed, until the new one arrives.
            let is_old = blamed.generation != result.generation || blamed.at != [at.x, at.y];
            ui.scope(|ui| {
                if is_old {
                    ui.multiply_opacity(0.6);
                }
                blame_ui(ui, state, result, blamed, actions);
            });
        }
        None if state.evaluated.progress.is_some() => {
            drop(ui.weak("Composition available when the picture is finished."));
        }
        None => drop(ui.weak("Finding the control colors …")),
    }
}

fn kind(result: &Result) -> String {
    match (result.lens.clay, result.picture.kind) {
        (true, _) => "Clay shading".into(),
        (false, Kind::Color) => format!("Color in {}", result.lens.graph.space()),
        (false, kind) => kind.to_string(),
    }
}

/// Draws the control colors, largest weight first.
fn blame_ui(ui: &mut Ui, state: &State, result: &Result, blamed: &Blamed, actions: &mut Vec<Action>) {
    ui.weak("Mixed of").on_hover_text("Control colors of this pixel and their weights, which sum to 1");
    ScrollArea::vertical().id_salt("blame").auto_shrink([false, true]).show(ui, |ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        ui.spacing_mut().interact_size.y = 15.0;
        for share in blamed.shares.iter().take(ROWS) {
            share_ui(ui, state, result, share, actions);
        }
        let rest: f64 = blamed.shares.iter().skip(ROWS).map(|share| share.weight).sum();
        if let Some(more) = blamed.shares.len().checked_sub(ROWS).filter(|more| *more > 0) {
            ui.horizontal(|ui| {
                ui.weak(format!("{} more", thousands(more as u64)));
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.weak(percent(rest)));
            });
        }
    });
}

fn share_ui(ui: &mut Ui, state: &State, result: &Result, share: &Share, actions: &mut Vec<Action>) {
    let row = ui.horizontal(|ui| {
        swatch_ui(ui, swatch(result.lens.graph.space(), share.color), 12.0);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.label(RichText::new(percent(share.weight)).monospace());
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                let space = result.lens.graph.space();
                let (called, is_chosen, help, click) = match &share.of {
                    Origin::Palette(name) => {
                        let key = SwatchKey::Named(name.clone());
                        let is_chosen = state.colors.chosen.as_ref() == Some(&key);
                        let click = vec![Action::Panel(Pane::Palette), Action::Swatch(Some(key))];
                        (name.clone(), is_chosen, "Click to show it in the palette.", click)
                    }
                    Origin::Node(node) => {
                        let called = match origin(&result.subject.root, node, share.color, space) {
                            Some(own) => format!("{node} · {own}"),
                            None => node.clone(),
                        };
                        let click = vec![Action::Visit(node.clone())];
                        (
                            called,
                            state.own_name(node).is_some_and(|own| state.selection.contains(own)),
                            "Click to select the node.",
                            click,
                        )
                    }
                    Origin::Pictures => ("pictures".into(), false, "Pictures that the document reads", Vec::new()),
                };
                let name = RichText::new(&called);
                let name = if is_chosen { name.strong() } else { name };
                let label = ui.add(egui::Label::new(name).truncate().sense(Sense::click()));
                let help = format!("{called}: {}\n{help}", written(&share.color, 3));
                if label.on_hover_text(help).clicked() {
                    actions.extend(click);
                }
            });
        });
    });
    // The weight as a bar below the row.
    let (line, _) = ui.allocate_exact_size(vec2(row.response.rect.width(), 2.0), Sense::hover());
    ui.painter().rect_filled(line, 1.0, ui.visuals().faint_bg_color);
    let filled = Rect::from_min_size(line.min, vec2(line.width() * share.weight.clamp(0.0, 1.0) as f32, line.height()));
    ui.painter().rect_filled(filled, 1.0, ui.visuals().selection.bg_fill);
}
