//! The document that repaints a picture: it takes the picture apart and mixes it of colors with names.

use crate::palette::named::Named;
use crate::palette::write::hex;
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};
use trochoid::{escape_frame, resolved};

/// Returns the document, in a file, that repaints a picture of this size. Colors are rounded to 8 bits, in the palette as
/// in what the picture is taken apart into.
pub(super) fn document(file: &Path, picture: &Path, [width, height]: [usize; 2], inks: &Named, softness: f64) -> Value {
    let colors: Vec<String> = inks.colors.iter().map(|color| hex(*color)).collect();
    let palette: Map<String, Value> = inks.names.iter().cloned().zip(colors.iter().map(|color| json!(color))).collect();
    let named: Vec<String> = inks.names.iter().map(|name| format!("palette.{name}")).collect();
    json!({
        "trochoid": 1,
        "format": { "width": width, "height": height },
        "working_space": "srgb",
        "palette": palette,
        "nodes": {
            "weights": { "type": "Decompose", "file": beside(file, picture), "colors": colors, "softness": softness },
            "picture": { "type": "Blend", "colors": named, "weights": "weights" },
        },
        "outputs": { "picture": { "color": "picture", "file": format!("{}.repainted.png", stem(file)) } },
    })
}

/// Returns the name of a file without its extension, as a document names it.
fn stem(file: &Path) -> String {
    escape_frame(&file.file_stem().unwrap_or_default().to_string_lossy())
}

/// Returns the path of a picture as a document names it: relative to the document's folder, with / between folders.
fn beside(file: &Path, picture: &Path) -> String {
    let [file, picture] = [file, picture].map(resolved);
    let folder = file.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    let relative = pathdiff::diff_paths(&picture, &folder).unwrap_or(picture);
    let steps: Vec<_> = relative.components().map(|step| step.as_os_str().to_string_lossy()).collect();
    escape_frame(&steps.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_named_from_the_document() {
        let of = |file: &str, picture: &str| beside(Path::new(file), Path::new(picture));
        assert_eq!(of("/a/b/c.json", "/a/b/d.png"), "d.png");
        assert_eq!(of("/a/b/c.json", "/a/e#1/d.png"), r"../e\#1/d.png");
    }
}
