//! Colors of pictures, as `Read` reads them.

use crate::failure::{FAILED, Failure};
use crate::remedies;
use serde_json::json;
use std::path::Path;
use trochoid::io::{self, Limits};
use trochoid::{Access, Buffers, Cache, Monitor, Plan, Settings, Window, escape_frame, parse_within};
use trochoid_palette::Cloud;

/// Part of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    /// Columns from the left, and rows from the top.
    at: [u32; 2],
    /// Width and height.
    size: [u32; 2],
}

/// Text that is no region.
#[derive(Debug, thiserror::Error)]
#[error("expected four whole numbers, such as 0,0,1920,400, with a width and a height above 0")]
pub(super) struct NoRegion;

/// Parses a region.
pub(super) fn region(text: &str) -> Result<Region, NoRegion> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    match numbers.map_err(|_| NoRegion)?[..] {
        [x, y, width, height] if width > 0 && height > 0 => Ok(Region { at: [x, y], size: [width, height] }),
        _ => Err(NoRegion),
    }
}

impl Region {
    fn contains(self, place: [usize; 2]) -> bool {
        (0..2).all(|axis| {
            let (at, end) = (u64::from(self.at[axis]), u64::from(self.at[axis]) + u64::from(self.size[axis]));
            (at..end).contains(&(place[axis] as u64))
        })
    }
}

/// Adds the pixels of a picture to a cloud: those in one of the regions, if there are any. Returns the number of pixels
/// that are brighter than white.
///
/// # Errors
/// The picture cannot be read, has illegal values, or has no pixel in the regions.
pub(super) fn read(path: &Path, regions: &[Region], cloud: &mut Cloud, monitor: &dyn Monitor) -> Result<u64, Failure> {
    let (window, colors) = self::colors(path, monitor)?;
    let width = window.width();
    let before = cloud.pixels();
    let mut brighter = 0;
    for (index, color) in colors.iter().enumerate() {
        let place = [index % width, index / width];
        if !regions.is_empty() && !regions.iter().any(|region| region.contains(place)) {
            continue;
        }
        let color = color.map(|channel| 255.0 * f64::from(channel));
        brighter += u64::from(color.iter().any(|channel| *channel > 255.0 + 1e-4));
        cloud.add_between(color);
    }
    if cloud.pixels() == before {
        let (name, height) = (path.display(), window.height());
        let message = format!("{name}: found {width} × {height} pixels, none of them in a --region");
        return Err(Failure::usage(message, "correct the region: x and y are of its upper left corner, in pixels"));
    }
    Ok(brighter)
}

/// Returns the colors of a picture as displayed, row by row.
///
/// # Errors
/// The picture cannot be read, or has illegal values.
pub(crate) fn colors(path: &Path, monitor: &dyn Monitor) -> Result<(Window, Vec<[f32; 3]>), Failure> {
    let info = io::info(path, &Limits::default()).map_err(|error| Failure::new(FAILED, error))?;
    let part = &info.parts[0];
    let [width, height] = [part.display.width(), part.display.height()];
    let file = trochoid::resolved(path);
    let document = json!({
        "trochoid": 1,
        "format": { "width": width, "height": height },
        "working_space": "srgb",
        "nodes": { "picture": { "type": "Read", "file": escape_frame(&file.to_string_lossy()), "as": "color" } },
        "outputs": { "picture": { "color": "picture" } },
    });
    let name = path.display().to_string();
    let loaded = parse_within(&name, &document.to_string(), Path::new("."), &[], Access::everything())?;
    let failed = |error: &trochoid::EvalError| Failure::new(FAILED, remedies::evaluation(error));
    let plan = Plan::new(&loaded.graph, &["picture"], 1, &[], &Settings::default())
        .map_err(|error| Failure::new(FAILED, error))?;
    let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), monitor).map_err(|error| failed(&error))?;
    let [r, g, b] = [0, 1, 2].map(|channel| frame.pictures[0].planes[channel].samples());
    let colors = r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]).collect();
    Ok((frame.window, colors))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_four_numbers() {
        let region = super::region("10, 20,30,40").unwrap();
        assert_eq!(region, Region { at: [10, 20], size: [30, 40] });
        assert!(region.contains([10, 20]) && region.contains([39, 59]));
        assert!(!region.contains([40, 20]) && !region.contains([9, 20]));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "1,2,0,4", "a,2,3,4", "-1,2,3,4"] {
            assert!(super::region(wrong).is_err(), "{wrong}");
        }
    }
}
