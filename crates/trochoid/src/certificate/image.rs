//! Image files as stored, with hashes of their samples in blocks; and images of certified errors.

use super::{ChannelText, ImageHashes};
use crate::exr_layer::file_channels;
use crate::files::folder_of_file;
use crate::files::target;
use crate::marks::with_marks;
use crate::{Form, OutputError, OutputFile};
use std::path::Path;
use trochoid_engine::Certified;
use trochoid_graph::CheckedGraph;
use trochoid_image::{Plane, Window};
use trochoid_io::{
    ExrChannel, ExrImage, FileKind, Limits, SampleType, Samples, Selection, info, read, read_metadata, write_exr,
};

/// Width and height of a block, in pixels.
pub(super) const BLOCK: usize = 64;

/// Decoded image file.
pub(super) struct StoredImage {
    pub(super) kind: FileKind,
    pub(super) parts: usize,
    pub(super) window: Window,
    /// Sorted by name.
    pub(super) channels: Vec<StoredChannel>,
    /// Keys and values of the metadata.
    pub(super) metadata: Vec<(String, String)>,
}

pub(super) struct StoredChannel {
    pub(super) name: String,
    pub(super) stored: SampleType,
    pub(super) plane: Plane,
}

impl StoredImage {
    /// Reads all channels of a file's first part.
    pub(super) fn read(path: &Path) -> Result<Self, trochoid_io::Error> {
        let limits = Limits::default();
        let info = info(path, &limits)?;
        let metadata = read_metadata(path)?;
        let names = info.parts[0].channels.iter().map(|channel| channel.full_name.clone());
        let picture = read(path, &Selection::channels(names).with_part(0), &limits)?;
        let channels = picture.channels.into_iter();
        let channels = channels.map(|c| StoredChannel { name: c.full_name, stored: c.sample_type, plane: c.plane });
        let mut channels: Vec<StoredChannel> = channels.collect();
        channels.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(Self { kind: info.kind, parts: info.parts.len(), window: picture.data, channels, metadata })
    }

    pub(super) fn channel(&self, name: &str) -> Option<&StoredChannel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Returns the hashes of all blocks.
    pub(super) fn hashes(&self, file: String) -> ImageHashes {
        let blocks: Vec<String> = self.window.tiles(BLOCK, BLOCK).map(|block| self.hash(block)).collect();
        ImageHashes {
            block: BLOCK as u32,
            channels: self
                .channels
                .iter()
                .map(|channel| ChannelText { name: channel.name.clone(), stored: channel.stored.to_string() })
                .collect(),
            file,
            height: self.window.height() as u32,
            kind: self.kind.to_string(),
            pixels: blake3::hash(blocks.concat().as_bytes()).to_hex().to_string(),
            width: self.window.width() as u32,
            blocks,
        }
    }

    fn hash(&self, block: Window) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut bytes = Vec::with_capacity(4 * BLOCK);
        for channel in &self.channels {
            for row in (block.y0..block.y1).filter_map(|y| channel.plane.row(y)) {
                let start = (block.x0 - self.window.x0) as usize;
                bytes.clear();
                bytes.extend(row[start..start + block.width()].iter().flat_map(|sample| sample.to_le_bytes()));
                hasher.update(&bytes);
            }
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// Writes the error bounds of a file's pixels against the references as EXR. Each channel `C` of an output has a
/// channel `error.C`, in units of the working space; `doubt` is the share of the pixel's samples that are ambiguous.
///
/// # Errors
/// The file cannot be written.
pub fn error_image(
    graph: &CheckedGraph,
    file: &OutputFile,
    certified: &[Certified],
    metadata: &[(String, String)],
    path: &Path,
) -> Result<(), OutputError> {
    folder_of_file(path)?;
    let mut channels = Vec::new();
    let mut data = graph.format().window();
    for certified in certified.iter().filter(|certified| file.outputs.contains(&certified.output)) {
        data = certified.window;
        let names = file_channels(graph, &graph.outputs()[certified.output], file);
        // The text before a channel's own name is its layer.
        let own = |name: &str, own: &str| match name.rsplit_once('.') {
            Some((layer, channel)) => (format!("{layer}.{own}.{channel}"), format!("{layer}.doubt")),
            None => (format!("{own}.{name}"), "doubt".into()),
        };
        for ((name, _), errors) in names.iter().zip(&certified.errors) {
            channels.push(ExrChannel::float(own(name, "error").0, Samples::contiguous(errors)));
        }
        if let Some((name, _)) = names.first() {
            channels.push(ExrChannel::float(own(name, "error").1, Samples::contiguous(&certified.doubt)));
        }
    }
    let metadata = with_marks(metadata, Form::Error);
    let image = ExrImage { display: graph.format().window(), channels, metadata, ..ExrImage::new(data) };
    Ok(write_exr(target(path, Form::Error, graph.access().overwrites()), &image)?)
}
