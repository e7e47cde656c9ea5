//! The help: a page for each node type, the chapters of the manual, and the keys. What is shown is the text of the
//! declarations and of the book; nothing is written here again.

mod draw;
mod markdown;
mod pages;

use crate::actions::{Action, HelpPage};
use crate::choice::fuzzy;
use crate::state::State;
use draw::{Target, blocks_ui};
use egui::{Button, Label, OpenUrl, RichText, ScrollArea, TextEdit, Ui, WidgetInfo, WidgetType};
use markdown::Block;
use trochoid::{Declaration, registry};

/// State of the panel that no other panel shares.
pub(crate) struct Help {
    page: HelpPage,
    before: Vec<HelpPage>,
    after: Vec<HelpPage>,
    /// The blocks of the page, as soon as it was drawn.
    blocks: Option<Vec<Block>>,
    /// Heading to scroll to.
    heading: Option<String>,
    /// Whether the page was just turned.
    is_new: bool,
    text: String,
    found: Vec<Found>,
}

/// A page that has what is sought.
struct Found {
    page: HelpPage,
    /// The line in which it stands; empty if the title has it.
    line: String,
}

impl Default for Help {
    fn default() -> Self {
        Self {
            page: HelpPage::Contents,
            before: Vec::new(),
            after: Vec::new(),
            blocks: None,
            heading: None,
            is_new: true,
            text: String::new(),
            found: Vec::new(),
        }
    }
}

impl Help {
    /// Turns to a page.
    pub(crate) fn turn(&mut self, page: HelpPage, heading: Option<String>) {
        if page != self.page {
            self.before.push(std::mem::replace(&mut self.page, page));
            self.after.clear();
        }
        self.show(heading);
    }

    fn show(&mut self, heading: Option<String>) {
        (self.blocks, self.heading, self.is_new) = (None, heading, true);
        (self.text, self.found) = (String::new(), Vec::new());
    }

    fn go_back(&mut self) {
        if let Some(page) = self.before.pop() {
            self.after.push(std::mem::replace(&mut self.page, page));
            self.show(None);
        }
    }

    fn go_ahead(&mut self) {
        if let Some(page) = self.after.pop() {
            self.before.push(std::mem::replace(&mut self.page, page));
            self.show(None);
        }
    }
}

/// Returns the declaration of a node type or of a group of the document.
fn declaration(state: &State, name: &str) -> Option<&'static Declaration> {
    let known = registry().get(name).map(|ty| ty.declaration());
    let known = known.or_else(|| state.sheet().library.face(name));
    known.or_else(|| crate::shipped::offered(state.sheet()).find(|offered| offered.name == name))
}

/// Draws the panel.
pub(crate) fn help_ui(help: &mut Help, ui: &mut Ui, state: &State, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        let named = |ui: &mut Ui, text: &str, name: &str, on: bool| {
            let button = ui.add_enabled(on, Button::new(text)).on_hover_text(name);
            button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, on, name));
            button.clicked()
        };
        if named(ui, "◀", "Back", !help.before.is_empty()) {
            help.go_back();
        }
        if named(ui, "▶", "Forward", !help.after.is_empty()) {
            help.go_ahead();
        }
        if ui.button("Contents").clicked() {
            help.turn(HelpPage::Contents, None);
        }
        if ui.button("Keys").clicked() {
            help.turn(HelpPage::Keys, None);
        }
        let width = (ui.available_size_before_wrap().x - 4.0).max(80.0);
        let field = ui.add(TextEdit::singleline(&mut help.text).hint_text("Search the help …").desired_width(width));
        field.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Search the help"));
        if field.changed() {
            help.found = found(&help.text, ui.ctx());
        }
    });
    ui.separator();
    if !help.text.trim().is_empty() {
        return found_ui(help, ui);
    }
    if let HelpPage::Node(name) = &help.page
        && let Some(known) = declaration(state, name)
    {
        ui.horizontal_wrapped(|ui| {
            let add = ui.button("Add").on_hover_text("Add a node of this type, connected to the selected one");
            if add.clicked() {
                actions.push(Action::AddType(known.name.into()));
            }
        });
    }
    let mut area = ScrollArea::vertical().id_salt("help page").auto_shrink(false);
    if std::mem::take(&mut help.is_new) {
        area = area.vertical_scroll_offset(0.0);
    }
    area.show(ui, |ui| page_ui(help, ui, state));
}

fn page_ui(help: &mut Help, ui: &mut Ui, state: &State) {
    if help.page == HelpPage::Contents {
        return contents_ui(help, ui);
    }
    let blocks = help.blocks.take().unwrap_or_else(|| {
        let text = match &help.page {
            HelpPage::Contents => String::new(),
            HelpPage::Keys => pages::keys(ui.ctx()),
            HelpPage::Chapter(name) => pages::chapter(name).unwrap_or("This chapter does not exist.").into(),
            HelpPage::Node(name) => match declaration(state, name) {
                Some(known) => pages::node(known),
                None => format!("# {name}\n\nNo node type and no group of this document has this name.\n"),
            },
        };
        markdown::read(&text)
    });
    let sought = help.heading.take();
    let clicked = blocks_ui(ui, &blocks, sought.as_deref());
    help.blocks = Some(blocks);
    match clicked {
        Some(Target::Page(page, heading)) => help.turn(page, heading),
        Some(Target::Heading(heading)) => help.heading = Some(heading),
        Some(Target::Web(address)) => ui.ctx().open_url(OpenUrl::new_tab(address)),
        Some(Target::Nowhere) | None => {}
    }
}

/// Draws the list of all pages.
fn contents_ui(help: &mut Help, ui: &mut Ui) {
    let mut turned = None;
    let mut link = |ui: &mut Ui, page: HelpPage| {
        if ui.link(pages::title(&page)).clicked() {
            turned = Some(page);
        }
    };
    ui.label(RichText::new("Manual").strong());
    let (nodes, others): (Vec<HelpPage>, Vec<HelpPage>) =
        pages::all().partition(|page| matches!(page, HelpPage::Node(_)));
    others.into_iter().for_each(|page| link(ui, page));
    ui.add_space(8.0);
    ui.label(RichText::new("Nodes").strong());
    for page in nodes {
        let HelpPage::Node(name) = &page else { continue };
        let summary = registry().get(name).map_or("", |ty| ty.declaration().summary).replace('`', "");
        ui.horizontal(|ui| {
            link(ui, page.clone());
            ui.add(Label::new(RichText::new(summary).weak()).truncate());
        });
    }
    if let Some(page) = turned {
        help.turn(page, None);
    }
}

fn found_ui(help: &mut Help, ui: &mut Ui) {
    let mut turned = None;
    ui.weak(match help.found.len() {
        0 => "No page has all of these words.".into(),
        count => crate::document::edit::count(count, "page"),
    });
    ScrollArea::vertical().id_salt("help found").auto_shrink(false).show(ui, |ui| {
        for found in &help.found {
            if ui.link(pages::title(&found.page)).clicked() {
                turned = Some(found.page.clone());
            }
            if !found.line.is_empty() {
                ui.add(Label::new(RichText::new(&found.line).weak().small()).truncate());
            }
        }
    });
    if let Some(page) = turned {
        help.turn(page, None);
    }
}

/// Finds the pages with all words of a text: those whose titles match first.
fn found(text: &str, context: &egui::Context) -> Vec<Found> {
    let words: Vec<String> = text.to_lowercase().split_whitespace().map(String::from).collect();
    if words.is_empty() {
        return Vec::new();
    }
    let (mut titles, mut texts) = (Vec::new(), Vec::new());
    for page in pages::all() {
        if let Some(cost) = fuzzy(text, &pages::title(&page)).filter(|cost| *cost < 4 * text.len() + 40) {
            titles.push((cost, Found { page, line: String::new() }));
            continue;
        }
        let whole = match &page {
            HelpPage::Contents => continue,
            HelpPage::Keys => pages::keys(context),
            HelpPage::Chapter(name) => pages::chapter(name).unwrap_or_default().into(),
            HelpPage::Node(name) => registry().get(name).map(|ty| pages::node(ty.declaration())).unwrap_or_default(),
        };
        let lower = whole.to_lowercase();
        if words.iter().all(|word| lower.contains(word)) {
            let line = whole.lines().find(|line| line.to_lowercase().contains(&words[0])).unwrap_or_default();
            let line = line.replace(['\\', '`', '*', '|', '#'], "").trim().trim_start_matches("- ").to_string();
            texts.push(Found { page, line });
        }
    }
    titles.sort_by_key(|(cost, _)| *cost);
    titles.into_iter().map(|(_, found)| found).chain(texts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::FontFamily;

    /// Returns all words of spans, items and code.
    fn words(blocks: &[Block]) -> String {
        let rows = |rows: &[Vec<Vec<markdown::Span>>]| {
            rows.iter().flatten().map(|cell| markdown::plain(cell)).collect::<Vec<String>>().join(" ")
        };
        let text = |block: &Block| match block {
            Block::Heading(_, spans) | Block::Text(spans) | Block::Item(_, _, spans) => markdown::plain(spans),
            Block::Code(text) => text.clone(),
            Block::Table(table) => rows(table),
            Block::Rule => String::new(),
        };
        blocks.iter().map(text).collect::<Vec<String>>().join("\n")
    }

    fn texts() -> impl Iterator<Item = (String, String)> {
        let context = egui::Context::default();
        pages::all().map(move |page| {
            let text = match &page {
                HelpPage::Node(name) => pages::node(registry().get(name).unwrap().declaration()),
                HelpPage::Chapter(name) => pages::chapter(name).unwrap().into(),
                _ => pages::keys(&context),
            };
            (pages::title(&page), text)
        })
    }

    #[test]
    fn every_letter_of_the_pages_can_be_drawn() {
        let context = egui::Context::default();
        crate::fonts::install(&context);
        context.run_ui(egui::RawInput::default(), |_| {}).textures_delta.clear();
        let mut missing = std::collections::BTreeMap::new();
        for family in [FontFamily::Proportional, FontFamily::Monospace] {
            let known: std::collections::BTreeSet<char> =
                context.fonts_mut(|fonts| fonts.fonts.font(&family).characters().keys().copied().collect());
            for (title, text) in texts() {
                let words = words(&markdown::read(&text));
                let unknown = words.chars().filter(|c| !c.is_whitespace() && !known.contains(c));
                missing.extend(unknown.map(|c| ((c, format!("{family:?}")), title.clone())));
            }
        }
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn nothing_of_a_declaration_is_lost_or_read_as_markup() {
        for ty in registry().iter() {
            let known = ty.declaration();
            let words = words(&markdown::read(&pages::node(known)));
            for text in [known.summary, known.formula, known.edge_cases, known.source] {
                let bare = |text: &str| text.replace('`', "").split_whitespace().collect::<String>();
                assert!(bare(&words).contains(&bare(text)), "{}: {text}", known.name);
            }
            for item in known.items {
                assert!(words.contains(&format!("{}: ", item.name())), "{}: {}", known.name, item.name());
            }
        }
    }

    #[test]
    fn every_chapter_of_the_book_is_a_page() {
        let summary = include_str!("../../manual/SUMMARY.md");
        let named = summary.split("](").skip(1).filter_map(|rest| rest.split_once(".md)")).map(|(name, _)| name);
        let missing: Vec<&str> = named.filter(|name| *name != "nodes" && pages::chapter(name).is_none()).collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn links_of_chapters_lead_to_headings_that_exist() {
        for (name, text) in pages::CHAPTERS {
            for block in markdown::read(text) {
                let (Block::Text(spans) | Block::Item(_, _, spans)) = block else { continue };
                for link in spans.iter().filter_map(|span| span.link.as_deref()) {
                    let (chapter, heading) = match draw::target(link) {
                        Target::Page(HelpPage::Chapter(other), Some(heading)) => (other, heading),
                        Target::Heading(heading) => ((*name).to_string(), heading),
                        Target::Nowhere => {
                            assert!(link.starts_with("../"), "{name}: {link} leads nowhere");
                            continue;
                        }
                        _ => continue,
                    };
                    let blocks = markdown::read(pages::chapter(&chapter).unwrap());
                    let is_it = |block: &Block| matches!(block, Block::Heading(_, spans) if markdown::anchor(&markdown::plain(spans)) == heading);
                    assert!(blocks.iter().any(is_it), "{name}: {link}");
                }
            }
        }
    }
}
