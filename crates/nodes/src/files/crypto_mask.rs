//! CryptoMask: masks of named objects from a cryptomatte.

use crate::files::cryptomatte::{Asked, Cryptomatte};
use crate::files::knobs::FitBy;
use crate::files::{
    ExactLines, Fit, FoundPass, Opened, Recipe, Rows, Rule, SharedFile, Stored, Stream, memory_on_demand,
};
use crate::view::named;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// A mask of objects, materials or assets by name, from a cryptomatte of another renderer.
///
/// # Formula
/// min(1, Σ c), over all ranks whose ID is that of one of `names`; c is the rank's coverage of the pixel
///
/// # Edge cases
/// IDs are those of the manifest in the file's header, and a name that it lacks is refused. Without a manifest, or with one
/// in another file, which is not read, they are computed from the names: then a misspelled name is an empty mask, and
/// `trochoid check` says so. Coverages up to 0.001 outside of [0, 1] count as rounded; others, and NaN, are refused with
/// their location, or repaired and counted. IDs are never blended: `"bilinear"` blends the mask.
///
/// # Source
/// Psyop, Cryptomatte Specification 1.2: MurmurHash3_32 of the UTF-8 name, its exponent limited to 1 to 254, as
/// a 32-bit float; after Friedman, Jones 2015, "Fully automatic ID mattes with support for motion blur and transparency".
#[derive(Clone, Node)]
#[node(
    stage,
    end = Front,
    revision = 1,
    example = r#""names": ["hull"]"#,
    output(mask: Kind::MASK = "How much of each pixel the named objects cover.")
)]
#[also_called("Cryptomatte", "IDMatte", "ObjectID", "MaterialID")]
pub(crate) struct CryptoMask {
    /// EXR file. #### or %04d stands for the frame number; write \# and \% for literal signs.
    #[knob(path)]
    file: String,
    /// Names of objects, materials or assets; the mask is of all of them together.
    #[knob(len = 1..=4096)]
    names: Vec<String>,
    /// Name of the cryptomatte: that of its layers without their numbers, such as CryptoObject. If unset, the only one.
    layer: Option<String>,
    /// Fit of a file whose size differs from the document's. If unset, such a file is refused.
    fit: Option<FitBy>,
    /// Sets illegal coverages to the nearest legal ones, and counts them.
    #[knob(default = false)]
    repair: bool,
}

impl CryptoMask {
    fn asked(&self) -> Asked<'_> {
        Asked { file: Self::FILE, layer: (Self::LAYER, self.layer.as_deref()), names: (Self::NAMES, &self.names) }
    }

    /// Returns the channels of each part with ranks, an ID and its coverage in turn, and the IDs of the names.
    fn found(&self, frame: &FrameContext, path: &Path) -> Result<(Vec<FoundPass>, Vec<u32>), NodeError> {
        let matte = Cryptomatte::find(frame, path, &self.asked())?;
        Ok((Self::parts(frame, path, &matte)?, matte.ids(path, &self.asked())?))
    }

    /// Returns the channels of each part with ranks, an ID and its coverage in turn.
    fn parts(frame: &FrameContext, path: &Path, matte: &Cryptomatte) -> Result<Vec<FoundPass>, NodeError> {
        let mut parts: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        for rank in &matte.ranks {
            parts.entry(rank.part).or_default().extend(rank.channels.iter().cloned());
        }
        parts.into_iter().map(|(part, channels)| FoundPass::of_channels(frame, path, part, channels)).collect()
    }

    fn fit(&self, frame: &FrameContext, path: &Path, found: &FoundPass) -> Result<Fit, NodeError> {
        Fit::new(self.fit, FitBy::WORDS, found.info.display, [frame.format, frame.document_format], path)
    }
}

impl Node for CryptoMask {
    fn check(&self, check: &mut Check<'_>) {
        if self.names.is_empty() {
            let remedy = "write the names of objects, such as [\"hull\"]";
            check.error(Self::NAMES, "no name", "at least one", remedy);
        }
    }
}

impl Stage for CryptoMask {
    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(&self.file)]
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        // A file that cannot be read counts as nothing.
        let path = context.frame.path(&self.file);
        let parts = Cryptomatte::find(context.frame, &path, &self.asked())
            .and_then(|matte| Self::parts(context.frame, &path, &matte));
        memory_on_demand(&parts.unwrap_or_default()).thread(BYTES_OF_PIXEL, u64::MAX)
    }

    fn check_headers(&self, frame: &FrameContext, _wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let path = named(frame, &self.file)?;
        for found in self.found(frame, &path)?.0 {
            self.fit(frame, &path, &found)?;
        }
        Ok(())
    }

    fn file_notes(&self, prepare: &Prepare<'_>) -> Vec<String> {
        let frame = prepare.frame;
        // What is wrong with the file is reported as its error.
        let found = named(frame, &self.file).and_then(|path| Cryptomatte::find(frame, &path, &self.asked()));
        found.map_or_else(|_| Vec::new(), |matte| matte.notes())
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let path = named(prepare.frame, &self.file)?;
        let (parts, ids) = self.found(prepare.frame, &path)?;
        let mut streams = Vec::new();
        for found in parts {
            let stored = Stored {
                path: path.clone(),
                part: found.info.part,
                names: found.names().full(&found.channels),
                data: found.info.data,
                rule: Rule::Field,
                repair: self.repair,
            };
            let covered = Covered {
                path: path.clone(),
                part: found.info.part,
                names: stored.names.clone(),
                repair: self.repair,
                ids: ids.clone(),
            };
            let fit = self.fit(prepare.frame, &path, &found)?;
            let rows = match Opened::new(prepare, &path, &found)? {
                Opened::Exr(reader) => {
                    let (file, places) = SharedFile::of(prepare, &path, &reader, &found.channels)?;
                    Rows::File(file, places)
                }
                Opened::Picture(_) => unreachable!("only EXR files have layers"),
            };
            streams.push(Stream::new(stored, rows, Some(Box::new(covered)), 1, fit));
        }
        Ok(Box::new(PreparedMask { streams }))
    }
}

/// How far outside of [0, 1] a coverage may lie to count as rounded.
const ROUNDED: f64 = 1e-3;

/// Recipe for the part of a pixel that chosen IDs cover, in the ranks of one part of the file.
struct Covered {
    path: PathBuf,
    part: usize,
    /// Full names of the channels, for messages.
    names: Vec<String>,
    repair: bool,
    /// IDs as the bits of samples, in ascending order.
    ids: Vec<u32>,
}

impl Covered {
    /// Returns the sum of the coverages whose IDs are chosen, pixel by pixel.
    fn sums(&self, lines: &[&[f32]]) -> Scratch<f64> {
        let mut sums = Scratch::of(0.0, lines.first().map_or(0, |line| line.len()));
        for rank in lines.chunks_exact(2) {
            for ((sum, id), coverage) in sums.iter_mut().zip(rank[0]).zip(rank[1]) {
                if self.ids.binary_search(&id.to_bits()).is_ok() {
                    *sum += f64::from(*coverage).clamp(0.0, 1.0);
                }
            }
        }
        sums
    }
}

impl Recipe for Covered {
    fn apply(&self, [x, y]: [i64; 2], lines: &mut [&mut [f32]]) -> Result<u64, NodeError> {
        let mut repaired = 0;
        for (rank, line) in lines.iter().skip(1).step_by(2).enumerate() {
            let is_off = |coverage: &f32| !(-ROUNDED..=1.0 + ROUNDED).contains(&f64::from(*coverage));
            let off = line.iter().filter(|coverage| is_off(coverage)).count();
            if off > 0 && !self.repair {
                let at = line.iter().position(is_off).unwrap_or_default();
                let remedy = "correct the file, or set \"repair\": true to take the nearest legal value";
                let bad = BadData::new(line[at], "a coverage from 0 to 1", remedy);
                let bad = bad.in_file(&self.path).in_part(self.part).in_channel(&*self.names[2 * rank + 1]);
                return Err(bad.at_pixel((x + at as i64, y)).into());
            }
            repaired += off as u64;
        }
        let sums = self.sums(&lines.iter().map(|line| &**line).collect::<Scratch<_>>());
        if let Some(mask) = lines.first_mut() {
            mask.iter_mut().zip(&sums).for_each(|(mask, sum)| *mask = *sum as f32);
        }
        Ok(repaired)
    }

    fn exact(&self) -> Option<ExactLines<'_>> {
        Some(Box::new(move |_, lines| vec![self.sums(lines).to_vec()]))
    }
}

/// Coverages of the chosen IDs: those of each part with ranks, to be added.
struct PreparedMask {
    streams: Vec<Stream>,
}

impl PreparedMask {
    fn value(&self, at: [f64; 2]) -> Result<f64, NodeError> {
        let mut sum = 0.0;
        for stream in &self.streams {
            sum += stream.reference(at)?.first().copied().unwrap_or_default();
        }
        Ok(sum.min(1.0))
    }
}

/// Bytes that a thread takes for a pixel: the sum of its coverages, and where it lies in the file.
const BYTES_OF_PIXEL: u64 = 32;

impl Prepared for PreparedMask {
    fn data_window(&self, picture: Window, _inputs: &dyn Fn(PortId) -> Window) -> Window {
        self.streams.iter().fold(picture, |window, stream| window.union(stream.window()))
    }

    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let mut sums = Scratch::of(0.0_f64, mask.len());
        for stream in &self.streams {
            stream.fill(block, &mut [Some(&mut *mask)])?;
            sums.iter_mut().zip(&*mask).for_each(|(sum, part)| *sum += f64::from(*part));
        }
        mask.iter_mut().zip(&sums).for_each(|(mask, sum)| *mask = sum.min(1.0) as f32);
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_at(outputs, SoleOutput, 0, |at| self.value(at).unwrap_or(f64::NAN));
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Mask(self.value(inputs.at)?)])
    }

    fn repaired(&self) -> u64 {
        self.streams.iter().map(Stream::repaired).sum()
    }

    fn rows_per_band(&self) -> Option<usize> {
        self.streams.iter().filter_map(Stream::rows_per_band).max()
    }

    fn bytes(&self) -> usize {
        self.streams.iter().map(Stream::bytes).sum()
    }
}
