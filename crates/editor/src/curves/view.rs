//! The view of the plot: which frames and values it shows, and its axes.

use crate::document::keyed::Channel;
use crate::plots;
use egui::{Align2, FontId, Painter, Pos2, Rect, Stroke, Ui, Visuals, pos2, vec2};
use trochoid::WorkingSpace;

/// Height of the ruler of frames, in points.
pub(super) const RULER: f32 = 20.0;
/// Share of the view that stays free beside what is fitted into it.
const MARGIN: f64 = 0.08;

/// The frames and values that the plot shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    /// Frames at the left and right edge.
    pub(super) frames: [f64; 2],
    /// Values at the lower and upper edge.
    pub(super) values: [f64; 2],
}

/// A view on the screen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Screen {
    pub(super) view: View,
    /// Place of the plot, without the ruler.
    pub(super) rect: Rect,
}

fn padded([low, high]: [f64; 2], least: f64) -> [f64; 2] {
    let (middle, span) = (0.5 * (low + high), (high - low).max(least));
    let half = span * (0.5 + MARGIN);
    [middle - half, middle + half]
}

fn hull(numbers: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    numbers.map(|number| [number; 2]).reduce(|[low, high], [number, _]| [low.min(number), high.max(number)])
}

impl View {
    /// Returns the view of all keys of some channels and of all frames of a range.
    pub(super) fn around(channels: &[&Channel], (first, last): (i64, i64), space: WorkingSpace) -> Self {
        let keys = channels.iter().flat_map(|channel| &channel.curve.keys).map(|key| key.frame);
        let frames = hull(keys.chain([first as f64, last as f64])).unwrap_or([0.0, 1.0]);
        let numbers = channels.iter().filter(|channel| super::is_drawn(channel)).flat_map(|channel| {
            let animated = super::animated(channel, space);
            let at_keys = channel.curve.keys.iter().filter_map(|key| Some(animated.as_ref()?.at(key.frame)));
            let turns = animated.iter().flat_map(|animated| animated.turns()).map(|(_, value)| value);
            at_keys.flatten().chain(turns).collect::<Vec<_>>()
        });
        let values = hull(numbers).unwrap_or([0.0, 1.0]);
        let least = 1e-3 * values[0].abs().max(values[1].abs()).max(1e-3);
        let least = if values[0] == values[1] { 1.0_f64.max(0.2 * values[0].abs()) } else { least };
        Self { frames: padded(frames, 2.0), values: padded(values, least) }
    }
}

impl Screen {
    /// Returns the place of a frame and a value.
    pub(super) fn place(&self, frame: f64, value: f64) -> Pos2 {
        pos2(self.x(frame), self.y(value))
    }

    pub(super) fn x(&self, frame: f64) -> f32 {
        let [low, high] = self.view.frames;
        self.rect.left() + ((frame - low) / (high - low)) as f32 * self.rect.width()
    }

    fn y(&self, value: f64) -> f32 {
        let [low, high] = self.view.values;
        // What lies far outside is clamped, so that lines to it stay lines.
        let share = ((value - low) / (high - low)).clamp(-50.0, 50.0) as f32;
        self.rect.bottom() - share * self.rect.height()
    }

    /// Returns the frame and the value at a place.
    pub(super) fn at(&self, place: Pos2) -> [f64; 2] {
        let ([left, right], [low, high]) = (self.view.frames, self.view.values);
        let across = f64::from((place.x - self.rect.left()) / self.rect.width().max(1.0));
        let up = f64::from((self.rect.bottom() - place.y) / self.rect.height().max(1.0));
        [left + across * (right - left), low + up * (high - low)]
    }

    /// Returns the view after it is dragged.
    pub(super) fn panned(&self, by: egui::Vec2) -> View {
        let [from, to] = [self.at(self.rect.center()), self.at(self.rect.center() - by)];
        let moved = |axis: usize, ends: [f64; 2]| ends.map(|end| end + to[axis] - from[axis]);
        View { frames: moved(0, self.view.frames), values: moved(1, self.view.values) }
    }

    /// Returns the view magnified around a place.
    pub(super) fn zoomed(&self, around: Pos2, factors: [f64; 2]) -> View {
        let fixed = self.at(around);
        let zoomed = |axis: usize, ends: [f64; 2]| {
            let factor = factors[axis].clamp(0.2, 5.0);
            let ends = ends.map(|end| fixed[axis] + (end - fixed[axis]) / factor);
            (ends[1] - ends[0] > 1e-9 && ends[1] - ends[0] < 1e12).then_some(ends)
        };
        View {
            frames: zoomed(0, self.view.frames).unwrap_or(self.view.frames),
            values: zoomed(1, self.view.values).unwrap_or(self.view.values),
        }
    }

    /// Draws the ruler above the plot, with lines down from its numbers.
    pub(super) fn ruler_ui(&self, ui: &Ui, painter: &Painter) {
        let visuals = ui.visuals();
        let [low, high] = self.view.frames;
        let point = (high - low) / f64::from(self.rect.width().max(1.0));
        let ruler = Rect::from_min_max(pos2(self.rect.left(), self.rect.top() - RULER), self.rect.right_top());
        painter.rect_filled(ruler, 0.0, visuals.faint_bg_color);
        for mark in plots::ticks((low, high), point, 0).iter().filter(|mark| mark.step_size >= 1.0) {
            let x = self.x(mark.value);
            line(painter, [pos2(x, self.rect.top()), pos2(x, self.rect.bottom())], visuals);
            let text = plots::numbered(mark.value, mark.step_size);
            let place = pos2(x, ruler.center().y);
            painter.text(place, Align2::CENTER_CENTER, text, FontId::proportional(10.0), visuals.text_color());
        }
    }

    /// Draws lines across at round values.
    pub(super) fn values_ui(&self, ui: &Ui, painter: &Painter) {
        for (y, _) in self.marks() {
            line(painter, [pos2(self.rect.left(), y), pos2(self.rect.right(), y)], ui.visuals());
        }
    }

    /// Draws the numbers of these values, in boxes over the curves.
    pub(super) fn labels_ui(&self, ui: &Ui, painter: &Painter) {
        let visuals = ui.visuals();
        for (y, text) in self.marks() {
            let galley = painter.layout_no_wrap(text, FontId::proportional(10.0), visuals.weak_text_color());
            let place = pos2(self.rect.left() + 3.0, y - 1.0);
            let text = Align2::LEFT_BOTTOM.anchor_size(place, galley.size());
            painter.rect_filled(text.expand2(vec2(2.0, 0.0)), 2.0, visuals.extreme_bg_color.gamma_multiply(0.85));
            painter.galley(text.min, galley, visuals.weak_text_color());
        }
    }

    /// Returns round values: their heights on the screen, and their numbers.
    fn marks(&self) -> Vec<(f32, String)> {
        let [low, high] = self.view.values;
        let point = (high - low) / f64::from(self.rect.height().max(1.0));
        let marks = plots::ticks((low, high), point, 1).into_iter();
        marks.map(|mark| (self.y(mark.value), plots::numbered(mark.value, mark.step_size))).collect()
    }

    /// Draws the current frame.
    pub(super) fn playhead_ui(&self, ui: &Ui, painter: &Painter, frame: i64) {
        let x = self.x(frame as f64);
        let color = ui.visuals().strong_text_color();
        let top = self.rect.top() - RULER;
        painter.line_segment([pos2(x, top), pos2(x, self.rect.bottom())], Stroke::new(1.5, color));
        let head = [pos2(x - 5.0, top), pos2(x + 5.0, top), pos2(x, top + 7.0)];
        painter.add(egui::Shape::convex_polygon(head.into(), color, Stroke::NONE));
    }
}

fn line(painter: &Painter, ends: [Pos2; 2], visuals: &Visuals) {
    painter.line_segment(ends, Stroke::new(1.0, visuals.weak_text_color().gamma_multiply(0.25)));
}
