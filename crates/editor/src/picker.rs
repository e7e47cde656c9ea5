//! Picking of colors by lightness, chroma and hue (OKLCh), with tracks that show what each change would give.

use crate::document::color::hex;
use crate::field::Gesture;
use egui::epaint::{Mesh, Shape};
use egui::{Color32, Id, Key, Pos2, Rect, Response, RichText, Sense, Stroke, StrokeKind, Ui, WidgetInfo, pos2, vec2};
use trochoid::{oklch, shown_oklch};

/// What a gesture did to a color; colors are sRGB values from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Picked {
    /// It is being dragged, and this far so far.
    Moved([f32; 3], Gesture),
    /// The gesture has ended with this color.
    Settled([f32; 3], Gesture),
    /// The gesture was cancelled.
    Cancelled,
}

/// Largest chroma of the track: beyond it there are no colors of sRGB.
const MOST_CHROMA: f64 = 0.33;
/// Height of a track, and width of the number beside it, in points.
const HEIGHT: f32 = 18.0;
const NUMBER: f32 = 46.0;
/// Under this, the id of the widget whose drag was cancelled is kept until the pointer is released.
const CANCELLED: &str = "cancelled";
/// Pieces of a gradient.
const PIECES: usize = 48;

/// A color that was picked.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    of: [f32; 3],
    /// What it was picked by: 8 bits lose the hue of grays.
    lch: [f64; 3],
}

/// Returns lightness, chroma and hue of a color; those that it was picked by, if it was.
fn lch_of(ui: &Ui, id: Id, color: [f32; 3]) -> [f64; 3] {
    let known = ui.data(|data| data.get_temp::<Known>(id));
    match known.filter(|held| hex(held.of) == hex(color)) {
        Some(held) => held.lch,
        None => oklch(color.map(f64::from)),
    }
}

/// Returns the color of lightness, chroma and hue, and remembers what it stands for.
fn chosen(ui: &Ui, id: Id, lch: [f64; 3]) -> [f32; 3] {
    let color = shown_oklch(lch).0.map(|channel| channel as f32);
    ui.data_mut(|data| data.insert_temp(id, Known { of: color, lch }));
    color
}

/// Turns what happens to a widget into a change of a color. `lch` says what the pointer's place gives.
pub(crate) fn dragged(ui: &Ui, id: Id, response: &Response, lch: impl FnOnce() -> Option<[f64; 3]>) -> Option<Picked> {
    let cancel = id.with(CANCELLED);
    let is_held = response.is_pointer_button_down_on() || response.dragged();
    let was_cancelled = ui.data(|data| data.get_temp::<Id>(cancel)) == Some(response.id);
    let ends = response.drag_stopped() || response.clicked();
    if was_cancelled {
        if !is_held || ends {
            ui.data_mut(|data| data.remove::<Id>(cancel));
        }
        return None;
    }
    if (is_held || ends) && ui.input(|input| input.key_pressed(Key::Escape)) {
        ui.data_mut(|data| data.insert_temp(cancel, response.id));
        return Some(Picked::Cancelled);
    }
    if ends {
        let gesture = Gesture::click(response).or_else(|| Gesture::dragged(response))?;
        return Some(Picked::Settled(chosen(ui, id, lch()?), gesture));
    }
    let (gesture, _) = Gesture::press(response).filter(|_| is_held)?;
    Some(Picked::Moved(chosen(ui, id, lch()?), gesture))
}

/// A number of a color that has a track.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Channel {
    Lightness,
    Chroma,
    Hue,
}

impl Channel {
    const ALL: [Self; 3] = [Self::Lightness, Self::Chroma, Self::Hue];

    fn label(self) -> &'static str {
        match self {
            Self::Lightness => "Lightness",
            Self::Chroma => "Chroma",
            Self::Hue => "Hue",
        }
    }

    /// Returns the end of the track; it begins at 0.
    fn end(self) -> f64 {
        match self {
            Self::Lightness => 1.0,
            Self::Chroma => MOST_CHROMA,
            Self::Hue => 360.0,
        }
    }

    fn text(self, value: f64) -> String {
        match self {
            Self::Lightness => format!("{:.0} %", 100.0 * value),
            Self::Chroma => format!("{value:.3}"),
            Self::Hue => format!("{value:.0}°"),
        }
    }

    /// Returns the color at a share of the track.
    fn at(self, lch: [f64; 3], share: f64) -> [f64; 3] {
        let mut next = lch;
        // The two ends of the circle are one hue.
        next[self as usize] = (share * self.end()).min(if self == Self::Hue { 359.99 } else { f64::INFINITY });
        next
    }
}

/// Draws tracks for the lightness, chroma and hue of a color. `id` tells its place from others.
pub(crate) fn picker_ui(ui: &mut Ui, id: Id, color: [f32; 3]) -> Option<Picked> {
    let lch = lch_of(ui, id, color);
    let mut picked = None;
    for channel in Channel::ALL {
        ui.horizontal(|ui| picked = picked.or(channel_ui(ui, id, lch, channel)));
    }
    let shown = shown_oklch(lch).1;
    if lch[1] > shown + 2e-3 {
        let text = format!("A display shows chroma up to {shown:.3} here.");
        ui.label(RichText::new(text).small().color(ui.visuals().warn_fg_color));
    }
    picked
}

fn channel_ui(ui: &mut Ui, id: Id, lch: [f64; 3], channel: Channel) -> Option<Picked> {
    let value = lch[channel as usize];
    let (place, _) = ui.allocate_exact_size(vec2(60.0, HEIGHT), Sense::hover());
    let (font, weak) = (egui::TextStyle::Body.resolve(ui.style()), ui.visuals().weak_text_color());
    ui.painter().text(place.left_center(), egui::Align2::LEFT_CENTER, channel.label(), font, weak);
    let width = (ui.available_width() - NUMBER).max(40.0);
    let (rect, response) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::slider(true, value, channel.label()));
    // Grays have no hue to show, so the track of hues has those of a moderate chroma.
    let seen = if channel == Channel::Hue { [lch[0], lch[1].max(0.06), lch[2]] } else { lch };
    track_ui(ui, rect, value / channel.end(), &response, &|share| channel.at(seen, share));
    let most = shown_oklch([lch[0], MOST_CHROMA, lch[2]]).1;
    if channel == Channel::Chroma && most < MOST_CHROMA {
        limit_ui(ui, rect, (most / MOST_CHROMA) as f32);
    }
    ui.label(RichText::new(channel.text(value)).monospace().weak());
    dragged(ui, id, &response, || {
        let share = |at: Pos2| f64::from(((at.x - rect.left()) / rect.width()).clamp(0.0, 1.0));
        Some(response.interact_pointer_pos().map_or(lch, |at| channel.at(lch, share(at))))
    })
}

fn color32(color: [f64; 3]) -> Color32 {
    let [r, g, b] = color.map(|channel| (255.0 * channel.clamp(0.0, 1.0)).round() as u8);
    Color32::from_rgb(r, g, b)
}

/// Draws a gradient with a mark at the present value.
fn track_ui(ui: &Ui, rect: Rect, share: f64, response: &Response, at: &dyn Fn(f64) -> [f64; 3]) {
    let mut mesh = Mesh::default();
    for piece in 0..=PIECES {
        let share = piece as f64 / PIECES as f64;
        let color = color32(shown_oklch(at(share)).0);
        let x = rect.left() + share as f32 * rect.width();
        mesh.colored_vertex(pos2(x, rect.top()), color);
        mesh.colored_vertex(pos2(x, rect.bottom()), color);
        if piece < PIECES {
            let first = 2 * piece as u32;
            mesh.add_triangle(first, first + 1, first + 2);
            mesh.add_triangle(first + 1, first + 2, first + 3);
        }
    }
    let painter = ui.painter();
    painter.add(Shape::mesh(mesh));
    let rim = if response.hovered() || response.dragged() {
        ui.visuals().widgets.hovered.fg_stroke.color
    } else {
        ui.visuals().widgets.noninteractive.bg_stroke.color
    };
    painter.rect_stroke(rect, 0.0, Stroke::new(1.0, rim), StrokeKind::Outside);
    let x = rect.left() + share.clamp(0.0, 1.0) as f32 * rect.width();
    painter.vline(x, rect.expand(2.0).y_range(), Stroke::new(4.0, Color32::BLACK));
    painter.vline(x, rect.expand(1.0).y_range(), Stroke::new(2.0, Color32::WHITE));
}

/// Dims the part of a track that no display shows.
fn limit_ui(ui: &Ui, rect: Rect, share: f32) {
    let x = rect.left() + share * rect.width();
    let beyond = Rect::from_min_max(pos2(x, rect.top()), rect.max);
    ui.painter().rect_filled(beyond, 0.0, Color32::from_black_alpha(140));
}

/// Drags a color by its swatch: up for more lightness, sideways for another hue, with Shift for another chroma.
pub(crate) fn swatch_drag(ui: &Ui, id: Id, color: [f32; 3], response: &Response) -> Option<Picked> {
    let start = id.with("start");
    if response.drag_started() {
        let lch = lch_of(ui, id, color);
        ui.data_mut(|data| {
            data.insert_temp(start, lch);
            // A drag that was cancelled is over.
            data.remove::<Id>(id.with(CANCELLED));
        });
    }
    // A click selects.
    if !response.dragged() && !response.drag_stopped() {
        return None;
    }
    let from = ui.data(|data| data.get_temp::<[f64; 3]>(start))?;
    let origin = ui.input(|input| input.pointer.press_origin());
    let (shift, now) = ui.input(|input| (input.modifiers.shift, input.pointer.latest_pos()));
    let key = start.with("last");
    let by = match (origin, now) {
        (Some(origin), Some(now)) => now - origin,
        // The pointer was released in this frame.
        _ => ui.data(|data| data.get_temp(key)).unwrap_or_default(),
    };
    ui.data_mut(|data| data.insert_temp(key, by));
    let [lightness, chroma, hue] = from;
    let next = [
        (lightness - f64::from(by.y) / 300.0).clamp(0.0, 1.0),
        if shift { (chroma + f64::from(by.x) / 600.0).clamp(0.0, MOST_CHROMA) } else { chroma },
        if shift { hue } else { (hue + f64::from(by.x) / 2.0).rem_euclid(360.0) },
    ];
    dragged(ui, id, response, || Some(next))
}

/// Draws small swatches of colors to pick from; returns the clicked one.
pub(crate) fn swatches_ui(ui: &mut Ui, colors: &[(String, [f32; 3])]) -> Option<Picked> {
    let mut picked = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(2.0, 2.0);
        for (name, color) in colors {
            let (rect, response) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::click());
            ui.painter().rect_filled(rect, 2.0, color32(color.map(f64::from)));
            if response.hovered() {
                ui.painter().rect_stroke(rect, 2.0, ui.visuals().widgets.hovered.fg_stroke, StrokeKind::Inside);
            }
            response.widget_info(|| WidgetInfo::labeled(egui::WidgetType::Button, true, format!("Take {name}")));
            picked = picked.or(Gesture::click(&response).map(|gesture| Picked::Settled(*color, gesture)));
            response.on_hover_text(name);
        }
    });
    picked
}
