//! Nodes that read files, and their shared code: decoding a selection, validation, fitting, and color conversion.

mod average;
mod color;
mod cost;
mod crypto_mask;
mod cryptomatte;
mod decompose;
mod kept;
mod knobs;
mod layer;
mod legal;
mod on_demand;
mod palette;
mod planar;
pub(crate) mod read;
mod reading;
mod recipe;
mod shared;
mod stream;
mod texture;
mod turned;
mod view_from_passes;

pub(crate) use cost::{memory_of_passes, memory_of_picture, memory_on_demand};
pub(crate) use kept::{KeptPlane, PartialPicture};
pub(crate) use layer::{Fit, Layer, index_of_nearest};
pub(crate) use legal::Rule;
pub(crate) use on_demand::{FoundPass, Opened, find_pass};
pub(crate) use palette::{controls, walked};
pub(crate) use reading::{Planes, Reading};
pub(crate) use recipe::{ExactLines, Recipe};
pub(crate) use shared::SharedFile;
pub(crate) use stream::{Accuracy, Rows, Stored, Stream};

use std::path::Path;
use trochoid_graph::{BadData, FrameContext, NodeError, NodeType};
use trochoid_image::{MAX_PIXELS, Window};
use trochoid_io::{ExrReader, Limits, Picture, PictureInfo, RowReader, Selection};

/// Which pictures a Read holds decoded.
#[derive(Clone, Copy, Debug)]
pub struct Holding {
    /// Colors of an EXR up to this many bytes are kept decoded: their file is read for the control colors anyway, so
    /// reading it on demand would decode it twice. Other EXRs are read on demand; `None` keeps them decoded, too.
    pub on_demand: Option<u64>,
    /// Pictures other than EXR up to this many bytes are kept whole; of larger ones, only the pixels that the
    /// document's samples need.
    pub whole: u64,
}

/// What is held unless a test asks for something else.
pub(crate) const HOLDING: Holding = Holding { on_demand: Some(256 << 20), whole: 64 << 20 };

/// Decodes a selection within the frame's memory limit.
pub(crate) fn decode(frame: &FrameContext, path: &Path, selection: &Selection) -> Result<Picture, NodeError> {
    let picture = trochoid_io::read(path, selection, &limits(frame)).map_err(|error| reading::selected(error, None))?;
    filled(path, picture.part, picture.data)?;
    Ok(picture)
}

fn limits(frame: &FrameContext) -> Limits {
    Limits { pixels: MAX_PIXELS, bytes: frame.memory_limit }
}

/// Returns the file's information about a selection, from its header alone.
pub(crate) fn header(
    frame: &FrameContext,
    path: &Path,
    selection: &Selection,
) -> Result<PictureInfo, trochoid_io::Error> {
    if trochoid_io::kind(path)?.is_exr() {
        return Ok(ExrReader::open(path, selection, &limits(frame))?.info().clone());
    }
    Ok(RowReader::open(path, selection, &limits(frame))?.info().clone())
}

/// Refuses a picture without pixels: there is nothing to repeat outside its data window.
fn filled(path: &Path, part: usize, data: Window) -> Result<(), NodeError> {
    if data.is_empty() {
        let found = format_args!("the empty data window {data}");
        return Err(BadData::new(found, "at least one pixel", "").in_file(path).in_part(part).into());
    }
    Ok(())
}

pub(crate) static NODES: &[NodeType] = &[
    NodeType::of::<read::Read>(),
    NodeType::of::<decompose::Decompose>(),
    NodeType::of::<texture::Texture>(),
    NodeType::of::<view_from_passes::ViewFromPasses>(),
    NodeType::of::<crypto_mask::CryptoMask>(),
];
