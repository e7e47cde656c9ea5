//! Reading of one part's pixels, band by band, from any thread.

use std::path::Path;
use std::sync::Arc;

use trochoid_image::{Plane, Window};

use super::band::{BandBuffer, ChunkTarget, Stored};
use super::chunks::{Chunks, Position};
use super::codec::{Codec, Described};
use super::failure::Failure;
use super::header::Header;
use super::parallel::in_order;
use crate::limits::{grow, zeroed};
use crate::source::{self, ReadAt, SourceFile};
use crate::{Error, FileKind, Limits, PartInfo, Picture, PictureInfo, Selection, Storage};

/// Remedy for a valid file that is not supported.
const REMEDY: &str = "re-save it as flat scanlines or tiles with ZIP compression";

/// Minimum number of rows that one thread reads in a row.
const GROUP: usize = 16;

/// EXR file opened for reading band by band: a few rows at a time, by any number of threads, in any order.
///
/// A band is one block of rows as stored in the file (16 for ZIP, 1 for ZIPS), or one row of tiles. Only the
/// [`BandBuffer`]s hold memory.
///
/// ```
/// use trochoid_image::{Plane, Window};
/// use trochoid_io::{BandBuffer, ExrChannel, ExrImage, ExrReader, Limits, Samples, Selection, write_exr};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("depth.exr");
/// let depth = Plane::filled(Window::sized(4, 40), 12.5);
/// let channels = vec![ExrChannel::float("Z", Samples::plane(&depth))];
/// write_exr(&path, &ExrImage { channels, ..ExrImage::new(depth.window()) })?;
///
/// let reader = ExrReader::open(&path, &Selection::channels(["Z"]), &Limits::default())?;
/// assert_eq!(reader.info().channels[0].full_name, "Z");
/// let mut buffer = BandBuffer::new();
/// let mut row = [0.0; 2];
/// for band in 0..reader.bands() {
///     reader.decode(band, &mut buffer)?;
///     for y in buffer.window().y0..buffer.window().y1 {
///         buffer.row_f32(0, y, 1, &mut row);
///         assert_eq!(row, [12.5, 12.5]);
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ExrReader {
    info: PictureInfo,
    /// Part with all its channels.
    part: Arc<PartInfo>,
    file: Arc<dyn ReadAt>,
    chunks: Arc<Chunks>,
    codec: Arc<Codec>,
    /// Selected channels, in the order of the selection.
    stored: Vec<Stored>,
    /// Indices of the selected channels in the part.
    channels: Vec<usize>,
    /// For each channel of the file, the words per pixel of the selected channels before it; `None` if it is not
    /// selected.
    places: Vec<Option<usize>>,
    /// Words per pixel of the selected channels.
    words: usize,
    limits: Limits,
    /// Number of bands that threads may decode at the same time within the limits.
    at_once: usize,
}

impl ExrReader {
    /// Opens a file, and reads its header and table of chunks, but no pixels.
    ///
    /// # Errors
    /// The file cannot be opened, is not an EXR, has a damaged header, is not supported, lacks what is selected, or
    /// exceeds the limits, where [`Limits::bytes`] applies to one band.
    pub fn open(path: impl AsRef<Path>, selection: &Selection, limits: &Limits) -> Result<Self, Error> {
        let mut source = source::open(path.as_ref())?;
        match source.kind()? {
            FileKind::Exr => Self::of(source, selection, limits),
            kind => Err(Error::invalid(&source.path, "first bytes", format!("a {kind} file"), "an EXR file")),
        }
    }

    pub(crate) fn of(mut source: SourceFile, selection: &Selection, limits: &Limits) -> Result<Self, Error> {
        let header = Header::read(&mut source)?;
        let found = selection.resolve(&source.path, &header.parts)?;
        let part = &header.parts[found.part];
        part.check_windows(&source.path, found.part, limits)?;
        let codec = supported(&source, &header, found.part)?;

        let layout = header.details[found.part].layout;
        let bytes_per_pixel: u64 = part.channels.iter().map(|channel| channel.sample_type.bytes() as u64).sum();
        let largest = layout.largest().saturating_mul(bytes_per_pixel);
        let place = part.place(found.part);
        // The format stores the sizes of chunks in 31 bits.
        let step = Limits { bytes: limits.bytes.min(i32::MAX as u64), ..*limits };
        step.check_bytes(&source.path, &format!("{place}, one chunk"), largest)?;
        // Decoding a chunk needs several times its size.
        let at_once = usize::try_from(limits.bytes / largest.saturating_mul(4).max(1)).unwrap_or(usize::MAX).max(1);

        let chunks = Chunks::find(&mut source, &header, found.part)?;
        let reader = Self {
            info: PictureInfo::new(part, found.part, &[]),
            part: Arc::new(part.clone()),
            file: source.share(),
            chunks: Arc::new(chunks),
            codec: Arc::new(codec),
            stored: Vec::new(),
            channels: Vec::new(),
            places: Vec::new(),
            words: 0,
            limits: *limits,
            at_once,
        };
        reader.choose(found.channels)
    }

    /// Returns a reader of the same open file with these channels of the part.
    fn choose(&self, channels: Vec<usize>) -> Result<Self, Error> {
        let (part, layout) = (&self.part, self.chunks.layout);
        let mut places = vec![None; part.channels.len()];
        let mut stored = Vec::new();
        let mut words = 0;
        for &index in &channels {
            let sample_type = part.channels[index].sample_type;
            // A channel may be selected twice.
            let before = *places[index].get_or_insert(words);
            if before == words {
                words += sample_type.bytes() / 2;
            }
            stored.push(Stored { sample_type, before });
        }
        let band = (layout.window.width() as u64).saturating_mul(layout.height.min(layout.window.height()) as u64);
        let place = format!("{}, one row of chunks", self.chunks.place);
        self.limits.check_bytes(&self.chunks.path, &place, band.saturating_mul(2 * words as u64))?;
        Ok(Self {
            info: PictureInfo::new(part, self.info.part, &channels),
            part: part.clone(),
            file: self.file.clone(),
            chunks: self.chunks.clone(),
            codec: self.codec.clone(),
            stored,
            channels,
            places,
            words,
            ..*self
        })
    }

    /// Returns a reader of the same open file with some of the channels, by their positions in [`ExrReader::info`].
    ///
    /// # Errors
    /// Only errors that opening the file can return.
    ///
    /// # Panics
    /// There is no channel at a position.
    pub fn narrowed(&self, channels: &[usize]) -> Result<Self, Error> {
        self.choose(channels.iter().map(|&channel| self.channels[channel]).collect())
    }

    /// Returns a reader of the same open file with the channels of this reader and some of another reader of the same
    /// part, which are decoded together; and the positions of the latter among all channels.
    ///
    /// # Errors
    /// The other reader reads another file or part, or both together exceed the limits.
    ///
    /// # Panics
    /// The other reader has no channel at a position.
    pub fn joined(&self, other: &Self, channels: &[usize]) -> Result<(Self, Vec<usize>), Error> {
        let looks = |reader: &Self| (reader.info.part, reader.part.data, reader.part.display, reader.part.compression);
        if looks(self) != looks(other)
            || self.part.storage != other.part.storage
            || self.part.channels != other.part.channels
        {
            let expected = "the header of the same file; it has changed since it was opened";
            let place = &*self.chunks.place;
            return Err(Error::invalid(&self.chunks.path, place, "another header", expected));
        }
        let mut all = self.channels.clone();
        let add = |&channel: &usize| {
            let index = other.channels[channel];
            all.iter().position(|&known| known == index).unwrap_or_else(|| {
                all.push(index);
                all.len() - 1
            })
        };
        let found = channels.iter().map(add).collect();
        Ok((self.choose(all)?, found))
    }

    /// Returns the description of the selected channels.
    pub fn info(&self) -> &PictureInfo {
        &self.info
    }

    /// Returns the number of rows in a band; the last band may have fewer.
    pub fn rows_per_band(&self) -> usize {
        self.chunks.layout.height
    }

    /// Returns the maximum size of a decoded band, in bytes.
    pub fn band_bytes(&self) -> usize {
        2 * self.words * self.info.data.width() * self.rows_per_band().min(self.info.data.height())
    }

    /// Returns the maximum memory for decoding the picture, in bytes, in addition to the result.
    pub(crate) fn decoding(&self) -> u64 {
        let layout = self.chunks.layout;
        let chunk = layout.largest().saturating_mul(self.codec.raw_size(Window::sized(1, 1)) as u64);
        let threads = self.at_once.min(rayon::current_num_threads()) as u64;
        threads.saturating_mul(chunk.saturating_mul(4).saturating_add(self.band_bytes() as u64))
    }

    /// Returns the number of bands, which are counted from the top.
    pub fn bands(&self) -> usize {
        self.chunks.layout.bands()
    }

    /// Returns the window of a band: whole rows of the data window; empty for a band that does not exist.
    pub fn band_window(&self, band: usize) -> Window {
        self.chunks.layout.band(band)
    }

    /// Returns the band that contains row `y` of the picture; `None` outside the data window.
    pub fn band_at(&self, y: i64) -> Option<usize> {
        let data = self.info.data;
        (data.y0..data.y1).contains(&y).then(|| (y - data.y0) as usize / self.rows_per_band())
    }

    /// Reads and decompresses one band.
    ///
    /// After an error the buffer is empty.
    ///
    /// # Errors
    /// The band's chunks are damaged or missing, or the file cannot be read.
    ///
    /// # Panics
    /// There is no such band.
    pub fn decode(&self, band: usize, buffer: &mut BandBuffer) -> Result<(), Error> {
        assert!(band < self.bands(), "band {band} of {}", self.bands());
        buffer.window = Window::default();
        buffer.channels.clone_from(&self.stored);
        let window = self.band_window(band);
        for column in 0..self.chunks.layout.columns() {
            let at = Position { column, band };
            let rectangle = self.chunks.rectangle(at);
            let packed = self.chunks.read(&*self.file, at, self.codec.raw_size(rectangle), &mut buffer.packed)?;
            self.codec.check(rectangle, packed).map_err(|failure| self.failed(at, failure))?;
            grow(&mut buffer.words, self.words * window.area())
                .map_err(|bytes| self.failed(at, Failure::Memory(bytes)))?;
            let mut target = ChunkTarget {
                words: &mut buffer.words,
                places: &self.places,
                band: window,
                chunk: Window { x0: window.x0 + rectangle.x0, x1: window.x0 + rectangle.x1, ..window },
            };
            let unpacked = self.codec.unpack(rectangle, packed, &mut buffer.inflater, &mut target);
            unpacked.map_err(|failure| self.failed(at, failure))?;
        }
        buffer.window = window;
        Ok(())
    }

    /// Decodes all bands on all threads.
    pub(crate) fn picture(&self) -> Result<Picture, Error> {
        let Chunks { path, place, .. } = &*self.chunks;
        let data = self.info.data;
        self.limits.check_planes(path, place, data, self.stored.len())?;
        let (claimed, most) = (self.codec.raw_size(data) as u64, self.codec.most(self.chunks.length));
        if claimed > most {
            let (found, expected) =
                (format!("{} bytes", self.chunks.length), format!("enough for {claimed} of samples"));
            return Err(Error::invalid(path, &**place, found, expected));
        }
        let mut planes: Vec<Vec<f32>> = Vec::new();
        for _ in &self.stored {
            // Touched band by band, so that memory is taken only for pixels that the file really contains.
            planes.push(zeroed(path, place, data.area())?);
        }
        // If bands are single rows, one thread decodes neighbors, which are read together.
        let bands_at_once = GROUP.div_ceil(self.rows_per_band());
        let area = self.rows_per_band().saturating_mul(bands_at_once).saturating_mul(data.width());
        let mut rows: Vec<_> = planes.iter_mut().map(|plane| plane.chunks_mut(area)).collect();
        let groups = (0..self.bands()).step_by(bands_at_once);
        let groups = groups.map(|first| (first, rows.iter_mut().filter_map(Iterator::next).collect()));
        in_order(groups, self.at_once, |buffer: &mut BandBuffer, (first, mut planes): (usize, Vec<&mut [f32]>)| {
            for band in first..self.bands().min(first + bands_at_once) {
                self.decode(band, buffer)?;
                for (channel, plane) in planes.iter_mut().enumerate() {
                    let out = plane.split_off_mut(..buffer.window.area()).unwrap_or_default();
                    buffer.copy_rows(channel, buffer.window, out);
                }
            }
            Ok(())
        })?;
        let incomplete = |error: trochoid_image::PlaneError| {
            Error::invalid(path, &**place, error.to_string(), "chunks that fill the data window")
        };
        let planes = planes.into_iter().map(|samples| Plane::new(data, samples).map_err(incomplete));
        Ok(self.info.clone().with_planes(planes.collect::<Result<_, _>>()?))
    }

    fn failed(&self, at: Position, failure: Failure) -> Error {
        let (path, place) = (&self.chunks.path, self.chunks.place(at));
        match failure {
            Failure::Invalid { found, expected } => Error::invalid(path, place, found, expected),
            Failure::Unsupported(found) => {
                Error::Unsupported { path: path.clone(), place, found: found.into(), remedy: REMEDY }
            }
            Failure::Memory(bytes) => Error::OutOfMemory { path: path.clone(), place, bytes },
        }
    }
}

impl std::fmt::Debug for ExrReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExrReader").field("path", &self.chunks.path).field("info", &self.info).finish_non_exhaustive()
    }
}

/// Returns the codec of a part, or the reason that it is not supported.
fn supported(source: &SourceFile, header: &Header, part: usize) -> Result<Codec, Error> {
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
    let described = info.channels.iter().zip(&detail.channels).map(|(channel, detail)| Described {
        name: &detail.name,
        sample_type: channel.sample_type,
        linear: detail.linear,
    });
    Codec::new(info.compression, &detail.layout, described)
        .ok_or_else(|| refuse(info.place(part), format!("{} compression", info.compression)))
}
