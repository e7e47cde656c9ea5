//! Pixels of one part: chunks are read in order, decoded in parallel, and appended to the planes.

use std::io::{BufRead, Seek};
use std::path::PathBuf;

use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use trochoid_image::{Plane, Window};

use super::chunks::{Chunks, Position};
use super::codec::{Codec, Failure, Stored};
use super::header::Header;
use super::layout::Layout;
use crate::limits::reserve;
use crate::source::Source;
use crate::{Error, Limits, PartInfo, SampleType, Storage};

/// Bytes of decoded chunks held besides the planes, and so also the unit of parallel work.
const BATCH: usize = 32 << 20;
/// What to do about a file that is valid but not read.
const REMEDY: &str = "re-save it as flat scanlines or tiles with ZIP compression";

/// Decodes `channels` of a part at full resolution, in that order.
pub(crate) fn read_planes<R: BufRead + Seek>(
    source: &mut Source<R>,
    header: &Header,
    part: usize,
    channels: &[usize],
    limits: &Limits,
) -> Result<Vec<Plane>, Error> {
    let info = &header.parts[part];
    let place = info.place(part);
    info.check_windows(&source.path, part, limits)?;
    limits.check_planes(&source.path, &place, info.data, channels.len())?;
    let codec = supported(source, header, part)?;
    let detail = &header.details[part];
    let bytes_per_pixel: u64 = info.channels.iter().map(|channel| channel.sample_type.bytes() as u64).sum();
    let largest = detail.layout.largest().saturating_mul(bytes_per_pixel);
    // The format states sizes of chunks in 31 bits.
    let step = Limits { bytes: limits.bytes.min(i32::MAX as u64), ..*limits };
    step.check_bytes(&source.path, &format!("{place}, one chunk"), largest)?;

    let chunks = Chunks::find(source, header, part)?;
    let path = source.path.clone();
    // Decoding a chunk takes it several times over; many threads at once stay within the limit together.
    let at_once = usize::try_from(limits.bytes / largest.saturating_mul(4).max(1)).unwrap_or(usize::MAX).max(1);
    let wanted = wanted(info, channels);
    let decoder = Decoder { path, place, window: info.data, chunks, codec, wanted, at_once };
    decoder.planes(source, &detail.layout)
}

/// The codec of a part, or why it is not read.
fn supported<R>(source: &Source<R>, header: &Header, part: usize) -> Result<Codec, Error> {
    let info = &header.parts[part];
    let refuse =
        |place: String, found: String| Error::Unsupported { path: source.path.clone(), place, found, remedy: REMEDY };
    match &info.storage {
        Storage::Scanline | Storage::Tiled { .. } => {}
        Storage::Deep => return Err(refuse(info.place(part), "deep data".into())),
        Storage::Other(kind) => {
            return Err(refuse(info.place(part), format!("the type \"{}\"", crate::error::printable(kind))));
        }
    }
    if let Some(channel) = info.channels.iter().find(|channel| channel.sampling != [1, 1]) {
        let place = format!("{}, channel \"{}\"", info.place(part), crate::error::printable(&channel.full_name));
        return Err(refuse(place, format!("subsampling by {} × {}", channel.sampling[0], channel.sampling[1])));
    }
    let detail = &header.details[part];
    let stored = info.channels.iter().zip(&detail.channels).map(|(channel, detail)| Stored {
        name: &detail.name,
        sample_type: channel.sample_type,
        linear: detail.linear,
    });
    Codec::new(info.compression, &detail.layout, stored)
        .ok_or_else(|| refuse(info.place(part), format!("{} compression", info.compression)))
}

/// A wanted channel: its type, and the bytes before it in a row of one pixel.
#[derive(Clone, Copy)]
struct Wanted {
    sample_type: SampleType,
    before: usize,
}

fn wanted(info: &PartInfo, channels: &[usize]) -> Vec<Wanted> {
    let before = |index: usize| info.channels[..index].iter().map(|channel| channel.sample_type.bytes()).sum();
    channels
        .iter()
        .map(|&index| Wanted { sample_type: info.channels[index].sample_type, before: before(index) })
        .collect()
}

/// All that decoding needs but the file itself, so that threads can share it.
struct Decoder<'a> {
    path: PathBuf,
    place: String,
    window: Window,
    chunks: Chunks<'a>,
    codec: Codec,
    wanted: Vec<Wanted>,
    /// Chunks decoded at the same time.
    at_once: usize,
}

impl Decoder<'_> {
    /// Reads band after band, so that memory is only touched for pixels that the file really holds.
    fn planes<R: BufRead + Seek>(&self, source: &mut Source<R>, layout: &Layout) -> Result<Vec<Plane>, Error> {
        let mut samples: Vec<Vec<f32>> = Vec::new();
        for _ in &self.wanted {
            samples.push(reserve(&self.path, &self.place, self.window.area())?);
        }
        let mut batch = Vec::new();
        let mut bytes = 0;
        for band in 0..layout.bands() {
            for column in 0..layout.columns() {
                let at = Position { column, band };
                let size = self.codec.raw_size(self.chunks.rectangle(at));
                batch.push((at, self.chunks.read(source, at, size)?));
                bytes += size;
            }
            if bytes >= BATCH || band + 1 == layout.bands() {
                self.append(std::mem::take(&mut batch), &mut samples)?;
                bytes = 0;
            }
        }
        let incomplete = |error: trochoid_image::PlaneError| {
            Error::invalid(&self.path, &*self.place, error.to_string(), "chunks that fill the data window")
        };
        samples.into_iter().map(|samples| Plane::new(self.window, samples).map_err(incomplete)).collect()
    }

    /// Decodes whole bands and appends their rows to the planes.
    fn append(&self, mut batch: Vec<(Position, Vec<u8>)>, planes: &mut [Vec<f32>]) -> Result<(), Error> {
        let mut decoded: Vec<(Window, Vec<Vec<f32>>)> = Vec::with_capacity(batch.len());
        while !batch.is_empty() {
            let group: Vec<_> = batch.drain(..self.at_once.min(batch.len())).collect();
            let chunks = group.into_par_iter().map(|(at, packed)| self.decode(at, packed));
            decoded.extend(chunks.collect::<Result<Vec<_>, Error>>()?);
        }
        let width = self.window.width();
        planes.par_iter_mut().enumerate().for_each(|(index, plane)| {
            for (rectangle, channels) in &decoded {
                let samples = &channels[index];
                if rectangle.width() == width {
                    plane.extend_from_slice(samples);
                    continue;
                }
                let end = rectangle.y1 as usize * width;
                if plane.len() < end {
                    plane.resize(end, 0.0);
                }
                for (row, y) in samples.chunks_exact(rectangle.width()).zip(rectangle.y0..) {
                    let start = y as usize * width + rectangle.x0 as usize;
                    plane[start..start + row.len()].copy_from_slice(row);
                }
            }
        });
        Ok(())
    }

    /// The wanted channels of one chunk.
    fn decode(&self, at: Position, packed: Vec<u8>) -> Result<(Window, Vec<Vec<f32>>), Error> {
        let rectangle = self.chunks.rectangle(at);
        let raw = self.codec.decompress(rectangle, packed).map_err(|failure| self.failed(at, failure))?;
        let bytes_per_pixel = self.codec.raw_size(PIXEL);
        let channels = self.wanted.iter().map(|wanted| unpack(&raw, rectangle, *wanted, bytes_per_pixel));
        Ok((rectangle, channels.collect()))
    }

    fn failed(&self, at: Position, failure: Failure) -> Error {
        let place = self.chunks.place(at);
        match failure {
            Failure::Invalid { found, expected } => Error::invalid(&self.path, place, found, expected),
            Failure::Unsupported(found) => Error::Unsupported { path: self.path.clone(), place, found, remedy: REMEDY },
        }
    }
}

/// One pixel, to ask how many bytes it has.
const PIXEL: Window = Window::new(0, 0, 1, 1);

/// One channel of a decoded chunk as f32.
fn unpack(raw: &[u8], rectangle: Window, wanted: Wanted, bytes_per_pixel: usize) -> Vec<f32> {
    let width = rectangle.width();
    let mut samples = Vec::with_capacity(rectangle.area());
    let mut halves: Vec<half::f16> = Vec::new();
    for row in raw.chunks_exact(width * bytes_per_pixel) {
        let bytes = &row[wanted.before * width..][..wanted.sample_type.bytes() * width];
        match wanted.sample_type {
            SampleType::Half | SampleType::U16 | SampleType::U8 => {
                halves.clear();
                halves.extend(bytes.as_chunks::<2>().0.iter().map(|bytes| half::f16::from_ne_bytes(*bytes)));
                let start = samples.len();
                samples.resize(start + width, 0.0);
                halves.convert_to_f32_slice(&mut samples[start..]);
            }
            SampleType::Float => {
                samples.extend(bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_ne_bytes(*bytes)));
            }
            SampleType::Uint => {
                samples.extend(bytes.as_chunks::<4>().0.iter().map(|bytes| u32::from_ne_bytes(*bytes) as f32));
            }
        }
    }
    samples
}
