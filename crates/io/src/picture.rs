use trochoid_image::{Chromaticities, Plane, Window};

use crate::info::{ChannelInfo, Encoding, PartInfo, SampleType};

/// Decoded channels of one part of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Index of the part that the channels come from.
    pub part: usize,
    /// Display window: the frame that viewers show.
    pub display: Window,
    /// Data window: the pixels of every plane.
    pub data: Window,
    /// Relation of the values to light.
    pub encoding: Encoding,
    /// Primaries and white point, if the file states them.
    pub chromaticities: Option<Chromaticities>,
    /// Channels in the order of the selection, or R, G, B, A, X, Y, Z, W and then in the order of the file.
    pub channels: Vec<PictureChannel>,
}

/// Decoded channel.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureChannel {
    /// Base name, such as `R`, in the file's case.
    pub name: String,
    /// Name as stored, such as `Ocean.Combined.R`.
    pub full_name: String,
    /// Type of the samples in the file.
    pub sample_type: SampleType,
    /// Values as stored.
    pub plane: Plane,
}

/// [`Picture`] without its pixels, as returned by [`ExrReader::info`](crate::ExrReader::info).
#[derive(Clone, Debug, PartialEq)]
pub struct PictureInfo {
    /// Index of the part that the channels come from.
    pub part: usize,
    /// Display window: the frame that viewers show.
    pub display: Window,
    /// Data window: the pixels of every channel.
    pub data: Window,
    /// Relation of the values to light.
    pub encoding: Encoding,
    /// Primaries and white point, if the file states them.
    pub chromaticities: Option<Chromaticities>,
    /// Channels, in the order of [`Picture::channels`].
    pub channels: Vec<ChannelInfo>,
}

impl Picture {
    /// Returns the channel with this base or full name, ignoring case if there is no exact match.
    pub fn channel(&self, name: &str) -> Option<&Plane> {
        let exact = |channel: &&PictureChannel| channel.name == name || channel.full_name == name;
        let folded = |channel: &&PictureChannel| channel.name.eq_ignore_ascii_case(name);
        if let Some(found) = self.channels.iter().find(exact) {
            return Some(&found.plane);
        }
        let mut fitting = self.channels.iter().filter(folded);
        match (fitting.next(), fitting.next()) {
            (Some(only), None) => Some(&only.plane),
            _ => None,
        }
    }
}

impl PictureInfo {
    /// Describes some channels of a part.
    pub(crate) fn new(info: &PartInfo, part: usize, channels: &[usize]) -> Self {
        Self {
            part,
            display: info.display,
            data: info.data,
            encoding: info.encoding,
            chromaticities: info.chromaticities,
            channels: channels.iter().map(|&index| info.channels[index].clone()).collect(),
        }
    }

    pub(crate) fn with_planes(self, planes: Vec<Plane>) -> Picture {
        let Self { part, display, data, encoding, chromaticities, channels } = self;
        let channels = channels.into_iter().zip(planes).map(|(channel, plane)| PictureChannel {
            name: channel.base,
            full_name: channel.full_name,
            sample_type: channel.sample_type,
            plane,
        });
        Picture { part, display, data, encoding, chromaticities, channels: channels.collect() }
    }
}
