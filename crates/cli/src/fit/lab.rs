//! OKLab of colors in a working space, and how it changes with them.

use trochoid::WorkingSpace;
use trochoid::oklab::{CONES, OPPONENTS};

/// Darkest channel, whose slope is that of all darker ones: the slope of a cube root has no bound at 0.
const DARKEST: f64 = 1e-4;

/// The way from a working space to OKLab.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lab {
    /// Whether channels are decoded first, as those of display values.
    is_encoded: bool,
    cones: [[f64; 3]; 3],
}

impl Lab {
    pub(super) fn of(space: WorkingSpace) -> Self {
        if space == WorkingSpace::Srgb {
            return Self { is_encoded: true, cones: CONES };
        }
        // A linear space: its primaries are the columns of a matrix.
        let primaries = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| space.to_linear_srgb(axis));
        let entry = |row: &[f64; 3], column: usize| (0..3).map(|k| row[k] * primaries[column][k]).sum();
        Self { is_encoded: false, cones: CONES.map(|row| [0, 1, 2].map(|column| entry(&row, column))) }
    }

    /// Returns OKLab of a color, and its derivatives by the channels: `slopes[i][j]` is that of the ith number by channel j.
    pub(super) fn with_slopes(self, color: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let channels = color.map(|v| if self.is_encoded { v.clamp(DARKEST, 1.0) } else { v.max(DARKEST) });
        let (linear, grows) = match self.is_encoded {
            true => (channels.map(trochoid::srgb_decode), channels.map(decode_slope)),
            false => (channels, [1.0; 3]),
        };
        let roots = self.cones.map(|row| libm::cbrt(dot(row, linear).max(1e-12)));
        let lab = OPPONENTS.map(|row| dot(row, roots));
        let by_root = roots.map(|root| 1.0 / (3.0 * root * root));
        let slope = |i: usize, j: usize| {
            (0..3).map(|k| OPPONENTS[i][k] * by_root[k] * self.cones[k][j]).sum::<f64>() * grows[j]
        };
        (lab, [0, 1, 2].map(|i| [0, 1, 2].map(|j| slope(i, j))))
    }

    /// Returns OKLab of a color.
    pub(super) fn lab(self, color: [f64; 3]) -> [f64; 3] {
        self.with_slopes(color).0
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the slope of the decoding of a display value.
fn decode_slope(value: f64) -> f64 {
    if value <= 0.040_45 { 1.0 / 12.92 } else { 2.4 / 1.055 * libm::pow((value + 0.055) / 1.055, 1.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spaces_agree_and_slopes_are_those_of_small_steps() {
        for linear in [[0.2, 0.5, 0.1], [0.9, 0.8, 0.7], [0.01, 0.02, 0.3]] {
            let expected = Lab::of(WorkingSpace::LinearSrgb).lab(linear);
            for space in WorkingSpace::ALL {
                let lab = Lab::of(space);
                let color = space.from_linear_srgb(linear);
                let (found, slopes) = lab.with_slopes(color);
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{space}: {found:?}");
                for channel in 0..3 {
                    let moved = |by: f64| {
                        let mut color = color;
                        color[channel] += by;
                        lab.lab(color)
                    };
                    let (less, more) = (moved(-1e-6), moved(1e-6));
                    for i in 0..3 {
                        let slope = (more[i] - less[i]) / 2e-6;
                        assert!((slope - slopes[i][channel]).abs() < 1e-4 * (1.0 + slope.abs()), "{space}: {slope}");
                    }
                }
            }
        }
    }
}
