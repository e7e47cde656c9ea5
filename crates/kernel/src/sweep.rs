//! Runs code over rows, chunk by chunk.

use crate::audit::ValueRule;
use crate::code::{CHUNK, Chunk, ColorOperand, Instruction, Row};
use crate::color::{
    FromConstant, FromLast, FromPair, FromRows, clamp_rows, is_all, mix_out, mix_rows, patch_rows, rgb, see_field,
    see_row, splat, write_out,
};
use crate::partition::{ChannelOperand, audit, blend};
use crate::run::{CodeFrame, KernelInputs, Look, PlaneRow, RowEnd, filled};
use fearless_simd::{Level, Simd};
use trochoid_memory::{Kernel, Scratch, Stream, Target, dispatch, prefetch};
use trochoid_weights::arithmetic as a;

/// Number of samples by which planes of the caller are prefetched: 1 KiB, measured.
const AHEAD: usize = 256;

/// Runs code over the first `width` pixels of a row, chunk by chunk, and writes the results to its targets from
/// sample `start` on.
#[allow(clippy::too_many_arguments, reason = "the machine's parts, borrowed one by one")]
pub(crate) fn sweep(
    level: Level,
    frame: &mut CodeFrame<'_>,
    inputs: KernelInputs<'_>,
    width: usize,
    out: &mut [Target<'_>],
    start: usize,
    end: &mut RowEnd,
    mut look: Option<Look<'_>>,
) {
    let whole = width / CHUNK * CHUNK;
    if whole > 0 {
        let look = look.as_mut().map(|look| &mut **look as Look<'_>);
        dispatch(level, Sweep { frame, inputs, from: 0, to: whole, valid: CHUNK, out, start, look });
    }
    if whole < width {
        end.padded.clear();
        end.padded.extend(inputs.planes.iter().map(|row| {
            let at = row.at + whole;
            filled(&row.plane.samples[at..at + width - whole])
        }));
        let planes: Scratch<PlaneRow<'_>> = end.padded.iter().map(|chunk| PlaneRow::padded(chunk, whole)).collect();
        end.results.resize(out.len(), Chunk::ZERO);
        let mut targets: Scratch<Target<'_>> = end.results.iter_mut().map(|chunk| Target::new(&mut chunk.0)).collect();
        let inputs = KernelInputs { planes: &planes, ..inputs };
        let (from, to, valid) = (whole, whole + CHUNK, width - whole);
        dispatch(level, Sweep { frame, inputs, from, to, valid, out: &mut targets, start: 0, look });
        drop(targets);
        for (out, rest) in out.iter_mut().zip(&end.results) {
            out.copy(start + whole, &rest.0[..valid]);
        }
    }
}

struct Sweep<'s, 'p, 't, 'l> {
    frame: &'s mut CodeFrame<'p>,
    inputs: KernelInputs<'s>,
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
fn chunk<'a>(own: &'a [Option<&mut Chunk>], inputs: KernelInputs<'a>, x: usize, row: Row) -> &'a [f32; CHUNK] {
    let found = match row {
        Row::Own(row) => own[row as usize].as_ref().map(|chunk| &chunk.0),
        Row::Plane(plane) => {
            let row = &inputs.planes[plane as usize];
            row.plane.samples[row.at.wrapping_add(x)..].first_chunk()
        }
        Row::Column(row) => inputs.columns[row as usize][x..].first_chunk(),
        Row::Line(row) => Some(&inputs.lines[row as usize].0),
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
        let inputs = self.inputs;
        let code = self.frame.code;
        let mut at = 0;
        while let Some(instruction) = code.list.get(at) {
            at += 1;
            let frame = &mut *self.frame;
            macro_rules! row {
                ($row:expr) => {
                    chunk(&frame.own, inputs, x, $row)
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
            match instruction {
                Instruction::Check { plane, index } => {
                    let row = &inputs.planes[*plane as usize];
                    for line in 0..CHUNK / 16 {
                        prefetch(row.plane.samples, row.at.wrapping_add(x + AHEAD + 16 * line));
                    }
                    let (row, bits) = (row!(Row::Plane(*plane)), &mut frame.checks[*index as usize]);
                    match code.checks[*index as usize].1 {
                        ValueRule::Field => see_field(simd, row, bits),
                        ValueRule::Mask | ValueRule::Color => see_row(simd, row, bits),
                    }
                }
                Instruction::Clamp { x: from, min, max, to } => {
                    if is_simple(*min, *max) {
                        write!(*to, |to| clamp_rows(simd, to, row!(*from), *min, *max));
                    } else {
                        unary!(*from, *to, |x| a::clamp(x, *min, *max));
                    }
                }
                Instruction::Smooth { t, to } => unary!(*t, *to, a::smooth),
                Instruction::Step { x: from, threshold, to } => unary!(*from, *to, |x| a::step(x, *threshold)),
                Instruction::Complement { t, to } => unary!(*t, *to, a::complement),
                Instruction::Power { t, p, to } => write!(*to, |to| {
                    *to = *row!(*t);
                    a::power_row(to, *p);
                }),
                Instruction::Product { t, u, to } => write!(*to, |to| {
                    for ((to, t), u) in to.iter_mut().zip(row!(*t)).zip(row!(*u)) {
                        *to = a::product(*t, *u);
                    }
                }),
                Instruction::Partition { weights, to } => partition(frame, inputs, x, weights, to, |to, _| {
                    a::round_partition_rows(to);
                }),
                Instruction::Normalize { values, floor, to } => {
                    partition(frame, inputs, x, values, to, |to, values| {
                        a::normalize_rows(values, *floor, to);
                    });
                }
                Instruction::AuditMask(row) => see_row(simd, row!(*row), &mut frame.weights),
                Instruction::AuditPartition(rows) => {
                    let seen = audit(rows.iter().map(|row| row!(*row)));
                    frame.partitions = frame.partitions.merge(seen);
                }
                Instruction::Patch { corners, x: u, y: v } => {
                    patch_rows(simd, &mut frame.last, corners, row!(*u), row!(*v));
                }
                Instruction::Mix { a, b, t, out } => {
                    // The look callback needs the color in the accumulator.
                    let straight = out.filter(|_| self.look.is_none() && !is_faulty(frame));
                    let to = self.start + x - self.from;
                    mix(simd, frame, inputs, x, [a, b], *t, straight.map(|root| (root, &mut *self.out, to)));
                    if let Some(root) = out.filter(|_| straight.is_none()) {
                        #[cfg(feature = "faults")]
                        sabotage(instruction, self.frame);
                        self.out_color(simd, x, root);
                        continue;
                    }
                }
                Instruction::Blend { colors, weights } => {
                    for c in 0..3 {
                        let terms = weights.iter().zip(colors).map(|(weight, color)| {
                            let channel = match color {
                                ColorOperand::Rows(rows) => ChannelOperand::Row(row!(rows[c])),
                                ColorOperand::Constant(color) => ChannelOperand::Constant(color[c]),
                                _ => unreachable!("a blend reads rows and constants"),
                            };
                            (row!(*weight), channel)
                        });
                        blend(&mut frame.last[c].0, terms);
                    }
                }
                Instruction::Load(source) => take(frame, inputs, x, source),
                Instruction::Keep(to) => {
                    for (to, last) in to.iter().zip(&mut frame.last) {
                        if let Some(own) = &mut frame.own[*to as usize] {
                            std::mem::swap(own, last);
                        }
                    }
                }
                Instruction::Gate { t, closed, otherwise, skip } => {
                    if is_all(simd, row!(*t), *closed) {
                        take(frame, inputs, x, otherwise);
                        at += skip;
                    }
                }
                Instruction::OutColor(root) => self.out_color(simd, x, *root),
                Instruction::OutRows { root, rows } => {
                    let (first, _) = code.roots[*root as usize];
                    for (channel, row) in rows.iter().enumerate() {
                        let row = chunk(&frame.own, inputs, x, *row);
                        see_field(simd, row, &mut frame.scalars[*root as usize]);
                        self.out[first + channel].copy(self.start + x - self.from, row);
                    }
                }
            }
            #[cfg(feature = "faults")]
            sabotage(instruction, self.frame);
        }
    }
}

/// Runs an operation that writes all rows of a partition.
#[inline(always)]
fn partition(
    frame: &mut CodeFrame<'_>,
    inputs: KernelInputs<'_>,
    x: usize,
    from: &[Row],
    to: &[u32],
    run: impl FnOnce(&mut [&mut [f32]], &[&[f32]]),
) {
    let mut taken: Scratch<Option<&mut Chunk>> = to.iter().map(|&to| frame.own[to as usize].take()).collect();
    {
        let from: Scratch<&[f32]> = from.iter().map(|row| &chunk(&frame.own, inputs, x, *row)[..]).collect();
        let mut to: Scratch<&mut [f32]> = taken.iter_mut().flatten().map(|chunk| &mut chunk.0[..]).collect();
        for (to, from) in to.iter_mut().zip(&from) {
            to.copy_from_slice(from);
        }
        run(&mut to, &from);
    }
    for (&to, taken) in to.iter().zip(&mut taken) {
        frame.own[to as usize] = taken.take();
    }
}

/// Loads a color into the accumulator.
#[inline(always)]
fn take(frame: &mut CodeFrame<'_>, inputs: KernelInputs<'_>, x: usize, source: &ColorOperand) {
    for c in 0..3 {
        match source {
            ColorOperand::Last => {}
            ColorOperand::Rows(rows) => frame.last[c].0 = *chunk(&frame.own, inputs, x, rows[c]),
            ColorOperand::Constant(color) => frame.last[c].0.fill(color[c]),
            ColorOperand::Pair { from, to, by } => {
                let by = chunk(&frame.own, inputs, x, *by);
                for (last, t) in frame.last[c].0.iter_mut().zip(by) {
                    *last = a::mix(from[c], to[c], *t);
                }
            }
        }
    }
}

/// Runs a loop with the same instruction set; as a function of its own in builds for tests, because a single function
/// of all loops takes the compiler minutes, and inline in others, because the call takes a tenth of a mix.
#[cfg_attr(debug_assertions, inline(never))]
#[cfg_attr(not(debug_assertions), inline(always))]
fn apart<S: Simd, R>(simd: S, run: impl FnOnce() -> R) -> R {
    simd.vectorize(run)
}

/// Mixes two colors. Frequent pairs of sources have their own compiled loops; for other pairs, the first color is
/// loaded into the accumulator beforehand.
#[inline(always)]
fn mix<S: Stream>(
    simd: S,
    frame: &mut CodeFrame<'_>,
    inputs: KernelInputs<'_>,
    x: usize,
    [a, b]: [&ColorOperand; 2],
    t: Row,
    out: Option<(u32, &mut [Target<'_>], usize)>,
) {
    use ColorOperand::{Constant, Last, Pair, Rows};
    let direct = match (a, b) {
        (Last, _) | (_, Last) => true,
        (Rows(_), _) | (_, Rows(_)) => S::FUSED,
        _ => false,
    };
    if !direct {
        take(frame, inputs, x, a);
    }
    let own = &frame.own;
    let t = chunk(own, inputs, x, t);
    // Closures might not be inlined, and would then be compiled without the instruction set.
    macro_rules! rows {
        ($rows:expr) => {
            FromRows(rgb!(c => chunk(own, inputs, x, $rows[c])))
        };
    }
    macro_rules! pair {
        ($from:expr, $to:expr, $by:expr) => {
            FromPair::new(simd, $from, $to, chunk(own, inputs, x, *$by))
        };
    }
    macro_rules! run {
        ($a:expr, $b:expr) => {
            match out {
                None => {
                    let (a, b, last) = ($a, $b, &mut frame.last);
                    apart(
                        simd,
                        #[inline(always)]
                        || mix_rows(simd, last, a, b, t),
                    );
                }
                Some((root, out, to)) => {
                    let root = root as usize;
                    let (first, _) = frame.code.roots[root];
                    if let Some(out) = out[first..].first_chunk_mut::<3>() {
                        let (a, b, last, colors) = ($a, $b, &frame.last, &mut frame.colors[root]);
                        apart(
                            simd,
                            #[inline(always)]
                            || mix_out(simd, last, a, b, t, out, to, colors),
                        );
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
pub(crate) fn is_simple(min: f32, max: f32) -> bool {
    max > min && min.abs() < a::LARGE && max.abs() < a::LARGE
}

/// Returns whether the kernels are broken on purpose.
#[inline(always)]
pub(crate) fn is_faulty(frame: &CodeFrame<'_>) -> bool {
    #[cfg(feature = "faults")]
    return frame.fault != crate::code::Fault::None;
    #[cfg(not(feature = "faults"))]
    {
        let _ = frame;
        false
    }
}

/// Corrupts what an instruction wrote, as the program's fault requests.
#[cfg(feature = "faults")]
fn sabotage(instruction: &Instruction, frame: &mut CodeFrame<'_>) {
    use crate::code::Fault;
    let mut spoil = |row: u32, f: fn(f32) -> f32| {
        if let Some(chunk) = &mut frame.own[row as usize] {
            chunk.0.iter_mut().for_each(|v| *v = f(*v));
        }
    };
    match (frame.fault, instruction) {
        (Fault::PartitionLeaks, Instruction::Normalize { to, .. }) => spoil(to[0], |v| v * 0.9),
        (Fault::ClampLeaks, Instruction::Clamp { to, .. }) => spoil(*to, |v| v + 0.25),
        (Fault::MixOvershoots, Instruction::Mix { .. } | Instruction::Patch { .. }) => {
            frame.last[0].0.iter_mut().for_each(|v| *v = *v * 1.5 + 0.01);
        }
        (Fault::MixLosesOne, Instruction::Mix { .. } | Instruction::Patch { .. }) => frame.last[0].0[40] = f32::NAN,
        _ => {}
    }
}
