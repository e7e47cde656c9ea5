//! Overlay that marks pixels near the faces of their palette's hull, which have little room left toward the outside.

use super::picture::{part, place};
use crate::evaluate::Result;
use egui::{
    Align2, Color32, ColorImage, Context, FontId, Painter, Pos2, Rect, Sense, TextureHandle, TextureOptions, Ui,
    WidgetInfo, WidgetType, pos2, vec2,
};
use rayon::prelude::*;
use std::sync::Arc;
use trochoid::{Hull, Picture};

/// The overlay of marks.
#[derive(Default)]
pub(super) struct Near {
    pub(super) shown: bool,
    /// Maximum distance to a face, in units of the working space.
    pub(super) distance: f32,
    made: Option<(Arc<Picture>, f32, Option<TextureHandle>)>,
}

/// Maximum number of measured samples, and of samples times faces: about a tenth of a second.
const SAMPLES: usize = 1 << 18;
const PRODUCTS: usize = 1 << 26;
/// Number of shades in the legend.
const STEPS: u32 = 12;
/// Color of the marks.
const MARK: [u8; 3] = [255, 64, 160];

impl Near {
    /// Turns the overlay on or off.
    pub(super) fn toggle(&mut self) {
        self.shown = !self.shown;
        if self.distance <= 0.0 {
            self.distance = 0.02;
        }
    }

    /// Draws what the marks mean, in the picture's lower left corner.
    pub(super) fn legend_ui(&self, ui: &mut Ui, area: Rect) {
        let far = format!("{} inside", self.distance);
        let text = format!("Near: on a face of the hull, to {far}");
        let back = Rect::from_min_size(area.left_bottom() + vec2(8.0, -30.0), vec2(236.0, 22.0));
        ui.painter().rect_filled(back, 4.0, Color32::from_black_alpha(170));
        let legend = ui.interact(back, ui.id().with("near"), Sense::hover());
        legend.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, &text));
        legend.on_hover_text(
            "Marked pixels have little room toward the outside of the palette's hull, in the working space.",
        );
        let painter = ui.painter().with_clip_rect(area);
        let (font, y) = (FontId::proportional(12.0), back.center().y);
        let face =
            painter.text(pos2(back.left() + 8.0, y), Align2::LEFT_CENTER, "On a face", font.clone(), Color32::WHITE);
        let end = painter.text(pos2(back.right() - 8.0, y), Align2::RIGHT_CENTER, far, font, Color32::WHITE);
        let bar = Rect::from_min_max(pos2(face.right() + 8.0, y - 5.0), pos2(end.left() - 8.0, y + 5.0));
        for step in 0..STEPS {
            let [left, right] = [step, step + 1].map(|step| egui::lerp(bar.x_range(), step as f32 / STEPS as f32));
            let color = mark(f64::from(step) / f64::from(STEPS - 1));
            painter.rect_filled(Rect::from_x_y_ranges(left..=right, bar.y_range()), 0.0, color);
        }
    }

    /// Draws the marks over the picture.
    pub(super) fn paint(&mut self, context: &Context, painter: &Painter, rect: Rect, result: &Result) {
        if !self.shown {
            return;
        }
        let known = self.made.as_ref();
        if !known
            .is_some_and(|(picture, distance, _)| Arc::ptr_eq(picture, &result.picture) && *distance == self.distance)
        {
            let image = marks(&result.picture, f64::from(self.distance));
            let handle = image.map(|image| context.load_texture("near", image, TextureOptions::NEAREST));
            self.made = Some((result.picture.clone(), self.distance, handle));
        }
        if let Some((_, _, Some(handle))) = &self.made {
            let part = part(result);
            let part = Rect::from_min_max(place(rect, part.min), place(rect, part.max));
            painter.image(handle.id(), part, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
        }
    }
}

/// Returns the message why nothing can be marked.
pub(super) fn objection(result: &Result) -> Option<&'static str> {
    match result.picture.hull.as_deref().map(Hull::dimension) {
        None => Some("Only colors have a palette."),
        Some(Some(3)) => None,
        Some(_) => Some("The palette is flat: every color lies on its face."),
    }
}

/// Returns the mark of a pixel inside of a face, by a share of the greatest distance.
fn mark(share: f64) -> Color32 {
    let strength = 0.15 + 0.5 * (1.0 - share.clamp(0.0, 1.0));
    let [r, g, b] = MARK;
    Color32::from_rgba_unmultiplied(r, g, b, (255.0 * strength) as u8)
}

/// Returns the image of marks, stronger near a face.
fn marks(picture: &Picture, distance: f64) -> Option<ColorImage> {
    let hull = picture.hull.as_deref().filter(|hull| hull.dimension() == Some(3))?;
    let [r, g, b] = picture.planes.as_slice() else { return None };
    let window = r.window();
    let most = SAMPLES.min(PRODUCTS / hull.facets().len().max(1)).max(64);
    let step = (1..).find(|step| window.width().div_ceil(*step) * window.height().div_ceil(*step) <= most)?;
    let size = [window.width().div_ceil(step), window.height().div_ceil(step)];
    let mut pixels = vec![Color32::TRANSPARENT; size[0] * size[1]];
    pixels.par_chunks_mut(size[0]).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let at = (window.x0 + (x * step) as i64, window.y0 + (y * step) as i64);
            let color = [r, g, b].map(|plane| f64::from(plane.nearest(at.0, at.1)));
            let inside = -hull.signed_distance(color);
            if inside < distance {
                *pixel = mark(inside / distance);
            }
        }
    });
    Some(ColorImage::new(size, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::{Audit, Guarantee, Kind, Plane, Window};

    fn picture(colors: &[[f32; 3]], palette: &[[f32; 3]]) -> Picture {
        let window = Window::new(0, 0, colors.len() as i64, 1);
        let plane = |channel: usize| Plane::new(window, colors.iter().map(|color| color[channel]).collect()).unwrap();
        Picture {
            output: 0,
            kind: Kind::Color,
            planes: (0..3).map(plane).collect(),
            guarantee: Some(Guarantee::Hull),
            audit: Audit::default(),
            control_count: palette.len(),
            control_colors: palette.to_vec(),
            hull: Some(Arc::new(Hull::new(palette))),
            margin: 0.0,
        }
    }

    #[test]
    fn what_is_near_a_face_is_marked_the_stronger_the_nearer() {
        let palette = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let colors = [[0.0, 0.2, 0.2], [0.015, 0.2, 0.2], [0.2, 0.2, 0.2]];
        let image = marks(&picture(&colors, &palette), 0.02).unwrap();
        let strength: Vec<u8> = image.pixels.iter().map(|pixel| pixel.a()).collect();
        assert!(strength[0] > strength[1] && strength[1] > 0 && strength[2] == 0, "{strength:?}");
    }

    #[test]
    fn a_flat_palette_marks_nothing() {
        assert!(marks(&picture(&[[0.5; 3]], &[[0.0; 3], [1.0; 3]]), 0.02).is_none());
    }
}
