//! `trochoid nodes`: prints the manual, generated from the node declarations.

use crate::failure::Failure;
use crate::shell::{self, HEADING, wrap};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use trochoid::{
    Accepts, Arity, Declaration, End, Item, Knob, KnobType, Port, Term, counted, expected, nearest, registry,
    smallest_node,
};

/// Options of `trochoid nodes`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  trochoid nodes\n  trochoid nodes Mix\n  trochoid nodes Ramp --json")]
pub(crate) struct Args {
    /// The node type to explain [default: list all types]
    #[arg(value_name = "TYPE")]
    ty: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Lists the node types, or explains one.
///
/// # Errors
/// The type is unknown, or stdout cannot be written.
pub(crate) fn run(args: &Args) -> Result<(), Failure> {
    let all = || registry().iter().map(|ty| ty.declaration());
    let Some(name) = &args.ty else {
        if args.json {
            return shell::print_json(&all().map(describe).collect());
        }
        return shell::print(&list(all()));
    };
    let exact = all().find(|declaration| declaration.name == name);
    match exact.or_else(|| all().find(|declaration| declaration.name.eq_ignore_ascii_case(name))) {
        Some(declaration) if args.json => shell::print_json(&describe(declaration)),
        Some(declaration) => shell::print(&manual(declaration)),
        None => Err(unknown(name)),
    }
}

fn unknown(name: &str) -> Failure {
    if let Some(refusal) = trochoid::refusal(name) {
        let message =
            format!("found the operation {name}, which is not convex: {}; {}", refusal.reason, refusal.witness);
        return Failure::usage(message, refusal.rewrite);
    }
    let remedy = match (Term::of(name, registry()), nearest(name, registry().names())) {
        (Some(term), _) => term.remedy(),
        (None, Some(near)) => format!("did you mean {near}?"),
        (None, None) => "run `trochoid nodes` for a list of the types".into(),
    };
    Failure::usage(format!("found the node type \"{name}\"; expected a known one"), remedy)
}

fn list(all: impl Iterator<Item = &'static Declaration>) -> String {
    let all: Vec<&Declaration> = all.collect();
    let width = all.iter().map(|declaration| declaration.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (end, heading) in [
        (End::Front, "Front end: any mathematics; produces passes"),
        (End::Back, "Back end: convex operations; produces colors and weights"),
    ] {
        let _ = writeln!(text, "{HEADING}{heading}{HEADING:#}");
        for declaration in all.iter().filter(|declaration| declaration.end == end) {
            // Further paragraphs are for the manual.
            let summary = declaration.summary.lines().next().unwrap_or_default();
            let _ = writeln!(text, "  {:width$}  {summary}", declaration.name);
        }
        text.push('\n');
    }
    text.push_str("`trochoid nodes TYPE` prints the manual of a type.\n");
    text
}

fn manual(declaration: &Declaration) -> String {
    let end = end_name(declaration.end);
    let mut text = format!("{HEADING}{}{HEADING:#} ({end} end)\n", declaration.name);
    for (heading, body) in [
        ("What it does", declaration.summary),
        ("Formula", declaration.formula),
        ("Edge cases", declaration.edge_cases),
        ("Source", declaration.source),
    ] {
        if !body.is_empty() {
            let _ = write!(text, "\n{HEADING}{heading}{HEADING:#}\n{}", wrap(body, 2));
        }
    }
    let ports = |item: &&Item| matches!(item, Item::Port(_));
    let groups = [("Ports", true), ("Knobs", false)];
    for (heading, wanted) in groups {
        let items: Vec<&Item> = declaration.items.iter().filter(|item| ports(item) == wanted).collect();
        if !items.is_empty() {
            let _ = writeln!(text, "\n{HEADING}{heading}{HEADING:#}");
            items.iter().for_each(|item| write_item(&mut text, item, 2));
        }
    }
    let _ = writeln!(text, "\n{HEADING}Outputs{HEADING:#}");
    for output in declaration.outputs {
        write_entry(&mut text, output.name, &output.kinds_in_words(), output.help, 2);
    }
    let (example, connected) = example(declaration);
    let _ = writeln!(text, "\n{HEADING}In a document{HEADING:#}\n  \"name\": {}", spaced(&example));
    for (name, accepts) in connected {
        let _ = writeln!(text, "  \"{name}\" stands for the name of a node that makes a {accepts}.");
    }
    text
}

/// Returns the smallest node of a type that is valid, with the names of other nodes in it and what they make.
fn example(declaration: &Declaration) -> (Value, BTreeMap<String, Accepts>) {
    let name = |accepts| match accepts {
        Accepts::Surface => Some("sea"),
        Accepts::Camera => Some("camera"),
        Accepts::Light => Some("light"),
        Accepts::View => Some("view"),
        Accepts::Weights => Some("weights"),
        Accepts::Direction => Some("direction"),
        // These take literals.
        Accepts::Color | Accepts::Image | Accepts::Mask | Accepts::Scalar | Accepts::Field => None,
    };
    let mut node = smallest_node(declaration, &|accepts| Some(json!(name(accepts)?)));
    let own: Value = serde_json::from_str(&format!("{{ {} }}", declaration.example)).unwrap_or_default();
    if let (Some(node), Value::Object(own)) = (node.as_object_mut(), own) {
        node.extend(own);
    }
    let mut connected = BTreeMap::new();
    for item in declaration.items {
        match (item, node.get_mut(item.name())) {
            // A file that the node can read.
            (Item::Knob(Knob { takes: KnobType::Path, .. }), Some(file)) if file == "" => {
                let ending = declaration.reads.and_then(|files| files.endings.first()).copied().unwrap_or("exr");
                *file = json!(format!("file.{ending}"));
            }
            (Item::Port(port), Some(value)) => {
                let values = value.as_array().map_or(std::slice::from_ref(&*value), Vec::as_slice);
                let names = values.iter().filter_map(Value::as_str).filter(|name| !name.starts_with('#'));
                connected.extend(names.map(|name| (name.to_string(), port.accepts)));
            }
            _ => {}
        }
    }
    (node, connected)
}

/// Writes JSON in one line, with spaces as in the book.
fn spaced(value: &Value) -> String {
    match value {
        Value::Array(items) => format!("[{}]", items.iter().map(spaced).collect::<Vec<_>>().join(", ")),
        Value::Object(entries) => {
            let entry = |(key, value): (&String, &Value)| format!("{}: {}", Value::from(key.as_str()), spaced(value));
            format!("{{ {} }}", entries.iter().map(entry).collect::<Vec<_>>().join(", "))
        }
        value => value.to_string(),
    }
}

fn end_name(end: End) -> &'static str {
    match end {
        End::Front => "front",
        End::Back => "back",
    }
}

fn write_entry(text: &mut String, name: &str, what: &str, help: &str, indent: usize) {
    let _ = writeln!(text, "{:indent$}{HEADING}{name}{HEADING:#}: {what}", "");
    text.push_str(&wrap(help, indent + 4));
}

fn write_item(text: &mut String, item: &Item, indent: usize) {
    match item {
        Item::Port(port) => write_entry(text, port.name, &port_text(port), port.help, indent),
        Item::Knob(knob) => write_entry(text, knob.name, &knob_text(knob), knob.help, indent),
        Item::List(list) => {
            let required = if list.min > 0 { "required: " } else { "" };
            let what = format!("{required}{} records, each with", counted(list.min, list.max));
            write_entry(text, list.name, &what, list.help, indent);
            list.items.iter().for_each(|item| write_item(text, item, indent + 4));
        }
    }
}

fn port_text(port: &Port) -> String {
    let required = if matches!(port.arity, Arity::Many { min: 1.., .. }) { "; required" } else { "" };
    format!("{}{required}", port.takes())
}

fn knob_text(knob: &Knob) -> String {
    let default = match knob.default_value() {
        Value::Null if knob.default.is_none() => "required".into(),
        Value::Null => "unset by default".into(),
        value => format!("default {value}"),
    };
    let keyed = if knob.animated { "; may be keyframed" } else { "" };
    format!("{}; {default}{keyed}", knob.takes_in_words())
}

fn describe(declaration: &'static Declaration) -> Value {
    let outputs: Vec<Value> = declaration
        .outputs
        .iter()
        .map(|output| json!({ "name": output.name, "kind": output.kinds_in_words(), "help": output.help }))
        .collect();
    json!({
        "type": declaration.name,
        "end": end_name(declaration.end),
        "what_it_does": declaration.summary,
        "formula": declaration.formula,
        "edge_cases": declaration.edge_cases,
        "source": declaration.source,
        "revision": declaration.revision,
        "items": declaration.items.iter().map(describe_item).collect::<Vec<_>>(),
        "outputs": outputs,
        "example": example(declaration).0,
    })
}

fn describe_item(item: &Item) -> Value {
    match item {
        Item::Port(port) => {
            let (min, max) = match port.arity {
                Arity::One => (1, 1),
                Arity::Optional => (0, 1),
                Arity::Many { min, max } => (min, max),
            };
            let accepts = port.accepts.to_string();
            json!({ "port": port.name, "accepts": accepts, "min": min, "max": max, "help": port.help })
        }
        Item::Knob(knob) => {
            let (min, max) = match knob.takes {
                KnobType::Number { min, max } => (json!(min), json!(max)),
                KnobType::Integer { min, max } => (json!(min), json!(max)),
                _ => (Value::Null, Value::Null),
            };
            json!({
                "knob": knob.name,
                "takes": expected(&knob.takes),
                "unit": knob.unit,
                "required": knob.default.is_none(),
                "default": knob.default_value(),
                "min": min,
                "max": max,
                "keyable": knob.animated,
                "help": knob.help,
            })
        }
        Item::List(list) => {
            let items: Vec<Value> = list.items.iter().map(describe_item).collect();
            json!({
                "list": list.name,
                "required": list.min > 0,
                "min": list.min,
                "max": list.max,
                "items": items,
                "help": list.help,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_has_a_whole_manual() {
        for ty in registry().iter() {
            let declaration = ty.declaration();
            let text = anstream::adapter::strip_str(&manual(declaration)).to_string();
            for heading in ["What it does", "Formula", "Edge cases", "Source", "Outputs"] {
                assert!(text.contains(&format!("\n{heading}\n")), "{}: no {heading}", declaration.name);
            }
            for item in declaration.items {
                assert!(text.contains(&format!("\n  {}: ", item.name())), "{}: {}", declaration.name, item.name());
                if let Item::List(list) = item {
                    let required = text.contains(&format!("\n  {}: required: ", list.name));
                    assert_eq!(required, list.min > 0, "{}: {}", declaration.name, list.name);
                }
            }
        }
    }

    #[test]
    fn every_type_is_one_line_of_the_list() {
        let text = anstream::adapter::strip_str(&list(registry().iter().map(|ty| ty.declaration()))).to_string();
        let listed: Vec<&str> = text.lines().filter(|line| line.starts_with("  ")).collect();
        assert_eq!(listed.len(), registry().iter().count());
        for name in registry().names() {
            let is_own = |line: &&&str| line.split_whitespace().next() == Some(name);
            let line = listed.iter().find(is_own).unwrap_or_else(|| panic!("{name} is not listed"));
            assert!(line.ends_with('.'), "no whole sentence: {line}");
        }
        // Besides them, there are two headings, an empty line after each group, and the hint.
        assert_eq!(text.lines().count(), listed.len() + 5, "{text}");
    }

    /// Nodes with the names that examples use.
    const AROUND: &str = r#"
        "camera": { "type": "Camera" }, "light": { "type": "Light", "direction": [0, 1, 0] },
        "sea": { "type": "GerstnerSea" }, "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "weights": { "type": "Bands", "field": 0.5, "thresholds": [0.2, 0.4] },
        "direction": { "type": "FlowField", "view": "view" }, "uv": { "type": "UV", "view": "view" },
        "boat": { "type": "Mesh", "file": "boat.obj" },
        "shore": { "type": "Render", "camera": "camera", "surfaces": ["boat"] }"#;

    #[test]
    fn the_example_of_every_type_is_a_valid_node() {
        let mut faults = Vec::new();
        for ty in registry().iter() {
            let declaration = ty.declaration();
            let (node, connected) = example(declaration);
            let text = spaced(&node);
            assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), node);
            for name in connected.keys() {
                assert!(AROUND.contains(&format!("\"{name}\": {{")), "{}: {name}", declaration.name);
            }
            let document = format!(
                r##"{{ "trochoid": 1, "format": {{ "width": 8, "height": 8 }}, "nodes": {{ {AROUND}, "name": {text} }},
                "outputs": {{ "depth": {{ "field": "direction" }} }} }}"##
            );
            if let Err(error) = trochoid::parse("example.json", &document, std::path::Path::new("."), &[]) {
                faults.push(format!("{}: {text}\n{error}", declaration.name));
            }
        }
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }
}
