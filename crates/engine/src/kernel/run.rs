//! Runs compiled programs.

use super::audit::{Bits, Legal, WeightAudit};
use super::code::{CHUNK, Chunk, Code, Compiled, Plane, Row, Source, Work};
use super::color::{
    FromConstant, FromLast, FromPair, FromRows, clamp_rows, is_all, mix_out, mix_rows, patch_rows, rgb, see_row, splat,
    write_out,
};
use super::partition::{Channel, audit, blend};
use fearless_simd::Level;
use trochoid_memory::{Kernel, Stream, Target, dispatch, prefetch};
use trochoid_weights::arithmetic as a;

/// Samples by which planes of the caller are fetched ahead: 1 KiB, measured.
const AHEAD: usize = 256;

/// The least and the largest value of each channel of a color root, over some rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) least: [f32; 3],
    pub(crate) largest: [f32; 3],
}

/// What is done besides with a chunk of a color root: (root, samples by channel).
pub(crate) type Look<'l> = &'l mut dyn FnMut(usize, [&[f32]; 3]);

/// Takes rows as (root, channel, y within the tile, samples).
pub(crate) type Rows<'s> = &'s mut dyn FnMut(usize, usize, usize, &[f32]);

/// Chunks and code of one thread.
#[derive(Debug)]
pub(crate) struct Machine<'p> {
    compiled: &'p Compiled,
    level: Level,
    column: Frame<'p>,
    row: Frame<'p>,
    main: Frame<'p>,
    /// What varies along x alone: rows as wide as the tile, and then what varies along y alone: chunks.
    columns: Vec<Vec<f32>>,
    rows: Vec<Vec<f32>>,
    /// Rows whose end is no whole chunk, filled up.
    padded: Vec<Chunk>,
    /// Results of the last chunk of such rows.
    rest: Vec<Vec<f32>>,
}

/// The state of some code.
#[derive(Debug)]
struct Frame<'p> {
    code: &'p Code,
    own: Vec<Option<Box<Chunk>>>,
    last: [Box<Chunk>; 3],
    weights: Bits,
    partitions: WeightAudit,
    checks: Vec<Bits>,
    /// By root.
    colors: Vec<[Bits; 3]>,
    /// Shifted by the sign.
    scalars: Vec<Bits>,
    #[cfg(test)]
    fault: super::code::Fault,
}

/// A row of a plane over which code runs; a fixed one is the same chunk everywhere.
#[derive(Clone, Copy)]
struct View<'a> {
    samples: &'a [f32],
    fixed: bool,
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

    /// The first plane that held something illegal, or −0, since the last call.
    pub(crate) fn suspect(&mut self) -> Option<usize> {
        let checks = self.main.code.checks.iter().zip(&self.main.checks);
        checks
            .filter(|((_, legal), bits)| bits.range().is_some_and(|(_, largest)| !legal.allows(largest)))
            .map(|((plane, _), _)| usize::from(*plane))
            .next()
    }

    /// Forgets what planes held, after a suspect was dealt with.
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

    /// Runs over row y of a tile of `width` pixels and writes every channel of every root to its target, from sample
    /// `start` on. `look` sees the chunks that it is given; the targets may be written around the cache.
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

    /// Runs over a tile and hands every row of every root to `sink` as (root, channel, y, samples).
    pub(crate) fn tile(&mut self, planes: &[Plane<'_>], width: usize, height: usize, sink: Rows<'_>) {
        let compiled = self.compiled;
        let mut rows = vec![vec![0.0; width]; compiled.main.channels()];
        self.begin(planes, width);
        for y in 0..height {
            let mut out: Vec<Target<'_>> = rows.iter_mut().map(|row| Target::new(row)).collect();
            self.row(planes, y, width, &mut out, None);
            for (root, &(first, count)) in compiled.main.roots.iter().enumerate() {
                for channel in 0..count {
                    sink(root, channel, y, &rows[first + channel]);
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
            own[usize::from(*row)] = Some(Box::new(Chunk([*value; CHUNK])));
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
fn filled(samples: &[f32], x: usize, count: usize) -> Chunk {
    let mut chunk = Chunk([0.0; CHUNK]);
    let count = count.min(samples.len() - x);
    chunk.0[..count].copy_from_slice(&samples[x..x + count]);
    let last = chunk.0[count - 1];
    chunk.0[count..].fill(last);
    chunk
}

/// Runs code over a row, chunk by chunk.
fn sweep(
    level: Level,
    frame: &mut Frame<'_>,
    views: &[View<'_>],
    width: usize,
    out: &mut [Target<'_>],
    (padded, rest): (&mut Vec<Chunk>, &mut Vec<Vec<f32>>),
    mut look: Option<Look<'_>>,
) {
    let whole = width / CHUNK * CHUNK;
    if whole > 0 {
        let look = look.as_mut().map(|look| &mut **look as Look<'_>);
        dispatch(level, Sweep { frame, views, width: whole, valid: CHUNK, out, look });
    }
    if whole < width {
        let count = width - whole;
        padded.clear();
        padded.extend(
            views.iter().map(|view| {
                if view.fixed { filled(view.samples, 0, CHUNK) } else { filled(view.samples, whole, count) }
            }),
        );
        let views: Vec<View<'_>> = padded.iter().map(|chunk| View { samples: &chunk.0, fixed: true }).collect();
        rest.resize(out.len(), Vec::new());
        rest.iter_mut().for_each(|row| row.resize(CHUNK, 0.0));
        let mut targets: Vec<Target<'_>> = rest.iter_mut().map(|row| Target::new(row)).collect();
        let sweep = Sweep { frame, views: &views, width: CHUNK, valid: count, out: &mut targets, look };
        dispatch(level, sweep);
        for (out, rest) in out.iter_mut().zip(rest) {
            out.copy(whole, &rest[..count]);
        }
    }
}

struct Sweep<'s, 'p, 't, 'v, 'l> {
    frame: &'s mut Frame<'p>,
    views: &'s [View<'v>],
    width: usize,
    /// Samples of a chunk that are not padding.
    valid: usize,
    out: &'s mut [Target<'t>],
    look: Option<Look<'l>>,
}

impl Kernel for Sweep<'_, '_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Stream>(mut self, simd: S) {
        let mut x = 0;
        while x < self.width {
            self.chunk(simd, x);
            x += CHUNK;
        }
    }
}

/// The chunk of a row.
#[inline(always)]
fn chunk<'a>(own: &'a [Option<Box<Chunk>>], views: &'a [View<'_>], x: usize, row: Row) -> &'a [f32; CHUNK] {
    let found = match row {
        Row::Own(row) => own[usize::from(row)].as_ref().map(|chunk| &chunk.0),
        Row::Plane(plane) => {
            let view = &views[usize::from(plane)];
            view.samples[if view.fixed { 0 } else { x }..].first_chunk()
        }
    };
    match found {
        Some(chunk) => chunk,
        None => unreachable!("no instruction reads what it writes, and rows are as long as the tile is wide"),
    }
}

impl Sweep<'_, '_, '_, '_, '_> {
    /// Writes a root from the accumulator.
    #[inline(always)]
    fn out_color<S: Stream>(&mut self, simd: S, x: usize, root: u16) {
        let root = usize::from(root);
        let (first, _) = self.frame.code.roots[root];
        if let Some(out) = self.out[first..].first_chunk_mut::<3>() {
            write_out(simd, &self.frame.last, out, x, &mut self.frame.colors[root]);
        }
        if let Some(look) = &mut self.look {
            look(root, rgb!(c => &self.frame.last[c].0[..self.valid]));
        }
    }

    /// Runs the code over one chunk.
    #[inline(always)]
    fn chunk<S: Stream>(&mut self, simd: S, x: usize) {
        let views = self.views;
        let code = self.frame.code;
        let mut at = 0;
        while let Some(work) = code.list.get(at) {
            at += 1;
            let frame = &mut *self.frame;
            macro_rules! row {
                ($row:expr) => {
                    chunk(&frame.own, views, x, $row)
                };
            }
            // Taken out, so that others can be read meanwhile.
            macro_rules! write {
                ($to:expr, |$chunk:ident| $body:expr) => {{
                    let mut taken = frame.own[usize::from($to)].take();
                    if let Some(taken) = &mut taken {
                        let $chunk = &mut taken.0;
                        $body;
                    }
                    frame.own[usize::from($to)] = taken;
                }};
            }
            macro_rules! unary {
                ($from:expr, $to:expr, $f:expr) => {
                    write!($to, |to| {
                        let from = row!($from);
                        for (to, from) in to.iter_mut().zip(from) {
                            *to = $f(*from);
                        }
                    })
                };
            }
            match work {
                Work::Check { plane, index } => {
                    let view = &views[usize::from(*plane)];
                    if !view.fixed {
                        for line in 0..CHUNK / 16 {
                            prefetch(view.samples, x + AHEAD + 16 * line);
                        }
                    }
                    let legal = code.checks[usize::from(*index)].1;
                    see_row(
                        simd,
                        row!(Row::Plane(*plane)),
                        legal == Legal::Field,
                        &mut frame.checks[usize::from(*index)],
                    );
                }
                Work::Clamp { x: from, min, max, to } => {
                    if is_simple(*min, *max) {
                        write!(*to, |to| clamp_rows(simd, to, row!(*from), *min, *max));
                    } else {
                        unary!(*from, *to, |x| a::clamp(x, *min, *max));
                    }
                }
                Work::Smooth { t, to } => unary!(*t, *to, a::smooth),
                Work::Step { x: from, threshold, to } => unary!(*from, *to, |x| a::step(x, *threshold)),
                Work::Complement { t, to } => unary!(*t, *to, a::complement),
                Work::Power { t, p, to } => write!(*to, |to| {
                    *to = *row!(*t);
                    a::power_row(to, *p);
                }),
                Work::Product { t, u, to } => write!(*to, |to| {
                    for ((to, t), u) in to.iter_mut().zip(row!(*t)).zip(row!(*u)) {
                        *to = a::product(*t, *u);
                    }
                }),
                Work::Partition { weights, to } => partition(frame, views, x, weights, to, |to, _| {
                    a::round_partition_rows(to);
                }),
                Work::Normalize { values, floor, to } => partition(frame, views, x, values, to, |to, values| {
                    a::normalize_rows(values, *floor, to);
                }),
                Work::AuditMask(row) => see_row(simd, row!(*row), false, &mut frame.weights),
                Work::AuditPartition(rows) => {
                    let seen = audit(rows.iter().map(|row| row!(*row)));
                    frame.partitions = frame.partitions.merge(seen);
                }
                Work::Patch { corners, x: u, y: v } => {
                    patch_rows(simd, &mut frame.last, corners, row!(*u), row!(*v));
                }
                Work::Mix { a, b, t, out } => {
                    // Whoever looks needs the color in the accumulator.
                    let straight = out.filter(|_| self.look.is_none() && !is_faulty(frame));
                    mix(simd, frame, views, x, [a, b], *t, straight.map(|root| (root, &mut *self.out)));
                    if let Some(root) = out.filter(|_| straight.is_none()) {
                        #[cfg(test)]
                        sabotage(work, self.frame);
                        self.out_color(simd, x, root);
                        continue;
                    }
                }
                Work::Blend { colors, weights } => {
                    for c in 0..3 {
                        let terms = weights.iter().zip(colors).map(|(weight, color)| {
                            let channel = match color {
                                Source::Rows(rows) => Channel::Row(row!(rows[c])),
                                Source::Constant(color) => Channel::Constant(color[c]),
                                _ => unreachable!("a blend reads rows and constants"),
                            };
                            (row!(*weight), channel)
                        });
                        blend(&mut frame.last[c].0, terms);
                    }
                }
                Work::Load(source) => take(frame, views, x, source),
                Work::Keep(to) => {
                    for (to, last) in to.iter().zip(&mut frame.last) {
                        if let Some(own) = &mut frame.own[usize::from(*to)] {
                            std::mem::swap(own, last);
                        }
                    }
                }
                Work::Gate { t, closed, otherwise, skip } => {
                    if is_all(simd, row!(*t), *closed) {
                        take(frame, views, x, otherwise);
                        at += skip;
                    }
                }
                Work::OutColor(root) => self.out_color(simd, x, *root),
                Work::OutRows { root, rows } => {
                    let (first, _) = code.roots[usize::from(*root)];
                    for (channel, row) in rows.iter().enumerate() {
                        let row = chunk(&frame.own, views, x, *row);
                        see_row(simd, row, true, &mut frame.scalars[usize::from(*root)]);
                        self.out[first + channel].copy(x, row);
                    }
                }
            }
            #[cfg(test)]
            sabotage(work, self.frame);
        }
    }
}

/// Runs an operation that writes all rows of a partition.
#[inline(always)]
fn partition(
    frame: &mut Frame<'_>,
    views: &[View<'_>],
    x: usize,
    from: &[Row],
    to: &[u16],
    run: impl FnOnce(&mut [&mut [f32]], &[&[f32]]),
) {
    let mut taken: Vec<Option<Box<Chunk>>> = to.iter().map(|&to| frame.own[usize::from(to)].take()).collect();
    {
        let from: Vec<&[f32]> = from.iter().map(|row| &chunk(&frame.own, views, x, *row)[..]).collect();
        let mut to: Vec<&mut [f32]> = taken.iter_mut().flatten().map(|chunk| &mut chunk.0[..]).collect();
        for (to, from) in to.iter_mut().zip(&from) {
            to.copy_from_slice(from);
        }
        run(&mut to, &from);
    }
    for (&to, taken) in to.iter().zip(taken) {
        frame.own[usize::from(to)] = taken;
    }
}

/// Takes a color into the accumulator.
#[inline(always)]
fn take(frame: &mut Frame<'_>, views: &[View<'_>], x: usize, source: &Source) {
    for c in 0..3 {
        match source {
            Source::Last => {}
            Source::Rows(rows) => frame.last[c].0 = *chunk(&frame.own, views, x, rows[c]),
            Source::Constant(color) => frame.last[c].0.fill(color[c]),
            Source::Pair { from, to, by } => {
                let by = chunk(&frame.own, views, x, *by);
                for (last, t) in frame.last[c].0.iter_mut().zip(by) {
                    *last = a::mix(from[c], to[c], *t);
                }
            }
        }
    }
}

/// Mixes two colors. Frequent pairs of sources are compiled into loops of their own; of others, the first color is taken
/// into the accumulator before.
#[inline(always)]
fn mix<S: Stream>(
    simd: S,
    frame: &mut Frame<'_>,
    views: &[View<'_>],
    x: usize,
    [a, b]: [&Source; 2],
    t: Row,
    out: Option<(u16, &mut [Target<'_>])>,
) {
    use Source::{Constant, Last, Pair, Rows};
    let direct = match (a, b) {
        (Last, _) | (_, Last) => true,
        (Rows(_), _) | (_, Rows(_)) => S::FUSED,
        _ => false,
    };
    if !direct {
        take(frame, views, x, a);
    }
    let own = &frame.own;
    let t = chunk(own, views, x, t);
    // Closures might not be inlined, and then lack the instruction set.
    macro_rules! rows {
        ($rows:expr) => {
            FromRows(rgb!(c => chunk(own, views, x, $rows[c])))
        };
    }
    macro_rules! pair {
        ($from:expr, $to:expr, $by:expr) => {
            FromPair::new(simd, $from, $to, chunk(own, views, x, *$by))
        };
    }
    macro_rules! run {
        ($a:expr, $b:expr) => {
            match out {
                None => mix_rows(simd, &mut frame.last, $a, $b, t),
                Some((root, out)) => {
                    let root = usize::from(root);
                    let (first, _) = frame.code.roots[root];
                    if let Some(out) = out[first..].first_chunk_mut::<3>() {
                        mix_out(simd, &frame.last, $a, $b, t, out, x, &mut frame.colors[root]);
                    }
                }
            }
        };
    }
    match (if direct { a } else { &Last }, b) {
        (Last, Last) => run!(FromLast, FromLast),
        (Last, Rows(b)) => run!(FromLast, rows!(b)),
        (Last, Constant(b)) => run!(FromLast, FromConstant(splat(simd, b))),
        (Last, Pair { from, to, by }) => run!(FromLast, pair!(from, to, by)),
        (Rows(a), Last) => run!(rows!(a), FromLast),
        (Constant(a), Last) => run!(FromConstant(splat(simd, a)), FromLast),
        (Pair { from, to, by }, Last) => run!(pair!(from, to, by), FromLast),
        (Rows(a), Rows(b)) if S::FUSED => run!(rows!(a), rows!(b)),
        (Rows(a), Constant(b)) if S::FUSED => run!(rows!(a), FromConstant(splat(simd, b))),
        (Rows(a), Pair { from, to, by }) if S::FUSED => run!(rows!(a), pair!(from, to, by)),
        (Constant(a), Rows(b)) if S::FUSED => run!(FromConstant(splat(simd, a)), rows!(b)),
        (Pair { from, to, by }, Rows(b)) if S::FUSED => run!(pair!(from, to, by), rows!(b)),
        _ => unreachable!("a color without a loop of its own is in the accumulator"),
    }
}

/// Whether bounds are those that [`clamp_rows`] takes.
fn is_simple(min: f32, max: f32) -> bool {
    const LARGE: f32 = 8.507_059e37; // 2¹²⁶
    max > min && min.abs() < LARGE && max.abs() < LARGE
}

/// Whether the kernels are broken on purpose.
#[inline(always)]
fn is_faulty(frame: &Frame<'_>) -> bool {
    #[cfg(test)]
    return frame.fault != super::code::Fault::None;
    #[cfg(not(test))]
    {
        let _ = frame;
        false
    }
}

/// Spoils what an instruction wrote, as the program's fault says.
#[cfg(test)]
fn sabotage(work: &Work, frame: &mut Frame<'_>) {
    use super::code::Fault;
    let mut spoil = |row: u16, f: fn(f32) -> f32| {
        if let Some(chunk) = &mut frame.own[usize::from(row)] {
            chunk.0.iter_mut().for_each(|v| *v = f(*v));
        }
    };
    match (frame.fault, work) {
        (Fault::PartitionLeaks, Work::Normalize { to, .. }) => spoil(to[0], |v| v * 0.9),
        (Fault::ClampLeaks, Work::Clamp { to, .. }) => spoil(*to, |v| v + 0.25),
        (Fault::MixOvershoots, Work::Mix { .. } | Work::Patch { .. }) => {
            frame.last[0].0.iter_mut().for_each(|v| *v = *v * 1.5 + 0.01);
        }
        (Fault::MixLosesOne, Work::Mix { .. } | Work::Patch { .. }) => frame.last[0].0[40] = f32::NAN,
        _ => {}
    }
}
