use trochoid_image::{Chromaticities, Plane, Window};

use crate::info::{ChannelInfo, Encoding, PartInfo, SampleType};

/// Decoded channels of one part of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Number of the part they come from.
    pub part: usize,
    /// The frame the viewer sees.
    pub display: Window,
    /// Where pixels are stored: the window of every plane.
    pub data: Window,
    /// How values relate to light.
    pub encoding: Encoding,
    /// Primaries and white point, if the file states them.
    pub chromaticities: Option<Chromaticities>,
    /// The channels: in the order of the selection, or R, G, B, A, X, Y, Z, W and then as in the file.
    pub channels: Vec<PictureChannel>,
}

/// One decoded channel.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureChannel {
    /// Base name, such as `R`, in the file's case.
    pub name: String,
    /// Name as stored, such as `Ocean.Combined.R`.
    pub full_name: String,
    /// Type of the samples in the file.
    pub sample_type: SampleType,
    /// The values, as stored.
    pub plane: Plane,
}

/// A [`Picture`] without its pixels: what [`ExrReader::info`](crate::ExrReader::info) says.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureInfo {
    /// Number of the part the channels come from.
    pub part: usize,
    /// The frame the viewer sees.
    pub display: Window,
    /// Where pixels are stored: the window of every channel.
    pub data: Window,
    /// How values relate to light.
    pub encoding: Encoding,
    /// Primaries and white point, if the file states them.
    pub chromaticities: Option<Chromaticities>,
    /// The channels, in the order of [`Picture::channels`].
    pub channels: Vec<ChannelInfo>,
}

impl Picture {
    /// The channel of that base or full name; in any case if no other fits.
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
    /// Of some channels of a part.
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
