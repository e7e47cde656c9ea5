//! Pixels that settings change.

use super::errors::distance;
use trochoid_engine::Picture;
use trochoid_graph::Kind;
use trochoid_image::{Window, WorkingSpace};

/// Pixels at which pictures differ.
#[derive(Debug, Default)]
pub(super) struct Apart {
    /// Pixels at which not all pictures are equal, by index in the window, the largest difference first.
    pub(super) pixels: Vec<usize>,
    /// Pixels at which a picture differs most from the last one.
    pub(super) most: Vec<usize>,
}

impl Apart {
    /// Compares each picture with the last one, in display values.
    pub(super) fn new(pictures: &[&Picture], space: WorkingSpace) -> Self {
        let Some((last, others)) = pictures.split_last() else { return Self::default() };
        let area = last.planes.first().map_or(0, |plane| plane.samples().len());
        let mut largest: Vec<f64> = vec![-1.0; area];
        let mut most = Vec::new();
        for other in others {
            let mut worst: Option<(f64, usize)> = None;
            for (pixel, largest) in largest.iter_mut().enumerate() {
                let same = |(a, b): (&trochoid_image::Plane, &trochoid_image::Plane)| {
                    a.samples()[pixel].to_bits() == b.samples()[pixel].to_bits()
                };
                if other.planes.iter().zip(&last.planes).all(same) {
                    continue;
                }
                let [a, b] = [other, last].map(|picture| shown(picture.kind, &values(picture, pixel), space));
                let apart = a.iter().zip(&b).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max);
                *largest = largest.max(apart);
                if worst.is_none_or(|(most, _)| apart > most) {
                    worst = Some((apart, pixel));
                }
            }
            most.extend(worst.map(|(_, pixel)| pixel));
        }
        let mut pixels: Vec<usize> = (0..area).filter(|pixel| largest[*pixel] >= 0.0).collect();
        pixels.sort_by(|a, b| largest[*b].total_cmp(&largest[*a]).then(a.cmp(b)));
        most.sort_unstable();
        most.dedup();
        Self { pixels, most }
    }
}

/// Returns a pixel of a picture, by channel.
pub(super) fn values(picture: &Picture, pixel: usize) -> Vec<f64> {
    picture.planes.iter().map(|plane| f64::from(plane.samples()[pixel])).collect()
}

/// Returns what a display shows of a value: colors are encoded, and limited to [0, 1].
pub(super) fn shown(kind: Kind, value: &[f64], space: WorkingSpace) -> Vec<f64> {
    match (kind, value) {
        (Kind::Color, [r, g, b]) => space.to_display([*r, *g, *b]).map(|channel| channel.clamp(0.0, 1.0)).to_vec(),
        _ => value.to_vec(),
    }
}

/// Returns the place of a pixel.
pub(super) fn place(window: Window, pixel: usize) -> [i64; 2] {
    [window.x0 + (pixel % window.width()) as i64, window.y0 + (pixel / window.width()) as i64]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use trochoid_engine::{Audit, Picture};
    use trochoid_image::Plane;

    /// A mask of one row.
    pub(in crate::accuracy::ladder) fn picture(samples: &[f32]) -> Picture {
        let mut plane = Plane::filled(Window::sized(samples.len() as u32, 1), 0.0);
        plane.samples_mut().copy_from_slice(samples);
        Picture {
            output: 0,
            kind: Kind::MASK,
            planes: vec![plane],
            guarantee: None,
            audit: Audit::default(),
            control_count: 0,
            control_colors: Vec::new(),
            hull: None,
            margin: 0.0,
        }
    }

    #[test]
    fn pixels_that_differ_are_found_and_sorted_by_how_much() {
        let coarse = picture(&[0.5, 0.5, 0.25, 0.0, 0.75]);
        let fine = picture(&[0.5, 0.5, 0.5, 0.0, 0.5]);
        let finest = picture(&[0.5, 0.5, 0.5, -0.0, 1.0]);
        let apart = Apart::new(&[&coarse, &fine, &finest], WorkingSpace::Srgb);
        assert_eq!(apart.pixels, [4, 2, 3], "signs of 0 differ, too");
        assert_eq!(apart.most, [2, 4]);
        assert!(Apart::new(&[&fine], WorkingSpace::Srgb).pixels.is_empty());
        assert!(Apart::new(&[], WorkingSpace::Srgb).pixels.is_empty());
    }

    #[test]
    fn displays_show_colors_from_0_to_1() {
        let shown = shown(Kind::Color, &[-1.0, 1.0, 0.5], WorkingSpace::LinearSrgb);
        assert!(shown[0] == 0.0 && (shown[1] - 1.0).abs() < 1e-12 && (shown[2] - 0.7354).abs() < 1e-3, "{shown:?}");
    }
}
