//! Lookup of channels by name, both in a file that is only opened and in a decoded picture.

use super::reading::selected;
use super::{decode, filled, header, shared};
use std::path::Path;
use trochoid_graph::{FrameContext, ItemName, NodeError, Prepare};
use trochoid_io::{Error, ExrReader, Picture, PictureInfo, SampleType, Selection};

/// Channels by name.
pub(crate) struct Names<'a> {
    pub(crate) part: usize,
    /// Base names and full names.
    list: Vec<(&'a str, &'a str)>,
}

impl<'a> From<&'a Picture> for Names<'a> {
    fn from(picture: &'a Picture) -> Self {
        let list = picture.channels.iter().map(|channel| (&*channel.name, &*channel.full_name)).collect();
        Self { part: picture.part, list }
    }
}

impl<'a> From<&'a PictureInfo> for Names<'a> {
    fn from(info: &'a PictureInfo) -> Self {
        let list = info.channels.iter().map(|channel| (&*channel.base, &*channel.full_name)).collect();
        Self { part: info.part, list }
    }
}

impl Names<'_> {
    pub(crate) fn count(&self) -> usize {
        self.list.len()
    }

    /// Returns the full names of all channels, for messages.
    pub(crate) fn all(&self) -> String {
        self.some(&(0..self.list.len()).collect::<Vec<_>>())
    }

    /// Returns the full names of some channels, for messages.
    pub(crate) fn some(&self, at: &[usize]) -> String {
        const SHOWN: usize = 12;
        let mut names: Vec<String> = at.iter().take(SHOWN).map(|&at| format!("\"{}\"", self.list[at].1)).collect();
        if at.len() > SHOWN {
            names.push(format!("{} more", at.len() - SHOWN));
        }
        names.join(", ")
    }

    /// Returns the full names of some channels.
    pub(crate) fn full(&self, at: &[usize]) -> Vec<String> {
        at.iter().map(|&index| self.list[index].1.to_owned()).collect()
    }

    /// Returns the positions of the channels named `bases`, ignoring case; `None` unless all are present.
    pub(crate) fn positions<const N: usize>(&self, bases: [&str; N]) -> Option<[usize; N]> {
        self.among(&(0..self.list.len()).collect::<Vec<_>>(), bases)
    }

    /// Returns the positions of the channels named `bases` among some channels.
    pub(crate) fn among<const N: usize>(&self, some: &[usize], bases: [&str; N]) -> Option<[usize; N]> {
        let mut found = [0; N];
        for (at, base) in found.iter_mut().zip(bases) {
            *at = *some.iter().find(|&&index| self.list[index].0.eq_ignore_ascii_case(base))?;
        }
        Some(found)
    }

    /// Returns the positions of R, G and B, or of the one channel besides alpha.
    pub(crate) fn color(&self) -> Option<[usize; 3]> {
        self.positions(["R", "G", "B"]).or_else(|| {
            let is_alpha = |index: &usize| self.list[*index].0.eq_ignore_ascii_case("A");
            let others: Vec<usize> = (0..self.list.len()).filter(|index| !is_alpha(index)).collect();
            if let [gray] = others[..] { Some([gray; 3]) } else { None }
        })
    }

    fn called(&self, base: &str) -> Vec<usize> {
        (0..self.list.len()).filter(|&index| self.list[index].0.eq_ignore_ascii_case(base)).collect()
    }
}

/// A picture that is read on demand row by row, if its format allows that, or decoded.
pub(crate) enum Opened {
    /// Read on demand.
    Exr(Box<ExrReader>),
    /// Decoded.
    Picture(Picture),
}

impl Opened {
    /// Opens the picture that contains a pass.
    pub(crate) fn new(prepare: &Prepare<'_>, path: &Path, found: &FoundPass) -> Result<Self, NodeError> {
        if found.is_exr {
            return Ok(Self::Exr(shared::open(prepare, path, &found.selection)?.into()));
        }
        decode(prepare.frame, path, &found.selection).map(Self::Picture)
    }
}

/// A layer, a part or a single channel named by a knob.
pub(crate) struct FoundPass {
    pub(crate) info: PictureInfo,
    /// Positions of the pass's channels among the selected ones.
    pub(crate) channels: Vec<usize>,
    selection: Selection,
    is_exr: bool,
}

impl FoundPass {
    /// Finds channels of one part by their full names, in this order.
    ///
    /// # Errors
    /// The file cannot be read, or lacks one of them.
    pub(crate) fn of_channels(
        frame: &FrameContext,
        path: &Path,
        part: usize,
        channels: Vec<String>,
    ) -> Result<Self, NodeError> {
        let selection = Selection::channels(channels).with_part(part);
        let info = header(frame, path, &selection)?;
        filled(path, info.part, info.data)?;
        let is_exr = trochoid_io::kind(path)?.is_exr();
        Ok(Self { channels: (0..info.channels.len()).collect(), info, selection, is_exr })
    }

    /// Returns the pass with channels of another one behind its own; `None` if they are in another part of the file, or
    /// no 32-bit floats.
    ///
    /// # Errors
    /// As [`FoundPass::of_channels`].
    pub(crate) fn with(
        &self,
        frame: &FrameContext,
        path: &Path,
        other: &Self,
        at: &[usize],
    ) -> Result<Option<Self>, NodeError> {
        let is_float = |index: &usize| other.info.channels[*index].sample_type == SampleType::Float;
        if !self.is_exr || self.info.part != other.info.part || !at.iter().all(is_float) {
            return Ok(None);
        }
        let mut channels = self.names().full(&self.channels);
        channels.extend(other.names().full(at));
        Self::of_channels(frame, path, self.info.part, channels).map(Some)
    }

    pub(crate) fn names(&self) -> Names<'_> {
        Names::from(&self.info)
    }
}

/// Pass name of the channels R, G and B in a file's main layer, which has no name.
const MAIN: &str = "RGB";

/// Finds a layer, a part or a single channel named by a knob, such as `Combined.A`, in the file's header.
///
/// # Errors
/// The file cannot be read, or contains nothing with that name.
pub(crate) fn find_pass(frame: &FrameContext, path: &Path, knob: ItemName, name: &str) -> Result<FoundPass, NodeError> {
    let is_exr = trochoid_io::kind(path)?.is_exr();
    let find = |selection: Selection| {
        let info = header(frame, path, &selection)?;
        Ok(FoundPass { channels: (0..info.channels.len()).collect(), info, selection, is_exr })
    };
    let mut found = find(Selection::layer(name));
    if let Err(missing @ Error::NotFound { .. }) = found {
        found = find(Selection::channels([name]));
        // Not a full channel name: its layer name may be abbreviated.
        if name == MAIN && matches!(found, Err(Error::NotFound { .. })) {
            found = find(Selection::channels(["R", "G", "B"]));
        }
        if let (Err(Error::NotFound { .. }), Some((layer, base))) = (&found, name.rsplit_once('.')) {
            found = find(Selection::layer(layer)).map(|pass| {
                let channels = pass.names().called(base);
                FoundPass { channels, ..pass }
            });
        }
        // If all lookups fail, report the layer's error: it lists the file's contents.
        if matches!(&found, Ok(pass) if pass.channels.is_empty()) || matches!(found, Err(Error::NotFound { .. })) {
            found = Err(missing);
        }
    }
    let found = found.map_err(|error| selected(error, Some(knob)))?;
    filled(path, found.info.part, found.info.data)?;
    Ok(found)
}
