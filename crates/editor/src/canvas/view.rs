//! The viewport on the canvas: pan and zoom.

use egui::{Pos2, Rect, Vec2, vec2};

/// Minimum and maximum zoom.
const ZOOM: [f32; 2] = [0.06, 3.0];

/// Minimum zoom at which most names are legible.
const READABLE: f32 = 0.5;

/// Mapping between the canvas and the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Area of the panel, in screen points.
    pub(super) rect: Rect,
    /// Position of the canvas origin relative to the panel's upper left corner, in screen points.
    pub(super) pan: Vec2,
    /// Screen points per canvas unit.
    pub(super) zoom: f32,
    /// Pan and zoom as they were when the graph was fitted into the view, until when nobody had moved it.
    pub(super) fitted: Option<(Vec2, f32)>,
}

impl Default for View {
    fn default() -> Self {
        Self { rect: Rect::NOTHING, pan: Vec2::ZERO, zoom: 1.0, fitted: None }
    }
}

impl View {
    /// Converts a point from the canvas to the screen.
    pub(super) fn screen(&self, at: Pos2) -> Pos2 {
        self.rect.min + self.pan + at.to_vec2() * self.zoom
    }

    /// Converts a point from the screen to the canvas.
    pub(super) fn canvas(&self, at: Pos2) -> Pos2 {
        ((at - self.rect.min - self.pan) / self.zoom).to_pos2()
    }

    /// Converts an area from the canvas to the screen.
    pub(super) fn area(&self, area: Rect) -> Rect {
        Rect::from_min_max(self.screen(area.min), self.screen(area.max))
    }

    /// Returns the visible part of the canvas.
    pub(super) fn seen(&self) -> Rect {
        Rect::from_min_max(self.canvas(self.rect.min), self.canvas(self.rect.max))
    }

    /// Sets the panel's area; the middle of the view stays in the middle.
    pub(super) fn set_rect(&mut self, rect: Rect) {
        if self.rect.is_finite() && self.rect.is_positive() {
            self.pan += (rect.size() - self.rect.size()) / 2.0;
        }
        self.rect = rect;
    }

    /// Zooms around a place on the screen, which stays fixed.
    pub(super) fn zoom_at(&mut self, at: Pos2, factor: f32) {
        let kept = self.canvas(at);
        self.zoom = (self.zoom * factor).clamp(ZOOM[0], ZOOM[1]);
        self.pan += at - self.screen(kept);
    }

    /// Zooms to fit an area, but to no more than 100%, and keeps a strip at the right free of it.
    pub(super) fn show(&mut self, area: Rect, strip: f32) {
        let room = (self.rect.size() - vec2(48.0 + strip, 52.0)).max(vec2(40.0, 40.0));
        let fits = (room / area.size().max(vec2(1.0, 1.0))).min_elem();
        self.zoom = fits.clamp(ZOOM[0], 1.0);
        self.center(area.center());
        self.pan.x -= strip / 2.0;
    }

    /// Returns whether nobody has moved the view since the graph was fitted into it.
    pub(super) fn is_untouched(&self) -> bool {
        self.fitted.is_none_or(|fitted| fitted == (self.pan, self.zoom))
    }

    /// Sets the initial view: all of an area if its names stay legible, otherwise the part of it around a place.
    pub(super) fn open(&mut self, area: Rect, around: Pos2) {
        self.show(area, 0.0);
        if self.zoom < READABLE {
            self.show_part(area, around);
        }
        self.fitted = Some((self.pan, self.zoom));
    }

    /// Shows the part of an area around a place, with names that are just legible.
    fn show_part(&mut self, area: Rect, around: Pos2) {
        self.zoom = READABLE;
        let half = (self.rect.size() / 2.0 - vec2(24.0, 36.0)) / self.zoom;
        let within = |at: f32, ends: egui::Rangef, half: f32| match ends.span() > 2.0 * half {
            true => at.clamp(ends.min + half, ends.max - half),
            false => ends.center(),
        };
        self.center(egui::pos2(within(around.x, area.x_range(), half.x), within(around.y, area.y_range(), half.y)));
    }

    /// Centers the view on a place of the canvas.
    pub(super) fn center(&mut self, at: Pos2) {
        self.pan = self.rect.size() / 2.0 - at.to_vec2() * self.zoom;
    }
}
