//! A decoded band: samples as stored, turned into f32 where they are wanted.

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use trochoid_image::Window;

use super::chunks::Part;
use super::codec::Target;
use super::zip::Inflater;
use crate::SampleType;

/// The wanted channels of one band of a file, in memory that is used again for the next band.
///
/// [`ExrReader::decode`](crate::ExrReader::decode) fills it; each thread has its own. Samples stay as they are stored, half
/// as half, and become f32 where rows are asked for.
#[derive(Default)]
pub struct BandBuffer {
    pub(super) window: Window,
    /// The channels wanted, in the order of the selection.
    pub(super) channels: Vec<Stored>,
    /// Channel after channel, row after row; 32-bit samples as two words, the low one first.
    pub(super) words: Vec<u16>,
    pub(super) packed: Part,
    pub(super) inflater: Inflater,
}

/// Where a band has the samples of a channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    pub(super) sample_type: SampleType,
    /// Words of the channels before, of one pixel.
    pub(super) before: usize,
}

impl BandBuffer {
    /// An empty buffer.
    pub fn new() -> Self {
        Self::default()
    }

    /// Pixels of the band that was decoded last: whole rows of the data window; empty if there is none.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Exchanges the decoded samples with those of another buffer. What decoding needs besides stays, so that one buffer can
    /// decode many bands that are kept.
    pub fn exchange(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.window, &mut other.window);
        std::mem::swap(&mut self.channels, &mut other.channels);
        std::mem::swap(&mut self.words, &mut other.words);
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<u16>() * self.words.capacity() + self.packed.bytes()
    }

    /// Samples of row `y` from column `x0` on, as many as `out` holds.
    ///
    /// `channel` counts the channels of [`ExrReader::info`](crate::ExrReader::info); `x0` and `y` are pixels of the picture.
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
            // EXR has no others.
            SampleType::Half | SampleType::U16 | SampleType::U8 => {
                samples.reinterpret_cast::<f16>().convert_to_f32_slice(out);
            }
        }
    }

    /// All samples of `window`, row by row.
    ///
    /// # Panics
    /// The band has no such channel or pixels, or `out` is not as large as the window.
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

/// A chunk's place within the words of its band.
pub(super) struct ChunkTarget<'a> {
    pub(super) words: &'a mut [u16],
    /// For each channel of the file, words of the wanted ones before it, of one pixel; none where it is not wanted.
    pub(super) places: &'a [Option<usize>],
    pub(super) band: Window,
    /// Pixels of the chunk, counted like the band's.
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
