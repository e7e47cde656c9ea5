//! EXR files. Headers are read here, so that every claim is checked before it is used; ZIP is decoded by libdeflate,
//! other methods by the `exr` crate.

mod attribute;
mod band;
mod chunks;
mod codec;
mod failure;
mod header;
mod layout;
mod parallel;
mod reader;
mod write;
mod write_header;
mod writer;
mod zip;

pub use band::BandBuffer;
pub(crate) use chunks::check_whole;
pub(crate) use header::{Header, readable_strings};
pub use reader::ExrReader;
pub use write::{ExrChannel, ExrImage, write_exr};
pub use write_header::ExrHeader;
pub use writer::{EncodeScratch, EncodedBand, ExrWriter};

/// First bytes of every EXR file.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Flags of the version field.
const TILED: u32 = 0x200;
const LONG_NAMES: u32 = 0x400;
const NON_IMAGE: u32 = 0x800;
const MULTI_PART: u32 = 0x1000;
/// Maximum length of the name of an attribute or channel, in bytes.
const NAME_LENGTH: usize = 255;
/// Maximum magnitude of window coordinates, as in the reference implementation.
const MAX_COORDINATE: i64 = (i32::MAX / 2) as i64;
