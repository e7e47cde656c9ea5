//! Overlay that marks pixels near the faces of their palette's hull, which have little room left toward the outside.

use super::picture::{part, place};
use crate::evaluate::Result;
use egui::{Color32, ColorImage, Context, Painter, Pos2, Rect, TextureHandle, TextureOptions, pos2};
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
                let strength = 0.15 + 0.5 * (1.0 - (inside / distance).clamp(0.0, 1.0));
                let [r, g, b] = MARK;
                *pixel = Color32::from_rgba_unmultiplied(r, g, b, (255.0 * strength) as u8);
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
