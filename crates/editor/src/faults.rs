//! How faults of the document are told: places first, and what who is still building knows anyway as a quiet note.

use egui::{Color32, Visuals};
use trochoid::{Diagnostic, Means, Severity};

/// Returns whether a fault is no more than a note: the document is being built, and some node leads nowhere yet.
pub(crate) fn is_note(fault: &Diagnostic) -> bool {
    matches!(fault.means, Some(Means::LeadToOutput))
}

/// Returns the color of a fault's text.
pub(crate) fn color(visuals: &Visuals, fault: &Diagnostic) -> Color32 {
    match fault.severity {
        _ if is_note(fault) => visuals.weak_text_color(),
        Severity::Error => crate::theme::error(visuals),
        Severity::Warning => visuals.warn_fg_color,
    }
}

/// Returns what is wrong, without the node that has it.
pub(crate) fn told(fault: &Diagnostic) -> String {
    let place = fault.port.as_ref().map_or(String::new(), |port| format!("{port}: "));
    match is_note(fault) {
        true => "Not rendered yet: no output needs this node.".into(),
        false => format!("{place}found {}; expected {}", fault.found, fault.expected),
    }
}
