//! Conversion between color texts of documents and sRGB values.

/// Parses a color such as `#2d3f52` or `#246` to sRGB values from 0 to 1.
pub fn rgb(text: &str) -> Option<[f32; 3]> {
    trochoid::parse_hex(text).ok().map(|color| color.map(|channel| channel as f32))
}

/// Returns whether a text in the place of a color stands for a color itself, and not for a node.
pub fn is_color(text: &str) -> bool {
    text.starts_with('#') || is_name(text)
}

/// Returns whether a text is the name of a color in the palette.
pub fn is_name(text: &str) -> bool {
    text.starts_with("palette.")
}

/// Formats sRGB values as a color text.
pub fn hex(color: [f32; 3]) -> String {
    let [r, g, b] = color.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}
