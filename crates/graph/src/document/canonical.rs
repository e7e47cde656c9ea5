//! The canonical text of a document.

use crate::spanned::{Entry, Json, Spanned};
use std::collections::HashMap;

/// Appends a value with sorted keys; at the top, notes and the names of included documents are left out, too. Texts at
/// offsets that `moved` has are written as it says.
pub(super) fn write(value: &Spanned, top: bool, moved: &HashMap<usize, String>, out: &mut String) {
    match &value.json {
        Json::Null => out.push_str("null"),
        Json::Bool(value) => out.push_str(if *value { "true" } else { "false" }),
        Json::Number(number) => out.push_str(&serde_json::Value::from(*number).to_string()),
        Json::String(text) => quoted(moved.get(&value.offset).unwrap_or(text), out),
        Json::Array(items) => {
            out.push('[');
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                write(item, false, moved, out);
            }
            out.push(']');
        }
        Json::Object(entries) => {
            let is_left_out = |key: &str| key == "ui" || (top && matches!(key, "notes" | "include"));
            let mut sorted: Vec<&Entry> = entries.iter().filter(|entry| !is_left_out(&entry.key)).collect();
            sorted.sort_by(|a, b| a.key.cmp(&b.key));
            out.push('{');
            for (index, entry) in sorted.into_iter().enumerate() {
                if index > 0 {
                    out.push(',');
                }
                quoted(&entry.key, out);
                out.push(':');
                write(&entry.value, false, moved, out);
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
