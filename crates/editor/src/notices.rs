//! Notices over the graph that report successes and failures. Each can be closed; all but errors also disappear by
//! themselves.

use egui::{
    Align2, Area, Color32, Context, Frame, Label, Order, RichText, Visuals, WidgetInfo, WidgetType, pos2, vec2,
};

/// Margin of the notices: over the graph, above the timeline and status bar, without covering tabs or titles.
const MARGIN: egui::Vec2 = vec2(8.0, 66.0);
/// Distance between notices, in points.
const APART: f32 = 6.0;
/// Maximum width of the text, in points.
const WIDTH: f32 = 460.0;

/// Importance of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// Confirmation of a small step.
    Plain,
    Info,
    Success,
    Warning,
    Error,
}

impl Level {
    /// Returns the seconds for which the notice stays; `None` if it stays until closed.
    fn stays(self) -> Option<f64> {
        match self {
            Self::Plain => Some(1.5),
            Self::Success => Some(4.0),
            Self::Info | Self::Warning => Some(8.0),
            Self::Error => None,
        }
    }

    fn color(self, visuals: &Visuals) -> Color32 {
        match self {
            Self::Plain | Self::Info => visuals.weak_text_color(),
            Self::Success => Color32::from_rgb(0x5f, 0xb8, 0x72),
            Self::Warning => visuals.warn_fg_color,
            Self::Error => crate::theme::error(visuals),
        }
    }
}

#[derive(Debug)]
struct Notice {
    number: u64,
    level: Level,
    text: String,
    /// Time of disappearance on the context's clock; set when the notice is first drawn.
    until: Option<f64>,
}

/// The visible notices, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Notices {
    all: Vec<Notice>,
    made: u64,
}

impl Notices {
    /// Confirms a small step.
    pub(crate) fn plain(&mut self, text: impl Into<String>) {
        self.tell(Level::Plain, text.into());
    }

    pub(crate) fn info(&mut self, text: impl Into<String>) {
        self.tell(Level::Info, text.into());
    }

    /// Reports a success.
    pub(crate) fn success(&mut self, text: impl Into<String>) {
        self.tell(Level::Success, text.into());
    }

    pub(crate) fn warning(&mut self, text: impl Into<String>) {
        self.tell(Level::Warning, text.into());
    }

    /// Reports a failure; the notice stays until closed.
    pub(crate) fn error(&mut self, why: impl ToString) {
        self.tell(Level::Error, why.to_string());
    }

    fn tell(&mut self, level: Level, text: String) {
        // A repeated text becomes the newest notice and keeps its number, so that it stays on screen.
        let is_this = |known: &Notice| (known.level, &known.text) == (level, &text);
        let number = match self.all.iter().position(is_this) {
            Some(index) => self.all.remove(index).number,
            None => {
                self.made += 1;
                self.made
            }
        };
        self.all.push(Notice { number, level, text, until: None });
    }

    /// Removes notices about the document being left; reports of successes stay.
    pub(crate) fn leave(&mut self) {
        self.all.retain(|notice| notice.level == Level::Success);
    }

    /// Returns the texts, oldest first.
    #[cfg(test)]
    pub(crate) fn texts(&self) -> Vec<&str> {
        self.all.iter().map(|notice| notice.text.as_str()).collect()
    }

    /// Draws the notices above one another. Only their own areas accept clicks.
    pub(crate) fn show(&mut self, context: &Context) {
        let now = context.input(|input| input.time);
        let room = context.content_rect();
        let mut bottom = room.bottom() - MARGIN.y;
        self.all.retain_mut(|notice| {
            if notice.until.is_none() {
                notice.until = notice.level.stays().map(|stays| now + stays);
            }
            let area = Area::new(egui::Id::new(("notice", notice.number))).order(Order::Middle);
            let area = area.pivot(Align2::LEFT_BOTTOM).fixed_pos(pos2(room.left() + MARGIN.x, bottom));
            let shown = area.show(context, |ui| notice_ui(ui, notice, room.width() - 2.0 * MARGIN.x));
            bottom = shown.response.rect.top() - APART;
            if shown.response.contains_pointer() {
                // A notice stays while the pointer is over it.
                notice.until = notice.until.map(|until| until.max(now + 1.0));
            }
            let left = notice.until.map(|until| until - now);
            if let Some(left) = left {
                context.request_repaint_after_secs(left.max(0.0) as f32);
            }
            !shown.inner && left.is_none_or(|left| left > 0.0)
        });
    }
}

/// Draws a notice; returns whether it was closed.
fn notice_ui(ui: &mut egui::Ui, notice: &Notice, room: f32) -> bool {
    let color = notice.level.color(ui.visuals());
    let frame = Frame::popup(ui.style()).stroke(egui::Stroke::new(1.0, color));
    let width = (room - 60.0).clamp(80.0, WIDTH);
    let framed = frame.show(ui, |ui| {
        ui.horizontal_top(|ui| {
            ui.scope(|ui| {
                ui.set_max_width(width);
                let color = if notice.level == Level::Error { color } else { ui.visuals().text_color() };
                ui.add(Label::new(RichText::new(&notice.text).color(color)).wrap());
            });
            let close = ui.small_button("×").on_hover_text("Close this notice");
            close.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "Close notice"));
            close.clicked()
        })
        .inner
    });
    framed.inner
}
