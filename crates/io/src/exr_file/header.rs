//! Headers of all parts. Every claim is checked against the file's length before anything is allocated for it.

use std::io::{BufRead, Read};

use trochoid_image::{Chromaticities, Window};

use super::attribute::{self, Fields};
use super::layout::Layout;
use super::{LONG_NAMES, MAGIC, MAX_COORDINATE, MULTI_PART, NAME_LENGTH, NON_IMAGE, TILED};
use crate::error::printable;
use crate::source::SourceFile;
use crate::{ChannelInfo, Compression, Encoding, Error, Levels, PartInfo, SampleType, Storage, names};

/// Maximum size of all headers together, in bytes: a hundred times the largest Cryptomatte manifests.
const MAX_HEADER: u64 = 64 << 20;
const MAX_PARTS: usize = 4096;
const MAX_CHANNELS: usize = 16_384;

/// Headers of an EXR file.
#[derive(Debug)]
pub(crate) struct Header {
    /// Descriptions of the parts for users.
    pub(crate) parts: Vec<PartInfo>,
    /// Further data of each part for decoding.
    pub(super) details: Vec<Detail>,
    /// Whether chunks start with the number of their part.
    pub(super) multi_part: bool,
    /// Position of the first part's table of chunk offsets.
    pub(crate) tables: u64,
}

/// Data of a part that only decoding needs.
#[derive(Debug)]
pub(super) struct Detail {
    /// Division of the part into chunks.
    pub(super) layout: Layout,
    /// Number of chunks stated by the file.
    pub(super) stated_chunks: Option<u64>,
    /// Data of each channel for decoding.
    pub(super) channels: Vec<ChannelDetail>,
    /// String attributes in order.
    pub(super) strings: Vec<(String, String)>,
}

/// Data of a channel that only decoding needs.
#[derive(Debug)]
pub(super) struct ChannelDetail {
    /// Name, which need not be UTF-8.
    pub(super) name: Vec<u8>,
    /// Whether lossy methods quantize the channel linearly.
    pub(super) linear: bool,
}

struct Attribute {
    name: String,
    kind: String,
    bytes: Vec<u8>,
}

impl Header {
    /// Reads and checks the headers of all parts.
    pub(crate) fn read(source: &mut SourceFile) -> Result<Self, Error> {
        source.seek(0)?;
        let start = source.bytes(8, "version")?;
        let mut fields = Fields(&start[4..]);
        let version = fields.u32().unwrap_or_default();
        if start[..4] != MAGIC {
            return Err(Error::invalid(&source.path, "first bytes", format!("{:02x?}", &start[..4]), "an EXR file"));
        }
        let known = TILED | LONG_NAMES | NON_IMAGE | MULTI_PART;
        if !(1..=2).contains(&(version & 0xff)) || version & !(0xff | known) != 0 {
            return Err(Error::Unsupported {
                path: source.path.clone(),
                place: "version".into(),
                found: format!("EXR version {} with flags {:#x}", version & 0xff, version >> 8),
                remedy: "re-save it as EXR version 2",
            });
        }
        let multi_part = version & MULTI_PART != 0;
        let mut reader = Reader { source, position: 8 };
        let mut header = Self { parts: Vec::new(), details: Vec::new(), multi_part, tables: 0 };
        loop {
            let index = header.parts.len();
            let mut attributes = Vec::new();
            reader.attributes(index, &mut attributes)?;
            if multi_part && attributes.is_empty() {
                break;
            }
            let (info, detail) = Builder { source: reader.source, index, version }.part(attributes)?;
            header.parts.push(info);
            header.details.push(detail);
            if !multi_part {
                break;
            }
            let channels = header.parts.iter().map(|part| part.channels.len()).sum::<usize>();
            reader.at_most("parts", header.parts.len(), MAX_PARTS)?;
            reader.at_most("channels", channels, MAX_CHANNELS)?;
        }
        if header.parts.is_empty() {
            return Err(Error::invalid(&reader.source.path, "header", "no part", "at least one"));
        }
        header.tables = reader.position;
        names::resolve(&mut header.parts);
        Ok(header)
    }

    pub(crate) fn into_parts(self) -> Vec<PartInfo> {
        self.parts
    }

    /// Returns the string attributes of the first part, in the order of the file.
    pub(crate) fn into_strings(self) -> Vec<(String, String)> {
        self.details.into_iter().next().map(|detail| detail.strings).unwrap_or_default()
    }
}

/// Returns the attributes of [`Header::into_strings`], as far as the file can be read.
pub(crate) fn readable_strings(source: &mut SourceFile) -> Vec<(String, String)> {
    let mut attributes = Vec::new();
    if source.seek(8).is_ok() {
        let _ = Reader { source, position: 8 }.attributes(0, &mut attributes);
    }
    strings(&attributes)
}

/// Returns the string attributes except for those that the format defines.
fn strings(attributes: &[Attribute]) -> Vec<(String, String)> {
    let strings = attributes.iter().filter(|a| a.kind == "string" && a.name != "name" && a.name != "type");
    strings.map(|a| (a.name.clone(), String::from_utf8_lossy(&a.bytes).into_owned())).collect()
}

/// Reader of attributes, which counts the bytes.
struct Reader<'a> {
    source: &'a mut SourceFile,
    position: u64,
}

impl Reader<'_> {
    /// Reads all attributes of one part; none at the end of the list of parts.
    fn attributes(&mut self, part: usize, attributes: &mut Vec<Attribute>) -> Result<(), Error> {
        loop {
            let place = format!("part {part}, attribute {}", attributes.len());
            let name = self.name(&place)?;
            if name.is_empty() {
                return Ok(());
            }
            let place = format!("part {part}, attribute \"{}\"", printable(&name));
            let kind = self.name(&place)?;
            let size = self.take(4, &place)?;
            let size = Fields(&size).i32().and_then(|size| u64::try_from(size).ok()).ok_or_else(|| {
                Error::invalid(&self.source.path, &*place, "a negative size", "the size of the attribute")
            })?;
            let bytes = self.take(size, &place)?;
            attributes.push(Attribute { name, kind, bytes });
        }
    }

    fn name(&mut self, place: &str) -> Result<String, Error> {
        let mut bytes = Vec::new();
        let limit = NAME_LENGTH as u64 + 1;
        let read = (&mut self.source.reader).take(limit).read_until(0, &mut bytes);
        self.position += read.map_err(Error::io(&self.source.path, "read the file"))? as u64;
        if bytes.pop() != Some(0) {
            let expected = format!("a name of at most {NAME_LENGTH} bytes that ends with a zero");
            return Err(Error::invalid(&self.source.path, place, "no end of the name", expected));
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn take(&mut self, size: u64, place: &str) -> Result<Vec<u8>, Error> {
        let rest = self.source.length.saturating_sub(self.position);
        if size > rest {
            return Err(Error::invalid(
                &self.source.path,
                place,
                format!("a size of {size} bytes"),
                format!("at most the {rest} bytes that follow"),
            ));
        }
        if self.position + size > MAX_HEADER {
            return Err(Error::TooLarge {
                path: self.source.path.clone(),
                place: place.into(),
                what: "bytes of headers",
                found: self.position + size,
                limit: MAX_HEADER,
            });
        }
        self.position += size;
        self.source.bytes(size, place)
    }

    fn at_most(&self, what: &'static str, found: usize, limit: usize) -> Result<(), Error> {
        if found <= limit {
            return Ok(());
        }
        let (path, place) = (self.source.path.clone(), "header".into());
        Err(Error::TooLarge { path, place, what, found: found as u64, limit: limit as u64 })
    }
}

/// Creates a part from its attributes.
struct Builder<'a> {
    source: &'a SourceFile,
    index: usize,
    version: u32,
}

impl Builder<'_> {
    fn part(&self, attributes: Vec<Attribute>) -> Result<(PartInfo, Detail), Error> {
        let find = |name: &str| attributes.iter().find(|attribute| attribute.name == name);
        let string = |name: &str| find(name).map(|attribute| String::from_utf8_lossy(&attribute.bytes).into_owned());
        let need = |name: &str| {
            find(name).ok_or_else(|| self.invalid("header", "no such attribute", format!("the attribute \"{name}\"")))
        };
        let data = self.window(need("dataWindow")?)?;
        let display = self.window(need("displayWindow")?)?;
        let bytes = &need("compression")?.bytes;
        let [number] = bytes[..] else {
            return Err(self.invalid("attribute \"compression\"", format!("{} bytes", bytes.len()), "1 byte"));
        };
        let compression = Compression::of_exr(number);
        let (storage, round_up) = self.storage(string("type"), find("tiles"))?;
        let (channels, details) = self.channels(need("channels")?)?;
        let stated_chunks = find("chunkCount").and_then(|a| Fields(&a.bytes).i32()).and_then(|n| u64::try_from(n).ok());
        let detail = Detail {
            layout: Layout::new(data, &storage, compression, round_up),
            stated_chunks,
            channels: details,
            strings: strings(&attributes),
        };
        let chromaticities: Option<Chromaticities> =
            find("chromaticities").and_then(|attribute| attribute::chromaticities(&attribute.bytes));
        // Space that a writer reserved has no meaning.
        let shown = attributes.iter().filter(|attribute| attribute.name != "channels" && attribute.kind != "free");
        let info = PartInfo {
            name: string("name"),
            display,
            data,
            compression,
            storage,
            layers: Vec::new(),
            channels,
            attributes: shown.map(|a| (a.name.clone(), attribute::text(&a.kind, &a.bytes))).collect(),
            chromaticities,
            encoding: Encoding::Linear,
        };
        Ok((info, detail))
    }

    fn window(&self, attribute: &Attribute) -> Result<Window, Error> {
        let place = format!("attribute \"{}\"", attribute.name);
        let window = attribute::window(&attribute.bytes)
            .ok_or_else(|| self.invalid(&place, format!("{} bytes", attribute.bytes.len()), "16 bytes"))?;
        let inside = |a: i64| a.abs() <= MAX_COORDINATE;
        let corners = [window.x0, window.y0, window.x1, window.y1];
        if window.is_empty() || !corners.into_iter().all(inside) {
            let expected = format!("a window with pixels, within ±{MAX_COORDINATE}");
            return Err(self.invalid(&place, window.to_string(), expected));
        }
        Ok(window)
    }

    /// Returns the storage, and whether the sizes of levels are rounded up.
    fn storage(&self, kind: Option<String>, tiles: Option<&Attribute>) -> Result<(Storage, bool), Error> {
        // For a single flat part the version's flag counts; some writers get its type attribute wrong.
        let flag = if self.version & TILED != 0 { "tiledimage" } else { "scanlineimage" };
        let kind = match kind {
            Some(kind) if self.version & (MULTI_PART | NON_IMAGE) != 0 => kind,
            _ => flag.into(),
        };
        match kind.as_str() {
            "scanlineimage" => Ok((Storage::Scanline, false)),
            "deepscanline" | "deeptile" => Ok((Storage::Deep, false)),
            "tiledimage" => {
                let place = "attribute \"tiles\"";
                let found = tiles
                    .ok_or_else(|| self.invalid(place, "no such attribute", "the size of tiles of a tiled part"))?;
                let limit = MAX_COORDINATE as u32;
                match attribute::tiles(&found.bytes) {
                    Some((width @ 1.., height @ 1.., levels, up)) if width <= limit && height <= limit => {
                        Ok((Storage::Tiled { width, height, levels }, up && levels != Levels::One))
                    }
                    _ => Err(self.invalid(place, format!("bytes {:02x?}", found.bytes), "size, levels and rounding")),
                }
            }
            _ => Ok((Storage::Other(kind), false)),
        }
    }

    fn channels(&self, attribute: &Attribute) -> Result<(Vec<ChannelInfo>, Vec<ChannelDetail>), Error> {
        let place = "attribute \"channels\"";
        let (mut channels, mut details): (Vec<ChannelInfo>, Vec<ChannelDetail>) = Default::default();
        let mut fields = Fields(&attribute.bytes);
        let cut = || self.invalid(place, "the end of the list within a channel", "16 bytes after each name");
        loop {
            let name = fields.name().ok_or_else(cut)?;
            if name.is_empty() {
                break;
            }
            let full_name = String::from_utf8_lossy(name).into_owned();
            let place = format!("channel \"{}\"", printable(&full_name));
            if name.len() > NAME_LENGTH {
                return Err(self.invalid(&place, format!("{} bytes", name.len()), "a name of at most 255 bytes"));
            }
            // Rows store channels in the order of their names; in any other order the channels could not be identified.
            if details.last().is_some_and(|last| last.name.as_slice() >= name) {
                return Err(self.invalid(&place, "a name out of order", "channels sorted by name, each once"));
            }
            if channels.len() == MAX_CHANNELS {
                return Err(self.invalid(&place, format!("more than {MAX_CHANNELS} channels"), "fewer"));
            }
            let number = fields.i32().ok_or_else(cut)?;
            let sample_type = match number {
                0 => SampleType::Uint,
                1 => SampleType::Half,
                2 => SampleType::Float,
                _ => return Err(self.invalid(&place, format!("sample type {number}"), "0, 1 or 2")),
            };
            let flags = fields.u32().ok_or_else(cut)?;
            let sampling = [fields.i32().ok_or_else(cut)?, fields.i32().ok_or_else(cut)?];
            if sampling.iter().any(|&step| step < 1) {
                return Err(self.invalid(&place, format!("sampling {sampling:?}"), "steps of 1 or more"));
            }
            channels.push(ChannelInfo { full_name, layer: String::new(), base: String::new(), sample_type, sampling });
            details.push(ChannelDetail { name: name.to_vec(), linear: flags & 0xff != 0 });
        }
        if channels.is_empty() {
            return Err(self.invalid(place, "an empty list", "at least one channel"));
        }
        Ok((channels, details))
    }

    fn invalid(&self, place: &str, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::invalid(&self.source.path, format!("part {}, {place}", self.index), found, expected)
    }
}
