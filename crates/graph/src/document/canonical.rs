//! The canonical text of a document.

use crate::spanned::{Entry, Json};

/// Appends a value with sorted keys; at the top, notes are left out, too.
pub(super) fn write(json: &Json, top: bool, out: &mut String) {
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
                write(&item.json, false, out);
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
                write(&entry.value.json, false, out);
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
