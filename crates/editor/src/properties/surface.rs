//! The patch editor: corner or Bézier colors on the surface that they span.

use super::color;
use super::context::WidgetContext;
use crate::actions::Action;
use crate::document::Path;
use crate::state::State;
use egui::{Color32, Mesh, Rect, Sense, Stroke, Ui, pos2, vec2};
use serde_json::Value;

/// Number of mesh cells along each side.
const PIECES: usize = 24;

/// Draws the surface spanned by a patch's colors, u to the right and v down, with a swatch for each color.
pub(super) fn patch_ui(ui: &mut Ui, state: &State, path: &Path, actions: &mut Vec<Action>) {
    let place = path.to("colors");
    let Some(values) = state.sheet().get(&place).and_then(Value::as_array) else { return };
    let side = match values.len() {
        4 => 2,
        16 => 4,
        _ => return,
    };
    // The color of a connected picture is unknown here; gray stands in.
    let colors: Vec<[f32; 3]> = values.iter().map(|value| color::display(value, state).unwrap_or([0.5; 3])).collect();
    let width = ui.available_width().min(260.0);
    let (rect, _) = ui.allocate_exact_size(vec2(width, width * 0.75), Sense::hover());
    let sheet = rect.shrink(12.0);
    let mut mesh = Mesh::default();
    for row in 0..=PIECES {
        for column in 0..=PIECES {
            let (u, v) = (column as f32 / PIECES as f32, row as f32 / PIECES as f32);
            let (along, down) = (bernstein(side, u), bernstein(side, v));
            let mut sum = [0.0; 3];
            for (index, color) in colors.iter().enumerate() {
                let weight = along[index % side] * down[index / side];
                sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
            }
            let [r, g, b] = sum.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
            mesh.colored_vertex(sheet.lerp_inside(vec2(u, v)), Color32::from_rgb(r, g, b));
            if row < PIECES && column < PIECES {
                let at = (row * (PIECES + 1) + column) as u32;
                let below = at + PIECES as u32 + 1;
                mesh.add_triangle(at, at + 1, below);
                mesh.add_triangle(at + 1, below + 1, below);
            }
        }
    }
    ui.painter().add(mesh);
    for (index, value) in values.iter().enumerate() {
        let share = vec2((index % side) as f32, (index / side) as f32) / (side - 1) as f32;
        let center = sheet.lerp_inside(share);
        let spot = Rect::from_center_size(pos2(center.x, center.y), vec2(18.0, 18.0));
        let literal = color::display(value, state);
        ui.painter().rect_stroke(
            spot,
            2.0,
            Stroke::new(1.0, Color32::from_white_alpha(160)),
            egui::StrokeKind::Outside,
        );
        if literal.is_none() {
            continue;
        }
        let mut own = ui.new_child(egui::UiBuilder::new().max_rect(spot).id_salt(index));
        own.spacing_mut().interact_size = vec2(18.0, 18.0);
        let own_place = WidgetContext::new(state, place.to(index), Some(value));
        let told = color::swatch_ui(&mut own, value, &own_place, 18.0, actions);
        told.edit(actions, |color| own_place.set(&color));
    }
}

fn bernstein(side: usize, t: f32) -> Vec<f32> {
    let s = 1.0 - t;
    if side == 2 { vec![s, t] } else { vec![s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t] }
}
