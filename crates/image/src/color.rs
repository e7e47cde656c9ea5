//! Hexadecimal colors.

/// Error: a string is not a hexadecimal color.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is not a color: write #rrggbb or #rgb with hexadecimal digits")]
pub struct HexError(String);

/// Reads `#rrggbb` or `#rgb` as display-encoded sRGB in 0 to 1.
///
/// # Errors
/// The string is not of that form.
///
/// ```
/// assert_eq!(trochoid_image::parse_hex("#ff0033")?, [1.0, 0.0, 0.2]);
/// # Ok::<(), trochoid_image::HexError>(())
/// ```
pub fn parse_hex(text: &str) -> Result<[f64; 3], HexError> {
    let error = || HexError(text.chars().take(40).collect());
    let digits: Vec<u8> = text
        .strip_prefix('#')
        .ok_or_else(error)?
        .chars()
        .take(7)
        .map(|c| c.to_digit(16).map(|d| d as u8))
        .collect::<Option<_>>()
        .ok_or_else(error)?;
    let byte = |high: u8, low: u8| f64::from(high * 16 + low) / 255.0;
    match digits[..] {
        [r, g, b] => Ok([byte(r, r), byte(g, g), byte(b, b)]),
        [r, s, g, h, b, c] => Ok([byte(r, s), byte(g, h), byte(b, c)]),
        _ => Err(error()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_form_doubles_digits() {
        assert_eq!(parse_hex("#0f8"), parse_hex("#00FF88"));
    }

    #[test]
    fn anything_else_is_refused() {
        for bad in ["", "#", "ff0000", "#ff000", "#ff00000", "#gg0000", "#ff00é0", "#+1+1+1"] {
            assert!(parse_hex(bad).is_err(), "{bad}");
        }
    }
}
