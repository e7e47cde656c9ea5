//! Generates the page of a node type from its declaration.

use serde_json::Value;
use std::fmt::Write as _;
use trochoid::{Declaration, End, Item, Knob, List, Port, counted};

/// Returns the page of a node type. `document` is its example, whose picture is next to the page.
pub(crate) fn node_page(declaration: &Declaration, document: &str) -> String {
    let name = declaration.name;
    let mut page = format!("# {name}\n\n{}\n\n![{name}]({name}.png)\n\n", prose(declaration.summary));
    let _ = writeln!(page, "{}\n", end(declaration.end));
    items(&mut page, declaration.items);
    page.push_str("## Outputs\n\n| name | what it is | what it holds |\n|---|---|---|\n");
    for (index, output) in declaration.outputs.iter().enumerate() {
        let main = if index == 0 { ", the node's name alone" } else { "" };
        let _ = writeln!(page, "| `{}`{main} | {} | {} |", output.name, output.kinds_in_words(), cell(output.help));
    }
    for (heading, body) in
        [("Formula", declaration.formula), ("Edge cases", declaration.edge_cases), ("Source", declaration.source)]
    {
        if !body.is_empty() {
            let _ = write!(page, "\n## {heading}\n\n{}\n", prose(body));
        }
    }
    let _ = write!(
        page,
        "\n## The document of the picture\n\n\
         It is complete: `trochoid render docs/nodes/{name}.json --out {name}.png` makes the picture above.\n\n```json\n{}\n```\n",
        document.trim_end()
    );
    page
}

/// Returns a node type's row in the table of nodes.
pub(crate) fn row(declaration: &Declaration) -> String {
    let name = declaration.name;
    format!(
        "| [<img src=\"nodes/{name}.png\" alt=\"{name}\" width=\"160\">](nodes/{name}.md) | [{name}](nodes/{name}.md) | {} |\n",
        cell(declaration.summary)
    )
}

fn end(end: End) -> &'static str {
    match end {
        End::Front => "*Front end:* any mathematics; makes passes.",
        End::Back => "*Back end:* convex operations only, so no color leaves the palette.",
    }
}

fn items(page: &mut String, items: &[Item]) {
    if items.is_empty() {
        page.push_str("It has no ports and no knobs.\n\n");
        return;
    }
    let ports: Vec<&Port> =
        items.iter().filter_map(|item| if let Item::Port(port) = item { Some(port) } else { None }).collect();
    if !ports.is_empty() {
        page.push_str("## Ports\n\n| name | takes | what it means |\n|---|---|---|\n");
        ports.iter().for_each(|port| port_row(page, port, ""));
        page.push('\n');
    }
    if ports.len() < items.len() {
        page.push_str("## Knobs\n\n| name | takes | default | what it means |\n|---|---|---|---|\n");
        for item in items {
            match item {
                Item::Port(_) => {}
                Item::Knob(knob) => knob_row(page, knob, ""),
                Item::List(list) => list_rows(page, list, ""),
            }
        }
        page.push_str("\nA knob with ◆ beside its default may be keyframed.\n\n");
    }
}

fn port_row(page: &mut String, port: &Port, prefix: &str) {
    let _ = writeln!(page, "| `{prefix}{}` | {} | {} |", port.name, port.takes(), cell(port.help));
}

fn knob_row(page: &mut String, knob: &Knob, prefix: &str) {
    let default = match knob.default_value() {
        _ if knob.default.is_none() => "**required**".into(),
        Value::Null => "unset".into(),
        value => format!("`{value}`"),
    };
    let keyed = if knob.animated { " ◆" } else { "" };
    let takes = cell(&knob.takes_in_words());
    let _ = writeln!(page, "| `{prefix}{}` | {takes} | {default}{keyed} | {} |", knob.name, cell(knob.help));
}

/// Adds a list of records, followed by the items of each record; `prefix` is the name of the enclosing list.
fn list_rows(page: &mut String, list: &List, prefix: &str) {
    let required = if list.min > 0 { "**required**" } else { "none" };
    let name = format!("{prefix}{}", list.name);
    let count = counted(list.min, list.max);
    let _ = writeln!(page, "| `{name}` | a list of {count} records, as below | {required} | {} |", cell(list.help));
    let within = format!("{name}[].");
    for item in list.items {
        match item {
            Item::Port(port) => {
                let default = if port.is_required() { "**required**" } else { "none" };
                let (takes, help) = (port.takes(), cell(port.help));
                let _ = writeln!(page, "| `{within}{}` | {takes} | {default} | {help} |", port.name);
            }
            Item::Knob(knob) => knob_row(page, knob, &within),
            Item::List(list) => list_rows(page, list, &within),
        }
    }
}

/// A declaration's text as Markdown: what stands between backticks stays code, all else is plain text.
fn prose(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (index, part) in text.split('`').enumerate() {
        if index % 2 == 1 {
            let _ = write!(out, "`{part}`");
            continue;
        }
        for c in part.chars() {
            if "\\*_{}[]<>#|~&^$".contains(c) {
                out.push('\\');
            }
            out.push(c);
        }
    }
    out
}

/// Like [`prose`], for a table cell, which a vertical bar would end.
fn cell(text: &str) -> String {
    let prose = prose(text);
    let mut out = String::with_capacity(prose.len());
    let mut last = ' ';
    for c in prose.chars() {
        if c == '|' && last != '\\' {
            out.push('\\');
        }
        out.push(c);
        last = c;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_text_stays_plain() {
        assert_eq!(prose("a*b_c with `size_y` < 1"), r"a\*b\_c with `size_y` \< 1");
        assert_eq!(cell("|n · v| of `a|b`"), r"\|n · v\| of `a\|b`");
    }

    #[test]
    fn pages_have_all_ports_knobs_and_outputs() {
        for ty in trochoid::registry().iter() {
            let declaration = ty.declaration();
            let page = node_page(declaration, "{}");
            for item in declaration.items {
                assert!(page.contains(&format!("\n| `{}` | ", item.name())), "{}: {}", declaration.name, item.name());
                if let Item::List(list) = item {
                    for item in list.items {
                        let row = format!("\n| `{}[].{}` | ", list.name, item.name());
                        assert!(page.contains(&row), "{}: {row}", declaration.name);
                    }
                }
            }
            for output in declaration.outputs {
                assert!(page.contains(&format!("\n| `{}`", output.name)), "{}: {}", declaration.name, output.name);
            }
        }
    }
}
