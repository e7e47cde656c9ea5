//! One thread's work on one tile: fills the stages, runs the program, averages the samples, and judges the result.

use super::adaptive::Adaptive;
use super::bands::Rows;
use super::fill::Fills;
use super::keep::PlaneKeeper;
use super::prepare::PreparedStage;
use crate::judge::{Judge, is_judged, nan_count};
use crate::planning::plan::{Pass, Sample};
use crate::{Buffers, EvalError, Monitor, Plan};
use fearless_simd::{Level, Simd, dispatch};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;
use trochoid_graph::NodeId;
use trochoid_image::Window;
use trochoid_kernel::{Chunk, Look, Machine, Plane, WeightAudit};
use trochoid_memory::{Scratch, Target, write_around};
use trochoid_weights::Audit;

/// If a frame moves more bytes than this, the size of the cache of large processors, results are written around the
/// cache. They would be evicted before anything reads them, and would evict data that is still to be read.
const CACHE: usize = 32 << 20;

/// Everything that the threads of an evaluation read.
#[derive(Clone, Copy)]
pub(crate) struct Evaluation<'p> {
    pub(crate) plan: &'p Plan<'p>,
    pub(crate) ready: &'p HashMap<NodeId, PreparedStage>,
    pub(crate) buffers: &'p Buffers<'p>,
    /// By output.
    pub(crate) judges: &'p [Option<Arc<Judge>>],
    pub(crate) keeper: &'p PlaneKeeper,
    pub(crate) monitor: &'p dyn Monitor,
}

/// State that a thread needs to evaluate tiles, reused from one tile to the next.
pub(crate) struct Worker<'p> {
    pub(super) plan: &'p Plan<'p>,
    pub(super) buffers: &'p Buffers<'p>,
    pub(super) judges: &'p [Option<Arc<Judge>>],
    keeper: &'p PlaneKeeper,
    pub(super) level: Level,
    pub(super) passes: Vec<PassState<'p>>,
    /// Seconds by node.
    pub(crate) fill_seconds: Vec<f64>,
    pub(crate) program_seconds: f64,
    /// Audits by output.
    pub(crate) audits: Vec<Audit>,
}

pub(super) struct PassState<'p> {
    pub(super) pass: &'p Pass,
    pub(super) machine: Machine<'p>,
    /// The same for single pixels.
    pub(super) scattered: Option<Machine<'p>>,
    pub(super) fills: Fills<'p>,
    /// Sums of the samples by channel, and one row of each channel.
    sums: Vec<Vec<f64>>,
    pub(super) rows: Vec<Vec<f32>>,
    pub(super) adaptive: Adaptive,
}

impl<'p> Worker<'p> {
    /// Makes a worker; its machines take the chunks that they need from `chunks`.
    pub(crate) fn new(evaluation: Evaluation<'p>, mut chunks: &'p mut [Chunk]) -> Self {
        let Evaluation { plan, ready, buffers, judges, keeper, monitor } = evaluation;
        let passes = plan
            .passes
            .iter()
            .map(|pass| PassState {
                pass,
                machine: Machine::new(&pass.program, &mut chunks),
                scattered: pass.scattered.as_ref().map(|program| Machine::new(program, &mut chunks)),
                fills: Fills::new(plan, ready, buffers, pass, monitor, &mut chunks).with_keeper(pass, keeper),
                sums: vec![Vec::new(); channel_count(pass)],
                rows: vec![Vec::new(); channel_count(pass)],
                adaptive: Adaptive::default(),
            })
            .collect();
        let nodes = plan.graph.nodes().len();
        Self {
            plan,
            buffers,
            judges,
            keeper,
            level: Level::new(),
            passes,
            fill_seconds: vec![0.0; nodes],
            program_seconds: 0.0,
            audits: vec![Audit::default(); judges.len()],
        }
    }

    /// Evaluates a tile into its rows; before the last step, only its stages.
    pub(crate) fn tile(&mut self, tile: Window, rows: &mut Rows<'_>) -> Result<(), EvalError> {
        if !self.keeper.is_last_step() {
            for PassState { pass, fills, .. } in &mut self.passes {
                pass.samples().try_for_each(|sample| fills.fill(tile, sample, &mut self.fill_seconds))?;
            }
            return Ok(());
        }
        for index in 0..self.passes.len() {
            let is_single = self.passes[index].pass.offsets.len() == 1;
            let mut seen = match self.plan.graph.format().adaptive() {
                _ if is_single => self.single(index, tile, rows)?,
                Some(tolerance) => self.adaptive(index, tile, rows, tolerance)?,
                None => self.averaged(index, tile, rows)?,
            };
            for (output, seen) in seen.iter_mut().enumerate() {
                if self.passes[index].pass.roots.iter().any(|(owner, _)| *owner == output) {
                    seen.pixels = tile.area() as u64;
                    self.audits[output] = self.audits[output].merge(*seen);
                }
            }
        }
        Ok(())
    }

    /// Evaluates one sample per pixel: the program writes straight into the rows.
    fn single(&mut self, index: usize, tile: Window, rows: &mut Rows<'_>) -> Result<Scratch<Audit>, EvalError> {
        let (plan, judges) = (self.plan, self.judges);
        let state = &mut self.passes[index];
        let pass = state.pass;
        state.fills.fill(tile, Sample { index: 0, offset: pass.offsets[0] }, &mut self.fill_seconds)?;
        let started = Instant::now();
        let width = tile.width();
        let planes = state.fills.planes(&pass.program);
        let machine = &mut state.machine;
        let mut seen = run_rows(plan, pass, judges, machine, &planes, tile, rows);
        if machine.has_illegal_input() {
            // The caller's planes hold an illegal value or −0. −0 must be treated like 0, so that no bit depends on
            // pruning.
            machine.reset_checks();
            let normalized = self.buffers.normalized(plan, &pass.program.planes, &planes, tile)?;
            let planes = with_normalized(&planes, &normalized, width);
            seen = run_rows(plan, pass, judges, machine, &planes, tile, rows);
        }
        for (root, &(output, _)) in pass.roots.iter().enumerate() {
            let judge = &judges[output];
            let suspicious = match judge {
                Some(judge) => state.machine.color_range(root).is_none_or(|range| !judge.is_boxed(&range)),
                None => state.machine.saw_nan(root),
            };
            if suspicious {
                seen[output] = audit_tile(judge.as_deref(), &rows[output], tile);
            }
        }
        self.program_seconds += started.elapsed().as_secs_f64();
        Ok(seen)
    }

    /// Averages several samples per pixel, with equal weights.
    fn averaged(&mut self, index: usize, tile: Window, rows: &mut Rows<'_>) -> Result<Scratch<Audit>, EvalError> {
        let plan = self.plan;
        let state = &mut self.passes[index];
        let pass = state.pass;
        let (width, height) = (tile.width(), tile.height());
        for sums in &mut state.sums {
            sums.clear();
            sums.resize(width * height, 0.0);
        }
        for sample in pass.samples() {
            state.fills.fill(tile, sample, &mut self.fill_seconds)?;
            let started = Instant::now();
            let (level, sums) = (self.level, &mut state.sums);
            run_samples(
                plan,
                self.buffers,
                pass,
                &mut state.machine,
                &state.fills,
                tile,
                &mut state.rows,
                |y, rows| {
                    dispatch!(level, simd => simd.vectorize(#[inline(always)] || {
                        for (sums, row) in sums.iter_mut().zip(rows) {
                            add(&mut sums[y * width..(y + 1) * width], row);
                        }
                    }));
                },
            )?;
            self.program_seconds += started.elapsed().as_secs_f64();
        }
        // The weights are equal and sum to 1. Partial sums of n values ≤ m are at most n·m, which f64 holds exactly
        // for every f32 m, so the average stays in the bounding box of the samples.
        let scale = 1.0 / pass.offsets.len() as f64;
        dispatch!(self.level, simd => simd.vectorize(#[inline(always)] || {
            for (slice, sums) in slices(pass, rows).iter_mut().zip(&state.sums) {
                for (to, sum) in slice.iter_mut().zip(sums) {
                    *to = (sum * scale) as f32;
                }
            }
        }));
        let mut seen = Scratch::of(Audit::default(), self.judges.len());
        // The channels of weights are separate roots, and are audited together.
        for &(output, _) in pass.roots.iter().filter(|(_, first)| *first == 0) {
            seen[output] = audit_tile(self.judges[output].as_deref(), &rows[output], tile);
        }
        Ok(seen)
    }

    /// Lists nodes with the number of samples that they left out since they do not show; nodes may come several times.
    pub(crate) fn left_out(&self) -> impl Iterator<Item = (NodeId, u64)> {
        self.passes.iter().flat_map(|state| state.fills.left_out())
    }

    /// Returns the extremes of weights over everything that this worker ran.
    pub(crate) fn audit(&self) -> WeightAudit {
        let audits = self.passes.iter().map(|state| state.fills.audit().merge(state.machine.audit()));
        audits.fold(WeightAudit::default(), WeightAudit::merge)
    }
}

/// Adds a row of samples to their sums. Most channels of a recipe are 0 at most pixels; to look is faster than to add.
#[inline(always)]
fn add(sums: &mut [f64], row: &[f32]) {
    if row.iter().fold(0, |bits, value| bits | value.to_bits()) == 0 {
        return;
    }
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += f64::from(*value);
    }
}

/// Runs a pass's program over a window of the current sample, and hands over each row of all channels.
#[expect(clippy::too_many_arguments, reason = "state of a pass")]
pub(super) fn run_samples(
    plan: &Plan<'_>,
    buffers: &Buffers<'_>,
    pass: &Pass,
    machine: &mut Machine<'_>,
    fills: &Fills<'_>,
    window: Window,
    rows: &mut [Vec<f32>],
    mut take: impl FnMut(usize, &[Vec<f32>]),
) -> Result<(), EvalError> {
    let width = window.width();
    rows.iter_mut().for_each(|row| row.resize(width, 0.0));
    let planes = fills.planes(&pass.program);
    let normalized = buffers.normalized(plan, &pass.program.planes, &planes, window)?;
    let planes = with_normalized(&planes, &normalized, width);
    let mut views = machine.begin(&planes, width);
    for y in 0..window.height() {
        let mut out: Scratch<Target<'_>> = rows.iter_mut().map(|row| Target::new(row)).collect();
        machine.row(&mut views, y, &mut out, 0, None);
        drop(out);
        take(y, rows);
    }
    Ok(())
}

/// Runs a pass's program over a tile, straight into its rows.
fn run_rows(
    plan: &Plan<'_>,
    pass: &Pass,
    judges: &[Option<Arc<Judge>>],
    machine: &mut Machine<'_>,
    planes: &[Plane<'_>],
    tile: Window,
    rows: &mut Rows<'_>,
) -> Scratch<Audit> {
    let width = tile.width();
    let mut seen = Scratch::of(Audit::default(), judges.len());
    let mut views = machine.begin(planes, width);
    let mut run = |targets: &mut [Target<'_>]| {
        let mut look = |root: usize, color: [&[f32]; 3]| {
            let (output, _) = pass.roots[root];
            if let Some(judge) = &judges[output] {
                seen[output] = seen[output].merge(judge.row(color));
            }
        };
        for y in 0..tile.height() {
            let judged = is_judged(plan.settings.judge, tile.y0 + y as i64);
            let look = judged.then_some(&mut look as Look<'_>);
            machine.row(&mut views, y, targets, y * width, look);
        }
    };
    let mut slices = slices(pass, rows);
    let read = pass.program.planes.iter().filter(|slot| plan.bound[slot.node.0]).count();
    // Rows of narrower tiles are copied from here.
    let stay = width == plan.window.width();
    if stay && 4 * plan.window.area() * (slices.len() + read) > CACHE {
        write_around(&mut slices, run);
    } else {
        run(&mut slices.iter_mut().map(|slice| Target::new(slice)).collect::<Scratch<_>>());
    }
    seen
}

/// Returns the planes of a tile with some of them replaced.
fn with_normalized<'a>(
    planes: &[Plane<'a>],
    normalized: &'a [(usize, Scratch<f32>)],
    width: usize,
) -> Scratch<Plane<'a>> {
    let mut planes: Scratch<Plane<'_>> = planes.iter().copied().collect();
    for (plane, samples) in normalized {
        planes[*plane] = Plane { samples, start: 0, stride: width };
    }
    planes
}

/// Returns the number of channels over all roots of a pass.
pub(crate) fn channel_count(pass: &Pass) -> usize {
    pass.program.roots.iter().sum()
}

/// Returns the rows of a tile that a pass writes, channel by channel in the order of its roots.
pub(super) fn slices<'r>(pass: &Pass, rows: &'r mut Rows<'_>) -> Scratch<&'r mut [f32]> {
    let made = |output: usize| pass.roots.iter().any(|(owner, _)| *owner == output);
    let mine = rows.iter_mut().enumerate().filter(|(output, _)| made(*output));
    mine.flat_map(|(_, channels)| channels.iter_mut().map(|channel| &mut **channel)).collect()
}

/// Audits every pixel of a finished tile.
pub(super) fn audit_tile(judge: Option<&Judge>, channels: &[&mut [f32]], tile: Window) -> Audit {
    let mut audit = Audit::default();
    for y in 0..tile.height() {
        let start = y * tile.width();
        let row: Scratch<&[f32]> = channels.iter().map(|channel| &channel[start..start + tile.width()]).collect();
        audit = audit.merge(match (judge, &row[..]) {
            (Some(judge), &[r, g, b]) => judge.row([r, g, b]),
            _ => Audit { nan_count: nan_count(&row), ..Audit::default() },
        });
    }
    audit
}
