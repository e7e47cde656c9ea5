//! Joining of tiles, which are pictures of regions of one picture, to the file that a render of the whole would write.

mod exr;
mod merge;
mod png;

use crate::files::{folder_of_file, target};
use crate::{Form, OutputError};
use std::path::{Path, PathBuf};
use trochoid_engine::Monitor;
use trochoid_image::Window;
use trochoid_io::{FileKind, Limits, PartInfo};

/// Metadata key of a PNG tile: its region, and the size of the whole picture.
pub(crate) const REGION: &str = "trochoid:region";

/// Largest number of tiles of one picture, which are open at the same time.
const MOST: usize = 512;

/// A joined picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joined {
    /// Pixels of the picture.
    pub window: Window,
    /// Number of its tiles.
    pub tiles: usize,
}

/// Reason that tiles are not joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// A tile cannot be read.
    #[error(transparent)]
    Read(#[from] trochoid_io::Error),
    /// The picture cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// A tile does not belong to the others.
    #[error("{}: found {found}; expected {expected}", path.display())]
    Tile {
        /// Path of the tile.
        path: PathBuf,
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// The tiles are not those of a whole picture.
    #[error("found {found}; expected {expected}")]
    Tiles {
        /// What was found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// There is not enough memory.
    #[error("found a picture of {0} bytes; expected one that fits in memory: render tiles and picture as EXR")]
    Memory(u64),
    /// The monitor has stopped it.
    #[error("cancelled")]
    Cancelled,
}

/// A tile, as its header describes it.
struct Tile {
    path: PathBuf,
    part: PartInfo,
    /// Region of the picture, in pixels.
    region: Window,
    metadata: Vec<(String, String)>,
}

impl Tile {
    fn read(path: &Path, kind: FileKind) -> Result<(Self, Window), JoinError> {
        let found = trochoid_io::info(path, &Limits::default())?;
        let is_other = found.kind != kind || found.parts.len() != 1;
        let metadata = trochoid_io::read_metadata(path)?;
        let mut parts = found.parts;
        let tile = |part: PartInfo| Self { path: path.into(), region: part.data, part, metadata };
        let mut tile = match parts.pop() {
            Some(part) if !is_other => tile(part),
            _ => {
                let (found, expected) = (format!("a {} file of {} parts", found.kind, parts.len() + 1), kind);
                return Err(JoinError::Tile {
                    path: path.into(),
                    found,
                    expected: format!("a {expected} file of one"),
                });
            }
        };
        trochoid_io::check_whole(path)?;
        let mut whole = tile.part.display;
        if kind == FileKind::Png {
            let region = tile.entry(REGION).and_then(read_region).filter(|(region, _)| {
                (region.width(), region.height()) == (tile.part.data.width(), tile.part.data.height())
            });
            let (region, picture) =
                region.ok_or_else(|| tile.fault("a picture that is no tile", "one of `trochoid render --region`"))?;
            (tile.region, whole) = (region, picture);
        }
        Ok((tile, whole))
    }

    fn entry(&self, key: &str) -> Option<&str> {
        self.metadata.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    fn fault(&self, found: impl Into<String>, expected: impl Into<String>) -> JoinError {
        JoinError::Tile { path: self.path.clone(), found: found.into(), expected: expected.into() }
    }

    /// Returns the names of the channels with the types of their samples.
    fn channels(&self) -> Vec<(String, trochoid_io::SampleType)> {
        self.part.channels.iter().map(|channel| (channel.full_name.clone(), channel.sample_type)).collect()
    }
}

/// Describes a region and its picture: `128,64,32,32 of 256,128`.
pub(crate) fn region_text(region: Window, picture: Window) -> String {
    let Window { x0, y0, .. } = region;
    format!("{x0},{y0},{},{} of {},{}", region.width(), region.height(), picture.width(), picture.height())
}

fn read_region(text: &str) -> Option<(Window, Window)> {
    let (region, picture) = text.split_once(" of ")?;
    let numbers = |text: &str| text.split(',').map(|number| number.parse::<u32>().ok()).collect::<Option<Vec<_>>>();
    let ([x, y, width, height], [w, h]) = (numbers(region)?.try_into().ok()?, numbers(picture)?.try_into().ok()?);
    let [x, y] = [x, y].map(i64::from);
    Some((Window::new(x, y, x + i64::from(width), y + i64::from(height)), Window::sized(w, h)))
}

/// Joins tiles to the file that rendering the whole picture would have written, byte by byte, in any order. The file's
/// ending selects EXR or PNG, which the tiles must be, too. EXR is joined band by band, so that memory does not grow
/// with the height of the picture; a PNG is joined in memory.
///
/// # Errors
/// A tile cannot be read, is no tile, or is one of another picture; pixels are missing, or two tiles have the same ones;
/// or the file cannot be written.
pub fn join(tiles: &[PathBuf], file: &Path, overwrite: bool, monitor: &dyn Monitor) -> Result<Joined, JoinError> {
    let is_png = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let (kind, form) = if is_png { (FileKind::Png, Form::Png) } else { (FileKind::Exr, Form::Exr) };
    if tiles.len() > MOST || tiles.is_empty() {
        let (found, expected) = (format!("{} tiles", tiles.len()), format!("1 to {MOST}"));
        return Err(JoinError::Tiles { found, expected });
    }
    let read = tiles.iter().map(|path| Tile::read(path, kind)).collect::<Result<Vec<_>, _>>()?;
    let whole = read[0].1;
    let same = |(tile, other): &(Tile, Window)| {
        let size = |window: &Window| format!("a tile of {} × {} pixels", window.width(), window.height());
        if *other != whole {
            return Err(tile.fault(size(other), size(&whole)));
        }
        if tile.channels() != read[0].0.channels() {
            return Err(tile.fault("other channels", format!("those of {}", read[0].0.path.display())));
        }
        Ok(())
    };
    read.iter().try_for_each(same)?;
    let tiles: Vec<Tile> = read.into_iter().map(|(tile, _)| tile).collect();
    partition(&tiles, whole)?;
    let metadata = merge::merged(&tiles)?;
    folder_of_file(file)?;
    let target = target(file, form, overwrite);
    if is_png {
        png::write(&tiles, whole, &metadata, target, monitor)?;
    } else {
        exr::write(&tiles, whole, &metadata, target, monitor)?;
    }
    Ok(Joined { window: whole, tiles: tiles.len() })
}

/// Checks that each pixel of the picture lies in one tile.
fn partition(tiles: &[Tile], whole: Window) -> Result<(), JoinError> {
    for (index, tile) in tiles.iter().enumerate() {
        if tile.region.intersect(whole) != tile.region {
            return Err(tile.fault(format!("pixels {}", tile.region), format!("some of {whole}")));
        }
        if let Some(other) = tiles[..index].iter().find(|other| !other.region.intersect(tile.region).is_empty()) {
            let found = format!("pixels {}", tile.region.intersect(other.region));
            return Err(tile.fault(found, format!("each pixel once; {} has them, too", other.path.display())));
        }
    }
    let found: usize = tiles.iter().map(|tile| tile.region.area()).sum();
    if found != whole.area() {
        let missing = whole.area() - found;
        let found = format!("{} tiles without {missing} of {} pixels", tiles.len(), whole.area());
        return Err(JoinError::Tiles { found, expected: format!("tiles of all pixels {whole}") });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_are_read_as_they_are_written() {
        let (region, picture) = (Window::new(128, 64, 160, 96), Window::sized(256, 128));
        assert_eq!(region_text(region, picture), "128,64,32,32 of 256,128");
        assert_eq!(read_region("128,64,32,32 of 256,128"), Some((region, picture)));
        for text in ["", "1,2,3 of 4,5", "1,2,3,4", "1,2,3,4 of 5", "-1,2,3,4 of 5,6", "1,2,3,4 of 5,6,7"] {
            assert_eq!(read_region(text), None, "{text}");
        }
    }
}
