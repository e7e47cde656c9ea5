//! Image files: EXR with layers, parts, tiles and windows; PNG, JPEG and TIFF; metadata and atomic writing.
//!
//! [`info`] reads a header, and [`read`] decodes a [`Selection`]. [`write_exr`], [`write_png8`] and [`write_png16`]
//! write pictures with metadata, [`read_metadata`] returns these metadata, and [`check_whole`] tells whether such a
//! file is complete. [`ExrReader`] and [`ExrWriter`] work band by band, from many threads, without holding the whole
//! picture. [`write_bytes`] writes any other file as safely; [`discard_partial_files`] removes partial files before a
//! process exits early.
//!
//! All files that are read by name, here or in other crates, are opened by [`open_file`], [`read_bytes`] or
//! [`read_text`], so that no pipe blocks and no device is read forever. Without the feature `pictures` the crate has
//! only these functions.
//!
//! Every header is checked against [`Limits`] before anything is allocated for pixels: a file of a few hundred bytes
//! can claim a picture of many gigabytes. A damaged file is an [`Error`] that names the place, never a panic.
//!
//! Values are returned as stored: floats of EXR and TIFF unchanged, integers of EXR as f32, those of PNG, JPEG and TIFF
//! divided by their maximum and still encoded for display ([`Encoding::Srgb`]). Palettes, CMYK and YCbCr are converted
//! to RGB. Orientation tags are applied, embedded color profiles are not.
//!
//! ```
//! use trochoid_image::{Plane, Window};
//! use trochoid_io::{ExrChannel, ExrImage, Limits, Samples, Selection, read, write_exr};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("depth.exr");
//! let depth = Plane::filled(Window::sized(4, 2), 12.5);
//! write_exr(&path, &ExrImage {
//!     channels: vec![ExrChannel::float("depth.Z", Samples::plane(&depth))],
//!     metadata: vec![("trochoid:frame".into(), "17".into())],
//!     ..ExrImage::new(Window::sized(4, 2))
//! })?;
//!
//! let picture = read(&path, &Selection::layer("depth"), &Limits::default())?;
//! assert_eq!(picture.channel("Z"), Some(&depth));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

#[cfg(feature = "pictures")]
mod atomic;
#[cfg(feature = "pictures")]
mod claim;
#[cfg(feature = "pictures")]
mod cost;
mod describe;
mod error;
#[cfg(feature = "pictures")]
mod exr_file;
#[cfg(feature = "pictures")]
mod info;
#[cfg(feature = "pictures")]
mod limits;
#[cfg(feature = "pictures")]
mod metadata;
#[cfg(feature = "pictures")]
mod names;
mod open;
#[cfg(feature = "pictures")]
mod partial;
#[cfg(feature = "pictures")]
mod picture;
#[cfg(feature = "pictures")]
mod png_file;
#[cfg(feature = "pictures")]
mod raster;
#[cfg(feature = "pictures")]
mod read;
#[cfg(feature = "pictures")]
mod row_reader;
#[cfg(feature = "pictures")]
mod samples;
#[cfg(feature = "pictures")]
mod selection;
#[cfg(feature = "pictures")]
mod source;
#[cfg(feature = "pictures")]
mod statistics;
#[cfg(feature = "pictures")]
mod tiff_file;

#[cfg(feature = "pictures")]
pub use atomic::{Target, copy_file, write_by, write_bytes, write_parts};
#[cfg(feature = "pictures")]
pub use claim::{Claim, Claims};
#[cfg(feature = "pictures")]
pub use cost::{Cost, cost};
pub use describe::describe;
pub use error::{Entry, Error};
#[cfg(feature = "pictures")]
pub use exr_file::{
    BandBuffer, EncodeScratch, EncodedBand, ExrChannel, ExrHeader, ExrImage, ExrReader, ExrWriter, write_exr,
};
#[cfg(feature = "pictures")]
pub use info::{ChannelInfo, Compression, Encoding, FileKind, Info, Levels, PartInfo, SampleType, Storage};
#[cfg(feature = "pictures")]
pub use limits::Limits;
#[cfg(feature = "pictures")]
pub use metadata::{check_whole, read_metadata, readable_metadata};
pub use open::{OpenFile, open_file, read_bytes, read_text};
#[cfg(feature = "pictures")]
pub use partial::{clear_partial_files, discard_partial_files};
#[cfg(feature = "pictures")]
pub use picture::{Picture, PictureChannel, PictureInfo};
#[cfg(feature = "pictures")]
pub use png_file::{PngImage, encode_png8, write_png8, write_png16};
#[cfg(feature = "pictures")]
pub use raster::TakeRow;
#[cfg(feature = "pictures")]
pub use read::{info, kind, read};
#[cfg(feature = "pictures")]
pub use row_reader::RowReader;
#[cfg(feature = "pictures")]
pub use samples::Samples;
#[cfg(feature = "pictures")]
pub use selection::{PartName, Selection};
#[cfg(feature = "pictures")]
pub use statistics::{Statistics, statistics};
