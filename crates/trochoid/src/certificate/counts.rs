//! Counts on the pixels of an output as its file stores them.

use super::PixelCounts;
use super::color::Coding;
use super::image::StoredChannel;
use super::storage::before_rounding;
use trochoid_engine::Hull;
use trochoid_graph::{Kind, LITERAL};

/// Hull that colors must lie in, and the margin of rounding around it.
pub(super) struct Palette {
    pub(super) hull: Hull,
    pub(super) margin: f64,
}

/// Distance of a stored color outside of the hull, and the distance that rounding explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Outside {
    pub(super) distance: f64,
    pub(super) explained: f64,
}

impl Palette {
    /// Makes the hull of some corners, in any order.
    pub(super) fn new(corners: &[[f32; 3]], margin: f64) -> Self {
        Self { hull: Hull::new(&sorted(corners)), margin }
    }

    /// Returns the distance of a stored color, given by the ranges of its channels before rounding, if rounding does
    /// not explain it.
    fn outside(&self, coding: Coding, ends: &[(f64, f64)]) -> Option<Outside> {
        let at = |share: &dyn Fn(usize) -> f64| {
            coding.color([0, 1, 2].map(|c| ends[c].0 + share(c) * (ends[c].1 - ends[c].0)))
        };
        let color = at(&|_| 0.5);
        let distance = self.hull.signed_distance(color);
        if distance <= self.margin {
            return None;
        }
        let corners = (0..8).map(|corner: usize| at(&|c| (corner >> c & 1) as f64));
        let apart = |other: [f64; 3]| color.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let size = color.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let rounded = corners.map(apart).fold(0.0, f64::max) + coding.rounding() * size;
        let explained = self.margin + rounded;
        (distance > explained).then_some(Outside { distance, explained })
    }
}

/// Sorts corners of a hull, so that nothing depends on their order.
pub(super) fn sorted(corners: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut corners = corners.to_vec();
    corners.sort_by(|a, b| a.iter().zip(b).fold(std::cmp::Ordering::Equal, |o, (a, b)| o.then(a.total_cmp(b))));
    corners
}

/// Returns the range of values before rounding for each channel of a stored pixel.
pub(super) fn stored(channels: &[&StoredChannel], pixel: usize) -> Vec<(f64, f64)> {
    channels.iter().map(|channel| before_rounding(channel.stored, channel.plane.samples()[pixel])).collect()
}

/// Counts the pixels of an output; those of colors are held against a palette.
pub(super) fn counts(
    kind: Kind,
    coding: Coding,
    channels: &[&StoredChannel],
    palette: Option<&Palette>,
) -> PixelCounts {
    let pixels = channels.first().map_or(0, |channel| channel.plane.samples().len());
    let mut counts = PixelCounts { infinite: 0, nan: 0, outside: 0, outside_by: 0.0, pixels: pixels as u64 };
    // Neighbors are often equal.
    let mut last: Option<(Vec<u32>, Option<Outside>)> = None;
    for pixel in 0..pixels {
        let samples = || channels.iter().map(|channel| channel.plane.samples()[pixel]);
        if samples().any(f32::is_nan) {
            counts.nan += 1;
        } else if samples().any(f32::is_infinite) {
            counts.infinite += 1;
        } else if let (Kind::Color, Some(palette)) = (kind, palette) {
            let bits: Vec<u32> = samples().map(f32::to_bits).collect();
            let outside = match &last {
                Some((same, outside)) if *same == bits => *outside,
                _ => palette.outside(coding, &stored(channels, pixel)),
            };
            last = Some((bits, outside));
            if let Some(Outside { distance, .. }) = outside {
                counts.outside += 1;
                counts.outside_by = counts.outside_by.max(distance);
            }
        } else if matches!(kind, Kind::Weights(_)) && !are_weights(&stored(channels, pixel)) {
            counts.outside += 1;
        }
    }
    counts
}

/// Returns whether stored weights, given by their ranges before rounding, may be weights that sum to 1.
fn are_weights(ends: &[(f64, f64)]) -> bool {
    let legal = ends.iter().all(|(low, high)| *low <= 1.0 && *high >= 0.0);
    let [least, most] = [ends.iter().map(|ends| ends.0).sum::<f64>(), ends.iter().map(|ends| ends.1).sum()];
    // Each weight was rounded to f32. For a mask, the file stores one of its two weights.
    let slack = LITERAL * ends.len() as f64;
    legal && (ends.len() == 1 || (least <= 1.0 + slack && most >= 1.0 - slack))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_image::{Plane, Window, WorkingSpace};
    use trochoid_io::SampleType;

    fn channel(samples: &[f32]) -> StoredChannel {
        let window = Window::sized(samples.len() as u32, 1);
        let mut plane = Plane::filled(window, 0.0);
        plane.samples_mut().copy_from_slice(samples);
        StoredChannel { name: "Y".into(), stored: SampleType::Float, plane }
    }

    #[test]
    fn every_pixel_is_counted_by_what_it_is() {
        let (nan, infinite) = (f32::NAN, f32::INFINITY);
        let [r, g, b] = [
            channel(&[0.5, nan, infinite, 0.5, 0.25]),
            channel(&[0.5, infinite, 0.5, 0.5, 0.25]),
            channel(&[0.5, 0.5, 0.5, 0.75, 0.25]),
        ];
        let palette = Palette::new(&[[0.0; 3], [1.0; 3]], 1e-6);
        let coding = Coding::new(Kind::Color, WorkingSpace::LinearSrgb, false);
        let found = counts(Kind::Color, coding, &[&r, &g, &b], Some(&palette));
        assert_eq!((found.pixels, found.nan, found.infinite, found.outside), (5, 1, 1, 1));
        assert!((found.outside_by - 0.25 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-12, "{}", found.outside_by);
        let field = counts(Kind::Field(1), Coding::None, &[&r], None);
        assert_eq!((field.nan, field.infinite, field.outside), (1, 1, 0));
        let weights = counts(Kind::Weights(3), Coding::None, &[&r, &g, &b], None);
        assert_eq!((weights.nan, weights.infinite, weights.outside), (1, 1, 3), "these sum to 1.5, 1.75 and 0.75");
        let mask = counts(Kind::MASK, Coding::None, &[&channel(&[0.0, 1.0, 1.5, -0.1])], None);
        assert_eq!((mask.nan, mask.outside), (0, 2));
    }
}
