//! Documents before validation: parsed JSON, in which every value has its place.

use crate::spanned::{Entry, Json, LineIndex, Spanned, line_and_column, parse, shorten};
use crate::{Diagnostic, Means, Severity};
use std::sync::OnceLock;

/// Largest size of a document, in bytes.
pub const MAX_BYTES: usize = 64 << 20;
/// Largest number of nodes in a document.
pub const MAX_NODES: usize = 100_000;

/// A parsed document.
#[derive(Clone, Debug)]
pub struct Document {
    name: String,
    text: String,
    /// Made when the place of the first fault is needed.
    lines: OnceLock<LineIndex>,
    pub(crate) root: Spanned,
    /// Assignments, in order; their values have offsets from [`OVERRIDE`] on.
    overrides: Vec<String>,
}

/// First offset that means an override: offset − `OVERRIDE` is its index.
const OVERRIDE: usize = usize::MAX / 2;

impl Document {
    /// Parses a JSON text; diagnostics call it `name`.
    ///
    /// # Errors
    /// The text is not JSON, or exceeds the limits of size or depth.
    pub fn parse(name: &str, text: &str) -> Result<Self, Box<Diagnostic>> {
        let fault = |line, column, found: String, expected: String, remedy: &str| {
            Box::new(Diagnostic {
                severity: Severity::Error,
                file: name.into(),
                is_assigned: false,
                line,
                column,
                node: None,
                port: None,
                found,
                expected,
                remedy: remedy.into(),
                means: None,
            })
        };
        if text.len() > MAX_BYTES {
            let found = format!("a document of {} bytes", text.len());
            return Err(fault(
                0,
                0,
                found,
                format!("at most {MAX_BYTES} bytes"),
                "split the scene into several documents",
            ));
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let root = parse(text).map_err(|error| {
            let (line, column) = line_and_column(text, error.offset);
            if text.trim().is_empty() {
                let found = if text.is_empty() { "an empty file" } else { "only white space" };
                return fault(line, column, found.into(), "JSON".into(), "write a document, or name another file");
            }
            let near: String = text[floor(text, error.offset)..].chars().take(20).collect();
            let remedy = if near.starts_with("NaN") || near.starts_with("Inf") || near.starts_with("-Inf") {
                "JSON has no NaN and no infinity: write a finite number"
            } else if near.is_empty() || error.fault.is_end() {
                "the text ends too early: close every bracket and quote"
            } else if error.fault.is_excess() {
                "no document needs that (lists and objects are a few levels deep): check what wrote it"
            } else {
                "correct the syntax there; JSON has no comments and no trailing commas"
            };
            fault(line, column, error.fault.to_string(), "JSON".into(), remedy)
        })?;
        Ok(Self { name: name.into(), text: text.into(), lines: OnceLock::new(), root, overrides: Vec::new() })
    }

    /// Returns the name of the document.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Sets a knob or port of a node by an assignment `NODE.KNOB=VALUE`; `VALUE` is JSON, or a bare word that stands for a
    /// string.
    ///
    /// # Errors
    /// The assignment has another form, or does not name a node of the document.
    pub fn set(&mut self, assignment: &str) -> Result<(), Box<Diagnostic>> {
        let mut fault = Diagnostic {
            severity: Severity::Error,
            file: shorten(assignment),
            is_assigned: true,
            line: 0,
            column: 0,
            node: None,
            port: None,
            found: format!("\"{}\"", shorten(assignment)),
            expected: "NODE.KNOB=VALUE, for example storm.height=3".into(),
            remedy: "write a node of the document, a dot, one of its knobs, =, and a JSON value".into(),
            means: None,
        };
        let Some(((node, knob), value)) =
            assignment.split_once('=').and_then(|(path, value)| Some((path.split_once('.')?, value)))
        else {
            return Err(Box::new(fault));
        };
        if let Some((list, _)) = knob.split_once('.') {
            fault.node = Some(shorten(node));
            fault.found = format!("\"{}\", a path into \"{}\"", shorten(knob), shorten(list));
            fault.expected = "a knob of the node itself".into();
            // For example "stops[1]" of "stops[1].color".
            let list = list.split('[').next().unwrap_or(list);
            let (list, example) = (shorten(list), format!("{node}.{list}=[{{ … }}]"));
            fault.remedy = format!("set all of \"{list}\", for example {example}");
            fault.means = Some(Means::SetList { list, example });
            return Err(Box::new(fault));
        }
        let mut value = match parse(value) {
            Ok(value) => value,
            // A bare word or color. A text that looks like JSON must be JSON.
            Err(_) if !value.is_empty() && !value.starts_with(['{', '[', '"', '-']) => {
                Spanned { offset: 0, json: Json::String(value.into()) }
            }
            Err(error) => {
                fault.found = error.fault.to_string();
                return Err(Box::new(fault));
            }
        };
        let place = OVERRIDE + self.overrides.len();
        relocate(&mut value, place);
        let at_top = matches!(&self.root.json, Json::Object(entries) if entries.iter().any(|entry| entry.key == node));
        let entries = match &mut self.root.json {
            Json::Object(entries) => entries.iter_mut().find(|entry| entry.key == "nodes"),
            _ => None,
        };
        let mut names = Vec::new();
        if let Some(Entry { value: Spanned { json: Json::Object(nodes), .. }, .. }) = entries {
            names = nodes.iter().map(|entry| entry.key.clone()).collect();
            if let Some(entry) = nodes.iter_mut().find(|entry| entry.key == node)
                && let Json::Object(items) = &mut entry.value.json
            {
                items.retain(|item| item.key != knob);
                items.push(Entry { key: knob.into(), offset: place, value });
                self.overrides.push(assignment.into());
                return Ok(());
            }
        }
        fault.found = format!("node \"{}\"", shorten(node));
        fault.expected = "a node of the document".into();
        if at_top {
            fault.found = format!("\"{}\", which is not a node but a key beside \"nodes\"", shorten(node));
            let key = shorten(node);
            fault.remedy = format!("change \"{key}\" in the document itself: assignments change only nodes");
            fault.means = Some(Means::EditDocument { key });
        } else if let Some(near) = crate::nearest(node, names.iter().map(String::as_str)) {
            fault.remedy = format!("did you mean \"{near}\"?");
        }
        Err(Box::new(fault))
    }

    /// Returns the assignment of an offset, if it is in one.
    pub(crate) fn assignment(&self, offset: usize) -> Option<String> {
        let index = offset.checked_sub(OVERRIDE)?;
        Some(shorten(self.overrides.get(index).map_or("", String::as_str)))
    }

    /// Returns line and column of an offset; 0 if it is in an assignment.
    pub(crate) fn place(&self, offset: usize) -> (usize, usize) {
        if offset >= OVERRIDE {
            return (0, 0);
        }
        self.lines.get_or_init(|| LineIndex::new(&self.text)).find(&self.text, offset)
    }

    /// Returns the document as canonical text: keys sorted, `ui` and notes left out, assignments applied. Documents with
    /// the same canonical text have the same results.
    pub fn canonical(&self) -> String {
        let mut text = String::with_capacity(self.text.len());
        canonical(&self.root.json, true, &mut text);
        text
    }
}

fn relocate(value: &mut Spanned, place: usize) {
    value.offset = place;
    match &mut value.json {
        Json::Array(items) => items.iter_mut().for_each(|item| relocate(item, place)),
        Json::Object(entries) => {
            for entry in entries {
                entry.offset = place;
                relocate(&mut entry.value, place);
            }
        }
        _ => {}
    }
}

fn canonical(json: &Json, top: bool, out: &mut String) {
    match json {
        Json::Null => out.push_str("null"),
        Json::Bool(value) => out.push_str(if *value { "true" } else { "false" }),
        Json::Number(number) => out.push_str(&serde_json::Value::from(*number).to_string()),
        Json::String(text) => quoted(text, out),
        Json::Array(items) => {
            out.push('[');
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                canonical(&item.json, false, out);
            }
            out.push(']');
        }
        Json::Object(entries) => {
            let mut sorted: Vec<&Entry> =
                entries.iter().filter(|entry| entry.key != "ui" && !(top && entry.key == "notes")).collect();
            sorted.sort_by(|a, b| a.key.cmp(&b.key));
            out.push('{');
            for (index, entry) in sorted.into_iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                quoted(&entry.key, out);
                out.push(':');
                canonical(&entry.value.json, false, out);
            }
            out.push('}');
        }
    }
}

/// Appends a string in JSON syntax.
fn quoted(text: &str, out: &mut String) {
    if text.bytes().any(|byte| byte < b' ' || byte == b'"' || byte == b'\\') {
        out.push_str(&serde_json::Value::from(text).to_string());
    } else {
        out.push('"');
        out.push_str(text);
        out.push('"');
    }
}

/// Returns the nearest character boundary at or before a byte offset.
fn floor(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn canonical_text_ignores_order_and_ui() {
        let a = Document::parse("a", r##"{"b": 1, "a": {"y": [1, 2], "x": "#fff"}, "ui": {"q": 1}}"##).expect("valid");
        let b = Document::parse("b", r##"{"a": {"x": "#fff", "y": [1.0, 2]}, "b": 1, "notes": "n"}"##).expect("valid");
        assert_eq!(a.canonical(), b.canonical());
    }

    #[test]
    fn set_replaces_a_knob_and_names_strangers() {
        let mut document = Document::parse("d", r#"{"nodes": {"storm": {"height": 1}}}"#).expect("valid");
        document.set("storm.height=2.5").expect("known node");
        document.set("storm.word=deep").expect("bare word");
        assert_eq!(document.canonical(), r#"{"nodes":{"storm":{"height":2.5,"word":"deep"}}}"#);
        let fault = document.set("strom.height=1").expect_err("unknown node");
        assert!(fault.remedy.contains("storm"), "{fault}");
        assert!(document.set("nonsense").is_err());
        assert!(document.set("storm.height={").is_err());
    }
}
