//! Parts of pictures, and the colors that a painter would take off them.

use std::ops::Range;
use trochoid_palette::{Palette, Tones};

/// Part of a picture, in pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Region {
    name: Option<String>,
    /// Columns from the left, and rows from the top.
    at: [u32; 2],
    /// Width and height.
    size: [u32; 2],
}

/// Text that is no region.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoRegion {
    #[error("expected four whole numbers, such as 0,0,1920,400, with a width and a height above 0")]
    Numbers,
    #[error("expected a name of letters, digits and _ before the =, such as sky=0,0,1920,400")]
    Name,
}

/// Parses a region.
pub(super) fn region(text: &str) -> Result<Region, NoRegion> {
    let (name, numbers) = text.split_once('=').map_or((None, text), |(name, numbers)| (Some(name.trim()), numbers));
    let is_word = |name: &str| {
        name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if !name.is_none_or(is_word) {
        return Err(NoRegion::Name);
    }
    let numbers: Result<Vec<u32>, _> = numbers.split(',').map(|number| number.trim().parse()).collect();
    match numbers.map_err(|_| NoRegion::Numbers)?[..] {
        [x, y, width, height] if width > 0 && height > 0 => {
            Ok(Region { name: name.map(str::to_owned), at: [x, y], size: [width, height] })
        }
        _ => Err(NoRegion::Numbers),
    }
}

impl Region {
    /// Returns the columns and rows within a picture of this width and height.
    fn within(&self, size: [usize; 2]) -> [Range<usize>; 2] {
        [0, 1].map(|axis| {
            let end = u64::from(self.at[axis]) + u64::from(self.size[axis]);
            self.at[axis] as usize..(end as usize).min(size[axis])
        })
    }

    /// Returns whether a place of a picture of this width and height is in the region.
    pub(super) fn contains(&self, place: [usize; 2], size: [usize; 2]) -> bool {
        contains(&self.within(size), place)
    }
}

fn contains(part: &[Range<usize>; 2], place: [usize; 2]) -> bool {
    (0..2).all(|axis| part[axis].contains(&place[axis]))
}

/// Parts of a region whose colors are taken, with what their names have.
const PARTS: [&str; 5] = ["", "_top_left", "_top_right", "_bottom_left", "_bottom_right"];

/// Parts of the width and of the height of a region that its corners have.
const CORNER: usize = 4;

/// Share of the pixels that are its darkest or brightest.
const SHARE: f64 = 0.1;

/// Returns the columns and rows of a region's [`PARTS`]: of all of it, and of its corners.
fn parts([columns, rows]: &[Range<usize>; 2]) -> [[Range<usize>; 2]; 5] {
    let start = |range: &Range<usize>| range.start..range.start + range.len().div_ceil(CORNER);
    let end = |range: &Range<usize>| range.end - range.len().div_ceil(CORNER)..range.end;
    [
        [columns.clone(), rows.clone()],
        [start(columns), start(rows)],
        [end(columns), start(rows)],
        [start(columns), end(rows)],
        [end(columns), end(rows)],
    ]
}

/// Colors of regions and their corners.
pub(super) struct RegionTones<'r> {
    regions: &'r [Region],
    tones: Vec<[Tones; 5]>,
}

impl<'r> RegionTones<'r> {
    pub(super) fn new(regions: &'r [Region]) -> Self {
        Self { regions, tones: regions.iter().map(|_| Default::default()).collect() }
    }

    /// Adds a pixel of a picture of this width and height.
    pub(super) fn add(&mut self, place: [usize; 2], size: [usize; 2], color: [f64; 3]) {
        for (region, tones) in self.regions.iter().zip(&mut self.tones) {
            let within = region.within(size);
            if contains(&within, place) {
                let parts = parts(&within);
                let inside = tones.iter_mut().zip(&parts).filter(|(_, part)| contains(part, place));
                inside.for_each(|(tones, _)| tones.add(color));
            }
        }
    }

    /// Returns the darkest and the brightest color of each region and of each corner that has pixels, in whole steps of
    /// 8 bits, with their names.
    pub(super) fn palette(&self) -> Palette {
        let mut palette = Palette { units: 1, ..Palette::default() };
        for (index, (region, tones)) in self.regions.iter().zip(&self.tones).enumerate() {
            let name = region.name.clone().unwrap_or_else(|| format!("region_{}", index + 1));
            for (part, tones) in PARTS.iter().zip(tones) {
                for (color, word) in [(tones.darkest(SHARE), "dark"), (tones.brightest(SHARE), "light")] {
                    let Some(color) = color else { continue };
                    palette.colors.push(color.map(|v| (255.0 * v).round().clamp(0.0, 255.0) / 255.0));
                    palette.names.push(format!("{name}{part}_{word}"));
                }
            }
        }
        palette
    }

    /// Returns a name that two regions have, if there is one.
    pub(super) fn twice(regions: &[Region]) -> Option<&str> {
        let names: Vec<&str> = regions.iter().filter_map(|region| region.name.as_deref()).collect();
        names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)).map(|(_, name)| *name)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn regions_are_four_numbers_and_perhaps_a_name() {
        let region = super::region("10, 20,30,40").unwrap();
        assert_eq!(region, Region { name: None, at: [10, 20], size: [30, 40] });
        assert_eq!(super::region("sky=10,20,30,40").unwrap(), Region { name: Some("sky".into()), ..region.clone() });
        let size = [100, 50];
        assert!(region.contains([10, 20], size) && region.contains([39, 49], size));
        assert!(!region.contains([40, 20], size) && !region.contains([9, 20], size));
        for wrong in
            ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "a,2,3,4", "-1,2,3,4", "=1,2,3,4", "a b=1,2,3,4", "a=", "1=1,2,3,4"]
        {
            assert!(super::region(wrong).is_err(), "{wrong}");
        }
        let end = super::region("4294967295,0,4294967295,1").unwrap();
        assert!(!end.contains([0, 0], size));
    }

    #[test]
    fn corners_have_a_sixteenth_of_what_the_picture_has_of_a_region() {
        let region = super::region("sea=2,2,100,8").unwrap();
        assert_eq!(
            parts(&region.within([10, 20])),
            [[2..10, 2..10], [2..4, 2..4], [8..10, 2..4], [2..4, 8..10], [8..10, 8..10]]
        );
        // A single pixel is all of its corners.
        assert_eq!(parts(&[3..4, 5..6])[4], [3..4, 5..6]);
        let regions = [region];
        let mut tones = RegionTones::new(&regions);
        for y in 0..20 {
            for x in 0..10 {
                let is_corner = x < 4 && y < 4;
                tones.add([x, y], [10, 20], [if is_corner { 0.2 } else { 0.6 }; 3]);
            }
        }
        let palette = tones.palette();
        assert_eq!((palette.names.len(), palette.names[0].as_str()), (10, "sea_dark"));
        let of = |name: &str| {
            let index = palette.names.iter().position(|own| own == name).unwrap();
            (255.0 * palette.colors[index][0]).round()
        };
        // Four of 64 pixels are dark, so the darkest tenth is a mean.
        let mixed = (255.0 * (4.0 * 0.2 + 2.4 * 0.6) / 6.4_f64).round();
        assert_eq!((of("sea_dark"), of("sea_light")), (mixed, 153.0));
        assert_eq!((of("sea_top_left_light"), of("sea_bottom_right_dark")), (51.0, 153.0));
    }
}
