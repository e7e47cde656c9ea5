//! Texts within a page.

use crate::shell::printable;

/// Text of a document as text of the page.
pub(super) fn escape(text: &str) -> String {
    let escaped = printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    escaped.replace('"', "&quot;").replace('\'', "&#39;")
}
