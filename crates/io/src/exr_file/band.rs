//! Decoded bands, whose samples are kept as stored and converted to f32 on request.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use trochoid_image::Window;

use super::chunks::Part;
use super::codec::Target;
use super::zip::Inflater;
use crate::SampleType;

/// Reusable buffer with the selected channels of one band of a file.
///
/// [`ExrReader::decode`](crate::ExrReader::decode) fills it; each thread has its own. Samples are kept as stored, for
/// example as half, and are converted to f32 when rows are requested.
#[derive(Default)]
pub struct BandBuffer {
    pub(super) window: Window,
    /// Selected channels, in the order of the selection.
    pub(super) channels: Vec<Stored>,
    /// Samples by channel, then by row; 32-bit samples as two words, low word first.
    pub(super) words: Vec<u16>,
    pub(super) packed: Part,
    pub(super) inflater: Inflater,
}

/// Place of a channel's samples in a band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub(super) sample_type: SampleType,
    /// Words per pixel of all channels before this one.
    pub(super) before: usize,
}

impl BandBuffer {
    /// Creates an empty buffer.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the window of the band that was decoded last: whole rows of the data window; empty if there is none.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Swaps the decoded samples with those of another buffer. The scratch memory for decoding stays, so that one
    /// buffer can decode many bands that are kept elsewhere.
    pub fn exchange(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.window, &mut other.window);
        std::mem::swap(&mut self.channels, &mut other.channels);
        std::mem::swap(&mut self.words, &mut other.words);
    }

    /// Returns the memory held, in bytes.
    pub fn bytes(&self) -> usize {
        size_of::<u16>() * self.words.capacity() + self.packed.bytes()
    }

    /// Copies samples of row `y` from column `x0` on, as many as fit in `out`.
    ///
    /// `channel` is an index into the channels of [`ExrReader::info`](crate::ExrReader::info); `x0` and `y` are pixel
    /// coordinates of the picture.
    ///
    /// # Panics
    /// The band has no such channel or pixels.
    pub fn row_f32(&self, channel: usize, y: i64, x0: i64, out: &mut [f32]) {
        let window = self.window;
        let wanted = Window::new(x0, y, x0.saturating_add(out.len() as i64), y.saturating_add(1));
        assert!(window.intersect(wanted) == wanted, "the band {window} does not hold the pixels {wanted}");
        let Stored { sample_type, before } = self.channels[channel];
        let index = (y - window.y0) as usize * window.width() + (x0 - window.x0) as usize;
        let words = sample_type.bytes() / 2;
        let samples = &self.words[before * window.area() + index * words..][..out.len() * words];
        let pairs = samples.as_chunks().0.iter().map(|&[low, high]| u32::from(low) | u32::from(high) << 16);
        match sample_type {
            SampleType::Float => out.iter_mut().zip(pairs).for_each(|(out, bits)| *out = f32::from_bits(bits)),
            SampleType::Uint => out.iter_mut().zip(pairs).for_each(|(out, bits)| *out = bits as f32),
            // EXR has no other types.
            SampleType::Half | SampleType::U16 | SampleType::U8 => {
                samples.reinterpret_cast::<f16>().convert_to_f32_slice(out);
            }
        }
    }

    /// Returns the samples of row `y` by their bits; `None` unless the channel is one of halves.
    ///
    /// # Panics
    /// The band has no such channel or row.
    pub fn row_bits(&self, channel: usize, y: i64) -> Option<&[u16]> {
        let Stored { sample_type, before } = self.channels[channel];
        let width = self.window.width();
        let start = before * self.window.area() + (y - self.window.y0) as usize * width;
        (sample_type == SampleType::Half).then(|| &self.words[start..start + width])
    }

    /// Copies all samples of `window`, row by row.
    ///
    /// # Panics
    /// The band has no such channel or pixels, or `out` has another size than the window.
    pub fn copy_rows(&self, channel: usize, window: Window, out: &mut [f32]) {
        assert!(out.len() == window.area(), "{} samples for the window {window}", out.len());
        if window.is_empty() {
            return;
        }
        for (row, y) in out.chunks_exact_mut(window.width()).zip(window.y0..) {
            self.row_f32(channel, y, window.x0, row);
        }
    }
}

impl std::fmt::Debug for BandBuffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BandBuffer").field("window", &self.window).field("channels", &self.channels).finish()
    }
}

/// Place of a chunk in the words of its band.
pub(super) struct ChunkTarget<'a> {
    pub(super) words: &'a mut [u16],
    /// For each channel of the file, the words per pixel of the selected channels before it; `None` if it is not
    /// selected.
    pub(super) places: &'a [Option<usize>],
    pub(super) band: Window,
    /// Window of the chunk, in the same coordinates as the band.
    pub(super) chunk: Window,
}

impl Target for ChunkTarget<'_> {
    fn row(&mut self, channel: usize, row: usize, words: usize) -> Option<&mut [u16]> {
        let before = self.places[channel]?;
        let index = row * self.band.width() + (self.chunk.x0 - self.band.x0) as usize;
        let start = before * self.band.area() + index * (words / self.chunk.width());
        Some(&mut self.words[start..start + words])
    }
}
