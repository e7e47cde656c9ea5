//! Writing of whole pictures as EXR.

use trochoid_image::{Chromaticities, Window};

use super::write_header::ExrHeader;
use super::writer::ExrWriter;
use crate::{Error, SampleType, Samples, Target};

/// Picture to write as EXR.
#[derive(Clone, Debug)]
pub struct ExrImage<'a> {
    /// Display window: the frame that viewers show.
    pub display: Window,
    /// Data window: the pixels that every channel stores.
    pub data: Window,
    /// Channels, in any order.
    pub channels: Vec<ExrChannel<'a>>,
    /// String attributes, which keep their order.
    pub metadata: Vec<(String, String)>,
    /// Bytes to reserve in the header for the metadata, so that the file equals one whose metadata were added late
    /// ([`ExrHeader::late_metadata`]); 0 to reserve as many as needed.
    pub reserved: usize,
    /// Primaries and white point of the RGB channels.
    pub chromaticities: Option<Chromaticities>,
}

impl ExrImage<'_> {
    /// Creates a picture without channels whose data window is its display window.
    pub fn new(window: Window) -> Self {
        Self {
            display: window,
            data: window,
            channels: Vec::new(),
            metadata: Vec::new(),
            reserved: 0,
            chromaticities: None,
        }
    }
}

/// Channel to write.
#[derive(Clone, Debug)]
pub struct ExrChannel<'a> {
    name: String,
    samples: Samples<'a>,
    half: bool,
}

impl<'a> ExrChannel<'a> {
    /// Creates a channel of 16-bit floats, rounded to nearest; finite values beyond ±65504 are refused.
    pub fn half(name: impl Into<String>, samples: Samples<'a>) -> Self {
        Self { name: name.into(), samples, half: true }
    }

    /// Creates a channel of 32-bit floats, stored unchanged.
    pub fn float(name: impl Into<String>, samples: Samples<'a>) -> Self {
        Self { name: name.into(), samples, half: false }
    }
}

/// Writes an EXR file atomically: scanlines, ZIP compression, equal bytes for equal pictures.
///
/// # Errors
/// Samples do not fill the data window, names clash or do not fit EXR, a window is empty or beyond 30 bits, a half
/// channel holds a finite value beyond ±65504, or the file cannot be written. An existing file is then left as it was.
pub fn write_exr(target: impl Into<Target>, image: &ExrImage<'_>) -> Result<(), Error> {
    let target = target.into();
    let path = target.path();
    let area = image.data.area();
    if let Some(ExrChannel { name, samples, .. }) = image.channels.iter().find(|c| c.samples.len() != area) {
        let found = format!("channel \"{name}\" with {} samples for a data window of {area} pixels", samples.len());
        return Err(Error::unwritable(path, found, "pass one sample per pixel"));
    }
    let (early, late) =
        if image.reserved > 0 { (&[][..], &image.metadata[..]) } else { (&image.metadata[..], &[][..]) };
    let sample_type = |half: bool| if half { SampleType::Half } else { SampleType::Float };
    let header = ExrHeader {
        display: image.display,
        data: image.data,
        channels: image.channels.iter().map(|c| (c.name.clone(), sample_type(c.half))).collect(),
        metadata: early.to_vec(),
        late_metadata: image.reserved,
        chromaticities: image.chromaticities,
    };
    let samples: Vec<Samples<'_>> = image.channels.iter().map(|channel| channel.samples).collect();
    let writer = ExrWriter::create(target, &header)?;
    let band_area = writer.rows_per_band() * image.data.width();
    writer
        .each_band(|band, scratch| writer.push(writer.encode_samples(band, &samples, band * band_area, scratch)?))?;
    writer.finish(late)
}
