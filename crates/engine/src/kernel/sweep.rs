//! Runs code over rows, one chunk after the other.

use super::audit::Legal;
use super::code::{CHUNK, Chunk, Row, Source, Work};
use super::color::{
    FromConstant, FromLast, FromPair, FromRows, clamp_rows, is_all, mix_out, mix_rows, patch_rows, rgb, see_row, splat,
    write_out,
};
use super::partition::{Channel, audit, blend};
use super::run::{Frame, Look, View, filled};
use fearless_simd::Level;
use trochoid_memory::{Kernel, Stream, Target, dispatch, prefetch};
use trochoid_weights::arithmetic as a;

/// Samples by which planes of the caller are fetched ahead: 1 KiB, measured.
const AHEAD: usize = 256;

/// Runs code over a row, chunk by chunk.
pub(super) fn sweep(
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
        Row::Own(row) => own[row as usize].as_ref().map(|chunk| &chunk.0),
        Row::Plane(plane) => {
            let view = &views[plane as usize];
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
    fn out_color<S: Stream>(&mut self, simd: S, x: usize, root: u32) {
        let root = root as usize;
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
                    let view = &views[*plane as usize];
                    if !view.fixed {
                        for line in 0..CHUNK / 16 {
                            prefetch(view.samples, x + AHEAD + 16 * line);
                        }
                    }
                    let legal = code.checks[*index as usize].1;
                    see_row(simd, row!(Row::Plane(*plane)), legal == Legal::Field, &mut frame.checks[*index as usize]);
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
                        if let Some(own) = &mut frame.own[*to as usize] {
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
                    let (first, _) = code.roots[*root as usize];
                    for (channel, row) in rows.iter().enumerate() {
                        let row = chunk(&frame.own, views, x, *row);
                        see_row(simd, row, true, &mut frame.scalars[*root as usize]);
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
    to: &[u32],
    run: impl FnOnce(&mut [&mut [f32]], &[&[f32]]),
) {
    let mut taken: Vec<Option<Box<Chunk>>> = to.iter().map(|&to| frame.own[to as usize].take()).collect();
    {
        let from: Vec<&[f32]> = from.iter().map(|row| &chunk(&frame.own, views, x, *row)[..]).collect();
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
    out: Option<(u32, &mut [Target<'_>])>,
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
                    let root = root as usize;
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
    max > min && min.abs() < a::LARGE && max.abs() < a::LARGE
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
