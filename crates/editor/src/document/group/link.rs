//! Links: texts that take a value from other knobs.

pub(super) use crate::document::link::is_link;
use serde_json::Value;
use std::ops::Range;

/// Returns the names `NODE.KNOB` in a link or formula, with their places.
pub(super) fn names(text: &str) -> Vec<(Range<usize>, &str, &str)> {
    let bytes = text.as_bytes();
    let is_part = |at: usize| bytes.get(at).is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    let (mut at, mut found) = (0, Vec::new());
    while at < bytes.len() {
        let start = at;
        while is_part(at) {
            at += 1;
        }
        if at == start {
            at += 1;
            continue;
        }
        let is_word = !bytes[start].is_ascii_digit();
        // Letters after a dot pick components.
        let is_picked = start > 0 && bytes[start - 1] == b'.';
        if is_word && !is_picked && bytes.get(at) == Some(&b'.') && is_part(at + 1) {
            let knob = at + 1;
            at = knob;
            while is_part(at) {
                at += 1;
            }
            found.push((start..at, &text[start..knob - 1], &text[knob..at]));
        }
    }
    found
}

/// Returns the name that a link consists of, if it is no formula.
pub(super) fn sole(text: &str) -> Option<(&str, &str)> {
    let bare = text.trim_start_matches('=').trim();
    match names(bare).as_slice() {
        [(range, node, knob)] if range.len() == bare.len() => Some((node, knob)),
        _ => None,
    }
}

/// Returns a link with other texts in the place of some of its names.
pub(super) fn replaced<E>(
    text: &str,
    mut to: impl FnMut(&str, &str) -> Result<Option<String>, E>,
) -> Result<String, E> {
    let (mut new, mut end) = (String::new(), 0);
    for (range, node, knob) in names(text) {
        if let Some(other) = to(node, knob)? {
            new.push_str(&text[end..range.start]);
            new.push_str(&other);
            end = range.end;
        }
    }
    new.push_str(&text[end..]);
    Ok(new)
}

/// Calls `f` with every link in a value.
pub(super) fn each(value: &Value, f: &mut dyn FnMut(&str)) {
    match value {
        Value::String(text) if is_link(text) => f(text),
        Value::Array(items) => items.iter().for_each(|item| each(item, f)),
        Value::Object(entries) => {
            entries.iter().filter(|(key, _)| !is_remark(key)).for_each(|(_, value)| each(value, f));
        }
        _ => {}
    }
}

/// Whether a key of a node is for people and editors alone.
pub(super) fn is_remark(key: &str) -> bool {
    matches!(key, "ui" | "notes")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_among_functions_numbers_and_components() {
        let text = "= 1.5e3*sin(left.x) + (knobs.size).y - camera.position.y";
        let found: Vec<(&str, &str)> = names(text).into_iter().map(|(_, node, knob)| (node, knob)).collect();
        assert_eq!(found, [("left", "x"), ("knobs", "size"), ("camera", "position")]);
        let to = |node: &str, knob: &str| -> Result<Option<String>, ()> {
            Ok((node != "left").then(|| format!("b_{node}.{knob}")))
        };
        let new = replaced(text, to);
        assert_eq!(new.as_deref(), Ok("= 1.5e3*sin(left.x) + (b_knobs.size).y - b_camera.position.y"));
        assert_eq!(sole("= left.x"), Some(("left", "x")));
        assert_eq!(sole("=left.x "), Some(("left", "x")));
        for formula in ["= left.x + 1", "= (left.x)", "= left.x.y", "= 2", "= frame"] {
            assert_eq!(sole(formula), None, "{formula}");
        }
    }
}
