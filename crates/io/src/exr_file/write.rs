//! Writing EXR: one part of scanlines, ZIP compression.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use trochoid_image::{Chromaticities, Window};

use super::codec::{Codec, Failure, Stored};
use super::layout::Layout;
use super::write_header;
use crate::atomic::write_atomically;
use crate::{Compression, Error, SampleType, Samples, Storage};

/// Largest finite half.
const MAX_HALF: f32 = 65504.0;
/// Chunks compressed at once, as a multiple of the number of threads; bounds memory beside the picture.
const CHUNKS_PER_THREAD: usize = 4;

/// A picture to be written as EXR.
#[derive(Clone, Debug)]
pub struct ExrImage<'a> {
    /// The frame the viewer sees.
    pub display: Window,
    /// Where pixels are stored: the window of every channel.
    pub data: Window,
    /// The channels, in any order.
    pub channels: Vec<ExrChannel<'a>>,
    /// String attributes, kept in order.
    pub metadata: Vec<(String, String)>,
    /// Primaries and white point of RGB channels.
    pub chromaticities: Option<Chromaticities>,
}

impl ExrImage<'_> {
    /// A picture whose data fill its display window, still without channels.
    pub fn new(window: Window) -> Self {
        Self { display: window, data: window, channels: Vec::new(), metadata: Vec::new(), chromaticities: None }
    }
}

/// One channel to be written.
#[derive(Clone, Debug)]
pub struct ExrChannel<'a> {
    pub(super) name: String,
    pub(super) samples: Samples<'a>,
    pub(super) half: bool,
}

impl<'a> ExrChannel<'a> {
    /// A channel of 16-bit floats, rounded to nearest; finite values beyond ±65504 are refused.
    pub fn half(name: impl Into<String>, samples: Samples<'a>) -> Self {
        Self { name: name.into(), samples, half: true }
    }

    /// A channel of 32-bit floats, stored as they are.
    pub fn float(name: impl Into<String>, samples: Samples<'a>) -> Self {
        Self { name: name.into(), samples, half: false }
    }

    fn bytes(&self) -> usize {
        if self.half { 2 } else { 4 }
    }
}

/// Writes an EXR file atomically: scanlines, ZIP compression, equal bytes for equal pictures.
///
/// # Errors
/// Samples do not fill the data window, names clash or do not fit EXR, a window is empty or beyond 30 bits, a half channel
/// holds a finite value beyond ±65504, or the file cannot be written. An existing file is then left as it was.
pub fn write_exr(path: impl AsRef<Path>, image: &ExrImage<'_>) -> Result<(), Error> {
    let path = path.as_ref();
    let mut channels: Vec<&ExrChannel<'_>> = image.channels.iter().collect();
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    write_header::check(path, image, &channels)?;
    channels.iter().filter(|channel| channel.half).try_for_each(|channel| check_half(path, channel, image.data))?;

    let layout = Layout::new(image.data, &Storage::Scanline, Compression::Zip, false);
    let stored = channels.iter().map(|channel| Stored {
        name: channel.name.as_bytes(),
        sample_type: if channel.half { SampleType::Half } else { SampleType::Float },
        linear: false,
    });
    let too_wide =
        || Error::unwritable(path, format!("rows of {} pixels", image.data.width()), "16 rows must stay below 2 GiB");
    let bytes_per_pixel: usize = channels.iter().map(|channel| channel.bytes()).sum();
    if layout.largest().saturating_mul(bytes_per_pixel as u64) > i32::MAX as u64 {
        return Err(too_wide());
    }
    let codec = Codec::new(Compression::Zip, &layout, stored).ok_or_else(too_wide)?;
    let header = write_header::encode(image, &channels);
    write_atomically(path, |file| {
        let io = |error| Error::io(path, "write the file")(error);
        file.write_all(&header).map_err(io)?;
        // The table is filled in at the end, when the chunks' places are known.
        file.write_all(&vec![0; 8 * layout.bands()]).map_err(io)?;
        let mut position = (header.len() + 8 * layout.bands()) as u64;
        let mut table = Vec::with_capacity(8 * layout.bands());
        let bands: Vec<usize> = (0..layout.bands()).collect();
        for batch in bands.chunks(CHUNKS_PER_THREAD * rayon::current_num_threads()) {
            let packed: Vec<Vec<u8>> = batch
                .par_iter()
                .map(|&band| codec.compress(layout.rectangle(0, band), rows(&channels, layout.rectangle(0, band))))
                .collect::<Result<_, Failure>>()
                .map_err(|failure| Error::unwritable(path, format!("the picture ({failure:?})"), "use other values"))?;
            for (&band, bytes) in batch.iter().zip(&packed) {
                table.extend(position.to_le_bytes());
                let y = image.data.y0 + layout.rectangle(0, band).y0;
                file.write_all(&(y as i32).to_le_bytes()).map_err(io)?;
                file.write_all(&(bytes.len() as i32).to_le_bytes()).map_err(io)?;
                file.write_all(bytes).map_err(io)?;
                position += 8 + bytes.len() as u64;
            }
        }
        file.seek(SeekFrom::Start(header.len() as u64)).map_err(io)?;
        file.write_all(&table).map_err(io)
    })
}

/// Refuses the first value that half cannot hold; NaN and infinities it can.
fn check_half(path: &Path, channel: &ExrChannel<'_>, data: Window) -> Result<(), Error> {
    let width = data.width();
    let bad = |value: &f32| value.is_finite() && value.abs() > MAX_HALF;
    let Some((index, value)) = channel.samples.range(0, data.area()).enumerate().find(|(_, value)| bad(value)) else {
        return Ok(());
    };
    Err(Error::Unrepresentable {
        path: path.into(),
        channel: channel.name.clone(),
        x: data.x0 + (index % width) as i64,
        y: data.y0 + (index / width) as i64,
        value,
        expected: "at most ±65504, the largest half; write float",
    })
}

/// A chunk's samples: for each row, for each channel in order of names, the row's samples.
fn rows(channels: &[&ExrChannel<'_>], rectangle: Window) -> Vec<u8> {
    let width = rectangle.width();
    let mut bytes = Vec::with_capacity(rectangle.area() * channels.iter().map(|c| c.bytes()).sum::<usize>());
    let mut values: Vec<f32> = Vec::with_capacity(width);
    let mut halves = vec![half::f16::ZERO; width];
    for y in rectangle.y0..rectangle.y1 {
        for channel in channels {
            values.clear();
            values.extend(channel.samples.range(y as usize * width, width));
            if channel.half {
                halves.convert_from_f32_slice(&values);
                bytes.extend(halves.iter().flat_map(|value| value.to_ne_bytes()));
            } else {
                bytes.extend(values.iter().flat_map(|value| value.to_ne_bytes()));
            }
        }
    }
    bytes
}
