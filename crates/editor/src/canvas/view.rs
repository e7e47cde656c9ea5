//! Which part of the canvas is seen, and how large.

use egui::{Pos2, Rect, Vec2, vec2};

/// The least and the greatest zoom.
const ZOOM: [f32; 2] = [0.06, 3.0];

/// The least zoom at which most names can be read.
const READABLE: f32 = 0.5;

/// Where the canvas lies on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// The panel, in points of the screen.
    pub(super) rect: Rect,
    /// What is seen at the panel's upper left corner, times −zoom.
    pub(super) pan: Vec2,
    /// Points of the screen to one of the canvas.
    pub(super) zoom: f32,
}

impl Default for View {
    fn default() -> Self {
        Self { rect: Rect::NOTHING, pan: Vec2::ZERO, zoom: 1.0 }
    }
}

impl View {
    /// From the canvas to the screen.
    pub(super) fn screen(&self, at: Pos2) -> Pos2 {
        self.rect.min + self.pan + at.to_vec2() * self.zoom
    }

    /// From the screen to the canvas.
    pub(super) fn canvas(&self, at: Pos2) -> Pos2 {
        ((at - self.rect.min - self.pan) / self.zoom).to_pos2()
    }

    /// An area of the canvas on the screen.
    pub(super) fn area(&self, area: Rect) -> Rect {
        Rect::from_min_max(self.screen(area.min), self.screen(area.max))
    }

    /// The part of the canvas that is seen.
    pub(super) fn seen(&self) -> Rect {
        Rect::from_min_max(self.canvas(self.rect.min), self.canvas(self.rect.max))
    }

    /// Takes the panel's new place; what was in the middle stays there.
    pub(super) fn set_rect(&mut self, rect: Rect) {
        if self.rect.is_finite() && self.rect.is_positive() {
            self.pan += (rect.size() - self.rect.size()) / 2.0;
        }
        self.rect = rect;
    }

    /// Zooms; what is at this place of the screen stays there.
    pub(super) fn zoom_at(&mut self, at: Pos2, factor: f32) {
        let kept = self.canvas(at);
        self.zoom = (self.zoom * factor).clamp(ZOOM[0], ZOOM[1]);
        self.pan += at - self.screen(kept);
    }

    /// Shows an area as large as it fits, but not larger than life.
    pub(super) fn show(&mut self, area: Rect) {
        let room = (self.rect.size() - vec2(48.0, 72.0)).max(vec2(40.0, 40.0));
        let fits = (room / area.size().max(vec2(1.0, 1.0))).min_elem();
        self.zoom = fits.clamp(ZOOM[0], 1.0);
        self.center(area.center());
    }

    /// Shows an area at first: where it does not fit with names that can be read, the part of it around a place.
    pub(super) fn open(&mut self, area: Rect, around: Pos2) {
        self.show(area);
        if self.zoom >= READABLE {
            return;
        }
        self.zoom = READABLE;
        let half = (self.rect.size() / 2.0 - vec2(24.0, 36.0)) / self.zoom;
        let within = |at: f32, ends: egui::Rangef, half: f32| match ends.span() > 2.0 * half {
            true => at.clamp(ends.min + half, ends.max - half),
            false => ends.center(),
        };
        self.center(egui::pos2(within(around.x, area.x_range(), half.x), within(around.y, area.y_range(), half.y)));
    }

    /// Brings a place of the canvas to the middle.
    pub(super) fn center(&mut self, at: Pos2) {
        self.pan = self.rect.size() / 2.0 - at.to_vec2() * self.zoom;
    }
}
