//! Encoding of values in files: unchanged, as linear light, or for display.

use crate::display::{ROUNDING, linear_errors, near, rounded};
use trochoid_graph::Kind;
use trochoid_image::{WorkingSpace, srgb_decode, srgb_encode, srgb_fall};

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

impl Coding {
    pub(super) fn new(kind: Kind, space: WorkingSpace, png: bool) -> Self {
        match (kind, png, space) {
            (Kind::Color, true, WorkingSpace::LinearSrgb | WorkingSpace::AcesCg) => Self::Display(space),
            (Kind::Color, false, WorkingSpace::Srgb) => Self::Linear,
            _ => Self::None,
        }
    }

    /// Returns the range of each channel in the file, before rounding, for values whose channels lie within these errors
    /// of the reference.
    ///
    /// Every conversion is increasing in each channel, so that it maps bounds to bounds, except for a small fall of the
    /// sRGB encoding.
    pub(super) fn ends(self, reference: &[f64], errors: &[f64]) -> Vec<(f64, f64)> {
        let around = |value: f64, error: f64| {
            match (value.is_finite(), error.is_finite()) {
                (true, _) => (value - error, value + error),
                // Infinities are exact, since the difference of two of them is undefined, or nothing is known.
                (false, true) => (value, value),
                (false, false) => (f64::NEG_INFINITY, f64::INFINITY),
            }
        };
        let each = |f: fn((f64, f64)) -> (f64, f64), values: &[f64], errors: &[f64]| {
            let ends = values.iter().zip(errors).map(|(value, error)| around(*value, *error));
            ends.map(|ends| rounded(f(ends))).collect()
        };
        match (self, reference) {
            (Self::Linear, _) => each(|(low, high)| (srgb_decode(low), srgb_decode(high)), reference, errors),
            (Self::Display(space), [r, g, b]) => {
                let linear = space.to_linear_srgb([*r, *g, *b]);
                let encoded = |(low, high): (f64, f64)| {
                    let fall = srgb_fall(low, high);
                    (srgb_encode(low) - fall, srgb_encode(high) + fall)
                };
                each(encoded, &linear, &linear_errors(space, errors))
            }
            _ => reference.iter().zip(errors).map(|(value, error)| around(*value, *error)).collect(),
        }
    }

    /// Bounds how far a displayed color lies from that of the reference, given the range of each of its channels before
    /// rounding and one error bound for all channels.
    pub(super) fn displayed(self, space: WorkingSpace, color: [(f64, f64); 3], error: f64) -> f64 {
        if error == 0.0 {
            return 0.0;
        }
        // Working colors that are encoded already are displayed as they are.
        let linear = match (self, space) {
            (_, WorkingSpace::Srgb) => return error.min(1.0),
            (Self::Display(_), _) => color.map(|(low, high)| (srgb_decode(low), srgb_decode(high))),
            _ => {
                let middle = space.to_linear_srgb(color.map(|(low, high)| 0.5 * (low + high)));
                let half = linear_errors(space, &color.map(|(low, high)| 0.5 * (high - low)));
                [0, 1, 2].map(|c| (middle[c] - half[c], middle[c] + half[c]))
            }
        };
        near(linear, linear_errors(space, &[error; 3]))
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
    fn displayed_errors_are_never_larger_than_their_bound_and_seldom_much_smaller() {
        let mut random = 1_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut closest = 0.0_f64;
        for (space, png) in [
            (WorkingSpace::LinearSrgb, true),
            (WorkingSpace::LinearSrgb, false),
            (WorkingSpace::AcesCg, true),
            (WorkingSpace::AcesCg, false),
            (WorkingSpace::Srgb, true),
        ] {
            let coding = Coding::new(Kind::Color, space, png);
            for _ in 0..2000 {
                let scale = libm::exp(-9.0 * next());
                let color = [0; 3].map(|_| 1.2 * next() * scale);
                let error = scale * libm::exp(-9.0 * next());
                let stored = if png { space.to_display(color) } else { color };
                let half = 0.002 * next();
                let bound = coding.displayed(space, stored.map(|stored| (stored - half, stored + half)), error);
                let shown = |color: [f64; 3]| space.to_display(color).map(|value| value.clamp(0.0, 1.0));
                for corner in 0..8 {
                    let other = [0, 1, 2].map(|c| color[c] + if corner >> c & 1 == 0 { -error } else { error });
                    for (a, b) in shown(color).iter().zip(shown(other)) {
                        let apart = (a - b).abs();
                        // The colors themselves are rounded.
                        assert!(apart <= bound + 1e-15, "{space}, {png}: {color:?} ± {error}: {apart} > {bound}");
                        closest = closest.max(apart / bound);
                    }
                }
            }
            assert_eq!(coding.displayed(space, [(0.1, 0.2); 3], 0.0), 0.0);
            assert!((0.5..=1.0).contains(&coding.displayed(space, [(0.1, 0.2); 3], f64::INFINITY)));
        }
        assert!(closest > 0.98, "{closest}");
    }

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
            let ends = coding.ends(&color, &[error; 3]);
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
        assert_eq!(depth.ends(&[f64::INFINITY], &[1.0]), [(f64::INFINITY, f64::INFINITY)]);
        assert_eq!(depth.ends(&[2.0], &[f64::INFINITY]), [(f64::NEG_INFINITY, f64::INFINITY)]);
        assert_eq!(depth.ends(&[f64::INFINITY], &[f64::INFINITY]), [(f64::NEG_INFINITY, f64::INFINITY)]);
    }
}
