//! Keyed values as curves: lines, keys, and the handles of those that are picked.

use super::view::Screen;
use super::{Curves, KEY, Picked, Spot, animated, components, is_color, is_drawn, list};
use crate::document::curve::Pick;
use crate::document::keyed::Channel;
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Ui, pos2, vec2};
use trochoid::WorkingSpace;

/// Distance between points of drawn curves, in points of the screen.
const STEP: f32 = 3.0;
/// Most picked keys whose handles are shown.
const MOST: usize = 24;

/// The end of a handle.
#[derive(Clone, Debug)]
pub(super) struct Grip {
    pub(super) picked: Picked,
    /// The side of the key: 0 before it, 1 after it.
    pub(super) side: usize,
    /// Frame and value of the key.
    pub(super) from: [f64; 2],
    /// Frame and value of the end.
    pub(super) to: [f64; 2],
    /// Whether it is moved without the handle at the other side.
    pub(super) is_alone: bool,
}

/// Returns the ends of the handles of picked keys.
pub(super) fn grips(panel: &Curves, channels: &[Channel]) -> Vec<Grip> {
    let mut grips = Vec::new();
    for (channel, picks) in panel.picked(channels).into_iter().filter(|(channel, _)| !is_color(channel)) {
        for pick in picks.into_iter().take(MOST) {
            let Some(index) = channel.curve.find(pick.frame) else { continue };
            let Some(value) = channel.curve.keys[index].numbers().get(pick.component).copied() else { continue };
            for (side, handle) in channel.curve.acting(index).into_iter().enumerate() {
                let Some(handle) = handle else { continue };
                let sign = if side == 0 { -1.0 } else { 1.0 };
                let to = [pick.frame + sign * handle.frames, value + handle.change[pick.component]];
                let picked = Picked { path: channel.path.clone(), pick };
                let is_alone = panel.is_corner(channel, &channel.curve.keys[index]);
                grips.push(Grip { picked, side, from: [pick.frame, value], to, is_alone });
            }
        }
    }
    grips
}

/// Draws curves with their keys, and returns the marks of keys.
pub(super) fn graph_ui(
    panel: &Curves,
    ui: &Ui,
    painter: &Painter,
    screen: &Screen,
    channels: &[Channel],
    space: WorkingSpace,
) -> Vec<Spot> {
    screen.values_ui(ui, painter);
    let (mut spots, mut color) = (Vec::new(), 0);
    let plot = painter.with_clip_rect(screen.rect);
    for channel in channels.iter().filter(|channel| is_drawn(channel)) {
        let count = components(channel);
        if panel.is_ticked(channel)
            && let Some(animated) = animated(channel, space)
        {
            let columns = (screen.rect.width() / STEP).ceil() as usize;
            // Keys are corners: between columns, they would be cut off.
            let mut frames: Vec<f64> = (0..=columns)
                .map(|column| screen.at(pos2(screen.rect.left() + STEP * column as f32, 0.0))[0])
                .chain(channel.curve.keys.iter().flat_map(|key| [key.frame.next_down(), key.frame]))
                .collect();
            frames.sort_by(f64::total_cmp);
            let values: Vec<Vec<f64>> = frames.iter().map(|frame| animated.at(*frame)).collect();
            for component in 0..count {
                let ink = list::ink(ui, channel, color, component);
                let points = frames.iter().zip(&values).map(|(frame, value)| screen.place(*frame, value[component]));
                plot.add(Shape::line(points.collect(), Stroke::new(1.6, ink)));
                for key in &channel.curve.keys {
                    let place = screen.place(key.frame, animated.at(key.frame)[component]);
                    let pick = Pick { frame: key.frame, component };
                    let picks = vec![Picked { path: channel.path.clone(), pick }];
                    spots.push(Spot { picks, place, is_sum: false });
                }
            }
        }
        color += if is_color(channel) { 0 } else { count };
    }
    screen.labels_ui(ui, painter);
    for grip in grips(panel, channels) {
        let [from, to] = [grip.from, grip.to].map(|[frame, value]| screen.place(frame, value));
        let ink = ui.visuals().strong_text_color();
        plot.line_segment([from, to], Stroke::new(1.0, ink.gamma_multiply(0.6)));
        // Square ends are moved one by one.
        let (fill, rim) = (ui.visuals().extreme_bg_color, Stroke::new(1.4, ink));
        match grip.is_alone {
            true => plot.rect(Rect::from_center_size(to, vec2(6.5, 6.5)), 0.0, fill, rim, StrokeKind::Middle),
            false => plot.circle(to, 3.5, fill, rim),
        };
    }
    spots
}

/// Draws a key: a filled one is picked.
pub(super) fn key_ui(ui: &Ui, painter: &Painter, at: Pos2, is_picked: bool) {
    let size = 4.5;
    let corners = [pos2(at.x, at.y - size), pos2(at.x + size, at.y), pos2(at.x, at.y + size), pos2(at.x - size, at.y)];
    let strong = ui.visuals().strong_text_color();
    let (fill, stroke) = match is_picked {
        true => (strong, Stroke::new(2.0, KEY)),
        false => (KEY, Stroke::new(1.0, Color32::from_black_alpha(150))),
    };
    painter.add(Shape::convex_polygon(corners.into(), fill, stroke));
}

impl Curves {
    /// Returns the shown curve that is nearest to a place, above or below it.
    pub(super) fn nearest<'c>(
        &self,
        channels: &'c [Channel],
        screen: &Screen,
        at: Pos2,
        space: WorkingSpace,
    ) -> Option<&'c Channel> {
        let frame = screen.at(at)[0];
        let away = |channel: &Channel| {
            let values = animated(channel, space).map_or(Vec::new(), |animated| animated.at(frame));
            let all = values.iter().map(|value| (screen.place(frame, *value).y - at.y).abs());
            all.fold(f32::INFINITY, f32::min)
        };
        self.shown(channels).into_iter().min_by(|a, b| away(a).total_cmp(&away(b)))
    }
}
