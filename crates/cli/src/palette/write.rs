//! Files of a palette.

use crate::failure::{FAILED, Failure};
use crate::files::OverwriteOptions;
use crate::remedies;
use serde_json::{Map, Value, json};
use std::fmt::Write as _;
use std::path::Path;
use trochoid::io::{PngImage, Samples, write_png8};
use trochoid::{Form, GENERATOR, VERSION, marks, quoted_path};
use trochoid_palette::Palette;

/// Returns the form of a file by its extension.
pub(crate) fn form(path: &Path) -> Option<Form> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    match ending.as_str() {
        "json" => Some(Form::Palette),
        "gpl" => Some(Form::Gimp),
        "png" => Some(Form::Swatches),
        _ => None,
    }
}

/// Returns the failure of a file without a form.
pub(crate) fn no_form(path: &Path) -> Failure {
    let found = path.extension().map_or("no extension".into(), |ending| format!("the extension .{}", ending.display()));
    let message = format!("--out {}: found {found}; expected .json, .gpl or .png", quoted_path(path));
    Failure::usage(message, format!("name it {}", quoted_path(&path.with_extension("json"))))
}

/// Returns the failure of a file whose form cannot hold the colors.
pub(super) fn unfit(path: &Path, palette: &Palette) -> Option<Failure> {
    (form(path) == Some(Form::Gimp) && palette.units != 1).then(|| {
        let message = format!(
            "{}: found colors between the steps of 8 bits; expected whole steps, which are all that .gpl holds",
            path.display()
        );
        Failure::usage(message, "write .json, or ask for another number of --colors")
    })
}

/// Writes a palette.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write(path: &Path, palette: &Palette, over: &OverwriteOptions) -> Result<(), Failure> {
    match form(path) {
        Some(Form::Swatches) => {
            let image = swatches(&palette.colors);
            let pixels = Samples::rgb(&image.pixels);
            let image = PngImage { metadata: marks(Form::Swatches), ..PngImage::new(image.width, SIDE, pixels) };
            let cannot = |error| Failure::new(FAILED, remedies::written(&error));
            write_png8(over.target(path, Form::Swatches), &image).map_err(cannot)
        }
        Some(Form::Gimp) => {
            let text = gimp(path, palette);
            Ok(trochoid::write_guarded(path, text.as_bytes(), Form::Gimp, over.overwrite)?)
        }
        _ => {
            let text = format!("{:#}\n", file(palette));
            Ok(trochoid::write_guarded(path, text.as_bytes(), Form::Palette, over.overwrite)?)
        }
    }
}

/// Returns the colors by name, as documents have them.
pub(super) fn colors(palette: &Palette) -> Value {
    let color = |color: &[f64; 3]| match palette.units {
        1 => json!(hex(*color)),
        _ => json!(color),
    };
    let named = palette.names.iter().zip(&palette.colors).map(|(name, of)| (name.clone(), color(of)));
    Value::Object(named.collect::<Map<String, Value>>())
}

/// Returns the text of a palette as JSON.
fn file(palette: &Palette) -> Value {
    json!({
        "trochoid_palette": 1,
        "working_space": "srgb",
        "palette": colors(palette),
    })
}

/// Returns a color as text, rounded to 8 bits.
pub(crate) fn hex(color: [f64; 3]) -> String {
    let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Returns the text of a palette of GIMP.
fn gimp(path: &Path, palette: &Palette) -> String {
    let name = path.file_stem().map_or("palette".into(), |stem| stem.to_string_lossy().replace(char::is_control, " "));
    let mut text = format!("GIMP Palette\nName: {name}\nColumns: {}\n# {GENERATOR}{VERSION}\n", palette.colors.len());
    for (name, color) in palette.names.iter().zip(&palette.colors) {
        let [r, g, b] = color.map(|channel| (255.0 * channel).round() as u8);
        let _ = writeln!(text, "{r:3} {g:3} {b:3}\t{name}");
    }
    text
}

/// Width and height of a swatch, in pixels.
const SIDE: u32 = 128;

/// Picture of colors side by side.
struct Swatches {
    width: u32,
    pixels: Vec<[f32; 3]>,
}

fn swatches(colors: &[[f64; 3]]) -> Swatches {
    let row: Vec<[f32; 3]> =
        colors.iter().flat_map(|color| vec![color.map(|channel| channel as f32); SIDE as usize]).collect();
    Swatches { width: SIDE * colors.len() as u32, pixels: row.repeat(SIDE as usize) }
}
