//! Conversion between color texts of documents and sRGB values.

/// Parses a color such as `#2d3f52` to sRGB values from 0 to 1.
pub fn rgb(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let channel = |index: usize| u8::from_str_radix(&digits[2 * index..2 * index + 2], 16).ok();
    Some([channel(0)?, channel(1)?, channel(2)?].map(|value| f32::from(value) / 255.0))
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
