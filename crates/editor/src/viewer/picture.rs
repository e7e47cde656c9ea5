//! The picture on the screen: its textures, pan, and zoom.

use crate::evaluate::{Result, Screen};
use egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle, TextureOptions, Vec2, pos2, vec2,
};
use std::sync::Arc;

/// Neutral gray around the picture.
pub(super) const SURROUND: Color32 = Color32::from_gray(0x2e);

/// Minimum and maximum zoom, in screen pixels per document pixel.
const ZOOMS: [f32; 2] = [0.02, 64.0];
/// Margin around a fitted picture, in points.
const MARGIN: f32 = 4.0;

/// Pan and zoom of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// Screen pixels per document pixel; `None` fits the picture to the panel.
    zoom: Option<f32>,
    /// Place in the middle of the panel, in fractions of the picture.
    center: Pos2,
}

impl Default for View {
    fn default() -> Self {
        Self { zoom: None, center: pos2(0.5, 0.5) }
    }
}

/// The area of the panel, and the size of the document's picture in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    pub(super) area: Rect,
    pub(super) size: Vec2,
    /// Screen pixels per point.
    pub(super) density: f32,
}

impl View {
    /// Returns the zoom, in screen pixels per document pixel.
    pub(super) fn zoom(&self, stage: &Stage) -> f32 {
        self.zoom.unwrap_or_else(|| {
            let room = (stage.area.size() - Vec2::splat(2.0 * MARGIN)).max(Vec2::splat(8.0)) * stage.density;
            (room.x / stage.size.x).min(room.y / stage.size.y)
        })
    }

    /// Returns the area of the picture on the screen.
    pub(super) fn rect(&self, stage: &Stage) -> Rect {
        let size = stage.size * (self.zoom(stage) / stage.density);
        let center = if self.zoom.is_some() { self.center } else { pos2(0.5, 0.5) };
        let corner = stage.area.center() - size * center.to_vec2();
        // Aligned to whole screen pixels, to keep the picture sharp.
        let corner = (corner.to_vec2() * stage.density).round() / stage.density;
        Rect::from_min_size(corner.to_pos2(), size)
    }

    /// Fits the picture to the panel.
    pub(super) fn fit(&mut self) {
        *self = Self::default();
    }

    /// Shows one document pixel per screen pixel.
    pub(super) fn one_to_one(&mut self, stage: &Stage) {
        let factor = 1.0 / self.zoom(stage);
        self.zoom_at(stage, stage.area.center(), factor);
    }

    /// Zooms around `at`, which stays fixed.
    pub(super) fn zoom_at(&mut self, stage: &Stage, at: Pos2, factor: f32) {
        let share = share(self.rect(stage), at);
        let zoom = (self.zoom(stage) * factor).clamp(ZOOMS[0], ZOOMS[1]);
        let size = stage.size * (zoom / stage.density);
        *self = Self { zoom: Some(zoom), center: share + (stage.area.center() - at) / size };
    }

    /// Keeps the picture in place while the panel changes its size, unless the picture is fitted.
    pub(super) fn keep(&mut self, from: &Stage, to: &Stage) {
        if self.zoom.is_some() {
            self.center += (to.area.center() - from.area.center()) / self.rect(from).size();
        }
    }

    /// Pans by an offset in points.
    pub(super) fn pan(&mut self, stage: &Stage, by: Vec2) {
        let (rect, zoom) = (self.rect(stage), self.zoom(stage));
        let center = share(rect, stage.area.center()) - by / rect.size();
        *self = Self { zoom: Some(zoom), center: center.clamp(pos2(0.0, 0.0), pos2(1.0, 1.0)) };
    }
}

/// Converts a place on the screen to fractions of a rectangle.
pub(super) fn share(rect: Rect, at: Pos2) -> Pos2 {
    ((at - rect.min) / rect.size()).to_pos2()
}

/// Converts fractions of a rectangle to a place on the screen.
pub(super) fn place(rect: Rect, share: Pos2) -> Pos2 {
    rect.min + share.to_vec2() * rect.size()
}

/// Returns the part of the document's picture that a result covers, in fractions.
pub(super) fn part(result: &Result) -> Rect {
    let whole = vec2(result.format.width() as f32, result.format.height() as f32);
    let window = result.window;
    let corner = |x: i64, y: i64| (vec2(x as f32, y as f32) / whole).to_pos2();
    Rect::from_min_max(corner(window.x0, window.y0), corner(window.x1, window.y1))
}

/// Textures of a picture.
#[derive(Default)]
pub(super) struct Image {
    /// The uploaded picture, and its reduction factor.
    shown: Option<(Arc<Screen>, usize)>,
    /// Tiles, each with its area in fractions of the picture.
    tiles: Vec<(TextureHandle, Rect)>,
}

impl Image {
    /// Uploads a picture to the graphics card, unless it is there already. `scale` is the number of screen pixels per
    /// picture pixel; if it is small, the picture is reduced by averaging.
    pub(super) fn upload(&mut self, context: &Context, screen: &Arc<Screen>, scale: f32) {
        let factor = if scale > 0.0 { (1.0 / scale).floor().clamp(1.0, 64.0) as usize } else { 1 };
        if self.shown.as_ref().is_some_and(|(known, by)| Arc::ptr_eq(known, screen) && *by == factor) {
            return;
        }
        let side = context.input(|input| input.max_texture_side).max(64);
        let options = TextureOptions {
            magnification: TextureFilter::Nearest,
            minification: TextureFilter::Linear,
            ..TextureOptions::LINEAR
        };
        let [width, height] = screen.size.map(|side| side.div_ceil(factor));
        let mut old = std::mem::take(&mut self.tiles).into_iter();
        for y in (0..height).step_by(side) {
            for x in (0..width).step_by(side) {
                let size = [side.min(width - x), side.min(height - y)];
                let image = reduced(screen, factor, [x, y], size);
                let handle = match old.next() {
                    Some((mut handle, _)) => {
                        handle.set(image, options);
                        handle
                    }
                    None => context.load_texture("picture", image, options),
                };
                let whole = vec2(screen.size[0] as f32, screen.size[1] as f32) / factor as f32;
                let at = vec2(x as f32, y as f32) / whole;
                let extent = vec2(size[0] as f32, size[1] as f32) / whole;
                self.tiles.push((handle, Rect::from_min_size(at.to_pos2(), extent)));
            }
        }
        self.shown = Some((screen.clone(), factor));
    }

    /// Draws the picture into a rectangle.
    pub(super) fn paint(&self, painter: &Painter, rect: Rect) {
        self.paint_tinted(painter, rect, Color32::WHITE);
    }

    /// Draws the picture into a rectangle, multiplied by a color.
    pub(super) fn paint_tinted(&self, painter: &Painter, rect: Rect, tint: Color32) {
        // Averages in the last row and column may cover fewer pixels and extend beyond the edge.
        let painter = painter.with_clip_rect(painter.clip_rect().intersect(rect));
        for (handle, part) in &self.tiles {
            let part = Rect::from_min_max(place(rect, part.min), place(rect, part.max));
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            painter.image(handle.id(), part, whole, tint);
        }
    }
}

/// Reduces a tile of a picture by averaging squares of encoded values.
fn reduced(screen: &Screen, factor: usize, at: [usize; 2], size: [usize; 2]) -> ColorImage {
    let [width, height] = screen.size;
    let color = |x: usize, y: usize| {
        let start = 4 * (y * width + x);
        [screen.pixels[start], screen.pixels[start + 1], screen.pixels[start + 2]]
    };
    let mean = |x: usize, y: usize| {
        let (columns, rows) = (x * factor..((x + 1) * factor).min(width), y * factor..((y + 1) * factor).min(height));
        let count = (columns.len() * rows.len()).max(1) as u32;
        let mut sum = [count / 2; 3];
        for y in rows {
            for x in columns.clone() {
                sum.iter_mut().zip(color(x, y)).for_each(|(sum, value)| *sum += u32::from(value));
            }
        }
        let [r, g, b] = sum.map(|sum| (sum / count) as u8);
        Color32::from_rgb(r, g, b)
    };
    let row = |y: usize| (at[0]..at[0] + size[0]).map(move |x| (x, y));
    let rows = at[1]..at[1] + size[1];
    // On this thread: the others may be evaluating for seconds, and the window would stand still until then.
    ColorImage::new(size, rows.flat_map(row).map(|(x, y)| mean(x, y)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAGE: Stage = Stage {
        area: Rect { min: pos2(100.0, 50.0), max: pos2(500.0, 350.0) },
        size: vec2(1000.0, 500.0),
        density: 2.0,
    };

    #[test]
    fn a_fitted_picture_lies_in_the_panel_and_keeps_its_shape() {
        let rect = View::default().rect(&STAGE);
        assert!(STAGE.area.contains_rect(rect), "{rect:?}");
        assert!((rect.width() / rect.height() - 2.0).abs() < 1e-3);
    }

    #[test]
    fn zooming_keeps_what_is_under_the_pointer() {
        let mut view = View::default();
        let at = pos2(180.0, 210.0);
        let before = share(view.rect(&STAGE), at);
        for factor in [2.0, 1.5, 0.3, 4.0] {
            view.zoom_at(&STAGE, at, factor);
            // The picture is aligned to whole pixels.
            assert!((share(view.rect(&STAGE), at) - before).length() < 2e-3, "{factor}");
        }
        view.pan(&STAGE, vec2(20.0, 0.0));
        assert!((share(view.rect(&STAGE), at + vec2(20.0, 0.0)) - before).length() < 4e-3);
        view.one_to_one(&STAGE);
        assert!((view.zoom(&STAGE) - 1.0).abs() < 1e-5);
        view.fit();
        assert_eq!(view, View::default());
    }

    #[test]
    fn a_picture_stays_where_it_is_while_its_panel_gets_smaller_unless_it_is_fitted() {
        let mut smaller = STAGE;
        smaller.area.max.x -= 100.0;
        let mut view = View::default();
        view.keep(&STAGE, &smaller);
        assert_eq!(view, View::default());
        view.zoom_at(&STAGE, pos2(180.0, 210.0), 2.0);
        let before = view.rect(&STAGE);
        view.keep(&STAGE, &smaller);
        assert!((view.rect(&smaller).min - before.min).length() < 1.0);
    }

    #[test]
    fn smaller_pictures_are_means() {
        let pixels = [[0, 0, 0, 255], [200, 100, 0, 255], [10, 20, 30, 255]];
        let screen = Screen { size: [3, 1], pixels: pixels.concat() };
        assert_eq!(
            reduced(&screen, 2, [0, 0], [2, 1]).pixels,
            [Color32::from_rgb(100, 50, 0), Color32::from_rgb(10, 20, 30)]
        );
        assert_eq!(reduced(&screen, 1, [1, 0], [2, 1]).pixels[0], Color32::from_rgb(200, 100, 0));
    }
}
