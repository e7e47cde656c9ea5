//! Writing of EXR band by band, from any thread: one part of scanlines with ZIP compression.

use std::collections::BTreeMap;
use std::io::{Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::Mutex;

use half::f16;
use half::slice::{HalfBitsSliceExt, HalfFloatSliceExt};
use trochoid_image::Window;

use super::layout::Layout;
use super::parallel::{in_order, lock};
use super::write_header::{self, ExrHeader};
use super::zip::Deflater;
use crate::atomic::AtomicFile;
use crate::{Compression, Error, SampleType, Samples, Storage, Target};

/// Largest finite half.
const MAX_HALF: f32 = 65504.0;
/// Maximum number of used buffers that are kept for further bands.
const SPARE: usize = 64;

/// EXR file being written band by band: 16 rows at a time, compressed by any number of threads, in any order.
///
/// The bytes of the file do not depend on that order. The whole file appears with [`ExrWriter::finish`]; without it, an
/// existing file stays unchanged.
///
/// ```
/// use trochoid_image::Window;
/// use trochoid_io::{EncodeScratch, ExrHeader, ExrWriter, SampleType, read_metadata};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("ramp.exr");
/// let header = ExrHeader {
///     channels: vec![("R".into(), SampleType::Half), ("Z".into(), SampleType::Float)],
///     late_metadata: 64,
///     ..ExrHeader::new(Window::sized(4, 40))
/// };
/// let writer = ExrWriter::create(&path, &header)?;
/// std::thread::scope(|scope| {
///     let halves = [0..writer.bands() / 2, writer.bands() / 2..writer.bands()];
///     let threads = halves.map(|bands| {
///         scope.spawn(|| {
///             let mut scratch = EncodeScratch::new();
///             for band in bands {
///                 let rows = vec![0.5; writer.band_window(band).area()];
///                 writer.push(writer.encode(band, &[&rows, &rows], &mut scratch)?)?;
///             }
///             Ok::<(), trochoid_io::Error>(())
///         })
///     });
///     threads.into_iter().try_for_each(|thread| thread.join().expect("no panic"))
/// })?;
/// writer.finish(&[("trochoid:frame".into(), "17".into())])?;
/// assert_eq!(read_metadata(&path)?, [("trochoid:frame".into(), "17".into())]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ExrWriter {
    path: PathBuf,
    header: ExrHeader,
    layout: Layout,
    /// Indices into the header's channels, in the order of their names, in which chunks store them.
    sorted: Vec<usize>,
    /// Words per pixel.
    words: usize,
    state: Mutex<State>,
}

/// State that threads change in turn when they push bands.
struct State {
    file: AtomicFile,
    /// Position of the next chunk.
    position: u64,
    /// Positions of the chunks so far.
    table: Vec<u8>,
    /// Bands that arrived before their predecessors.
    early: BTreeMap<usize, Vec<u8>>,
    spare: Vec<Vec<u8>>,
}

/// Reusable memory of a thread that encodes bands.
#[derive(Default)]
pub struct EncodeScratch {
    words: Vec<u16>,
    row: Vec<f32>,
    deflater: Deflater,
}

impl EncodeScratch {
    /// Creates empty scratch memory, which grows with the first band.
    pub fn new() -> Self {
        Self::default()
    }
}

impl std::fmt::Debug for EncodeScratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("EncodeScratch").finish_non_exhaustive()
    }
}

/// Compressed band, which [`ExrWriter::encode`] returns and [`ExrWriter::push`] takes.
#[derive(Debug)]
pub struct EncodedBand {
    band: usize,
    bytes: Vec<u8>,
}

impl ExrWriter {
    /// Starts writing a file.
    ///
    /// # Errors
    /// Names clash or do not fit EXR, a sample type is neither half nor float, a window is empty or beyond 30 bits, or
    /// the file cannot be created.
    pub fn create(target: impl Into<Target>, header: &ExrHeader) -> Result<Self, Error> {
        let target = target.into();
        let path = target.path();
        let mut sorted: Vec<usize> = (0..header.channels.len()).collect();
        sorted.sort_by(|&a, &b| header.channels[a].0.cmp(&header.channels[b].0));
        write_header::check(path, header, &sorted)?;
        let layout = Layout::new(header.data, &Storage::Scanline, Compression::Zip, false);
        let words = header.channels.iter().map(|(_, sample_type)| sample_type.bytes() / 2).sum();
        if layout.largest().saturating_mul(2 * words as u64) > i32::MAX as u64 {
            let found = format!("rows of {} pixels", header.data.width());
            return Err(Error::unwritable(path, found, "16 rows must stay below 2 GiB"));
        }
        let mut file = AtomicFile::create(&target)?;
        // The header and the table are written last, into the space reserved here.
        let position = (write_header::encode(header, &sorted, &[]).len() + 8 * layout.bands()) as u64;
        file.writer.seek(SeekFrom::Start(position)).map_err(Error::io(path, "write the file"))?;
        let state = State { file, position, table: Vec::new(), early: BTreeMap::new(), spare: Vec::new() };
        Ok(Self { path: path.into(), header: header.clone(), layout, sorted, words, state: Mutex::new(state) })
    }

    /// Returns the description of the file.
    pub fn header(&self) -> &ExrHeader {
        &self.header
    }

    /// Returns the number of rows in a band; the last band may have fewer.
    pub fn rows_per_band(&self) -> usize {
        self.layout.height
    }

    /// Returns the number of bands, which are counted from the top.
    pub fn bands(&self) -> usize {
        self.layout.bands()
    }

    /// Returns the window of a band: whole rows of the data window; empty for a band that does not exist.
    pub fn band_window(&self, band: usize) -> Window {
        self.layout.band(band)
    }

    /// Compresses one band: for each channel in the header's order, all its samples of that band, row by row.
    ///
    /// # Errors
    /// A finite value beyond ±65504 for a half channel; samples that do not fill the band.
    pub fn encode(&self, band: usize, rows: &[&[f32]], scratch: &mut EncodeScratch) -> Result<EncodedBand, Error> {
        let area = self.band_window(band).area();
        if area == 0 || rows.len() != self.header.channels.len() || rows.iter().any(|samples| samples.len() != area) {
            let lengths: Vec<usize> = rows.iter().map(|samples| samples.len()).collect();
            let found = format!("band {band} of {area} pixels with channels of {lengths:?} samples");
            return Err(Error::unwritable(&self.path, found, "pass all channels of a band, one sample per pixel"));
        }
        let samples: Vec<Samples<'_>> = rows.iter().map(|samples| Samples::contiguous(samples)).collect();
        self.encode_samples(band, &samples, 0, scratch)
    }

    /// Compresses samples that begin at `start`.
    pub(super) fn encode_samples(
        &self,
        band: usize,
        samples: &[Samples<'_>],
        start: usize,
        scratch: &mut EncodeScratch,
    ) -> Result<EncodedBand, Error> {
        let window = self.band_window(band);
        let width = window.width();
        scratch.words.resize(window.area() * self.words, 0);
        let mut rest = &mut scratch.words[..];
        for (row, y) in (window.y0..window.y1).enumerate() {
            for &channel in &self.sorted {
                let values = samples[channel].row(start + row * width, width, &mut scratch.row);
                let sample_type = self.header.channels[channel].1;
                let out = rest.split_off_mut(..width * sample_type.bytes() / 2).unwrap_or_default();
                if sample_type == SampleType::Half {
                    self.check_half(channel, values, y)?;
                    out.reinterpret_cast_mut::<f16>().convert_from_f32_slice(values);
                } else {
                    for (words, value) in out.as_chunks_mut().0.iter_mut().zip(values) {
                        let bits = value.to_bits();
                        *words = [bits as u16, (bits >> 16) as u16];
                    }
                }
            }
        }
        let mut bytes = lock(&self.state).spare.pop().unwrap_or_default();
        bytes.extend((window.y0 as i32).to_le_bytes());
        bytes.extend([0; 4]);
        scratch.deflater.deflate(&scratch.words, &mut bytes);
        let size = (bytes.len() - 8) as i32;
        bytes[4..8].copy_from_slice(&size.to_le_bytes());
        Ok(EncodedBand { band, bytes })
    }

    /// Calls `work` with every band and a thread's scratch memory, on all threads, until one call fails.
    ///
    /// # Errors
    /// The first error of `work`.
    pub fn each_band<S: Default, E: Send>(
        &self,
        work: impl Fn(usize, &mut S) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        in_order(0..self.bands(), usize::MAX, |scratch, band| work(band, scratch))
    }

    /// Refuses the first value of a row that half cannot represent; NaN and infinities are accepted.
    fn check_half(&self, channel: usize, values: &[f32], y: i64) -> Result<(), Error> {
        let bad = |value: &f32| value.is_finite() && value.abs() > MAX_HALF;
        // Without a branch per value, eight or more are compared at once.
        if !values.iter().fold(false, |any, value| any | bad(value)) {
            return Ok(());
        }
        let column = values.iter().position(bad).unwrap_or_default();
        Err(Error::Unrepresentable {
            path: self.path.clone(),
            channel: self.header.channels[channel].0.clone(),
            x: self.header.data.x0 + column as i64,
            y,
            value: values[column],
            expected: "at most ±65504, the largest half: set \"precision\": \"float\" of the output",
        })
    }

    /// Adds a band to the file, in any order, from any thread.
    ///
    /// A band is held in memory until all bands before it have been pushed.
    ///
    /// # Errors
    /// The band has been pushed before, or the file cannot be written.
    pub fn push(&self, encoded: EncodedBand) -> Result<(), Error> {
        let mut state = lock(&self.state);
        let state = &mut *state;
        let EncodedBand { band, bytes } = encoded;
        let written = state.table.len() / 8;
        if band < written || band >= self.bands() || state.early.insert(band, bytes).is_some() {
            let found = format!("band {band} of {}", self.bands());
            return Err(Error::unwritable(&self.path, found, "push every band of this file once"));
        }
        while let Some(mut bytes) = state.early.remove(&(state.table.len() / 8)) {
            state.file.writer.write_all(&bytes).map_err(Error::io(&self.path, "write the file"))?;
            state.table.extend(state.position.to_le_bytes());
            state.position += bytes.len() as u64;
            if state.spare.len() < SPARE {
                bytes.clear();
                state.spare.push(bytes);
            }
        }
        Ok(())
    }

    /// Completes the file with late metadata, and moves it to its place.
    ///
    /// # Errors
    /// A band is missing, the metadata clash with the header's or exceed [`ExrHeader::late_metadata`], or the file
    /// cannot be written.
    pub fn finish(self, late: &[(String, String)]) -> Result<(), Error> {
        write_header::check_late(&self.path, &self.header, late)?;
        let State { mut file, table, .. } = self.state.into_inner().unwrap_or_else(|error| error.into_inner());
        let (written, bands) = (table.len() / 8, self.layout.bands());
        if written < bands {
            let found = format!("a picture without band {written} of {bands}");
            return Err(Error::unwritable(&self.path, found, "push every band of this file once"));
        }
        let header = write_header::encode(&self.header, &self.sorted, late);
        let io = |error| Error::io(&self.path, "write the file")(error);
        file.writer.seek(SeekFrom::Start(0)).map_err(io)?;
        file.writer.write_all(&header).map_err(io)?;
        file.writer.write_all(&table).map_err(io)?;
        file.commit()
    }
}

impl std::fmt::Debug for ExrWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExrWriter").field("path", &self.path).field("header", &self.header).finish_non_exhaustive()
    }
}
