//! Runs compiled programs.

use crate::audit::{BitRange, ValueRule, WeightAudit};
use crate::block::Spare;
use crate::code::{CHUNK, Chunk, Code, CompiledProgram, Plane};
use crate::native::NativeMemory;
use crate::sweep::{is_faulty, sweep};
use fearless_simd::Level;
use trochoid_memory::{Scratch, Target};

/// Least and largest value of each channel of a color root, over some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least value by channel.
    pub least: [f32; 3],
    /// Largest value by channel.
    pub largest: [f32; 3],
}

/// Callback that sees each chunk of a color root: (root, samples by channel).
pub type Look<'l> = &'l mut dyn FnMut(usize, [&[f32]; 3]);

/// Callback that takes rows as (root, channel, y within the tile, samples).
pub type TakeRow<'s> = &'s mut dyn FnMut(usize, usize, usize, &[f32]);

/// Chunks of one thread's machines, in one allocation: scattered chunks would compete for the same cache sets.
#[derive(Debug)]
pub struct Chunks(Vec<Chunk>);

impl Chunks {
    /// Allocates as many chunks as the programs need.
    pub fn of<'c>(programs: impl IntoIterator<Item = &'c CompiledProgram>) -> Self {
        Self(vec![Chunk::ZERO; programs.into_iter().map(CompiledProgram::chunks).sum()])
    }

    /// Returns all chunks, to be handed out to machines.
    pub fn all(&mut self) -> &mut [Chunk] {
        &mut self.0
    }
}

/// A program and its chunks, for one thread.
#[derive(Debug)]
pub struct Machine<'p> {
    pub(crate) compiled: &'p CompiledProgram,
    pub(crate) level: Level,
    column: CodeFrame<'p>,
    row: CodeFrame<'p>,
    pub(crate) main: CodeFrame<'p>,
    /// Values that vary only along x: rows as wide as the tile, rounded up to whole chunks.
    columns: Vec<Vec<f32>>,
    /// Values that vary only along y.
    lines: Vec<Chunk>,
    pub(crate) end: RowEnd,
    /// Scratch space for machine code.
    pub(crate) scratch: NativeMemory,
    /// Memory of the lists that blocks need.
    pub(crate) spare: Spare,
}

/// The end of a row, where it is not as long as a whole chunk, and its results.
#[derive(Debug, Default)]
pub(crate) struct RowEnd {
    /// Inputs by plane, padded.
    pub(crate) padded: Vec<Chunk>,
    /// Results by channel.
    pub(crate) results: Vec<Chunk>,
}

/// State of some code.
#[derive(Debug)]
pub(crate) struct CodeFrame<'p> {
    pub(crate) code: &'p Code,
    /// Own chunks; each is `None` only while it is being written.
    pub(crate) own: Vec<Option<&'p mut Chunk>>,
    pub(crate) last: [&'p mut Chunk; 3],
    pub(crate) weights: BitRange,
    pub(crate) partitions: WeightAudit,
    pub(crate) checks: Vec<BitRange>,
    /// Bits of colors, by root.
    pub(crate) colors: Vec<[BitRange; 3]>,
    /// Bits of scalars, by root, with the sign shifted out.
    pub(crate) scalars: Vec<BitRange>,
    #[cfg(feature = "faults")]
    pub(crate) fault: crate::code::Fault,
}

/// Planes of a tile, with the start of the current row in each.
#[derive(Debug)]
pub struct TilePlanes<'a> {
    pub(crate) planes: Scratch<PlaneRow<'a>>,
    width: usize,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneRow<'a> {
    pub(crate) plane: Plane<'a>,
    /// Index of the current row's first sample.
    pub(crate) at: usize,
}

impl<'a> PlaneRow<'a> {
    /// Returns a view of a chunk as the samples from column `x` on.
    pub(crate) fn padded(chunk: &'a Chunk, x: usize) -> Self {
        // Column x is sample 0: at + x wraps around to it.
        Self { plane: Plane { samples: &chunk.0, start: 0, stride: 0 }, at: x.wrapping_neg() }
    }
}

impl<'a> TilePlanes<'a> {
    fn new(planes: &[Plane<'a>], width: usize) -> Self {
        Self { planes: planes.iter().map(|plane| PlaneRow { plane: *plane, at: plane.start }).collect(), width }
    }
}

/// Inputs that code reads.
#[derive(Clone, Copy)]
pub(crate) struct KernelInputs<'a> {
    pub(crate) planes: &'a [PlaneRow<'a>],
    pub(crate) columns: &'a [Vec<f32>],
    pub(crate) lines: &'a [Chunk],
}

impl<'p> Machine<'p> {
    /// Makes a machine; takes the chunks that it needs from `chunks`.
    pub fn new(compiled: &'p CompiledProgram, chunks: &mut &'p mut [Chunk]) -> Self {
        Self {
            compiled,
            level: compiled.instructions.level(),
            column: CodeFrame::new(&compiled.column, compiled, chunks),
            row: CodeFrame::new(&compiled.row, compiled, chunks),
            main: CodeFrame::new(&compiled.main, compiled, chunks),
            columns: vec![Vec::new(); compiled.column.channels()],
            lines: vec![Chunk::ZERO; compiled.row.channels()],
            end: RowEnd::default(),
            scratch: NativeMemory::default(),
            spare: Spare::default(),
        }
    }

    /// Returns the extremes of weights over everything that ran.
    pub fn audit(&self) -> WeightAudit {
        let planes = self.main.code.checks.iter().zip(&self.main.checks);
        let masks = planes.filter(|((_, rule), _)| *rule == ValueRule::Mask).map(|(_, bits)| bits.least_weight());
        [&self.column, &self.row, &self.main].into_iter().fold(
            WeightAudit { min: masks.fold(f32::INFINITY, f32::min), max_deviation: 0.0 },
            |all, frame| {
                let masks = WeightAudit { min: frame.weights.least_weight(), max_deviation: 0.0 };
                all.merge(frame.partitions).merge(masks)
            },
        )
    }

    /// Returns whether a plane of the caller held an illegal value, or −0.
    pub fn has_illegal_input(&self) -> bool {
        let mut checks = self.main.code.checks.iter().zip(&self.main.checks);
        checks.any(|((_, rule), bits)| !rule.allows(bits.largest()))
    }

    /// Resets the checks of planes, after the suspicious values were dealt with.
    pub fn reset_checks(&mut self) {
        self.main.partitions = self.audit();
        self.main.checks.fill(BitRange::default());
    }

    /// Returns the range of a color root since the last call; `None` if a sample was negative (including −0),
    /// infinite or NaN.
    pub fn color_range(&mut self, root: usize) -> Option<Range> {
        let bits = std::mem::take(&mut self.main.colors[root]);
        let mut range = Range { least: [0.0; 3], largest: [0.0; 3] };
        for (c, bits) in bits.iter().enumerate() {
            let (least, largest) = bits.range()?;
            if largest > f32::MAX.to_bits() {
                return None;
            }
            (range.least[c], range.largest[c]) = (f32::from_bits(least), f32::from_bits(largest));
        }
        Some(range)
    }

    /// Returns whether a root of scalars held a NaN since the last call.
    pub fn saw_nan(&mut self, root: usize) -> bool {
        let bits = std::mem::take(&mut self.main.scalars[root]);
        !ValueRule::Field.allows(bits.largest())
    }

    /// Begins a tile of `width` pixels: computes the values that do not vary from row to row.
    pub fn begin<'a>(&mut self, planes: &[Plane<'a>], width: usize) -> TilePlanes<'a> {
        let tile = TilePlanes::new(planes, width);
        if !self.compiled.column.list.is_empty() {
            self.columns.iter_mut().for_each(|row| row.resize(width.next_multiple_of(CHUNK), 0.0));
            let inputs = KernelInputs { planes: &tile.planes, columns: &[], lines: &[] };
            let mut out: Scratch<Target<'_>> = self.columns.iter_mut().map(|row| Target::new(row)).collect();
            sweep(self.level, &mut self.column, inputs, width, &mut out, 0, &mut self.end, None);
            drop(out);
            // Padded like the end of planes.
            for row in &mut self.columns {
                let last = row[width - 1];
                row[width..].fill(last);
            }
        }
        tile
    }

    /// Runs over row y of the tile and writes every channel of every root to its target, from sample `start` on.
    /// `look` sees every chunk of every color root.
    pub fn row(
        &mut self,
        tile: &mut TilePlanes<'_>,
        y: usize,
        out: &mut [Target<'_>],
        start: usize,
        mut look: Option<Look<'_>>,
    ) {
        for plane in &mut tile.planes {
            plane.at = plane.plane.start + y * plane.plane.stride;
        }
        let width = tile.width;
        if !self.compiled.row.list.is_empty() {
            let inputs = KernelInputs { planes: &tile.planes, columns: &self.columns, lines: &[] };
            let mut out: Scratch<Target<'_>> = self.lines.iter_mut().map(|chunk| Target::new(&mut chunk.0)).collect();
            let count = width.min(CHUNK);
            sweep(self.level, &mut self.row, inputs, count, &mut out, 0, &mut self.end, None);
            drop(out);
            for chunk in &mut self.lines {
                // A single value throughout.
                let value = chunk.0[0];
                chunk.0[count..].fill(value);
            }
        }
        let inputs = KernelInputs { planes: &tile.planes, columns: &self.columns, lines: &self.lines };
        if let Some(native) = &self.compiled.native
            && !is_faulty(&self.main)
        {
            let look = look.as_mut().map(|look| &mut **look as Look<'_>);
            if native.row(&mut self.main, inputs, width, out, start, look, &mut self.scratch) {
                return;
            }
        }
        sweep(self.level, &mut self.main, inputs, width, out, start, &mut self.end, look);
    }

    /// Runs over a tile and writes every channel of every root to a plane of its size.
    pub fn fill(&mut self, planes: &[Plane<'_>], width: usize, height: usize, into: &mut [&mut [f32]]) {
        let mut tile = self.begin(planes, width);
        let mut out: Scratch<Target<'_>> = into.iter_mut().map(|plane| Target::new(plane)).collect();
        for y in 0..height {
            self.row(&mut tile, y, &mut out, y * width, None);
        }
    }

    /// Runs over a tile and hands every row of every root to `take` as (root, channel, y, samples).
    pub fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, take: TakeRow<'_>) {
        let compiled = self.compiled;
        let mut rows: Scratch<Scratch<f32>> = (0..compiled.main.channels()).map(|_| Scratch::of(0.0, width)).collect();
        let mut tile = self.begin(planes, width);
        for y in 0..height {
            let mut out: Scratch<Target<'_>> = rows.iter_mut().map(|row| Target::new(row)).collect();
            self.row(&mut tile, y, &mut out, 0, None);
            drop(out);
            for (root, &(first, count)) in compiled.main.roots.iter().enumerate() {
                for channel in 0..count {
                    take(root, channel, y, &rows[first + channel]);
                }
            }
        }
    }
}

impl<'p> CodeFrame<'p> {
    fn new(code: &'p Code, compiled: &'p CompiledProgram, chunks: &mut &'p mut [Chunk]) -> Self {
        let mine = chunks.split_off_mut(..code.chunks()).unwrap_or_default();
        let [r, g, b, own @ ..] = mine else { unreachable!("as many chunks were made as programs need") };
        for (row, value) in &code.constants {
            own[*row as usize].0.fill(*value);
        }
        #[cfg(not(feature = "faults"))]
        let _ = compiled;
        Self {
            code,
            own: own.iter_mut().map(Some).collect(),
            last: [r, g, b],
            weights: BitRange::default(),
            partitions: WeightAudit::default(),
            checks: vec![BitRange::default(); code.checks.len()],
            colors: vec![[BitRange::default(); 3]; code.roots.len()],
            scalars: vec![BitRange::default(); code.roots.len()],
            #[cfg(feature = "faults")]
            fault: compiled.fault,
        }
    }
}

/// Returns a chunk that begins with `samples` and repeats the last of them, so that the padding adds nothing new to
/// any audit.
pub(crate) fn filled(samples: &[f32]) -> Chunk {
    let mut chunk = Chunk::ZERO;
    let (first, rest) = chunk.0.split_at_mut(samples.len());
    first.copy_from_slice(samples);
    rest.fill(samples.last().copied().unwrap_or_default());
    chunk
}
