//! One thread's work on one tile: fill the stages, run the program, average the samples.

use crate::kernel::{Compiled, Machine, Plane, Sink, WeightAudit};
use crate::plan::{Feed, Fill, Pass};
use crate::prepare::Ready;
use crate::{Buffers, EvalError, Plan};
use std::collections::HashMap;
use std::time::Instant;
use trochoid_graph::{Block, Inputs, NodeError, NodeId, Outputs, Slot, Variance};
use trochoid_image::Window;

/// What a thread needs to evaluate tiles, reused from one to the next.
pub(crate) struct Worker<'p> {
    plan: &'p Plan<'p>,
    ready: &'p HashMap<NodeId, Ready>,
    buffers: &'p Buffers<'p>,
    passes: Vec<PassState<'p>>,
    /// Seconds by node, and of all programs together.
    pub(crate) fill_seconds: Vec<f64>,
    pub(crate) program_seconds: f64,
}

struct PassState<'p> {
    pass: &'p Pass,
    machine: Machine<'p>,
    fills: Vec<FillState<'p>>,
    /// Which fill holds a node's planes.
    by_node: HashMap<NodeId, usize>,
    sums: Vec<f64>,
    /// The first plane of sums of each root.
    sum_of: Vec<usize>,
}

struct FillState<'p> {
    fill: &'p Fill,
    taps: Option<Machine<'p>>,
    /// By output, by channel; empty where not wanted.
    planes: Vec<Vec<Vec<f32>>>,
    one_row: bool,
}

impl<'p> Worker<'p> {
    pub(crate) fn new(plan: &'p Plan<'p>, ready: &'p HashMap<NodeId, Ready>, buffers: &'p Buffers<'p>) -> Self {
        let passes = plan
            .passes
            .iter()
            .map(|pass| PassState {
                pass,
                machine: Machine::new(&pass.program),
                fills: pass
                    .fills
                    .iter()
                    .map(|fill| FillState {
                        fill,
                        taps: fill.taps.as_ref().map(Machine::new),
                        planes: fill.wanted.iter().map(|channels| vec![Vec::new(); channels.len()]).collect(),
                        one_row: fill.variance <= Variance::Column,
                    })
                    .collect(),
                by_node: pass.fills.iter().enumerate().map(|(index, fill)| (fill.node, index)).collect(),
                sums: Vec::new(),
                sum_of: pass
                    .program
                    .roots
                    .iter()
                    .scan(0, |next, rows| Some(std::mem::replace(next, *next + rows.len())))
                    .collect(),
            })
            .collect();
        let nodes = plan.graph.nodes().len();
        Self { plan, ready, buffers, passes, fill_seconds: vec![0.0; nodes], program_seconds: 0.0 }
    }

    /// Evaluates a tile; `sink` receives rows as (output of the plan, channel, y within the tile, samples).
    pub(crate) fn tile(&mut self, tile: Window, sink: Sink<'_>) -> Result<(), EvalError> {
        let (width, height) = (tile.width(), tile.height());
        for state in &mut self.passes {
            let samples = state.pass.offsets.len();
            let plane = width * height;
            if samples > 1 {
                state.sums.clear();
                state.sums.resize(plane * channel_count(state.pass), 0.0);
            }
            for &offset in &state.pass.offsets {
                for index in 0..state.fills.len() {
                    let started = Instant::now();
                    let node = state.fills[index].fill.node;
                    fill(self.plan, self.ready, self.buffers, &mut state.fills, &state.by_node, index, tile, offset)
                        .map_err(|error| {
                            let node = self.plan.graph.node(node);
                            let ty = node.ty.declaration().name.into();
                            EvalError::Node { node: node.name.clone(), ty, message: error.message }
                        })?;
                    self.fill_seconds[node.0] += started.elapsed().as_secs_f64();
                }
                let started = Instant::now();
                let planes = planes(&state.pass.program, &state.fills, &state.by_node);
                let (program_height, program_width) =
                    if self.plan.settings.switches.fuse || planes.iter().any(|plane| plane.one_row) {
                        (height, width)
                    } else {
                        // Unfused: one operation after the other over the whole tile.
                        (1, plane)
                    };
                let roots = &state.pass.roots;
                let (sums, sum_of) = (&mut state.sums, &state.sum_of);
                state.machine.tile(&planes, program_width, program_height, &mut |root, channel, y, row| {
                    let (output, first) = roots[root];
                    if samples > 1 {
                        let start = (sum_of[root] + channel) * plane + y * program_width;
                        for (sum, value) in sums[start..start + program_width].iter_mut().zip(row) {
                            *sum += f64::from(*value);
                        }
                    } else {
                        for (part, row) in row.chunks_exact(width).enumerate() {
                            sink(output, first + channel, y + part, row);
                        }
                    }
                });
                self.program_seconds += started.elapsed().as_secs_f64();
            }
            if samples > 1 {
                // Equal weights that sum to 1: partial sums of n values ≤ m are at most n·m, which f64 holds
                // exactly for every f32 m, so the average stays in the samples' box.
                let scale = 1.0 / samples as f64;
                let mut row = vec![0.0f32; width];
                for root in 0..state.pass.roots.len() {
                    let (output, first) = state.pass.roots[root];
                    for channel in 0..state.pass.program.roots[root].len() {
                        let start = (state.sum_of[root] + channel) * plane;
                        for y in 0..height {
                            let sums = &state.sums[start + y * width..start + (y + 1) * width];
                            for (to, sum) in row.iter_mut().zip(sums) {
                                *to = (sum * scale) as f32;
                            }
                            sink(output, first + channel, y, &row);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The extremes of weights over everything that this worker ran.
    pub(crate) fn audit(&self) -> WeightAudit {
        let machines = self.passes.iter().flat_map(|state| {
            state.fills.iter().filter_map(|fill| fill.taps.as_ref()).chain(std::iter::once(&state.machine))
        });
        machines.map(Machine::audit).fold(WeightAudit::default(), WeightAudit::merge)
    }
}

/// Number of channels over all roots of a pass.
fn channel_count(pass: &Pass) -> usize {
    pass.program.roots.iter().map(Vec::len).sum()
}

/// The planes that a program reads, in its order.
fn planes<'a>(program: &Compiled, fills: &'a [FillState<'_>], by_node: &HashMap<NodeId, usize>) -> Vec<Plane<'a>> {
    program.planes.iter().map(|slot| plane(slot, fills, by_node)).collect()
}

fn plane<'a>(slot: &Slot, fills: &'a [FillState<'_>], by_node: &HashMap<NodeId, usize>) -> Plane<'a> {
    match by_node.get(&slot.node).and_then(|&index| fills.get(index)) {
        Some(state) => Plane { samples: &state.planes[slot.output][slot.channel], one_row: state.one_row },
        None => unreachable!("a plane is filled before it is read"),
    }
}

/// Fills one stage's planes over a tile.
#[allow(clippy::too_many_arguments, reason = "one call site; a struct would only name the same things twice")]
fn fill(
    plan: &Plan<'_>,
    ready: &HashMap<NodeId, Ready>,
    buffers: &Buffers<'_>,
    fills: &mut [FillState<'_>],
    by_node: &HashMap<NodeId, usize>,
    index: usize,
    tile: Window,
    offset: [f64; 2],
) -> Result<(), NodeError> {
    let (before, rest) = fills.split_at_mut(index);
    let Some(state) = rest.first_mut() else { return Ok(()) };
    let (width, height) = (tile.width(), tile.height());
    let window = match state.fill.variance {
        Variance::Constant | Variance::Column => Window { y1: tile.y0 + 1, ..tile },
        Variance::Row => Window { x1: tile.x0 + 1, ..tile },
        Variance::Pixel => tile,
    };
    for (planes, wanted) in state.planes.iter_mut().flatten().zip(state.fill.wanted.iter().flatten()) {
        planes.resize(if *wanted { window.area() } else { 0 }, 0.0);
    }
    if plan.bound[state.fill.node.0] {
        copy_bound(plan, buffers, state, tile);
        return Ok(());
    }
    let taps = run_taps(state, before, by_node, width, height);
    let constants = constants(state.fill, window.area());
    let expanded = expand(state.fill, before, by_node, state.one_row, height);
    let mut ports = Vec::with_capacity(state.fill.inputs.len());
    for (port, connections) in &state.fill.inputs {
        let connections = connections
            .iter()
            .map(|feeds| {
                feeds
                    .iter()
                    .map(|feed| match feed {
                        Feed::Nothing => None,
                        Feed::Constant(value) => constants.get(&value.to_bits()).map(Vec::as_slice),
                        Feed::Tap(root, channel) => taps.get(&(*root, *channel)).map(Vec::as_slice),
                        Feed::Slot(slot) => Some(match expanded.get(slot) {
                            Some(plane) => plane.as_slice(),
                            None => plane(slot, before, by_node).samples,
                        }),
                    })
                    .collect()
            })
            .collect();
        ports.push((*port, connections));
    }
    let outputs = state
        .planes
        .iter_mut()
        .zip(&state.fill.wanted)
        .map(|(planes, wanted)| {
            planes.iter_mut().zip(wanted).map(|(plane, wanted)| wanted.then_some(plane.as_mut_slice())).collect()
        })
        .collect();
    let Some(ready) = ready.get(&state.fill.node) else { return Ok(()) };
    ready.prepared.fill(&Block { window, offset }, &Inputs::new(&ports), &mut Outputs::new(outputs))?;
    if state.fill.variance == Variance::Row {
        for plane in state.planes.iter_mut().flatten().filter(|plane| !plane.is_empty()) {
            *plane = plane.iter().flat_map(|value| std::iter::repeat_n(*value, width)).collect();
        }
    }
    Ok(())
}

/// Copies a tile of the caller's buffers; adding 0 turns −0 into 0, so that no bit depends on pruning.
fn copy_bound(plan: &Plan<'_>, buffers: &Buffers<'_>, state: &mut FillState<'_>, tile: Window) {
    let picture = plan.graph.format().window();
    let Some(sources) = buffers.get(&plan.graph.node(state.fill.node).name) else { return };
    for (plane, source) in state.planes[0].iter_mut().zip(sources).filter(|(plane, _)| !plane.is_empty()) {
        for (row, y) in plane.chunks_exact_mut(tile.width()).zip(tile.y0..) {
            let start = y as usize * picture.width() + tile.x0 as usize;
            for (to, from) in row.iter_mut().zip(&source[start..]) {
                *to = from + 0.0;
            }
        }
    }
}

/// Runs the pointwise program before a stage; gives its roots' planes.
fn run_taps(
    state: &mut FillState<'_>,
    before: &[FillState<'_>],
    by_node: &HashMap<NodeId, usize>,
    width: usize,
    height: usize,
) -> HashMap<(usize, usize), Vec<f32>> {
    let mut taps: HashMap<(usize, usize), Vec<f32>> = HashMap::new();
    if let (Some(machine), Some(compiled)) = (&mut state.taps, &state.fill.taps) {
        let planes = planes(compiled, before, by_node);
        let rows = if state.one_row { 1 } else { height };
        machine.tile(&planes, width, rows, &mut |root, channel, _, row| {
            taps.entry((root, channel)).or_default().extend_from_slice(row);
        });
    }
    taps
}

/// Planes of the literals that a stage takes, by their bits.
fn constants(fill: &Fill, area: usize) -> HashMap<u32, Vec<f32>> {
    let feeds = fill.inputs.iter().flat_map(|(_, connections)| connections).flatten();
    feeds
        .filter_map(
            |feed| if let Feed::Constant(value) = feed { Some((value.to_bits(), vec![*value; area])) } else { None },
        )
        .collect()
}

/// Full planes of inputs that hold one row only, where the stage itself works on all rows.
fn expand(
    fill: &Fill,
    before: &[FillState<'_>],
    by_node: &HashMap<NodeId, usize>,
    one_row: bool,
    height: usize,
) -> HashMap<Slot, Vec<f32>> {
    let mut expanded = HashMap::new();
    for feed in fill.inputs.iter().flat_map(|(_, connections)| connections).flatten() {
        if let Feed::Slot(slot) = feed {
            let source = plane(slot, before, by_node);
            if source.one_row && !one_row {
                expanded.insert(*slot, source.samples.repeat(height));
            }
        }
    }
    expanded
}
