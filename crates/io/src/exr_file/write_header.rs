//! Writing of headers, attribute by attribute in a fixed order, so that equal pictures make equal bytes.

use std::path::Path;

use trochoid_image::{Chromaticities, Window};

use super::{LONG_NAMES, MAGIC, MAX_COORDINATE, NAME_LENGTH};
use crate::{Error, SampleType};

/// Names that the format or this crate defines, which metadata must not use.
const RESERVED: [&str; 15] = [
    "channels",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "name",
    "type",
    "version",
    "chunkCount",
    "chromaticities",
    FREE,
];
/// Name of the attribute with the rest of the bytes reserved for late metadata.
const FREE: &str = "reserved";
/// Size of an entry in addition to its name and value, in bytes: `\0string\0` and a size of four bytes.
const ENTRY: usize = 12;

/// Longest name that readers older than version 2.0 accept.
const SHORT_NAME: usize = 31;

/// Description of an EXR file to write, without its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrHeader {
    /// Display window: the frame that viewers show.
    pub display: Window,
    /// Data window: the pixels that every channel stores.
    pub data: Window,
    /// Names of the channels, in any order, with the types of their samples: [`SampleType::Half`] rounds to nearest and
    /// refuses finite values beyond ±65504, [`SampleType::Float`] stores them unchanged.
    pub channels: Vec<(String, SampleType)>,
    /// String attributes, which keep their order.
    pub metadata: Vec<(String, String)>,
    /// Bytes to reserve for the metadata that [`ExrWriter::finish`](super::ExrWriter::finish) adds: for each entry, the
    /// lengths of its name and value, and 12. The rest becomes an attribute without meaning.
    pub late_metadata: usize,
    /// Primaries and white point of the RGB channels.
    pub chromaticities: Option<Chromaticities>,
}

impl ExrHeader {
    /// Creates a header without channels whose data window is its display window.
    pub fn new(window: Window) -> Self {
        Self {
            display: window,
            data: window,
            channels: Vec::new(),
            metadata: Vec::new(),
            late_metadata: 0,
            chromaticities: None,
        }
    }
}

/// Refuses content that the format cannot represent; `sorted` has the channels in the order of their names.
pub(super) fn check(path: &Path, header: &ExrHeader, sorted: &[usize]) -> Result<(), Error> {
    for (what, window) in [("data", header.data), ("display", header.display)] {
        let corners = [window.x0, window.y0, window.x1, window.y1];
        if window.is_empty() || corners.iter().any(|a| a.abs() > MAX_COORDINATE) {
            let found = format!("the {what} window {window}");
            return Err(Error::unwritable(path, found, "EXR takes windows with pixels, within 30 bits"));
        }
    }
    if header.channels.is_empty() {
        return Err(Error::unwritable(path, "an EXR without channels", "pass at least one"));
    }
    for (name, sample_type) in &header.channels {
        check_name(path, "channel", name)?;
        if !matches!(sample_type, SampleType::Half | SampleType::Float) {
            let found = format!("channel \"{name}\" of {sample_type}");
            return Err(Error::unwritable(path, found, "write half or float"));
        }
    }
    let name = |index: usize| &header.channels[index].0;
    if let Some(pair) = sorted.windows(2).find(|pair| name(pair[0]) == name(pair[1])) {
        let found = format!("two channels \"{}\"", name(pair[0]));
        return Err(Error::unwritable(path, found, "names must differ"));
    }
    if header.late_metadata > i32::MAX as usize {
        let found = format!("{} bytes reserved for late metadata", header.late_metadata);
        return Err(Error::unwritable(path, found, "EXR takes less than 2 GiB"));
    }
    check_metadata(path, &header.metadata, &[])
}

/// Refuses late metadata that clash with the header's or do not fit.
pub(super) fn check_late(path: &Path, header: &ExrHeader, late: &[(String, String)]) -> Result<(), Error> {
    check_metadata(path, &header.metadata, late)?;
    let (needed, free) = (size(late), header.late_metadata);
    if needed > free {
        let found = format!("late metadata of {needed} bytes with {free} bytes reserved");
        return Err(Error::unwritable(path, found, "reserve more bytes in the header"));
    }
    Ok(())
}

fn check_metadata(path: &Path, metadata: &[(String, String)], late: &[(String, String)]) -> Result<(), Error> {
    let mut keys = std::collections::HashSet::new();
    for (key, value) in metadata.iter().chain(late) {
        check_name(path, "metadata", key)?;
        if RESERVED.contains(&key.as_str()) || !keys.insert(key) {
            let found = format!("the metadata \"{key}\"");
            return Err(Error::unwritable(path, found, "the name is taken; choose another"));
        }
        if value.len() > i32::MAX as usize {
            let found = format!("the metadata \"{key}\" of {} bytes", value.len());
            return Err(Error::unwritable(path, found, "EXR takes less than 2 GiB"));
        }
    }
    Ok(())
}

/// Returns the size of these entries in a header, in bytes.
fn size(metadata: &[(String, String)]) -> usize {
    metadata.iter().map(|(key, value)| key.len() + value.len() + ENTRY).sum()
}

fn check_name(path: &Path, what: &str, name: &str) -> Result<(), Error> {
    if (1..=NAME_LENGTH).contains(&name.len()) && !name.contains('\0') {
        return Ok(());
    }
    let found = format!("the {what} name \"{}\"", crate::error::printable(name));
    Err(Error::unwritable(path, found, "EXR takes 1 to 255 bytes without zeros"))
}

/// Returns the bytes before the table of chunk offsets; their number does not depend on the late metadata.
pub(super) fn encode(header: &ExrHeader, sorted: &[usize], late: &[(String, String)]) -> Vec<u8> {
    let metadata = || header.metadata.iter().chain(late);
    let names = header.channels.iter().map(|(name, _)| name).chain(metadata().map(|(key, _)| key));
    let long = names.map(String::len).max() > Some(SHORT_NAME);
    let mut bytes = MAGIC.to_vec();
    bytes.extend((2 | if long { LONG_NAMES } else { 0 }).to_le_bytes());
    push(&mut bytes, "channels", "chlist", &channel_list(header, sorted));
    // 3: ZIP, 16 rows at a time.
    push(&mut bytes, "compression", "compression", &[3]);
    push(&mut bytes, "dataWindow", "box2i", &corners(header.data));
    push(&mut bytes, "displayWindow", "box2i", &corners(header.display));
    // 0: increasing y.
    push(&mut bytes, "lineOrder", "lineOrder", &[0]);
    push(&mut bytes, "pixelAspectRatio", "float", &1_f32.to_le_bytes());
    push(&mut bytes, "screenWindowCenter", "v2f", &[0; 8]);
    push(&mut bytes, "screenWindowWidth", "float", &1_f32.to_le_bytes());
    if let Some(Chromaticities { red, green, blue, white }) = header.chromaticities {
        let values: Vec<u8> = [red, green, blue, white].into_iter().flatten().flat_map(f32::to_le_bytes).collect();
        push(&mut bytes, "chromaticities", "chromaticities", &values);
    }
    for (key, value) in metadata() {
        push(&mut bytes, key, "string", value.as_bytes());
    }
    if header.late_metadata > 0 {
        // A type that no reader knows, so that no reader takes it for metadata.
        push(&mut bytes, FREE, "free", &vec![0; header.late_metadata.saturating_sub(size(late))]);
    }
    bytes.push(0);
    bytes
}

fn push(bytes: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]) {
    for text in [name, kind] {
        bytes.extend(text.as_bytes());
        bytes.push(0);
    }
    bytes.extend((value.len() as i32).to_le_bytes());
    bytes.extend(value);
}

fn channel_list(header: &ExrHeader, sorted: &[usize]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, sample_type) in sorted.iter().map(|&index| &header.channels[index]) {
        bytes.extend(name.as_bytes());
        bytes.push(0);
        bytes.extend(if *sample_type == SampleType::Half { 1_i32 } else { 2 }.to_le_bytes());
        // Not quantized linearly (relevant for lossy methods only); three reserved bytes.
        bytes.extend([0; 4]);
        bytes.extend([1_i32.to_le_bytes(), 1_i32.to_le_bytes()].concat());
    }
    bytes.push(0);
    bytes
}

/// Writes a window in the form of EXR, with inclusive corners; [`check`] keeps them within 31 bits.
fn corners(window: Window) -> Vec<u8> {
    [window.x0, window.y0, window.x1 - 1, window.y1 - 1].iter().flat_map(|&a| (a as i32).to_le_bytes()).collect()
}
