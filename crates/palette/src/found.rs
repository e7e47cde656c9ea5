//! What is found in a cloud of colors.

use crate::Cloud;
use crate::order::names;
use crate::vector::{Point, length, sub};
use rayon::prelude::*;
use trochoid_weights::Hull;

/// Volume up to which a palette is the default, relative to that of the pixels' hull: palettes of fewer colors are loud.
pub(crate) const QUIET: f64 = 2.5;

/// Colors with names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Palette {
    /// Colors as displayed, from 0 to 1.
    pub colors: Vec<[f64; 3]>,
    /// A name for each color.
    pub names: Vec<String>,
    /// Parts into which the grid of the colors divides a step of 8 bits: 1, 16 or 256.
    pub units: u32,
}

impl Palette {
    /// Returns displayed colors, from 0 to 1, with names by their lightness and hue.
    #[must_use]
    pub fn named(colors: Vec<[f64; 3]>, units: u32) -> Self {
        Self { names: names(&colors, &[]), colors, units }
    }

    fn hull(&self) -> Hull {
        // Counted in steps, colors are exact in f32, on any of the grids.
        let parts = f64::from(self.units.max(1));
        let exact = |v: f64| ((255.0 * parts * v).round() / parts) as f32;
        Hull::new(&self.colors.iter().map(|color| color.map(exact)).collect::<Vec<_>>())
    }

    /// Returns whether no color, in steps of 8 bits, is farther outside than allowed. The distance from a hull is a convex
    /// function, so the extreme colors decide for all.
    pub(crate) fn is_near(&self, extremes: &[Point], within: f64) -> bool {
        let hull = self.hull();
        extremes.iter().all(|color| hull.signed_distance(*color) <= within)
    }

    /// Returns how the pixels of a cloud lie outside of the hull.
    #[must_use]
    pub fn outside(&self, cloud: &Cloud) -> Outside {
        Outside::of(&self.hull(), cloud)
    }

    /// Returns the colors that are no corners of the hull: they lie within that of the others.
    #[must_use]
    pub fn inner(&self) -> Vec<usize> {
        let corners: Vec<[f64; 3]> = self.hull().vertices().iter().map(|corner| corner.map(f64::from)).collect();
        let is_at = |corner: &[f64; 3], color: &[f64; 3]| (0..3).all(|c| (corner[c] - 255.0 * color[c]).abs() < 1e-3);
        (0..self.colors.len())
            .filter(|index| !corners.iter().any(|corner| is_at(corner, &self.colors[*index])))
            .collect()
    }
}

/// Pixels outside of a hull.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outside {
    /// Number of pixels outside.
    pub pixels: u64,
    /// Largest distance of a pixel from the hull, in steps of 8 bits.
    pub largest: f64,
    /// Root mean square of the distances of all pixels, in steps of 8 bits.
    pub rms: f64,
}

impl Outside {
    pub(crate) fn of(hull: &Hull, cloud: &Cloud) -> Self {
        let colors: Vec<([u8; 3], u32)> = cloud.colors().collect();
        let distances: Vec<f64> =
            colors.par_iter().map(|(color, _)| hull.signed_distance(color.map(f64::from))).collect();
        let mut all = Self::default();
        let mut squares = 0.0;
        for ((_, count), distance) in colors.iter().zip(distances) {
            if distance > 1e-9 {
                all.pixels += u64::from(*count);
                all.largest = all.largest.max(distance);
                squares += distance * distance * f64::from(*count);
            }
        }
        all.rms = (squares / cloud.pixels().max(1) as f64).sqrt();
        all
    }
}

/// A palette that encloses every pixel, up to the distance that is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct Enclosing {
    /// The colors: prior ones first, then the darkest of the others.
    pub palette: Palette,
    /// Volume of the hull, relative to that of the pixels' hull with the prior colors; 1 if that has none.
    pub volume: f64,
    /// Distance of each color from the nearest pixel, in steps of 8 bits.
    pub distances: Vec<f64>,
    /// Pixels outside, no farther than allowed.
    pub outside: Outside,
}

impl Enclosing {
    /// Measures a palette of a cloud with these extreme colors.
    pub(crate) fn new(palette: Palette, volume: f64, extremes: &[Point], outside: Outside) -> Self {
        let distance = |color: &[f64; 3]| {
            let point = color.map(|v| 255.0 * v);
            extremes.iter().map(|extreme| length(sub(*extreme, point))).fold(f64::INFINITY, f64::min)
        };
        let distances = palette.colors.iter().map(distance).collect();
        Self { palette, volume, distances, outside }
    }

    /// Returns the number of colors.
    #[must_use]
    pub fn count(&self) -> usize {
        self.palette.colors.len()
    }
}

/// A palette of fewer colors than any that was found to enclose every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Short {
    /// Colors as displayed, from 0 to 1, in whole steps of 8 bits; prior ones first, then the darkest of the others.
    pub colors: Vec<[f64; 3]>,
    /// Share of the pixels that lie outside.
    pub share: f64,
    /// Pixels outside.
    pub outside: Outside,
}

/// Palettes of a cloud.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extraction {
    /// Number of different colors of the pixels, each rounded to 8 bits.
    pub distinct: usize,
    /// Number of corners of the hull of the pixels and the prior colors.
    pub corners: usize,
    /// Palettes that enclose every pixel, of up to 12 colors beside the prior ones, by their number of colors: each in a
    /// smaller hull than those of fewer colors, unless these are flat.
    pub enclosing: Vec<Enclosing>,
    /// Palettes of fewer colors than these, by their number of colors.
    pub short: Vec<Short>,
}

impl Extraction {
    /// Returns the palette to take if nobody asks for a number of colors: the one of the fewest colors whose hull has at
    /// most 2.5 times the volume of the pixels' hull, in whole steps of 8 bits if there is one; or else the one of the
    /// least volume.
    #[must_use]
    pub fn usual(&self) -> Option<&Enclosing> {
        let quiet = || self.enclosing.iter().filter(|found| found.volume <= QUIET);
        let whole = quiet().find(|found| found.palette.units == 1);
        whole.or_else(|| quiet().next()).or_else(|| self.enclosing.iter().min_by(|a, b| a.volume.total_cmp(&b.volume)))
    }

    /// Returns the palette of the fewest colors.
    #[must_use]
    pub fn fewest(&self) -> Option<&Enclosing> {
        self.enclosing.first()
    }

    /// Returns the palette of a number of colors.
    #[must_use]
    pub fn of(&self, colors: usize) -> Option<&Enclosing> {
        self.enclosing.iter().find(|found| found.count() == colors)
    }
}
