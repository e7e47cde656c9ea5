use std::fmt;
use std::path::Path;

use trochoid_image::{Chromaticities, Window};

use crate::error::Error;
use crate::limits::Limits;

/// Kind of an image file, determined by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FileKind {
    /// OpenEXR.
    Exr,
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// TIFF.
    Tiff,
}

impl FileKind {
    /// Returns whether rows can be read in any order; if not, they are read from the top down.
    pub fn is_exr(self) -> bool {
        self == Self::Exr
    }

    pub(crate) fn of(magic: &[u8]) -> Option<Self> {
        match magic {
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            _ => None,
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Exr => "EXR",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
        })
    }
}

/// Contents of a file's header.
#[derive(Clone, Debug, PartialEq)]
pub struct Info {
    /// Kind of file.
    pub kind: FileKind,
    /// Parts of the file: one, except in multi-part EXR.
    pub parts: Vec<PartInfo>,
}

/// Description of one picture in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct PartInfo {
    /// Name; parts of single-part files often have none.
    pub name: Option<String>,
    /// Display window: the frame that viewers show.
    pub display: Window,
    /// Data window: the stored pixels; may be smaller or larger than the display window, negative or disjoint.
    pub data: Window,
    /// Compression of the pixels.
    pub compression: Compression,
    /// Storage layout of the pixels.
    pub storage: Storage,
    /// Canonical layer names, in the order of the channels; `""` is the unnamed layer.
    pub layers: Vec<String>,
    /// All channels, in the file's order.
    pub channels: Vec<ChannelInfo>,
    /// All other attributes as text, in the file's order.
    pub attributes: Vec<(String, String)>,
    /// Primaries and white point, if the file states them.
    pub chromaticities: Option<Chromaticities>,
    /// Relation of the values to light.
    pub encoding: Encoding,
}

/// Channel of a part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelInfo {
    /// Name as stored, such as `Ocean.Combined.R`.
    pub full_name: String,
    /// Canonical layer: the name before the last dot, else the name of the part in a multi-part file, else `""`.
    pub layer: String,
    /// Base name after the last dot: R, G, B, A, Y, X, Z, V…, in the file's case.
    pub base: String,
    /// Type of the stored samples.
    pub sample_type: SampleType,
    /// Pixels per stored sample, across and down; not 1 only for subsampled chroma, which is not supported.
    pub sampling: [i32; 2],
}

/// Relation of a picture's values to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Proportional to light, or plain data.
    Linear,
    /// Encoded for display by the sRGB curve; [`trochoid_image::srgb_decode`] gives linear light.
    Srgb,
}

/// Type of a channel's stored samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// 16-bit floating point.
    Half,
    /// 32-bit floating point.
    Float,
    /// 32-bit unsigned integer.
    Uint,
    /// 8-bit unsigned integer, read as value / 255.
    U8,
    /// 16-bit unsigned integer, read as value / 65535.
    U16,
}

impl SampleType {
    /// Returns the size of a stored sample, in bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::Half | Self::U16 => 2,
            Self::Float | Self::Uint => 4,
        }
    }
}

impl fmt::Display for SampleType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Half => "half",
            Self::Float => "float",
            Self::Uint => "uint",
            Self::U8 => "u8",
            Self::U16 => "u16",
        })
    }
}

/// Storage layout of a part's pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Scanlines.
    Scanline,
    /// Tiles, possibly at several resolutions, of which the largest is read.
    Tiled {
        /// Width of a tile, in pixels.
        width: u32,
        /// Height of a tile, in pixels.
        height: u32,
        /// Stored resolutions.
        levels: Levels,
    },
    /// Any number of samples per pixel; not supported.
    Deep,
    /// Unknown type of part; not supported.
    Other(String),
}

impl fmt::Display for Storage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scanline => f.write_str("scanline"),
            Self::Tiled { width, height, levels } => {
                write!(f, "tiled {width} × {height}")?;
                match levels {
                    Levels::One => Ok(()),
                    Levels::Mip => f.write_str(", mip map"),
                    Levels::Rip => f.write_str(", rip map"),
                }
            }
            Self::Deep => f.write_str("deep"),
            Self::Other(kind) => write!(f, "\"{kind}\""),
        }
    }
}

/// Resolutions in a tiled part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Levels {
    /// Full resolution only.
    One,
    /// Repeatedly halved in both directions together.
    Mip,
    /// Repeatedly halved in each direction separately.
    Rip,
}

/// Compression of a part's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Compression {
    /// Not compressed.
    None,
    /// Run lengths.
    Rle,
    /// Deflate, one row at a time.
    Zips,
    /// Deflate, 16 rows at a time.
    Zip,
    /// Wavelets.
    Piz,
    /// Deflate of floats cut to 24 bits.
    Pxr24,
    /// Blocks of 4 × 4 pixels, lossy for half.
    B44,
    /// B44 with smaller flat blocks.
    B44a,
    /// Lossy cosine transform, 32 rows at a time.
    Dwaa,
    /// Lossy cosine transform, 256 rows at a time.
    Dwab,
    /// JPEG 2000, 256 rows at a time; not supported.
    Htj2k256,
    /// JPEG 2000, 32 rows at a time; not supported.
    Htj2k32,
    /// Lossy JPEG 2000, 256 rows at a time; not supported.
    Lj2k,
    /// Zstandard; not supported.
    Zstd,
    /// Unknown compression number of EXR; not supported.
    Other(u8),
    /// The compression of PNG.
    Png,
    /// The compression of JPEG.
    Jpeg,
    /// Any compression of TIFF.
    Tiff,
}

impl Compression {
    /// Returns the method with this number in an EXR file.
    pub(crate) fn of_exr(number: u8) -> Self {
        match number {
            0 => Self::None,
            1 => Self::Rle,
            2 => Self::Zips,
            3 => Self::Zip,
            4 => Self::Piz,
            5 => Self::Pxr24,
            6 => Self::B44,
            7 => Self::B44a,
            8 => Self::Dwaa,
            9 => Self::Dwab,
            10 => Self::Htj2k256,
            11 => Self::Htj2k32,
            // As of OpenEXR 3.5.
            12 => Self::Lj2k,
            13 => Self::Zstd,
            other => Self::Other(other),
        }
    }
}

impl fmt::Display for Compression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Rle => "RLE",
            Self::Zips => "ZIPS",
            Self::Zip => "ZIP",
            Self::Piz => "PIZ",
            Self::Pxr24 => "PXR24",
            Self::B44 => "B44",
            Self::B44a => "B44A",
            Self::Dwaa => "DWAA",
            Self::Dwab => "DWAB",
            Self::Htj2k256 => "HTJ2K256",
            Self::Htj2k32 => "HTJ2K32",
            Self::Lj2k => "LJ2K",
            Self::Zstd => "ZSTD",
            Self::Other(number) => return write!(f, "method {number}"),
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
        })
    }
}

impl PartInfo {
    /// Returns the name of the part in messages.
    pub(crate) fn place(&self, index: usize) -> String {
        match &self.name {
            Some(name) => format!("part {index} \"{}\"", crate::error::printable(name)),
            None => format!("part {index}"),
        }
    }

    pub(crate) fn check_windows(&self, path: &Path, index: usize, limits: &Limits) -> Result<(), Error> {
        for (name, window) in [("data", self.data), ("display", self.display)] {
            limits.check_window(path, &format!("{}, {name} window {window}", self.place(index)), window)?;
        }
        Ok(())
    }
}
