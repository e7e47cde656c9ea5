//! The picture on the screen: its textures, and where it lies.

use crate::evaluate::{Result, Screen};
use egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, TextureFilter, TextureHandle, TextureOptions, Vec2, pos2, vec2,
};
use std::sync::Arc;

/// What surrounds the picture: a gray that makes no color look different.
pub(super) const SURROUND: Color32 = Color32::from_gray(0x2e);

/// How far in and out one can go: pixels of the screen for one of the document.
const ZOOMS: [f32; 2] = [0.02, 64.0];
/// What is left around a picture that is fitted, points.
const MARGIN: f32 = 4.0;

/// Where the picture lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// Pixels of the screen for one of the document; fitted to the panel if `None`.
    zoom: Option<f32>,
    /// What stands in the middle of the panel, in shares of the picture.
    center: Pos2,
}

impl Default for View {
    fn default() -> Self {
        Self { zoom: None, center: pos2(0.5, 0.5) }
    }
}

/// The panel, and the size of the document's picture in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    pub(super) area: Rect,
    pub(super) size: Vec2,
    /// Pixels of the screen for one point.
    pub(super) density: f32,
}

impl View {
    /// Pixels of the screen for one of the document.
    pub(super) fn zoom(&self, stage: &Stage) -> f32 {
        self.zoom.unwrap_or_else(|| {
            let room = (stage.area.size() - Vec2::splat(2.0 * MARGIN)).max(Vec2::splat(8.0)) * stage.density;
            (room.x / stage.size.x).min(room.y / stage.size.y)
        })
    }

    /// Where the picture lies on the screen.
    pub(super) fn rect(&self, stage: &Stage) -> Rect {
        let size = stage.size * (self.zoom(stage) / stage.density);
        let center = if self.zoom.is_some() { self.center } else { pos2(0.5, 0.5) };
        let corner = stage.area.center() - size * center.to_vec2();
        // On whole pixels of the screen, so that those of the picture stay sharp.
        let corner = (corner.to_vec2() * stage.density).round() / stage.density;
        Rect::from_min_size(corner.to_pos2(), size)
    }

    /// Shows all of it.
    pub(super) fn fit(&mut self) {
        *self = Self::default();
    }

    /// Shows a pixel of the document as one of the screen.
    pub(super) fn one_to_one(&mut self, stage: &Stage) {
        let factor = 1.0 / self.zoom(stage);
        self.zoom_at(stage, stage.area.center(), factor);
    }

    /// Goes in or out; what is at `at` stays there.
    pub(super) fn zoom_at(&mut self, stage: &Stage, at: Pos2, factor: f32) {
        let share = share(self.rect(stage), at);
        let zoom = (self.zoom(stage) * factor).clamp(ZOOMS[0], ZOOMS[1]);
        let size = stage.size * (zoom / stage.density);
        *self = Self { zoom: Some(zoom), center: share + (stage.area.center() - at) / size };
    }

    /// Leaves a picture where it is, unless it is fitted, while the panel gets larger or smaller.
    pub(super) fn keep(&mut self, from: &Stage, to: &Stage) {
        if self.zoom.is_some() {
            self.center += (to.area.center() - from.area.center()) / self.rect(from).size();
        }
    }

    /// Brings a place of the picture into the panel by the shortest way.
    pub(super) fn show(&mut self, stage: &Stage, at: Pos2) {
        let (rect, room) = (self.rect(stage), stage.area.shrink(14.0_f32.min(0.5 * stage.area.size().min_elem())));
        if self.zoom.is_some() {
            let at = place(rect, at);
            self.center += (at - at.clamp(room.min, room.max)) / rect.size();
        }
    }

    /// Moves the picture by so many points.
    pub(super) fn pan(&mut self, stage: &Stage, by: Vec2) {
        let (rect, zoom) = (self.rect(stage), self.zoom(stage));
        let center = share(rect, stage.area.center()) - by / rect.size();
        *self = Self { zoom: Some(zoom), center: center.clamp(pos2(0.0, 0.0), pos2(1.0, 1.0)) };
    }
}

/// A place on the screen in shares of a rectangle.
pub(super) fn share(rect: Rect, at: Pos2) -> Pos2 {
    ((at - rect.min) / rect.size()).to_pos2()
}

/// A place in shares of a rectangle on the screen.
pub(super) fn place(rect: Rect, share: Pos2) -> Pos2 {
    rect.min + share.to_vec2() * rect.size()
}

/// The part of the document's picture that a result shows, in shares.
pub(super) fn part(result: &Result) -> Rect {
    let whole = vec2(result.format.width() as f32, result.format.height() as f32);
    let Some(window) = result.picture.planes.first().map(trochoid::Plane::window) else { return Rect::NOTHING };
    let corner = |x: i64, y: i64| (vec2(x as f32, y as f32) / whole).to_pos2();
    Rect::from_min_max(corner(window.x0, window.y0), corner(window.x1, window.y1))
}

/// Textures of a picture.
#[derive(Default)]
pub(super) struct Image {
    /// What they show, and by how much smaller.
    shown: Option<(Arc<Screen>, usize)>,
    /// With the place of each in shares of the picture.
    tiles: Vec<(TextureHandle, Rect)>,
}

impl Image {
    /// Brings a picture to the graphics card unless it is there. `scale` is how many pixels of the screen one of its own
    /// takes: where that is little, fewer are brought, each the mean of some.
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

    /// Draws it into a rectangle.
    pub(super) fn paint(&self, painter: &Painter, rect: Rect) {
        // Means of the last rows and columns may be of fewer pixels, and reach beyond.
        let painter = painter.with_clip_rect(painter.clip_rect().intersect(rect));
        for (handle, part) in &self.tiles {
            let part = Rect::from_min_max(place(rect, part.min), place(rect, part.max));
            let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
            painter.image(handle.id(), part, whole, Color32::WHITE);
        }
    }
}

/// A part of a picture that is so many times smaller: means of squares, as they are encoded.
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
    let mut pixels = Vec::with_capacity(size[0] * size[1]);
    for y in at[1]..at[1] + size[1] {
        pixels.extend((at[0]..at[0] + size[0]).map(|x| mean(x, y)));
    }
    ColorImage::new(size, pixels)
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
            // The picture lies on whole pixels.
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
        // What lies below the part that is gone comes into the rest.
        let at = share(before, pos2(450.0, 210.0));
        view.show(&smaller, at);
        assert!(smaller.area.contains(place(view.rect(&smaller), at)));
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
