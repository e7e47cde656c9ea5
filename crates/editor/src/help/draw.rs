//! Draws the blocks of a page.

use super::markdown::{Block, Span, anchor, plain};
use crate::actions::HelpPage;
use crate::prose::MONOSPACE;
use egui::text::{LayoutJob, TextFormat};
use egui::{
    Align, Color32, FontFamily, FontId, Frame, Label, Layout, RichText, ScrollArea, TextStyle, Ui, Visuals, vec2,
};
use trochoid::registry;

/// Where a link leads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// A page, and a heading there.
    Page(HelpPage, Option<String>),
    /// A heading of this page.
    Heading(String),
    Web(String),
    /// A file of the repository, which is not part of the help.
    Nowhere,
}

/// Returns where a link leads.
pub(super) fn target(link: &str) -> Target {
    let (path, heading) =
        link.split_once('#').map_or((link, None), |(path, heading)| (path, Some(heading.to_string())));
    if link.contains("://") {
        return Target::Web(link.into());
    }
    let page = path.strip_suffix(".md").and_then(|name| match name.strip_prefix("nodes/") {
        Some(node) if registry().get(node).is_some() => Some(HelpPage::Node(node.into())),
        Some(_) => None,
        None if name == "nodes" => Some(HelpPage::Contents),
        None => super::pages::chapter(name).map(|_| HelpPage::Chapter(name.into())),
    });
    match (page, heading) {
        (Some(page), heading) => Target::Page(page, heading),
        (None, Some(heading)) if path.is_empty() => Target::Heading(heading),
        _ => Target::Nowhere,
    }
}

/// Returns where a span leads: code that is the name of a node leads to its page.
fn target_of(span: &Span) -> Target {
    match &span.link {
        Some(link) => target(link),
        None if span.code && registry().get(&span.text).is_some() => {
            Target::Page(HelpPage::Node(span.text.clone()), None)
        }
        None => Target::Nowhere,
    }
}

/// Draws blocks; returns the link that was clicked. The heading with the name `sought` is scrolled to.
pub(super) fn blocks_ui(ui: &mut Ui, blocks: &[Block], sought: Option<&str>) -> Option<Target> {
    let mut clicked = None;
    for (index, block) in blocks.iter().enumerate() {
        match block {
            Block::Heading(level, spans) => {
                ui.add_space(if *level == 1 { 2.0 } else { 10.0 });
                let size = TextStyle::Body.resolve(ui.style()).size * [1.55, 1.25, 1.1][(*level - 1).min(2)];
                let text = plain(spans);
                let label = ui.label(RichText::new(&text).size(size).strong());
                if sought == Some(anchor(&text).as_str()) {
                    label.scroll_to_me(Some(Align::Min));
                }
                ui.add_space(2.0);
            }
            Block::Text(spans) => {
                clicked = spans_ui(ui, spans).or(clicked);
                ui.add_space(4.0);
            }
            Block::Item(depth, mark, spans) => {
                ui.horizontal_top(|ui| {
                    ui.add_space(6.0 + 14.0 * *depth as f32);
                    let (_, place) = ui.allocate_space(vec2(16.0, ui.spacing().interact_size.y.min(16.0)));
                    let font = TextStyle::Body.resolve(ui.style());
                    let color = ui.visuals().weak_text_color();
                    ui.painter().text(place.left_top(), egui::Align2::LEFT_TOP, mark, font, color);
                    ui.allocate_ui_with_layout(vec2(ui.available_width(), 0.0), Layout::top_down(Align::Min), |ui| {
                        clicked = spans_ui(ui, spans).or(clicked.take());
                    });
                });
            }
            Block::Code(text) => code_ui(ui, index, text),
            Block::Table(rows) => clicked = table_ui(ui, rows).or(clicked),
            Block::Rule => drop(ui.separator()),
        }
    }
    clicked
}

/// Draws a text with its links; returns the one that was clicked.
fn spans_ui(ui: &mut Ui, spans: &[Span]) -> Option<Target> {
    let is_plain = |span: &Span| target_of(span) == Target::Nowhere;
    let mut clicked = None;
    if spans.iter().all(is_plain) {
        let mut job = LayoutJob::default();
        spans.iter().for_each(|span| append(ui, &mut job, span, None));
        ui.add(Label::new(job).wrap());
        return None;
    }
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        for span in spans {
            let mut job = LayoutJob::default();
            let target = target_of(span);
            if target == Target::Nowhere {
                append(ui, &mut job, span, None);
                ui.add(Label::new(job).wrap());
                continue;
            }
            append(ui, &mut job, span, Some(ui.visuals().hyperlink_color));
            if ui.link(job).clicked() {
                clicked = Some(target);
            }
        }
    });
    clicked
}

fn append(ui: &Ui, job: &mut LayoutJob, span: &Span, color: Option<Color32>) {
    let font = TextStyle::Body.resolve(ui.style());
    let visuals = ui.visuals();
    let color = color.unwrap_or(if span.strong { visuals.strong_text_color() } else { visuals.text_color() });
    let (family, size) = match span.code {
        true => (FontFamily::Monospace, MONOSPACE * font.size),
        false => (font.family, font.size),
    };
    let format = TextFormat { italics: span.emphasis, ..TextFormat::simple(FontId::new(size, family), color) };
    job.append(&span.text, 0.0, format);
}

/// Draws code, which can be selected and copied.
fn code_ui(ui: &mut Ui, index: usize, text: &str) {
    Frame::new().fill(fill(ui.visuals())).corner_radius(4).inner_margin(6).show(ui, |ui| {
        ui.set_width(ui.available_width());
        ScrollArea::horizontal().id_salt(("code", index)).show(ui, |ui| {
            let text = RichText::new(text).monospace();
            ui.add(Label::new(text).extend().selectable(true));
        });
    });
    ui.add_space(6.0);
}

fn fill(visuals: &Visuals) -> Color32 {
    visuals.extreme_bg_color
}

/// Draws a table whose cells wrap; returns the link that was clicked.
fn table_ui(ui: &mut Ui, rows: &[Vec<Vec<Span>>]) -> Option<Target> {
    const GAP: f32 = 10.0;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    if columns == 0 {
        return None;
    }
    let room = ui.available_width() - GAP * (columns - 1) as f32 - 8.0;
    let widths = widths(rows, columns, room, TextStyle::Body.resolve(ui.style()).size * 0.52);
    let mut clicked = None;
    for (index, row) in rows.iter().enumerate() {
        let color = if index % 2 == 1 { ui.visuals().faint_bg_color } else { Color32::TRANSPARENT };
        Frame::new().fill(color).inner_margin(egui::Margin::symmetric(4, 2)).show(ui, |ui| {
            ui.horizontal_top(|ui| {
                ui.spacing_mut().item_spacing.x = GAP;
                for (cell, width) in row.iter().zip(&widths) {
                    ui.allocate_ui_with_layout(vec2(*width, 0.0), Layout::top_down(Align::Min), |ui| {
                        ui.set_width(*width);
                        let strong: Vec<Span>;
                        let cell = if index == 0 {
                            strong = cell.iter().map(|span| Span { strong: true, ..span.clone() }).collect();
                            &strong
                        } else {
                            cell
                        };
                        clicked = spans_ui(ui, cell).or(clicked.take());
                    });
                }
            });
        });
    }
    ui.add_space(6.0);
    clicked
}

/// Returns the widths of columns: as wide as their texts if there is room, otherwise in proportion, short ones first.
fn widths(rows: &[Vec<Vec<Span>>], columns: usize, room: f32, letter: f32) -> Vec<f32> {
    let longest = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| plain(cell).chars().count()).max().unwrap_or(0) as f32
    };
    let wanted: Vec<f32> = (0..columns).map(|column| letter * longest(column) + 6.0).collect();
    let mut order: Vec<usize> = (0..columns).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let (mut widths, mut left) = (vec![0.0; columns], room.max(40.0 * columns as f32));
    for (done, column) in order.into_iter().enumerate() {
        widths[column] = wanted[column].min(left / (columns - done) as f32);
        left -= widths[column];
    }
    widths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lead_to_pages_headings_and_the_web() {
        let heading = |text: &str| Some(text.to_string());
        assert_eq!(
            target("documents.md#groups"),
            Target::Page(HelpPage::Chapter("documents".into()), heading("groups"))
        );
        assert_eq!(target("nodes.md"), Target::Page(HelpPage::Contents, None));
        assert_eq!(target("#keys"), Target::Heading("keys".into()));
        assert_eq!(target("https://ffmpeg.org"), Target::Web("https://ffmpeg.org".into()));
        assert_eq!(target("../../graphs/README.md"), Target::Nowhere);
        let node = trochoid::registry().names().next().unwrap();
        assert_eq!(target(&format!("nodes/{node}.md")), Target::Page(HelpPage::Node(node.into()), None));
    }

    #[test]
    fn short_columns_keep_their_width() {
        let cell = |count: usize| vec![Span { text: "x".repeat(count), ..Span::default() }];
        let rows = [vec![cell(4), cell(200), cell(100)]];
        assert_eq!(widths(&rows, 3, 430.0, 6.0), [30.0, 200.0, 200.0]);
        assert_eq!(widths(&rows, 3, 5000.0, 6.0), [30.0, 1206.0, 606.0]);
    }
}
