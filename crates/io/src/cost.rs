//! Memory needed to read image files, from their headers.

use std::path::Path;

use trochoid_image::Window;

use crate::source::{self};
use crate::{Error, ExrReader, FileKind, Limits, Selection, raster};

/// Memory needed to read a file, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Memory held afterward: an f32 for each pixel and channel.
    pub held: u64,
    /// Maximum additional memory during decoding.
    pub decoding: u64,
}

/// Returns the memory needed to read a selection, judging only by the file's header: of the whole picture or, if only
/// `window` is kept, of that part.
///
/// ```
/// use trochoid_image::Window;
/// use trochoid_io::{Limits, PngImage, Samples, Selection, cost, write_png8};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("swatch.png");
/// write_png8(&path, &PngImage::new(8, 4, Samples::rgb(&[[0.5; 3]; 32])))?;
/// let (all, limits) = (Selection::default(), Limits::default());
/// assert_eq!(cost(&path, &all, None, &limits)?.held, 4 * 3 * 8 * 4);
/// assert_eq!(cost(&path, &all, Some(Window::sized(2, 2)), &limits)?.held, 4 * 3 * 2 * 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// The file cannot be opened, is not a picture, its header is damaged, holds something that is not supported, or lacks
/// what is selected.
pub fn cost(
    path: impl AsRef<Path>,
    selection: &Selection,
    window: Option<Window>,
    limits: &Limits,
) -> Result<Cost, Error> {
    let mut source = source::open(path.as_ref())?;
    let (data, channels, decoding) = match source.kind()? {
        FileKind::Exr => {
            let reader = ExrReader::of(source, selection, limits)?;
            (reader.info().data, reader.info().channels.len(), reader.decoding())
        }
        kind => {
            let (part, form) = raster::info(&mut source, kind)?;
            let found = selection.resolve(&source.path, std::slice::from_ref(&part))?;
            (part.data, found.channels.len(), form.decoding())
        }
    };
    let kept = window.map_or(data, |window| window.intersect(data));
    let held = (kept.area() as u64).saturating_mul(channels as u64).saturating_mul(4);
    Ok(Cost { held, decoding })
}
