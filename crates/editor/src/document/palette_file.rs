//! Palettes in files.

use super::change::style;
use super::color::hex;
use super::json::quoted;
use super::swatches::{Swatch, SwatchKey, shown};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::Path;
use trochoid::{Access, LoadError, PaletteColor, WorkingSpace, load_palette};

/// Maximum size of a palette file, in bytes.
const MOST: u64 = 1 << 20;

/// Reads a palette as [`load_palette`] does. Colors are as they are written there.
///
/// # Errors
/// The file cannot be read, or is no palette.
pub fn read(path: &Path, space: WorkingSpace, access: &Access) -> Result<Vec<(String, Value)>, LoadError> {
    let colors = load_palette(path, space, access)?;
    let text = trochoid::io::read_text(path, MOST).map_err(LoadError::Io)?;
    let raw: Value = serde_json::from_str(text.trim_start_matches('\u{feff}')).unwrap_or_default();
    let raw = raw.get("palette").unwrap_or(&raw);
    let written = |named: &PaletteColor| {
        let color = named.color.at(0.0);
        let shown = space.to_display([color[0], color[1], color[2]]).map(|channel| channel as f32);
        // Only those of GIMP, which have 8 bits, are not JSON.
        let value = raw.get(&named.name).cloned().unwrap_or_else(|| json!(hex(shown)));
        (named.name.clone(), value)
    };
    Ok(colors.iter().map(written).collect())
}

/// Returns the text of a palette file with the named ones of some colors: of GIMP if its name ends so, and otherwise JSON.
/// Palettes of GIMP have keyed colors at the frame that is shown.
pub fn text(path: &Path, all: &[Swatch], space: WorkingSpace) -> String {
    let named = all.iter().filter_map(|swatch| match &swatch.key {
        SwatchKey::Named(name) => Some((name, swatch)),
        SwatchKey::Literal(_) => None,
    });
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gpl")) {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().replace(char::is_control, " ");
        let mut text = format!("GIMP Palette\nName: {name}\nColumns: {}\n", named.clone().count());
        for (name, swatch) in named {
            let [r, g, b] = swatch.color.unwrap_or_default().map(|channel| (255.0 * channel).round() as u8);
            let _ = writeln!(text, "{r:3} {g:3} {b:3}\t{name}");
        }
        return text;
    }
    let color = |swatch: &Swatch| swatch.value.clone().unwrap_or_else(|| json!(hex(swatch.color.unwrap_or_default())));
    let lines = named.map(|(name, swatch)| format!("    {}: {}", quoted(name), style(&color(swatch))));
    let lines: Vec<String> = lines.collect();
    let space = quoted(space.name());
    format!(
        "{{\n  \"trochoid_palette\": 1,\n  \"working_space\": {space},\n  \"palette\": {{\n{}\n  }}\n}}\n",
        lines.join(",\n")
    )
}

/// Returns the colors of a palette at a frame as they are displayed.
pub fn displayed(entries: &[(String, Value)], space: WorkingSpace, frame: i64) -> Vec<[f32; 3]> {
    entries.iter().filter_map(|(_, value)| shown(value, space, frame as f64)).collect()
}
