//! What the nodes that read files share: decoding a selection, bad data, fitting, and color conversion.

mod color;
mod covered;
mod layer;
mod legal;

pub(crate) use color::{Premultiplied, convert};
pub(crate) use layer::{Fit, Layer};
pub(crate) use legal::{Rule, take};

use std::path::Path;
use trochoid_graph::{FrameContext, NodeError};
use trochoid_image::MAX_PIXELS;
use trochoid_io::{Error, Limits, Picture, Selection};

/// Words of the knob `fit`.
pub(crate) const FITS: &[&str] = &["nearest", "bilinear", "crop"];

/// Decodes a selection within the frame's limit of memory.
pub(crate) fn decode(frame: &FrameContext, path: &Path, selection: &Selection) -> Result<Picture, NodeError> {
    trochoid_io::read(path, selection, &limits(frame)).map_err(NodeError::new).and_then(|picture| filled(path, picture))
}

/// Decodes a layer or part, or the one channel of that name, such as `Combined.A`.
pub(crate) fn decode_pass(frame: &FrameContext, path: &Path, name: &str) -> Result<Picture, NodeError> {
    let read = |selection: &Selection| trochoid_io::read(path, selection, &limits(frame));
    let missing = match read(&Selection::layer(name)) {
        Err(missing @ Error::NotFound { .. }) => missing,
        other => return other.map_err(NodeError::new).and_then(|picture| filled(path, picture)),
    };
    let mut found = read(&Selection::channels([name]));
    // Not the channel's full name: perhaps that of its layer was cut short.
    if let (Err(Error::NotFound { .. }), Some((layer, base))) = (&found, name.rsplit_once('.')) {
        found = read(&Selection::layer(layer)).map(|mut picture| {
            picture.channels.retain(|channel| channel.name.eq_ignore_ascii_case(base));
            picture
        });
    }
    match found {
        Ok(picture) if !picture.channels.is_empty() => filled(path, picture),
        // Of several misses the layer's says most: it lists what the file has.
        Ok(_) | Err(Error::NotFound { .. }) => Err(NodeError::new(missing)),
        Err(other) => Err(NodeError::new(other)),
    }
}

fn limits(frame: &FrameContext) -> Limits {
    Limits { pixels: MAX_PIXELS, bytes: frame.memory_limit }
}

/// Refuses a picture without a pixel: there is none to repeat outside its data window.
fn filled(path: &Path, picture: Picture) -> Result<Picture, NodeError> {
    if picture.data.is_empty() {
        let (path, part, data) = (path.display(), picture.part, picture.data);
        return Err(NodeError::new(format!("{path}: part {part}: found the data window {data}, expected a pixel")));
    }
    Ok(picture)
}

/// The full names of all channels of a picture, for messages.
pub(crate) fn channel_names(picture: &Picture) -> String {
    const SHOWN: usize = 12;
    let mut names: Vec<String> =
        picture.channels.iter().take(SHOWN).map(|channel| format!("\"{}\"", channel.full_name)).collect();
    if picture.channels.len() > SHOWN {
        names.push(format!("{} more", picture.channels.len() - SHOWN));
    }
    names.join(", ")
}

/// Positions of the channels called `bases`, in any case; `None` unless all are there.
pub(crate) fn positions<const N: usize>(picture: &Picture, bases: [&str; N]) -> Option<[usize; N]> {
    let mut found = [0; N];
    for (at, base) in found.iter_mut().zip(bases) {
        *at = picture.channels.iter().position(|channel| channel.name.eq_ignore_ascii_case(base))?;
    }
    Some(found)
}
