//! Finding channels, in a file that is only opened as in a picture that is decoded.

use super::reading::selected;
use super::{filled, limits, shared};
use std::path::Path;
use trochoid_graph::{NodeError, Prepare};
use trochoid_image::Window;
use trochoid_io::{Error, ExrReader, FileKind, Picture, PictureInfo, Selection};

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

    /// The full names of all, for messages.
    pub(crate) fn all(&self) -> String {
        self.some(&(0..self.list.len()).collect::<Vec<_>>())
    }

    /// The same of some.
    pub(crate) fn some(&self, at: &[usize]) -> String {
        const SHOWN: usize = 12;
        let mut names: Vec<String> = at.iter().take(SHOWN).map(|&at| format!("\"{}\"", self.list[at].1)).collect();
        if at.len() > SHOWN {
            names.push(format!("{} more", at.len() - SHOWN));
        }
        names.join(", ")
    }

    /// Full names of some.
    pub(crate) fn full(&self, at: &[usize]) -> Vec<String> {
        at.iter().map(|&index| self.list[index].1.to_owned()).collect()
    }

    /// Positions of the channels called `bases`, in any case; `None` unless all are there.
    pub(crate) fn positions<const N: usize>(&self, bases: [&str; N]) -> Option<[usize; N]> {
        self.among(&(0..self.list.len()).collect::<Vec<_>>(), bases)
    }

    /// The same among some.
    pub(crate) fn among<const N: usize>(&self, some: &[usize], bases: [&str; N]) -> Option<[usize; N]> {
        let mut found = [0; N];
        for (at, base) in found.iter_mut().zip(bases) {
            *at = *some.iter().find(|&&index| self.list[index].0.eq_ignore_ascii_case(base))?;
        }
        Some(found)
    }

    /// R, G and B, or the one channel besides alpha.
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

/// A picture whose rows are read on demand where its format allows that, and its size.
pub(crate) enum Opened {
    /// Read on demand.
    Exr(Box<ExrReader>),
    /// Decoded.
    Picture(Picture),
}

impl Opened {
    pub(crate) fn names(&self) -> Names<'_> {
        match self {
            Self::Exr(reader) => reader.info().into(),
            Self::Picture(picture) => picture.into(),
        }
    }

    pub(crate) fn windows(&self) -> (Window, Window) {
        match self {
            Self::Exr(reader) => (reader.info().display, reader.info().data),
            Self::Picture(picture) => (picture.display, picture.data),
        }
    }

    fn open(prepare: &Prepare<'_>, path: &Path, selection: &Selection) -> Result<Self, Error> {
        if trochoid_io::kind(path)? != FileKind::Exr {
            return trochoid_io::read(path, selection, &limits(prepare.frame)).map(Self::Picture);
        }
        shared::open(prepare, path, selection).map(|reader| Self::Exr(reader.into()))
    }
}

/// What the channels R, G and B of a file's main layer, which has no name, are called as a pass.
const MAIN: &str = "RGB";

/// Opens a layer or part, or the one channel, that a knob names, such as `Combined.A`. Which channels are meant comes with it.
pub(crate) fn open_pass(
    prepare: &Prepare<'_>,
    path: &Path,
    knob: &str,
    name: &str,
) -> Result<(Opened, Vec<usize>), NodeError> {
    let open = |selection: &Selection| Opened::open(prepare, path, selection);
    let whole = |opened: Opened| {
        let all = (0..opened.names().count()).collect();
        (opened, all)
    };
    let mut found = open(&Selection::layer(name)).map(whole);
    if let Err(missing @ Error::NotFound { .. }) = found {
        found = open(&Selection::channels([name])).map(whole);
        // Not the channel's full name: perhaps that of its layer was cut short.
        if name == MAIN && matches!(found, Err(Error::NotFound { .. })) {
            found = open(&Selection::channels(["R", "G", "B"])).map(whole);
        }
        if let (Err(Error::NotFound { .. }), Some((layer, base))) = (&found, name.rsplit_once('.')) {
            found = open(&Selection::layer(layer)).map(|opened| {
                let called = opened.names().called(base);
                (opened, called)
            });
        }
        // Of several misses the layer's says most: it lists what the file has.
        if matches!(&found, Ok((_, channels)) if channels.is_empty()) || matches!(found, Err(Error::NotFound { .. })) {
            found = Err(missing);
        }
    }
    let (opened, channels) = found.map_err(|error| selected(error, Some(knob)))?;
    filled(path, opened.names().part, opened.windows().1)?;
    Ok((opened, channels))
}
