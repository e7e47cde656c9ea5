//! One thread's work on one tile: fill the stages, run the program, average the samples.

use crate::fill::Fills;
use crate::kernel::{Machine, Sink, WeightAudit};
use crate::plan::Pass;
use crate::prepare::Ready;
use crate::{Buffers, EvalError, Plan};
use std::collections::HashMap;
use std::time::Instant;
use trochoid_graph::NodeId;
use trochoid_image::Window;

/// What a thread needs to evaluate tiles, reused from one to the next.
pub(crate) struct Worker<'p> {
    plan: &'p Plan<'p>,
    passes: Vec<PassState<'p>>,
    /// Seconds by node, and of all programs together.
    pub(crate) fill_seconds: Vec<f64>,
    pub(crate) program_seconds: f64,
}

struct PassState<'p> {
    pass: &'p Pass,
    machine: Machine<'p>,
    fills: Fills<'p>,
    sums: Vec<f64>,
    /// The first plane of sums of each root.
    sum_of: Vec<usize>,
}

impl<'p> Worker<'p> {
    pub(crate) fn new(plan: &'p Plan<'p>, ready: &'p HashMap<NodeId, Ready>, buffers: &'p Buffers<'p>) -> Self {
        let passes = plan
            .passes
            .iter()
            .map(|pass| PassState {
                pass,
                machine: Machine::new(&pass.program),
                fills: Fills::new(plan, ready, buffers, &pass.fills),
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
        Self { plan, passes, fill_seconds: vec![0.0; nodes], program_seconds: 0.0 }
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
                state.fills.fill(tile, offset, &mut self.fill_seconds)?;
                let started = Instant::now();
                let planes = state.fills.planes(&state.pass.program);
                // Unfused: one operation after the other over the whole tile, where that is one row of memory.
                let contiguous = planes.iter().all(|plane| plane.stride == width);
                let (program_height, program_width) =
                    if self.plan.settings.switches.fuse || !contiguous { (height, width) } else { (1, plane) };
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
        let audits = self.passes.iter().map(|state| state.fills.audit().merge(state.machine.audit()));
        audits.fold(WeightAudit::default(), WeightAudit::merge)
    }
}

/// Number of channels over all roots of a pass.
fn channel_count(pass: &Pass) -> usize {
    pass.program.roots.iter().map(Vec::len).sum()
}
