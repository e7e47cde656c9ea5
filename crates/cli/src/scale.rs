//! Pictures at another size.

use crate::failure::{FAILED, Failure};
use trochoid::{CheckedGraph, Format};

/// Smallest factor.
const LEAST: f64 = 1.0 / 64.0;

/// A text is no factor.
#[derive(Debug, thiserror::Error)]
#[error("expected a factor from 1/64 to 1, such as 1/2 or 0.25")]
pub(crate) struct NoFactor;

/// Reads a factor, such as `1/2` or `0.25`.
///
/// # Errors
/// The text has another form, or the factor is out of range.
pub(crate) fn factor(text: &str) -> Result<f64, NoFactor> {
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| NoFactor);
    let factor = match text.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => number(text)?,
    };
    if (LEAST..=1.0).contains(&factor) { Ok(factor) } else { Err(NoFactor) }
}

/// Returns the size of a picture that is scaled, with even sides if need be.
pub(crate) fn size(format: Format, factor: f64, is_even: bool) -> [u32; 2] {
    [format.width(), format.height()].map(|side| {
        let side = f64::from(side) * factor;
        if is_even { 2 * ((side / 2.0).round() as u32).max(1) } else { (side.round() as u32).max(1) }
    })
}

/// Returns the graph of the same picture at another size, as the editor draws it: what is in pixels scales, too.
///
/// # Errors
/// There are no pictures of this size.
pub(crate) fn sized(graph: CheckedGraph, [width, height]: [u32; 2]) -> Result<CheckedGraph, Failure> {
    let whole = graph.format();
    if [whole.width(), whole.height()] == [width, height] {
        return Ok(graph);
    }
    let format = Format::new(width, height, whole.samples()).map_err(|error| Failure::new(FAILED, error))?;
    Ok(graph.with_scaled_format(format.sampled_like(whole)))
}

/// Returns the graph scaled by a factor, if one is given.
///
/// # Errors
/// As [`sized`].
pub(crate) fn scaled(graph: CheckedGraph, factor: Option<f64>) -> Result<CheckedGraph, Failure> {
    match factor {
        Some(factor) => {
            let size = size(graph.format(), factor, false);
            sized(graph, size)
        }
        None => Ok(graph),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_fractions_or_decimals() {
        for (text, found) in [("1/2", 0.5), ("0.25", 0.25), (" 1 / 4 ", 0.25), ("1", 1.0), ("1/64", 1.0 / 64.0)] {
            assert_eq!(factor(text).ok(), Some(found), "{text}");
        }
        for text in ["", "0", "-1", "2", "1/0", "0/0", "1/65", "half", "1/2/3", "NaN", "inf", "1/inf", "50%"] {
            assert!(factor(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sides_are_rounded_and_never_vanish() {
        let format = Format::new(1919, 7, 4).unwrap();
        assert_eq!(size(format, 0.5, false), [960, 4]);
        assert_eq!(size(format, 0.25, true), [480, 2]);
        assert_eq!(size(format, 1.0 / 64.0, false), [30, 1]);
        assert_eq!(size(format, 1.0, true), [1920, 8]);
    }
}
