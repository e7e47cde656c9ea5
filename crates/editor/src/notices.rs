//! Notices over the graph: what was done, and what could not be. Each can be closed; only errors wait for that.

use egui::{
    Align2, Area, Color32, Context, Frame, Label, Order, RichText, Visuals, WidgetInfo, WidgetType, pos2, vec2,
};

/// Notices come where they cover neither tabs nor the title: over the graph, off the timeline and the status below it.
const MARGIN: egui::Vec2 = vec2(8.0, 66.0);
/// From one to the next, points.
const APART: f32 = 6.0;
/// Greatest width of a text, points.
const WIDTH: f32 = 460.0;

/// What a notice says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// A small thing was done.
    Plain,
    Info,
    Success,
    Warning,
    Error,
}

impl Level {
    /// Seconds that it stays; `None` until it is closed.
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
    /// When it goes, by the context's clock; from its first frame on.
    until: Option<f64>,
}

/// All that are to be seen, the oldest first.
#[derive(Debug, Default)]
pub(crate) struct Notices {
    all: Vec<Notice>,
    made: u64,
}

impl Notices {
    /// Says that a small thing was done.
    pub(crate) fn plain(&mut self, text: impl Into<String>) {
        self.tell(Level::Plain, text.into());
    }

    pub(crate) fn info(&mut self, text: impl Into<String>) {
        self.tell(Level::Info, text.into());
    }

    /// Says that it worked.
    pub(crate) fn success(&mut self, text: impl Into<String>) {
        self.tell(Level::Success, text.into());
    }

    pub(crate) fn warning(&mut self, text: impl Into<String>) {
        self.tell(Level::Warning, text.into());
    }

    /// Says that it did not, until that is closed.
    pub(crate) fn error(&mut self, why: impl ToString) {
        self.tell(Level::Error, why.to_string());
    }

    fn tell(&mut self, level: Level, text: String) {
        // Said once more, it is the newest, and stays in sight.
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

    /// Forgets what was said of a document that is left; that something worked is true all the same.
    pub(crate) fn leave(&mut self) {
        self.all.retain(|notice| notice.level == Level::Success);
    }

    /// What is said, the oldest first.
    #[cfg(test)]
    pub(crate) fn texts(&self) -> Vec<&str> {
        self.all.iter().map(|notice| notice.text.as_str()).collect()
    }

    /// Shows them one above another. Nothing but their own ground takes clicks.
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
                // While it is being read, it stays.
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

/// Draws a notice; whether it is closed.
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
            let close = ui.small_button("×").on_hover_text("Closes this notice.");
            close.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "Close notice"));
            close.clicked()
        })
        .inner
    });
    framed.inner
}
