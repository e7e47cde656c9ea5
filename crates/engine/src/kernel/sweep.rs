//! Runs code over rows, chunk by chunk.

use super::audit::Legal;
use super::code::{CHUNK, Chunk, Row, Source, Work};
use super::color::{
    FromConstant, FromLast, FromPair, FromRows, clamp_rows, is_all, mix_out, mix_rows, patch_rows, rgb, see_field,
    see_row, splat, write_out,
};
use super::partition::{Channel, audit, blend};
use super::run::{Frame, Given, Look, View, filled};
use fearless_simd::Level;
use trochoid_memory::{Kernel, Stream, Target, dispatch, prefetch};
use trochoid_weights::arithmetic as a;

/// Number of samples by which planes of the caller are prefetched: 1 KiB, measured.
const AHEAD: usize = 256;

/// Runs code over the first `width` pixels of a row, chunk by chunk, and writes the results to its targets from
/// sample `start` on.
#[allow(clippy::too_many_arguments, reason = "the machine's parts, borrowed one by one")]
pub(super) fn sweep(
    level: Level,
    frame: &mut Frame<'_>,
    given: Given<'_>,
    width: usize,
    out: &mut [Target<'_>],
    start: usize,
    (padded, rest): (&mut Vec<Chunk>, &mut Vec<Chunk>),
    mut look: Option<Look<'_>>,
) {
    let whole = width / CHUNK * CHUNK;
    if whole > 0 {
        let look = look.as_mut().map(|look| &mut **look as Look<'_>);
        dispatch(level, Sweep { frame, given, from: 0, to: whole, valid: CHUNK, out, start, look });
    }
    if whole < width {
        padded.clear();
        padded.extend(given.planes.iter().map(|view| {
            let at = view.at + whole;
            filled(&view.plane.samples[at..at + width - whole])
        }));
        let planes: Vec<View<'_>> = padded.iter().map(|chunk| View::padded(chunk, whole)).collect();
        rest.resize(out.len(), Chunk::ZERO);
        let mut targets: Vec<Target<'_>> = rest.iter_mut().map(|chunk| Target::new(&mut chunk.0)).collect();
        let given = Given { planes: &planes, ..given };
        let (from, to, valid) = (whole, whole + CHUNK, width - whole);
        dispatch(level, Sweep { frame, given, from, to, valid, out: &mut targets, start: 0, look });
        for (out, rest) in out.iter_mut().zip(rest) {
            out.copy(start + whole, &rest.0[..valid]);
        }
    }
}

struct Sweep<'s, 'p, 't, 'l> {
    frame: &'s mut Frame<'p>,
    given: Given<'s>,
    /// Range of columns, in whole chunks.
    from: usize,
    to: usize,
    /// Number of samples of a chunk that are not padding.
    valid: usize,
    out: &'s mut [Target<'t>],
    /// Position of column `from` in the targets.
    start: usize,
    look: Option<Look<'l>>,
}

impl Kernel for Sweep<'_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Stream>(mut self, simd: S) {
        let mut x = self.from;
        while x < self.to {
            self.chunk(simd, x);
            x += CHUNK;
        }
    }
}

/// Returns the chunk of a row at column `x`.
#[inline(always)]
fn chunk<'a>(own: &'a [Option<&mut Chunk>], given: Given<'a>, x: usize, row: Row) -> &'a [f32; CHUNK] {
    let found = match row {
        Row::Own(row) => own[row as usize].as_ref().map(|chunk| &chunk.0),
        Row::Plane(plane) => {
            let view = &given.planes[plane as usize];
            view.plane.samples[view.at.wrapping_add(x)..].first_chunk()
        }
        Row::Column(row) => given.columns[row as usize][x..].first_chunk(),
        Row::Line(row) => Some(&given.lines[row as usize].0),
    };
    match found {
        Some(chunk) => chunk,
        None => unreachable!("no instruction reads what it writes, and rows are as long as the tile is wide"),
    }
}

impl Sweep<'_, '_, '_, '_> {
    /// Writes a root from the accumulator.
    #[inline(always)]
    fn out_color<S: Stream>(&mut self, simd: S, x: usize, root: u32) {
        let root = root as usize;
        let (first, _) = self.frame.code.roots[root];
        if let Some(out) = self.out[first..].first_chunk_mut::<3>() {
            write_out(simd, &self.frame.last, out, self.start + x - self.from, &mut self.frame.colors[root]);
        }
        if let Some(look) = &mut self.look {
            look(root, rgb!(c => &self.frame.last[c].0[..self.valid]));
        }
    }

    /// Runs the code over one chunk.
    #[inline(always)]
    fn chunk<S: Stream>(&mut self, simd: S, x: usize) {
        let given = self.given;
        let code = self.frame.code;
        let mut at = 0;
        while let Some(work) = code.list.get(at) {
            at += 1;
            let frame = &mut *self.frame;
            macro_rules! row {
                ($row:expr) => {
                    chunk(&frame.own, given, x, $row)
                };
            }
            // Taken out, so that other chunks can be read meanwhile.
            macro_rules! write {
                ($to:expr, |$chunk:ident| $body:expr) => {{
                    let mut taken = frame.own[$to as usize].take();
                    if let Some(taken) = &mut taken {
                        let $chunk = &mut taken.0;
                        $body;
                    }
                    frame.own[$to as usize] = taken;
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
                    let view = &given.planes[*plane as usize];
                    for line in 0..CHUNK / 16 {
                        prefetch(view.plane.samples, view.at.wrapping_add(x + AHEAD + 16 * line));
                    }
                    let (row, bits) = (row!(Row::Plane(*plane)), &mut frame.checks[*index as usize]);
                    match code.checks[*index as usize].1 {
                        Legal::Field => see_field(simd, row, bits),
                        Legal::Mask | Legal::Color => see_row(simd, row, bits),
                    }
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
                Work::Partition { weights, to } => partition(frame, given, x, weights, to, |to, _| {
                    a::round_partition_rows(to);
                }),
                Work::Normalize { values, floor, to } => partition(frame, given, x, values, to, |to, values| {
                    a::normalize_rows(values, *floor, to);
                }),
                Work::AuditMask(row) => see_row(simd, row!(*row), &mut frame.weights),
                Work::AuditPartition(rows) => {
                    let seen = audit(rows.iter().map(|row| row!(*row)));
                    frame.partitions = frame.partitions.merge(seen);
                }
                Work::Patch { corners, x: u, y: v } => {
                    patch_rows(simd, &mut frame.last, corners, row!(*u), row!(*v));
                }
                Work::Mix { a, b, t, out } => {
                    // The look callback needs the color in the accumulator.
                    let straight = out.filter(|_| self.look.is_none() && !is_faulty(frame));
                    let to = self.start + x - self.from;
                    mix(simd, frame, given, x, [a, b], *t, straight.map(|root| (root, &mut *self.out, to)));
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
                Work::Load(source) => take(frame, given, x, source),
                Work::Keep(to) => {
                    for (to, last) in to.iter().zip(&mut frame.last) {
                        if let Some(own) = &mut frame.own[*to as usize] {
                            std::mem::swap(own, last);
                        }
                    }
                }
                Work::Gate { t, closed, otherwise, skip } => {
                    if is_all(simd, row!(*t), *closed) {
                        take(frame, given, x, otherwise);
                        at += skip;
                    }
                }
                Work::OutColor(root) => self.out_color(simd, x, *root),
                Work::OutRows { root, rows } => {
                    let (first, _) = code.roots[*root as usize];
                    for (channel, row) in rows.iter().enumerate() {
                        let row = chunk(&frame.own, given, x, *row);
                        see_field(simd, row, &mut frame.scalars[*root as usize]);
                        self.out[first + channel].copy(self.start + x - self.from, row);
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
    given: Given<'_>,
    x: usize,
    from: &[Row],
    to: &[u32],
    run: impl FnOnce(&mut [&mut [f32]], &[&[f32]]),
) {
    let mut taken: Vec<Option<&mut Chunk>> = to.iter().map(|&to| frame.own[to as usize].take()).collect();
    {
        let from: Vec<&[f32]> = from.iter().map(|row| &chunk(&frame.own, given, x, *row)[..]).collect();
        let mut to: Vec<&mut [f32]> = taken.iter_mut().flatten().map(|chunk| &mut chunk.0[..]).collect();
        for (to, from) in to.iter_mut().zip(&from) {
            to.copy_from_slice(from);
        }
        run(&mut to, &from);
    }
    for (&to, taken) in to.iter().zip(taken) {
        frame.own[to as usize] = taken;
    }
}

/// Loads a color into the accumulator.
#[inline(always)]
fn take(frame: &mut Frame<'_>, given: Given<'_>, x: usize, source: &Source) {
    for c in 0..3 {
        match source {
            Source::Last => {}
            Source::Rows(rows) => frame.last[c].0 = *chunk(&frame.own, given, x, rows[c]),
            Source::Constant(color) => frame.last[c].0.fill(color[c]),
            Source::Pair { from, to, by } => {
                let by = chunk(&frame.own, given, x, *by);
                for (last, t) in frame.last[c].0.iter_mut().zip(by) {
                    *last = a::mix(from[c], to[c], *t);
                }
            }
        }
    }
}

/// Mixes two colors. Frequent pairs of sources have their own compiled loops; for other pairs, the first color is
/// loaded into the accumulator beforehand.
#[inline(always)]
fn mix<S: Stream>(
    simd: S,
    frame: &mut Frame<'_>,
    given: Given<'_>,
    x: usize,
    [a, b]: [&Source; 2],
    t: Row,
    out: Option<(u32, &mut [Target<'_>], usize)>,
) {
    use Source::{Constant, Last, Pair, Rows};
    let direct = match (a, b) {
        (Last, _) | (_, Last) => true,
        (Rows(_), _) | (_, Rows(_)) => S::FUSED,
        _ => false,
    };
    if !direct {
        take(frame, given, x, a);
    }
    let own = &frame.own;
    let t = chunk(own, given, x, t);
    // Closures might not be inlined, and would then be compiled without the instruction set.
    macro_rules! rows {
        ($rows:expr) => {
            FromRows(rgb!(c => chunk(own, given, x, $rows[c])))
        };
    }
    macro_rules! pair {
        ($from:expr, $to:expr, $by:expr) => {
            FromPair::new(simd, $from, $to, chunk(own, given, x, *$by))
        };
    }
    macro_rules! run {
        ($a:expr, $b:expr) => {
            match out {
                None => mix_rows(simd, &mut frame.last, $a, $b, t),
                Some((root, out, to)) => {
                    let root = root as usize;
                    let (first, _) = frame.code.roots[root];
                    if let Some(out) = out[first..].first_chunk_mut::<3>() {
                        mix_out(simd, &frame.last, $a, $b, t, out, to, &mut frame.colors[root]);
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

/// Returns whether [`clamp_rows`] supports these bounds.
pub(super) fn is_simple(min: f32, max: f32) -> bool {
    max > min && min.abs() < a::LARGE && max.abs() < a::LARGE
}

/// Returns whether the kernels are broken on purpose.
#[inline(always)]
pub(super) fn is_faulty(frame: &Frame<'_>) -> bool {
    #[cfg(test)]
    return frame.fault != super::code::Fault::None;
    #[cfg(not(test))]
    {
        let _ = frame;
        false
    }
}

/// Corrupts what an instruction wrote, as the program's fault requests.
#[cfg(test)]
fn sabotage(work: &Work, frame: &mut Frame<'_>) {
    use super::code::Fault;
    let mut spoil = |row: u32, f: fn(f32) -> f32| {
        if let Some(chunk) = &mut frame.own[row as usize] {
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
