//! Reading a file as the planes of a Color, of weights or of a field.

use super::color::{ColorSource, Conversion, Premultiplied, convert};
use super::knobs::{FitBy, Knobs, SelectionKnobs};
use super::legal::take;
use super::on_demand::Names;
use super::recipe::{Colors, Normalized};
use super::stream::MOST_ROWS;
use super::{Fit, Recipe, Rows, Rule, SharedFile, Stored, Stream, decode, filled, header, shared};
use std::path::{Path, PathBuf};
use trochoid_graph::{BadData, Choice, FrameContext, ItemName, Kind, NodeError, Prepare};
use trochoid_image::{Plane, Rgb};
use trochoid_io::Entry;
use trochoid_io::{FileKind, Picture, PictureInfo, Selection};
use trochoid_memory::Scratch;
use trochoid_weights::sums;

/// One reading of a file with a node's knobs.
pub(crate) struct Reading<'a> {
    pub(crate) knobs: Knobs<'a>,
    pub(crate) frame: &'a FrameContext,
    pub(crate) path: &'a Path,
    /// Color outside the data window, also used if no pixel is covered.
    pub(crate) outside: Option<Rgb>,
}

/// Construction of the output's channels from stored ones.
pub(super) struct ChannelPlan {
    pub(super) rule: Rule,
    /// Positions of the stored channels in the selection.
    pub(super) at: Vec<usize>,
    /// Conversion of the stored channels to the output's; `None` if they are the same.
    pub(super) recipe: Option<Box<dyn Recipe>>,
    /// The output's channels.
    pub(super) targets: Vec<usize>,
}

/// The planes of an output.
#[derive(Default)]
pub(crate) struct Planes {
    /// `None` for unwanted planes.
    pub(crate) planes: Vec<Option<Plane>>,
    /// What the planes are rounded from, sample by sample; empty if they are exact.
    pub(crate) exact: Vec<Vec<f64>>,
    /// Number of repaired values.
    pub(crate) repaired: u64,
}

impl Planes {
    fn new(planes: Vec<Plane>, repaired: u64) -> Self {
        Self { planes: planes.into_iter().map(Some).collect(), exact: Vec::new(), repaired }
    }

    /// Returns each channel's plane with what it is rounded from, if it is not exact.
    pub(crate) fn channels(self) -> impl Iterator<Item = Option<(Plane, Option<Vec<f64>>)>> {
        let mut exact = self.exact.into_iter();
        self.planes.into_iter().map(move |plane| {
            let exact = exact.next();
            plane.map(|plane| (plane, exact))
        })
    }
}

/// Callback that inspects a picture before its values are validated, and may refuse it.
type Accept<'a> = dyn FnMut(&Picture) -> Result<(), NodeError> + 'a;

impl Reading<'_> {
    /// Reads the wanted planes of a value of `kind`.
    ///
    /// # Errors
    /// The file cannot be read, `accept` refuses it, or its values are not legal.
    pub(crate) fn planes(&self, kind: Kind, wanted: &[bool], accept: &mut Accept<'_>) -> Result<Planes, NodeError> {
        match kind {
            _ if !wanted.contains(&true) => {
                Ok(Planes { planes: (0..kind.channels()).map(|_| None).collect(), ..Planes::default() })
            }
            Kind::Color => self.color(accept),
            Kind::Field(_) => self.field(wanted, accept),
            _ => self.weights(accept),
        }
    }

    /// Checks the header for errors that reading would encounter, with the picture `laid` over the document's pixels
    /// or looked up anywhere.
    ///
    /// # Errors
    /// The file cannot be read, has another size and no fit is set, or lacks a selected item.
    pub(crate) fn check_headers(&self, wanted: &[bool], laid: bool) -> Result<(), NodeError> {
        let kind = self.knobs.kind();
        if !wanted.contains(&true) {
            return Ok(());
        }
        let channels = if kind == Kind::Color { self.color_channels() } else { self.wanted_channels(kind, wanted) };
        let named = channels.len();
        let info = header(self.frame, self.path, &self.selection(channels)).map_err(|error| selected(error, None))?;
        filled(self.path, info.part, info.data)?;
        if laid {
            Fit::new(
                self.knobs.fit,
                FitBy::WORDS,
                info.display,
                [self.frame.format, self.frame.document_format],
                self.path,
            )?;
        }
        self.channel_plan(kind, &info, named, wanted)?;
        if kind == Kind::Color {
            self.alpha(&Names::from(&info), named)?;
        }
        Ok(())
    }

    pub(super) fn repair(&self) -> bool {
        self.knobs.taken.repair
    }

    pub(super) fn selection(&self, channels: Vec<String>) -> Selection {
        let SelectionKnobs { part, layer, .. } = self.knobs.selected;
        Selection { part: part.as_deref().map(Into::into), layer: layer.clone(), channels }
    }

    pub(super) fn fault(&self, part: usize, found: String, expected: &str) -> NodeError {
        BadData::new(found, expected, "").in_file(self.path).in_part(part).into()
    }

    /// Returns the output's channels as a stream that reads rows on demand, and their indices. Returns `None` if the
    /// whole picture must be decoded first, or for colors of at most `budget` bytes: their control colors are needed
    /// first, so the file would be decoded twice.
    ///
    /// # Errors
    /// The file cannot be opened, or lacks a selected item.
    pub(crate) fn on_demand(
        &self,
        prepare: &Prepare<'_>,
        kind: Kind,
        wanted: &[bool],
        budget: u64,
    ) -> Result<Option<(Stream, Vec<usize>)>, NodeError> {
        let io = |error: trochoid_io::Error| selected(error, None);
        let premultiplied = kind == Kind::Color && self.knobs.taken.premultiplied;
        if !wanted.contains(&true) || premultiplied || trochoid_io::kind(self.path).map_err(io)? != FileKind::Exr {
            return Ok(None);
        }
        let channels = self.wanted_channels(kind, wanted);
        let named = channels.len();
        let reader = shared::open(prepare, self.path, &self.selection(channels)).map_err(io)?;
        let info = reader.info();
        filled(self.path, info.part, info.data)?;
        let small = 3 * size_of::<f32>() as u64 * info.data.area() as u64 <= budget.min(self.frame.memory_limit);
        if info.data.height() > MOST_ROWS || (kind == Kind::Color && small) {
            return Ok(None);
        }
        let fit = Fit::new(
            self.knobs.fit,
            FitBy::WORDS,
            info.display,
            [self.frame.format, self.frame.document_format],
            self.path,
        )?;
        let ChannelPlan { rule, at, recipe, targets } = self.channel_plan(kind, info, named, wanted)?;
        let stored = Stored {
            path: self.path.into(),
            part: info.part,
            names: Names::from(info).full(&at),
            data: info.data,
            rule,
            repair: self.repair(),
        };
        let (file, places) = SharedFile::of(prepare, self.path, &reader, &at)?;
        let mut stream = Stream::new(stored, Rows::File(file, places), recipe, targets.len(), fit);
        stream.outside = self.outside;
        Ok(Some((stream, targets)))
    }

    /// Returns the channels to select for a value of `kind`; for fields, only the wanted ones.
    pub(super) fn wanted_channels(&self, kind: Kind, wanted: &[bool]) -> Vec<String> {
        match kind {
            Kind::Field(_) => self.wanted_names(wanted),
            _ => self.knobs.selected.channels.clone(),
        }
    }

    /// Returns how the output's channels are made from the file's.
    pub(super) fn channel_plan(
        &self,
        kind: Kind,
        info: &PictureInfo,
        named: usize,
        wanted: &[bool],
    ) -> Result<ChannelPlan, NodeError> {
        let names = Names::from(info);
        if kind != Kind::Color {
            self.only(&names, named)?;
        }
        let (rule, at) = match kind {
            Kind::Color => {
                let at = self.find_color(&names, named)?;
                (Rule::Color, if at[0] == at[1] { vec![at[0]] } else { at.to_vec() })
            }
            Kind::Field(_) => (Rule::Field, (0..names.count()).collect()),
            _ => (Rule::Mask, (0..names.count()).collect()),
        };
        let mut recipe: Option<Box<dyn Recipe>> = None;
        let mut targets: Vec<usize> = (0..kind.channels()).collect();
        match kind {
            Kind::Color => {
                let gray = at.len() == 1;
                let conversion = self.conversion(info, at[0])?;
                if gray || !conversion.identity {
                    recipe = Some(Box::new(Colors::new(gray, conversion)));
                }
            }
            Kind::Field(_) => targets.retain(|&channel| wanted[channel]),
            _ if at.len() > 1 => recipe = Some(Box::new(Normalized(self.sums(&names)))),
            _ => {}
        }
        Ok(ChannelPlan { rule, at, recipe, targets })
    }

    fn sums(&self, names: &Names<'_>) -> SumNormalizer {
        SumNormalizer { path: self.path.into(), part: names.part, names: names.all(), repair: self.repair() }
    }

    fn conversion(&self, info: &PictureInfo, channel: usize) -> Result<Conversion, NodeError> {
        let source = ColorSource {
            path: self.path.into(),
            part: info.part,
            encoding: info.encoding,
            chromaticities: info.chromaticities,
            stored: info.channels[channel].sample_type,
            space: self.frame.space,
            repair: self.repair(),
        };
        Conversion::new(source, self.knobs.taken.encoding)
    }

    /// Returns the wanted ones of the named channels.
    fn wanted_names(&self, wanted: &[bool]) -> Vec<String> {
        let names = self.knobs.selected.channels.iter().zip(wanted);
        names.filter(|(_, wanted)| **wanted).map(|(name, _)| name.clone()).collect()
    }

    /// Takes the planes at these positions out of a picture, checking each against a rule.
    fn take(&self, picture: &mut Picture, at: &[usize], rule: Rule) -> Result<(Vec<Plane>, u64), NodeError> {
        let mut repaired = 0;
        let mut planes = Vec::with_capacity(at.len());
        for &index in at {
            let (plane, more) = take(self.path, picture, index, rule, self.repair())?;
            planes.push(plane);
            repaired += more;
        }
        Ok((planes, repaired))
    }

    fn color(&self, accept: &mut Accept<'_>) -> Result<Planes, NodeError> {
        let channels = self.color_channels();
        let named = channels.len();
        let mut picture = decode(self.frame, self.path, &self.selection(channels))?;
        accept(&picture)?;
        let at = self.find_color(&Names::from(&picture), named)?;
        let (alpha, mut repaired) = match self.alpha(&Names::from(&picture), named)? {
            Some(at) => {
                let (planes, repaired) = self.take(&mut picture, &[at], Rule::Color)?;
                (planes.into_iter().next(), repaired)
            }
            None => (None, 0),
        };
        let gray = at[0] == at[1];
        let bytes = 3 * size_of::<f32>() as u64 * picture.data.area() as u64;
        if gray && bytes > self.frame.memory_limit {
            let found = format!("a gray picture of {bytes} bytes as color");
            return Err(self.fault(picture.part, found, &format!("at most {} bytes", self.frame.memory_limit)));
        }
        let source = ColorSource {
            path: self.path.into(),
            part: picture.part,
            encoding: picture.encoding,
            chromaticities: picture.chromaticities,
            stored: picture.channels[at[0]].sample_type,
            space: self.frame.space,
            repair: self.repair(),
        };
        let (planes, more) = self.take(&mut picture, if gray { &at[..1] } else { &at }, Rule::Color)?;
        repaired += more;
        let mut planes: [Plane; 3] = match <[Plane; 3]>::try_from(planes) {
            Ok(planes) => planes,
            Err(gray) => [0, 1, 2].map(|_| gray[0].clone()),
        };
        let premultiplied = alpha.map(|alpha| Premultiplied { alpha, uncovered: self.outside });
        let mut conversion = Conversion::new(source, self.knobs.taken.encoding)?;
        repaired += convert(&mut conversion, &mut planes, premultiplied.as_ref())?;
        Ok(Planes::new(planes.into(), repaired))
    }

    /// Returns the channels to select for a color: the named ones, and alpha if colors are divided by it.
    fn color_channels(&self) -> Vec<String> {
        let mut channels = self.knobs.selected.channels.clone();
        if let Some(first) = channels.first().filter(|_| self.knobs.taken.premultiplied) {
            // Alpha is in the same layer as the named channels.
            let layer = first.rfind('.').map_or("", |dot| &first[..=dot]);
            channels.push(format!("{layer}A"));
        }
        channels
    }

    /// Returns the position of the alpha by which colors are divided, if they are.
    fn alpha(&self, names: &Names<'_>, named: usize) -> Result<Option<usize>, NodeError> {
        match (self.knobs.taken.premultiplied, named) {
            (false, _) => Ok(None),
            (true, 0) => names.positions(["A"]).map(|[at]| Some(at)).ok_or_else(|| {
                let expected = "a channel \"A\" to divide by; set \"premultiplied\": false";
                self.fault(names.part, format!("the channels {}", names.all()), expected)
            }),
            (true, _) => Ok(Some(named - 1)),
        }
    }

    /// Returns the positions of a color's channels: the named ones, otherwise R, G and B, or the one channel besides
    /// alpha.
    fn find_color(&self, names: &Names<'_>, named: usize) -> Result<[usize; 3], NodeError> {
        match named {
            0 => names.color().ok_or_else(|| {
                let expected = "R, G and B, or one channel; name 1 or 3 of them in \"channels\"";
                self.fault(names.part, format!("the channels {}", names.all()), expected)
            }),
            1 | 2 => Ok([0; 3]),
            _ => Ok([0, 1, 2]),
        }
    }

    /// Decodes the named channels, or the only one.
    fn scalars(&self, channels: Vec<String>) -> Result<Picture, NodeError> {
        let named = channels.len();
        let picture = decode(self.frame, self.path, &self.selection(channels))?;
        self.only(&Names::from(&picture), named)?;
        Ok(picture)
    }

    /// Refuses several channels if none is named.
    fn only(&self, names: &Names<'_>, named: usize) -> Result<(), NodeError> {
        if named > 0 || names.count() == 1 {
            return Ok(());
        }
        let found = format!("{} channels: {}", names.count(), names.all());
        Err(self.fault(names.part, found, "one; list the wanted channels in \"channels\""))
    }

    fn field(&self, wanted: &[bool], accept: &mut Accept<'_>) -> Result<Planes, NodeError> {
        let mut picture = self.scalars(self.wanted_names(wanted))?;
        accept(&picture)?;
        let all: Vec<usize> = (0..picture.channels.len()).collect();
        let (planes, repaired) = self.take(&mut picture, &all, Rule::Field)?;
        let mut planes = planes.into_iter();
        let planes = wanted.iter().map(|wanted| if *wanted { planes.next() } else { None }).collect();
        Ok(Planes { planes, exact: Vec::new(), repaired })
    }

    fn weights(&self, accept: &mut Accept<'_>) -> Result<Planes, NodeError> {
        let mut picture = self.scalars(self.knobs.selected.channels.clone())?;
        accept(&picture)?;
        let all: Vec<usize> = (0..picture.channels.len()).collect();
        let (mut planes, mut repaired) = self.take(&mut picture, &all, Rule::Mask)?;
        if planes.len() == 1 {
            return Ok(Planes::new(planes, repaired));
        }
        let sums = self.sums(&Names::from(&picture));
        let window = planes[0].window();
        let mut exact: Vec<Vec<f64>> = vec![Vec::new(); if planes.len() == 2 { 1 } else { planes.len() }];
        let mut rows: Vec<_> = planes.iter_mut().map(|plane| plane.samples_mut().chunks_mut(window.width())).collect();
        for y in window.y0..window.y1 {
            let mut lines: Vec<&mut [f32]> = rows.iter_mut().filter_map(Iterator::next).collect();
            let parts = parts(&lines.iter().map(|line| &**line).collect::<Vec<_>>());
            exact.iter_mut().zip(parts).for_each(|(exact, parts)| exact.extend(parts));
            repaired += sums.normalize([window.x0, y], &mut lines)?;
        }
        if planes.len() == 2 {
            // A mask is written as the weight of its second control.
            planes.remove(0);
        }
        let is_exact = |(plane, exact): (&Plane, &Vec<f64>)| {
            plane.samples().iter().zip(exact).all(|(sample, exact)| f64::from(*sample) == *exact)
        };
        if planes.iter().zip(&exact).all(is_exact) {
            exact.clear();
        }
        Ok(Planes { exact, ..Planes::new(planes, repaired) })
    }
}

/// Adds to a file's error the knob that names the missing item: `knob`, or by default the one for its kind.
pub(super) fn selected(error: trochoid_io::Error, knob: Option<ItemName>) -> NodeError {
    match &error {
        trochoid_io::Error::NotFound { kind, existing, .. } if !existing.is_empty() => {
            let own = match kind {
                Entry::Part => SelectionKnobs::PART,
                Entry::Layer => SelectionKnobs::LAYER,
                Entry::Channel => SelectionKnobs::CHANNELS,
            };
            NodeError::missing(error, knob.unwrap_or(own))
        }
        _ => error.into(),
    }
}

/// Divides weights by their sum, pixel by pixel, given one line for each of them. A mask is written as the weight of its
/// second control.
pub(crate) fn parts(lines: &[&[f32]]) -> Vec<Vec<f64>> {
    let sums = sums::sums(lines);
    let part = |(weight, sum): (&f32, &f64)| sums::part(*weight, *sum, lines.len());
    let written = if lines.len() == 2 { &lines[1..] } else { lines };
    written.iter().map(|line| line.iter().zip(&sums).map(part).collect()).collect()
}

/// Divides weights by their sum, and refuses sums that are not nearly 1.
pub(crate) struct SumNormalizer {
    path: PathBuf,
    part: usize,
    /// Names of the channels, for messages.
    names: String,
    repair: bool,
}

impl SumNormalizer {
    /// Divides the pixels from (`x`, `y`) on by their sum, one line for each channel. Returns the number of repaired
    /// pixels.
    pub(crate) fn normalize(&self, [x, y]: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let sums = sums::sums(&lines.iter().map(|line| &**line).collect::<Scratch<_>>());
        let off = sums.iter().fold(0, |off, sum| off + u64::from(sums::is_off(*sum)));
        if off > 0 && !self.repair {
            let at = sums.iter().position(|sum| sums::is_off(*sum)).unwrap_or_default();
            let (sum, x) = (sums[at], x + at as i64);
            let found = format_args!("weights in {} that sum to {sum}", self.names);
            let remedy = "set \"repair\": true to divide them by their sum";
            let bad = BadData::new(found, "the sum 1 within 0.001", remedy);
            return Err(bad.in_file(&self.path).in_part(self.part).at_pixel((x, y)).into());
        }
        let count = lines.len();
        for line in lines.iter_mut() {
            line.iter_mut().zip(&sums).for_each(|(weight, sum)| *weight = sums::part(*weight, *sum, count) as f32);
        }
        Ok(off)
    }
}
