//! Runs compiled programs.

use super::audit::{Bits, Legal, WeightAudit};
use super::code::{CHUNK, Chunk, Code, Compiled, Plane};
use super::sweep::sweep;
use fearless_simd::Level;
use trochoid_memory::Target;

/// The least and the largest value of each channel of a color root, over some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) least: [f32; 3],
    pub(crate) largest: [f32; 3],
}

/// What is done besides with a chunk of a color root: (root, samples by channel).
pub(crate) type Look<'l> = &'l mut dyn FnMut(usize, [&[f32]; 3]);

/// Takes rows as (root, channel, y within the tile, samples).
pub(crate) type TakeRow<'s> = &'s mut dyn FnMut(usize, usize, usize, &[f32]);

/// Chunks and code of one thread.
#[derive(Debug)]
pub(crate) struct Machine<'p> {
    compiled: &'p Compiled,
    level: Level,
    column: Frame<'p>,
    row: Frame<'p>,
    main: Frame<'p>,
    /// What varies along x alone: rows as wide as the tile.
    columns: Vec<Vec<f32>>,
    /// What varies along y alone: chunks.
    rows: Vec<Vec<f32>>,
    /// Rows whose end is no whole chunk, filled up.
    padded: Vec<Chunk>,
    /// Results of the last chunk of such rows.
    rest: Vec<Vec<f32>>,
}

/// The state of some code.
#[derive(Debug)]
pub(super) struct Frame<'p> {
    pub(super) code: &'p Code,
    pub(super) own: Vec<Option<Box<Chunk>>>,
    pub(super) last: [Box<Chunk>; 3],
    pub(super) weights: Bits,
    pub(super) partitions: WeightAudit,
    pub(super) checks: Vec<Bits>,
    /// By root.
    pub(super) colors: Vec<[Bits; 3]>,
    /// Shifted by the sign.
    pub(super) scalars: Vec<Bits>,
    #[cfg(test)]
    pub(super) fault: super::code::Fault,
}

/// A row of a plane over which code runs; a fixed one is the same chunk everywhere.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) samples: &'a [f32],
    pub(super) fixed: bool,
}

impl<'p> Machine<'p> {
    pub(crate) fn new(compiled: &'p Compiled) -> Self {
        let frame = |code| Frame::new(code, compiled);
        Self {
            compiled,
            level: compiled.instructions.level(),
            column: frame(&compiled.column),
            row: frame(&compiled.row),
            main: frame(&compiled.main),
            columns: vec![Vec::new(); compiled.column.channels()],
            rows: vec![vec![0.0; CHUNK]; compiled.row.channels()],
            padded: Vec::new(),
            rest: vec![vec![0.0; CHUNK]; compiled.main.channels()],
        }
    }

    /// The extremes of weights over everything that ran.
    pub(crate) fn audit(&self) -> WeightAudit {
        let planes = self.main.code.checks.iter().zip(&self.main.checks);
        let masks = planes.filter(|((_, legal), _)| *legal == Legal::Mask).map(|(_, bits)| bits.least_weight());
        [&self.column, &self.row, &self.main].into_iter().fold(
            WeightAudit { min: masks.fold(f32::INFINITY, f32::min), max_deviation: 0.0 },
            |all, frame| {
                let masks = WeightAudit { min: frame.weights.least_weight(), max_deviation: 0.0 };
                all.merge(frame.partitions).merge(masks)
            },
        )
    }

    /// Whether a plane of the caller held something illegal, or −0.
    pub(crate) fn is_suspect(&self) -> bool {
        let mut checks = self.main.code.checks.iter().zip(&self.main.checks);
        checks.any(|((_, legal), bits)| bits.range().is_some_and(|(_, largest)| !legal.allows(largest)))
    }

    /// Forgets what planes held, after that was dealt with.
    pub(crate) fn acquit(&mut self) {
        self.main.partitions = self.audit();
        self.main.checks.fill(Bits::default());
    }

    /// The range of a color root since the last call; `None` where a sample is negative (−0 too), infinite or NaN.
    pub(crate) fn color_range(&mut self, root: usize) -> Option<Range> {
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

    /// Whether a root of scalars held a NaN since the last call.
    pub(crate) fn saw_nan(&mut self, root: usize) -> bool {
        let bits = std::mem::take(&mut self.main.scalars[root]);
        bits.range().is_some_and(|(_, largest)| !Legal::Field.allows(largest))
    }

    /// Computes what does not vary along the columns of a tile of `width` pixels. To be called before its rows.
    pub(crate) fn begin(&mut self, planes: &[Plane<'_>], width: usize) {
        if self.compiled.column.list.is_empty() {
            return;
        }
        let mut columns = std::mem::take(&mut self.columns);
        columns.iter_mut().for_each(|row| row.resize(width, 0.0));
        let views: Vec<View<'_>> = planes.iter().map(|plane| View { samples: plane.from(0), fixed: false }).collect();
        let mut out: Vec<Target<'_>> = columns.iter_mut().map(|row| Target::new(row)).collect();
        sweep(self.level, &mut self.column, &views, width, &mut out, (&mut self.padded, &mut Vec::new()), None);
        self.columns = columns;
    }

    /// Runs over row y of a tile of `width` pixels and writes every channel of every root to its target. `look` sees
    /// every chunk of every color root.
    pub(crate) fn row(
        &mut self,
        planes: &[Plane<'_>],
        y: usize,
        width: usize,
        out: &mut [Target<'_>],
        look: Option<Look<'_>>,
    ) {
        let mut views: Vec<View<'_>> =
            planes.iter().map(|plane| View { samples: plane.from(y), fixed: false }).collect();
        let columns = std::mem::take(&mut self.columns);
        views.extend(columns.iter().map(|row| View { samples: row, fixed: false }));
        let mut rows = std::mem::take(&mut self.rows);
        if !self.compiled.row.list.is_empty() {
            let mut out: Vec<Target<'_>> = rows.iter_mut().map(|row| Target::new(row)).collect();
            let first: Vec<Chunk> = views.iter().map(|view| filled(view.samples, 0, width.min(CHUNK))).collect();
            let views: Vec<View<'_>> = first.iter().map(|chunk| View { samples: &chunk.0, fixed: true }).collect();
            sweep(self.level, &mut self.row, &views, CHUNK, &mut out, (&mut self.padded, &mut Vec::new()), None);
        }
        views.extend(rows.iter().map(|row| View { samples: row, fixed: true }));
        sweep(self.level, &mut self.main, &views, width, out, (&mut self.padded, &mut self.rest), look);
        (self.columns, self.rows) = (columns, rows);
    }

    /// Runs over a tile and hands every row of every root to `take` as (root, channel, y, samples).
    pub(crate) fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, take: TakeRow<'_>) {
        let compiled = self.compiled;
        let mut rows = vec![vec![0.0; width]; compiled.main.channels()];
        self.begin(planes, width);
        for y in 0..height {
            let mut out: Vec<Target<'_>> = rows.iter_mut().map(|row| Target::new(row)).collect();
            self.row(planes, y, width, &mut out, None);
            for (root, &(first, count)) in compiled.main.roots.iter().enumerate() {
                for channel in 0..count {
                    take(root, channel, y, &rows[first + channel]);
                }
            }
        }
    }
}

impl<'p> Frame<'p> {
    fn new(code: &'p Code, compiled: &'p Compiled) -> Self {
        let chunk = || Box::new(Chunk([0.0; CHUNK]));
        let mut own: Vec<Option<Box<Chunk>>> = (0..code.own).map(|_| Some(chunk())).collect();
        for (row, value) in &code.constants {
            own[*row as usize] = Some(Box::new(Chunk([*value; CHUNK])));
        }
        #[cfg(not(test))]
        let _ = compiled;
        Self {
            code,
            own,
            last: [chunk(), chunk(), chunk()],
            weights: Bits::default(),
            partitions: WeightAudit::default(),
            checks: vec![Bits::default(); code.checks.len()],
            colors: vec![[Bits::default(); 3]; code.roots.len()],
            scalars: vec![Bits::default(); code.roots.len()],
            #[cfg(test)]
            fault: compiled.fault,
        }
    }
}

/// A chunk whose first `count` samples come from `x` on and whose others repeat the last of them, so that what they
/// would add to any audit is there already.
pub(super) fn filled(samples: &[f32], x: usize, count: usize) -> Chunk {
    let mut chunk = Chunk([0.0; CHUNK]);
    let count = count.min(samples.len() - x);
    chunk.0[..count].copy_from_slice(&samples[x..x + count]);
    let last = chunk.0[count - 1];
    chunk.0[count..].fill(last);
    chunk
}
