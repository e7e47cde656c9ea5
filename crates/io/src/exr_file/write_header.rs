//! The header of a written file, attribute by attribute in a fixed order: equal pictures make equal bytes.

use std::path::Path;

use trochoid_image::{Chromaticities, Window};

use super::write::{ExrChannel, ExrImage};
use super::{LONG_NAMES, MAGIC, MAX_COORDINATE, NAME_LENGTH};
use crate::Error;

/// Names that the format or this crate gives a meaning; metadata must not take them.
const RESERVED: [&str; 14] = [
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
];

/// Longest name that readers of before 2.0 know.
const SHORT_NAME: usize = 31;

/// Refuses what the format cannot hold; `channels` are sorted by name.
pub(super) fn check(path: &Path, image: &ExrImage<'_>, channels: &[&ExrChannel<'_>]) -> Result<(), Error> {
    for (what, window) in [("data", image.data), ("display", image.display)] {
        let corners = [window.x0, window.y0, window.x1, window.y1];
        if window.is_empty() || corners.iter().any(|a| a.abs() > MAX_COORDINATE) {
            let found = format!("the {what} window {window}");
            return Err(Error::unwritable(path, found, "EXR takes windows with pixels, within 30 bits"));
        }
    }
    if channels.is_empty() {
        return Err(Error::unwritable(path, "an EXR without channels", "pass at least one"));
    }
    for channel in channels {
        check_name(path, "channel", &channel.name)?;
        if channel.samples.len() != image.data.area() {
            let (name, found, area) = (&channel.name, channel.samples.len(), image.data.area());
            let found = format!("channel \"{name}\" with {found} samples for a data window of {area} pixels");
            return Err(Error::unwritable(path, found, "pass one sample a pixel"));
        }
    }
    if let Some(pair) = channels.windows(2).find(|pair| pair[0].name == pair[1].name) {
        let found = format!("two channels \"{}\"", pair[0].name);
        return Err(Error::unwritable(path, found, "names must differ"));
    }
    let mut keys = std::collections::HashSet::new();
    for (key, value) in &image.metadata {
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

fn check_name(path: &Path, what: &str, name: &str) -> Result<(), Error> {
    if (1..=NAME_LENGTH).contains(&name.len()) && !name.contains('\0') {
        return Ok(());
    }
    let found = format!("the {what} name \"{}\"", crate::error::printable(name));
    Err(Error::unwritable(path, found, "EXR takes 1 to 255 bytes without zeros"))
}

/// The bytes before the table of chunk offsets.
pub(super) fn encode(image: &ExrImage<'_>, channels: &[&ExrChannel<'_>]) -> Vec<u8> {
    let names = channels.iter().map(|channel| &channel.name).chain(image.metadata.iter().map(|(key, _)| key));
    let long = names.map(String::len).max() > Some(SHORT_NAME);
    let mut bytes = MAGIC.to_vec();
    bytes.extend((2 | if long { LONG_NAMES } else { 0 }).to_le_bytes());
    push(&mut bytes, "channels", "chlist", &channel_list(channels));
    // 3: ZIP, 16 rows at a time.
    push(&mut bytes, "compression", "compression", &[3]);
    push(&mut bytes, "dataWindow", "box2i", &corners(image.data));
    push(&mut bytes, "displayWindow", "box2i", &corners(image.display));
    // 0: increasing y.
    push(&mut bytes, "lineOrder", "lineOrder", &[0]);
    push(&mut bytes, "pixelAspectRatio", "float", &1_f32.to_le_bytes());
    push(&mut bytes, "screenWindowCenter", "v2f", &[0; 8]);
    push(&mut bytes, "screenWindowWidth", "float", &1_f32.to_le_bytes());
    if let Some(Chromaticities { red, green, blue, white }) = image.chromaticities {
        let values: Vec<u8> = [red, green, blue, white].into_iter().flatten().flat_map(f32::to_le_bytes).collect();
        push(&mut bytes, "chromaticities", "chromaticities", &values);
    }
    for (key, value) in &image.metadata {
        push(&mut bytes, key, "string", value.as_bytes());
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

fn channel_list(channels: &[&ExrChannel<'_>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for channel in channels {
        bytes.extend(channel.name.as_bytes());
        bytes.push(0);
        bytes.extend(if channel.half { 1_i32 } else { 2 }.to_le_bytes());
        // Not quantized linearly (only lossy methods care); three reserved bytes.
        bytes.extend([0; 4]);
        bytes.extend([1_i32.to_le_bytes(), 1_i32.to_le_bytes()].concat());
    }
    bytes.push(0);
    bytes
}

/// The window as the format has it, corners inclusive; [`check`] keeps them within 31 bits.
fn corners(window: Window) -> Vec<u8> {
    [window.x0, window.y0, window.x1 - 1, window.y1 - 1].iter().flat_map(|&a| (a as i32).to_le_bytes()).collect()
}
