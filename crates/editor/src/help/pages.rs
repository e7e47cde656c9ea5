//! The texts of all pages: nodes from their declarations, chapters of the manual, and the keys.

use crate::actions::HelpPage;
use crate::commands::{MENUS, commands};
use egui::Context;
use serde_json::Value;
use std::fmt::Write as _;
use trochoid::{Declaration, End, Item, Knob, List, counted, registry};

macro_rules! chapters {
    ($($name:literal)*) => {
        /// The chapters of the manual by the names of their files, with their texts.
        pub(super) const CHAPTERS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../manual/", $name, ".md"))),)*];
    };
}

chapters! {
    "index" "getting-started" "documents" "editor" "commands" "certificates" "files" "farm" "embedding" "blender"
    "palette" "colored-light" "night" "repainting" "upscaled-passes" "thin-lines" "section" "toon-foam" "definitions"
    "scenes" "internals"
}

/// Chapter that explains the editor, and its heading above the keys.
const EDITOR: &str = "editor";
const KEYS: &str = "## Keys\n";

/// Returns all pages, in the order of the contents.
pub(super) fn all() -> impl Iterator<Item = HelpPage> {
    let chapters = CHAPTERS.iter().map(|(name, _)| HelpPage::Chapter((*name).into()));
    let nodes = registry().names().map(|name| HelpPage::Node(name.into()));
    std::iter::once(HelpPage::Keys).chain(chapters).chain(nodes)
}

/// Returns the text of a chapter.
pub(super) fn chapter(name: &str) -> Option<&'static str> {
    CHAPTERS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// Returns the title of a page.
pub(super) fn title(page: &HelpPage) -> String {
    match page {
        HelpPage::Contents => "Contents".into(),
        HelpPage::Keys => "Keys and commands".into(),
        HelpPage::Node(name) => name.clone(),
        HelpPage::Chapter(name) => {
            let heading = chapter(name).and_then(|text| text.lines().next()?.strip_prefix("# "));
            heading.unwrap_or(name).into()
        }
    }
}

/// Returns the page that explains the keys, with all commands.
pub(super) fn keys(context: &Context) -> String {
    let own = chapter(EDITOR).and_then(|text| text.split_once(KEYS)).map_or("", |(_, rest)| rest);
    let own = own.split("\n## ").next().unwrap_or_default();
    let mut text = format!("# Keys and commands\n\n{}\n", own.trim());
    for menu in MENUS {
        let _ = writeln!(text, "\n## {menu}\n\n| command | keys | what it does |\n|---|---|---|");
        for command in commands().filter(|command| command.menu == menu) {
            let keys = escaped(&command.written_keys(context));
            let _ = writeln!(text, "| {} | {keys} | {} |", command.name, prose(&command.whole_help()));
        }
    }
    text
}

/// Returns the page of a node type, as `trochoid nodes` prints it.
pub(super) fn node(declaration: &Declaration) -> String {
    let mut text = format!("# {}\n\n{}\n\n", declaration.name, prose(declaration.summary));
    text.push_str(match declaration.end {
        End::Front => "*Front end:* any mathematics; makes passes.\n",
        End::Back => "*Back end:* convex operations only, so no color leaves the palette.\n",
    });
    for (heading, body) in
        [("Formula", declaration.formula), ("Edge cases", declaration.edge_cases), ("Source", declaration.source)]
    {
        if !body.is_empty() {
            let _ = write!(text, "\n## {heading}\n\n{}\n", prose(body));
        }
    }
    let is_port = |item: &&Item| matches!(item, Item::Port(_));
    for (heading, ports) in [("Ports", true), ("Knobs", false)] {
        let items: Vec<&Item> = declaration.items.iter().filter(|item| is_port(item) == ports).collect();
        if !items.is_empty() {
            let _ = write!(text, "\n## {heading}\n\n");
            items.iter().for_each(|item| write_item(&mut text, item, 0));
        }
    }
    text.push_str("\n## Outputs\n\n");
    for output in declaration.outputs {
        write_entry(&mut text, output.name, &output.kind.to_string(), output.help, 0);
    }
    let aliases: Vec<&str> = declaration.aliases.iter().map(|alias| alias.word).collect();
    if !aliases.is_empty() {
        let _ = write!(text, "\n## In other programs\n\n{}\n", prose(&aliases.join(", ")));
    }
    text
}

fn write_entry(text: &mut String, name: &str, what: &str, help: &str, depth: usize) {
    let _ = writeln!(text, "{:depth$}- **{}**: {}  \n{:depth$}  {}", "", prose(name), prose(what), "", prose(help));
}

fn write_item(text: &mut String, item: &Item, depth: usize) {
    match item {
        Item::Port(port) => {
            let required = if port.is_required() { "; required" } else { "" };
            write_entry(text, port.name, &format!("{}{required}", port.takes()), port.help, depth);
        }
        Item::Knob(knob) => write_entry(text, knob.name, &knob_text(knob), knob.help, depth),
        Item::List(list) => write_list(text, list, depth),
    }
}

fn write_list(text: &mut String, list: &List, depth: usize) {
    let required = if list.min > 0 { "required: " } else { "" };
    let what = format!("{required}{} records, each with", counted(list.min, list.max));
    write_entry(text, list.name, &what, list.help, depth);
    list.items.iter().for_each(|item| write_item(text, item, depth + 2));
}

fn knob_text(knob: &Knob) -> String {
    let default = match knob.default_value() {
        Value::Null if knob.default.is_none() => "required".into(),
        Value::Null => "unset by default".into(),
        value => format!("default {value}"),
    };
    let keyed = if knob.animated { "; may be keyed" } else { "" };
    format!("{}; {default}{keyed}", knob.takes_in_words())
}

/// Returns a text of a declaration as Markdown: only its backticks mean something.
fn prose(text: &str) -> String {
    let part = |(index, part): (usize, &str)| if index % 2 == 1 { format!("`{part}`") } else { escaped(part) };
    text.split('`').enumerate().map(part).collect()
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_ascii_punctuation() {
            out.push('\\');
        }
        out.push(c);
    }
    out
}
