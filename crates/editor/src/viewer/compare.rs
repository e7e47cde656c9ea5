//! Comparison of the current picture with a held one.

use super::picture::{Image, Stage, part, place};
use crate::evaluate::{Display, Result, Screen, shown};
use egui::{Align2, Color32, CursorIcon, FontId, Rect, Sense, Stroke, Ui, WidgetInfo, WidgetType, pos2, vec2};
use std::sync::Arc;
use trochoid::{Kind, Picture, WorkingSpace};

/// Way to compare with the held picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// The held picture to the left of a movable line.
    Wipe,
    /// The difference of both pictures.
    Difference,
}

/// The held picture and the comparison.
#[derive(Default)]
pub(super) struct Compare {
    pub(super) held: Option<HeldPicture>,
    pub(super) gain: f32,
    image: Image,
    difference: Option<Difference>,
    /// Number of pictures held so far.
    count: u64,
    /// Value range of the current picture, computed once.
    range: Option<(Arc<Picture>, Display, [f32; 2])>,
}

/// The held picture.
pub(super) struct HeldPicture {
    pub(super) name: String,
    pub(super) mode: Mode,
    number: u64,
    picture: Arc<Picture>,
    space: WorkingSpace,
    /// The picture converted for the screen, with these display settings.
    screen: Arc<Screen>,
    display: Display,
    /// Part of the document's picture that it covers.
    part: Rect,
    /// Position of the line, as a fraction of the picture's width.
    wipe: f32,
}

/// A cached difference.
struct Difference {
    of: [Arc<Screen>; 2],
    gain: f32,
    screen: Arc<Screen>,
}

impl HeldPicture {
    /// Returns whether the picture is shown with these display settings, ignoring the value range.
    pub(super) fn is_shown(&self, display: &Display) -> bool {
        Display { range: self.display.range, ..display.clone() } == self.display
    }
}

impl Compare {
    /// Holds a picture.
    pub(super) fn hold(&mut self, name: &str, result: &Result) {
        self.count += 1;
        self.held = Some(HeldPicture {
            name: format!("{name}, frame {}", result.frame),
            mode: self.held.as_ref().map_or(Mode::Wipe, |held| held.mode),
            number: self.count,
            picture: result.picture.clone(),
            space: result.lens.graph.space(),
            screen: result.screen.clone(),
            display: self.display(result),
            part: part(result),
            wipe: 0.5,
        });
        if self.gain <= 0.0 {
            self.gain = 4.0;
        }
    }

    /// Numbers held pictures from here on.
    pub(super) fn count_from(&mut self, number: u64) {
        self.count = number;
    }

    /// Returns the display settings for the held picture beside a result: those of the result, with the same value
    /// range.
    fn display(&mut self, result: &Result) -> Display {
        let display = result.display.clone();
        if display.range.is_some() || !matches!(result.picture.kind, Kind::Field(_)) {
            return display;
        }
        let known = self.range.as_ref().filter(|known| Arc::ptr_eq(&known.0, &result.picture) && known.1 == display);
        let range = known.map_or_else(|| shown::range(&result.picture, &display), |known| known.2);
        self.range = Some((result.picture.clone(), display.clone(), range));
        // A value range is meaningful only for the same kind.
        let is_alike = self.held.as_ref().is_none_or(|held| held.picture.kind == result.picture.kind);
        if is_alike { Display { range: Some(range), ..display } } else { display }
    }

    /// Returns the request for the held picture, if it needs other display settings.
    pub(super) fn wanted(&mut self, result: &Result) -> Option<(u64, Arc<Picture>, WorkingSpace, Display)> {
        self.held.as_ref()?;
        let display = self.display(result);
        let held = self.held.as_ref().filter(|held| held.display != display && !held.picture.planes.is_empty())?;
        Some((held.number, held.picture.clone(), held.space, display))
    }

    /// Receives the requested held picture.
    pub(super) fn take(&mut self, number: u64, display: Display, screen: Arc<Screen>) {
        if let Some(held) = self.held.as_mut().filter(|held| held.number == number) {
            (held.display, held.screen) = (display, screen);
        }
    }

    /// Returns the screen pixels to draw: the current picture, or the difference.
    pub(super) fn shown(&mut self, result: &Result) -> Arc<Screen> {
        let Some(held) = self.held.as_ref().filter(|held| held.mode == Mode::Difference) else {
            self.difference = None;
            return result.screen.clone();
        };
        // Keep the previous difference until both pictures have the same display settings.
        if let Some(known) = self.difference.as_ref().filter(|_| !held.is_shown(&result.display)) {
            return known.screen.clone();
        }
        let of = [&held.screen, &result.screen];
        let known = self.difference.as_ref().filter(|known| {
            known.of.iter().zip(of).all(|(known, of)| Arc::ptr_eq(known, of)) && known.gain == self.gain
        });
        if let Some(known) = known {
            return known.screen.clone();
        }
        let screen = Arc::new(difference(&held.screen, held.part, &result.screen, part(result), self.gain));
        self.difference = Some(Difference { of: of.map(Arc::clone), gain: self.gain, screen: screen.clone() });
        screen
    }

    /// Draws the held picture to the left of the wipe line, and handles the line's input.
    pub(super) fn wipe_ui(&mut self, ui: &mut Ui, stage: &Stage, rect: Rect, zoom: f32) {
        let Some(held) = self.held.as_mut().filter(|held| held.mode == Mode::Wipe) else { return };
        let x = rect.left() + held.wipe * rect.width();
        let mut left = stage.area;
        left.max.x = x.clamp(stage.area.left(), stage.area.right());
        let own = Rect::from_min_max(place(rect, held.part.min), place(rect, held.part.max));
        let across = held.part.width() * stage.size.x / held.screen.size[0].max(1) as f32;
        self.image.upload(ui.ctx(), &held.screen, zoom * across);
        self.image.paint(&ui.painter().with_clip_rect(left.intersect(ui.clip_rect())), own);
        let shown = stage.area.intersect(rect);
        let grip = Rect::from_center_size(pos2(x, shown.center().y), vec2(9.0, shown.height()));
        let line = ui.interact(grip, ui.id().with("wipe"), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
        line.widget_info(|| WidgetInfo::labeled(WidgetType::Slider, true, "Wipe line"));
        if line.dragged()
            && let Some(pointer) = line.interact_pointer_pos()
        {
            held.wipe = ((pointer.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
        }
        let strong = line.hovered() || line.dragged();
        let painter = ui.painter().with_clip_rect(stage.area);
        painter.vline(x, shown.y_range(), Stroke::new(3.0, Color32::from_black_alpha(120)));
        painter.vline(x, shown.y_range(), Stroke::new(if strong { 2.0 } else { 1.0 }, Color32::WHITE));
        for (text, align, shift) in [("A", Align2::RIGHT_TOP, -6.0), ("B", Align2::LEFT_TOP, 6.0)] {
            let at = pos2(x + shift, shown.top() + 6.0);
            painter.text(at + vec2(1.0, 1.0), align, text, FontId::proportional(13.0), Color32::from_black_alpha(180));
            painter.text(at, align, text, FontId::proportional(13.0), Color32::WHITE);
        }
    }
}

/// Returns the absolute difference of two pictures as displayed, at the size of the second; pixels that the first does
/// not cover are black.
fn difference(a: &Screen, part_a: Rect, b: &Screen, part_b: Rect, gain: f32) -> Screen {
    let mut pixels = vec![255_u8; b.pixels.len()];
    let nearest = |index: usize, axis: usize| {
        let (low, high) = (part_b.min[axis], part_b.max[axis]);
        let share = low + (index as f32 + 0.5) / b.size[axis] as f32 * (high - low);
        let own = (share - part_a.min[axis]) / (part_a.max[axis] - part_a.min[axis]) * a.size[axis] as f32;
        (own >= 0.0 && own < a.size[axis] as f32).then_some(own as usize)
    };
    let columns: Vec<Option<usize>> = (0..b.size[0]).map(|x| nearest(x, 0)).collect();
    for (y, row) in pixels.chunks_exact_mut(4 * b.size[0].max(1)).enumerate() {
        let from = nearest(y, 1);
        for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
            let (Some(fx), Some(fy)) = (columns[x], from) else {
                pixel[..3].fill(0);
                continue;
            };
            for (channel, value) in pixel[..3].iter_mut().enumerate() {
                let old = a.pixels[4 * (fy * a.size[0] + fx) + channel];
                let new = b.pixels[4 * (y * b.size[0] + x) + channel];
                *value = (f32::from(old.abs_diff(new)) * gain).min(255.0) as u8;
            }
        }
    }
    Screen { size: b.size, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: Rect = Rect { min: pos2(0.0, 0.0), max: pos2(1.0, 1.0) };

    fn screen(size: [usize; 2], gray: &[u8]) -> Screen {
        Screen { size, pixels: gray.iter().flat_map(|v| [*v, *v, *v, 255]).collect() }
    }

    #[test]
    fn a_difference_is_absolute_and_multiplied() {
        let found = difference(&screen([2, 1], &[10, 200]), WHOLE, &screen([2, 1], &[14, 190]), WHOLE, 4.0);
        assert_eq!(found, screen([2, 1], &[16, 40]));
    }

    #[test]
    fn pictures_of_other_sizes_and_parts_are_laid_over_each_other() {
        let found = difference(&screen([1, 1], &[50]), WHOLE, &screen([3, 1], &[50, 60, 80]), WHOLE, 1.0);
        assert_eq!(found, screen([3, 1], &[0, 10, 30]));
        let right = Rect::from_min_max(pos2(0.5, 0.0), pos2(1.0, 1.0));
        let found = difference(&screen([1, 1], &[50]), right, &screen([2, 1], &[90, 90]), WHOLE, 1.0);
        assert_eq!(found, screen([2, 1], &[0, 40]));
    }
}
