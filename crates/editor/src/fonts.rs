//! Letters that the interface's own fonts lack: formulas have indices, arrows and brackets.

use egui::epaint::text::{FontInsert, FontPriority, InsertFontFamily};
use egui::{Context, FontData, FontFamily};

/// Adds a font in which such letters are looked up last.
pub(crate) fn install(context: &Context) {
    let families = [FontFamily::Proportional, FontFamily::Monospace]
        .map(|family| InsertFontFamily { family, priority: FontPriority::Lowest });
    context.add_font(FontInsert::new("DejaVu Sans", FontData::from_static(dejavu::sans::regular()), families.into()));
}
