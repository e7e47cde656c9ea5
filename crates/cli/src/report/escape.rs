//! Escaping of text in a page.

use crate::shell::printable;

/// Escapes a text for HTML, and replaces its control characters.
pub(crate) fn escape(text: &str) -> String {
    let escaped = printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    escaped.replace('"', "&quot;").replace('\'', "&#39;")
}
