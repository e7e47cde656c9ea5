//! Links: values that are taken from other knobs, or are formulas of them.

use super::json::Path;
use serde_json::Value;
use std::cell::RefCell;

/// Returns whether a text in the place of a value is a link.
pub fn is_link(text: &str) -> bool {
    text.starts_with('=')
}

/// Returns a typed link in the form that documents have, with one space after the sign; `None` if the text is no link.
pub fn written(typed: &str) -> Option<String> {
    let formula = typed.trim().strip_prefix('=')?.trim();
    Some(format!("= {formula}"))
}

/// Returns a link with other names for the nodes whose knobs it follows; names for which there is none stay.
pub fn renamed(link: &str, to: &dyn Fn(&str) -> Option<String>) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (mut text, mut rest) = (String::new(), link);
    while let Some(start) = rest.find(is_part) {
        let word = &rest[start..];
        let word = &word[..word.find(|c: char| !is_part(c)).unwrap_or(word.len())];
        text.push_str(&rest[..start]);
        rest = &rest[start + word.len()..];
        // A word after a dot is a knob, or picks components.
        let is_name = !word.starts_with(|c: char| c.is_ascii_digit());
        let is_node = is_name && rest.starts_with('.') && !text.ends_with('.');
        text.push_str(&is_node.then(|| to(word)).flatten().unwrap_or_else(|| word.into()));
    }
    text + rest
}

/// Returns the names before the dots in a link: of nodes, and `knobs`.
pub fn nodes(link: &str) -> Vec<String> {
    let found = RefCell::new(Vec::new());
    renamed(link, &|name| {
        found.borrow_mut().push(name.to_string());
        None
    });
    found.into_inner()
}

/// Returns all links in a value, with their places.
pub fn links<'v>(value: &'v Value, at: &Path) -> Vec<(Path, &'v str)> {
    let mut found = Vec::new();
    match value {
        Value::String(text) if is_link(text) => found.push((at.clone(), text.as_str())),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(index, item)| found.extend(links(item, &at.to(index))));
        }
        Value::Object(entries) => {
            let own = entries.iter().filter(|(key, _)| !matches!(key.as_str(), "ui" | "notes"));
            own.for_each(|(key, value)| found.extend(links(value, &at.to(key))));
        }
        _ => {}
    }
    found
}

/// Renames nodes in all links within a value.
pub fn redirect(value: &mut Value, to: &dyn Fn(&str) -> Option<String>) {
    match value {
        Value::String(text) if is_link(text) => *text = renamed(text, to),
        Value::Array(items) => items.iter_mut().for_each(|item| redirect(item, to)),
        Value::Object(entries) => {
            let own = entries.iter_mut().filter(|(key, _)| !matches!(key.as_str(), "ui" | "notes"));
            own.for_each(|(_, value)| redirect(value, to));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_follows_the_new_name_of_its_node() {
        let to = |name: &str| (name == "hull").then(|| "boat".to_string());
        assert_eq!(renamed("= hull.x", &to), "= boat.x");
        assert_eq!(renamed("= 2*hull.x+sin(hull.y.x)", &to), "= 2*boat.x+sin(boat.y.x)");
        // Other names that begin or end so, knobs of that name, and functions stay.
        let others = "= hull2.x + my_hull.x + sail.hull + hull(1) + knobs.hull.x";
        assert_eq!(renamed(others, &to), others);
    }

    #[test]
    fn a_link_names_the_nodes_that_it_follows() {
        assert_eq!(nodes("= 2*hull.x + sin(time)*knobs.storm + (sail.a).y"), ["hull", "knobs", "sail"]);
        assert!(nodes("= frame/1.5").is_empty());
    }

    #[test]
    fn a_typed_link_has_one_space() {
        assert_eq!(written(" =hull.x "), Some("= hull.x".into()));
        assert_eq!(written("=  2 + a.b"), Some("= 2 + a.b".into()));
        assert_eq!(written("2 + a.b"), None);
    }
}
