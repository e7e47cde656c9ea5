//! The painting that a picture is fitted to.

use super::lab::Lab;
use super::picture::Weighed;
use super::{aligned, sliced};
use crate::failure::Failure;
use crate::palette::source;
use crate::progress::Progress;
use std::path::Path;
use trochoid::WorkingSpace;

/// What is compared.
pub(super) enum Painting {
    /// The displayed colors at the picture's pixels.
    Aligned(Vec<[f64; 3]>),
    /// Colors in OKLab, from anywhere.
    Cloud(Vec<[f64; 3]>),
}

impl Painting {
    /// Reads a painting at some pixels of a picture of this size.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn aligned(
        path: &Path,
        size: [usize; 2],
        pixels: &[usize],
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let all = source::scaled(path, size, progress)?;
        Ok(Self::Aligned(pixels.iter().map(|pixel| all[*pixel].map(f64::from)).collect()))
    }

    /// Reads the colors of a painting.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn cloud(path: &Path, progress: &Progress) -> Result<Self, Failure> {
        let (_, all) = source::colors(path, progress)?;
        Ok(Self::Cloud(sliced::cloud(&all)))
    }

    /// Returns the colors in which a picture comes nearest, with a pull to those before, all in the working space.
    pub(super) fn fit(
        &self,
        picture: &Weighed,
        before: &[[f64; 3]],
        keep: Option<f64>,
        space: WorkingSpace,
    ) -> Vec<[f64; 3]> {
        match self {
            Self::Aligned(shown) => {
                let target = shown.iter().map(|color| space.from_linear_srgb(color.map(trochoid::srgb_decode)));
                aligned::fit(picture, &target.collect::<Vec<_>>(), before, keep.unwrap_or(1e-3))
            }
            Self::Cloud(cloud) => sliced::fit(picture, cloud, before, keep.unwrap_or(0.2), Lab::of(space)),
        }
    }

    /// Returns the distance of a picture in some colors.
    pub(super) fn distance(&self, picture: &Weighed, colors: &[[f64; 3]], space: WorkingSpace) -> f64 {
        match self {
            Self::Aligned(shown) => {
                let square = |(pixel, shown): (usize, &[f64; 3])| -> f64 {
                    let own = space.to_display(picture.mixed(pixel, colors));
                    own.iter().zip(shown).map(|(a, b)| (a - b) * (a - b)).sum()
                };
                let sum: f64 = shown.iter().enumerate().map(square).sum();
                libm::sqrt(sum / (3 * shown.len().max(1)) as f64)
            }
            Self::Cloud(cloud) => sliced::distance(picture, cloud, colors, Lab::of(space)),
        }
    }
}
