//! Encoding of values in files: unchanged, as linear light, or for display.

use trochoid_graph::Kind;
use trochoid_image::{WorkingSpace, srgb_decode, srgb_encode};

/// Conversion from an output's values to those of its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    /// Unchanged.
    None,
    /// From colors of a display-encoded space to linear light, for EXR.
    Linear,
    /// From colors of this space to display values, for PNG.
    Display(WorkingSpace),
}

/// Relative and absolute error of a conversion: one rounding to f32, and the error of a library's power function.
const ROUNDING: (f64, f64) = (1.0 / 16_777_216.0, 1e-12);

impl Coding {
    pub(super) fn new(kind: Kind, space: WorkingSpace, png: bool) -> Self {
        match (kind, png, space) {
            (Kind::Color, true, WorkingSpace::LinearSrgb | WorkingSpace::AcesCg) => Self::Display(space),
            (Kind::Color, false, WorkingSpace::Srgb) => Self::Linear,
            _ => Self::None,
        }
    }

    /// Returns the range of each channel in the file, before rounding, for values within an error of the reference.
    ///
    /// Every conversion is increasing in each channel, so that it maps bounds to bounds.
    pub(super) fn ends(self, reference: &[f64], error: f64) -> Vec<(f64, f64)> {
        let around = |value: f64, error: f64| {
            // Infinities are exact, since the difference of two of them is undefined.
            if value.is_finite() { (value - error, value + error) } else { (value, value) }
        };
        let rounded = |(low, high): (f64, f64)| {
            let slack = |value: f64| value.abs() * ROUNDING.0 + ROUNDING.1;
            (low - slack(low), high + slack(high))
        };
        let each = |f: fn(f64) -> f64, values: &[f64], errors: &[f64]| {
            let ends = values.iter().zip(errors).map(|(value, error)| around(*value, *error));
            ends.map(|(low, high)| rounded((f(low), f(high)))).collect()
        };
        match (self, reference) {
            (Self::Linear, _) => each(srgb_decode, reference, &vec![error; reference.len()]),
            (Self::Display(space), [r, g, b]) => {
                let linear = space.to_linear_srgb([*r, *g, *b]);
                let columns = [0, 1, 2].map(|j| space.to_linear_srgb([0, 1, 2].map(|i| f64::from(u8::from(i == j)))));
                let errors = [0, 1, 2].map(|i| {
                    columns.iter().filter(|column| column[i] != 0.0).map(|column| column[i].abs() * error).sum()
                });
                each(srgb_encode, &linear, &errors)
            }
            _ => reference.iter().map(|value| around(*value, error)).collect(),
        }
    }

    /// Converts a color of the file to the working space.
    pub(super) fn color(self, stored: [f64; 3]) -> [f64; 3] {
        match self {
            Self::None => stored,
            Self::Linear => stored.map(srgb_encode),
            Self::Display(space) => space.from_linear_srgb(stored.map(srgb_decode)),
        }
    }

    /// Returns the rounding error of a converted color relative to its channels.
    pub(super) fn rounding(self) -> f64 {
        if self == Self::None { 0.0 } else { 4.0 * ROUNDING.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_hold_all_colors_within_the_error_and_no_more() {
        for (space, png) in [
            (WorkingSpace::LinearSrgb, true),
            (WorkingSpace::AcesCg, true),
            (WorkingSpace::Srgb, true),
            (WorkingSpace::Srgb, false),
            (WorkingSpace::AcesCg, false),
        ] {
            let coding = Coding::new(Kind::Color, space, png);
            let stored = |color: [f64; 3]| match (png, space) {
                (true, _) => space.to_display(color),
                (false, WorkingSpace::Srgb) => space.to_linear_srgb(color),
                (false, _) => color,
            };
            let (color, error) = ([0.4, 0.5, 0.6], 0.01);
            let ends = coding.ends(&color, error);
            for corner in 0..8 {
                let moved = [0, 1, 2].map(|c| color[c] + if corner >> c & 1 == 0 { -error } else { error });
                for (value, (low, high)) in stored(moved).iter().zip(&ends) {
                    assert!(low <= value && value <= high, "{space}: {value} in [{low}, {high}]");
                    assert!(high - low < 0.06, "{space}: [{low}, {high}]");
                }
            }
            let back = coding.color(stored(color));
            assert!(back.iter().zip(color).all(|(back, color)| (back - color).abs() < 1e-6), "{space}: {back:?}");
        }
        let depth = Coding::new(Kind::Field(1), WorkingSpace::Srgb, false);
        assert_eq!(depth.ends(&[f64::INFINITY], 1.0), [(f64::INFINITY, f64::INFINITY)]);
        assert_eq!(depth.ends(&[2.0], f64::INFINITY), [(f64::NEG_INFINITY, f64::INFINITY)]);
    }
}
