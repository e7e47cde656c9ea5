//! The stages of one pass, filled over one tile after the other.

use crate::kernel::{Compiled, Machine, Plane, WeightAudit};
use crate::plan::{Feed, Fill};
use crate::prepare::Ready;
use crate::{Buffers, EvalError, Plan};
use std::collections::HashMap;
use std::time::Instant;
use trochoid_graph::{Block, Inputs, NodeError, NodeId, Outputs, Slot, Variance};
use trochoid_image::Window;

/// All stages of a pass, with their planes over the current tile.
pub(crate) struct Fills<'p> {
    plan: &'p Plan<'p>,
    ready: &'p HashMap<NodeId, Ready>,
    buffers: &'p Buffers<'p>,
    fills: Vec<FillState<'p>>,
    /// Which fill holds a node's planes.
    by_node: HashMap<NodeId, usize>,
    /// The current tile.
    tile: Window,
}

struct FillState<'p> {
    fill: &'p Fill,
    taps: Option<Machine<'p>>,
    /// By output, by channel; empty where not wanted.
    planes: Vec<Vec<Vec<f32>>>,
    one_row: bool,
}

impl<'p> Fills<'p> {
    pub(crate) fn new(
        plan: &'p Plan<'p>,
        ready: &'p HashMap<NodeId, Ready>,
        buffers: &'p Buffers<'p>,
        fills: &'p [Fill],
    ) -> Self {
        let by_node = fills.iter().enumerate().map(|(index, fill)| (fill.node, index)).collect();
        let fills = fills
            .iter()
            .map(|fill| FillState {
                fill,
                taps: fill.taps.as_ref().map(Machine::new),
                planes: fill.wanted.iter().map(|channels| vec![Vec::new(); channels.len()]).collect(),
                one_row: fill.variance <= Variance::Column,
            })
            .collect();
        Self { plan, ready, buffers, fills, by_node, tile: Window::default() }
    }

    /// Fills every stage over a tile at one offset within the pixels; adds the time that each took to `seconds`.
    pub(crate) fn fill(&mut self, tile: Window, offset: [f64; 2], seconds: &mut [f64]) -> Result<(), EvalError> {
        self.tile = tile;
        for index in 0..self.fills.len() {
            let started = Instant::now();
            let id = self.fills[index].fill.node;
            self.stage(index, offset).map_err(|error| {
                let node = self.plan.graph.node(id);
                let ty = node.ty.declaration().name.into();
                EvalError::Node { node: node.name.clone(), ty, message: error.message }
            })?;
            seconds[id.0] += started.elapsed().as_secs_f64();
        }
        Ok(())
    }

    /// The planes that a program reads over the current tile, in its order.
    pub(crate) fn planes(&self, program: &Compiled) -> Vec<Plane<'_>> {
        program.planes.iter().map(|slot| self.plane(slot, &self.fills)).collect()
    }

    /// The extremes of weights over everything that ran before stages.
    pub(crate) fn audit(&self) -> WeightAudit {
        let machines = self.fills.iter().filter_map(|fill| fill.taps.as_ref());
        machines.map(Machine::audit).fold(WeightAudit::default(), WeightAudit::merge)
    }

    fn is_bound(&self, node: NodeId) -> bool {
        self.plan.bound[node.0]
    }

    /// A slot over the current tile: a buffer of the caller is read in place.
    fn plane<'a>(&'a self, slot: &Slot, fills: &'a [FillState<'_>]) -> Plane<'a> {
        if self.is_bound(slot.node) {
            let width = self.plan.graph.format().window().width();
            let sources = self.buffers.get(&self.plan.graph.node(slot.node).name).unwrap_or_default();
            let samples: &[f32] = sources.get(slot.channel).copied().unwrap_or_default();
            return Plane { samples, start: self.tile.y0 as usize * width + self.tile.x0 as usize, stride: width };
        }
        match self.by_node.get(&slot.node).and_then(|&index| fills.get(index)) {
            Some(state) => Plane {
                samples: &state.planes[slot.output][slot.channel],
                start: 0,
                stride: if state.one_row { 0 } else { self.tile.width() },
            },
            None => unreachable!("a plane is filled before it is read"),
        }
    }

    /// Fills one stage's planes over the current tile.
    fn stage(&mut self, index: usize, offset: [f64; 2]) -> Result<(), NodeError> {
        if self.is_bound(self.fills[index].fill.node) {
            return Ok(());
        }
        // Taken out, so that the stages before it can be read meanwhile.
        let (mut planes, mut machine) = {
            let state = &mut self.fills[index];
            (std::mem::take(&mut state.planes), state.taps.take())
        };
        let filled = self.fill_into(index, offset, &mut planes, machine.as_mut());
        let state = &mut self.fills[index];
        (state.planes, state.taps) = (planes, machine);
        filled
    }

    fn fill_into(
        &self,
        index: usize,
        offset: [f64; 2],
        planes: &mut [Vec<Vec<f32>>],
        machine: Option<&mut Machine<'p>>,
    ) -> Result<(), NodeError> {
        let state = &self.fills[index];
        let before = &self.fills[..index];
        let tile = self.tile;
        let (width, height) = (tile.width(), tile.height());
        let window = match state.fill.variance {
            Variance::Constant | Variance::Column => Window { y1: tile.y0 + 1, ..tile },
            Variance::Row => Window { x1: tile.x0 + 1, ..tile },
            Variance::Pixel => tile,
        };
        for (plane, wanted) in planes.iter_mut().flatten().zip(state.fill.wanted.iter().flatten()) {
            plane.resize(if *wanted { window.area() } else { 0 }, 0.0);
        }
        let taps = self.run_taps(state, before, machine, width, if state.one_row { 1 } else { height });
        let constants = constants(state.fill, window.area());
        let copies = self.copies(state, before, window);
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
                            Feed::Slot(slot) => Some(match copies.get(slot) {
                                Some(copy) => copy.as_slice(),
                                None => self.plane(slot, before).samples,
                            }),
                        })
                        .collect()
                })
                .collect();
            ports.push((*port, connections));
        }
        let outputs = planes
            .iter_mut()
            .zip(&state.fill.wanted)
            .map(|(planes, wanted)| {
                planes.iter_mut().zip(wanted).map(|(plane, wanted)| wanted.then_some(plane.as_mut_slice())).collect()
            })
            .collect();
        let Some(ready) = self.ready.get(&state.fill.node) else { return Ok(()) };
        ready.prepared.fill(&Block { window, offset }, &Inputs::new(&ports), &mut Outputs::new(outputs))?;
        if state.fill.variance == Variance::Row {
            for plane in planes.iter_mut().flatten().filter(|plane| !plane.is_empty()) {
                *plane = plane.iter().flat_map(|value| std::iter::repeat_n(*value, width)).collect();
            }
        }
        Ok(())
    }

    /// Runs the pointwise program before a stage; gives its roots' planes.
    fn run_taps(
        &self,
        state: &FillState<'_>,
        before: &[FillState<'_>],
        machine: Option<&mut Machine<'p>>,
        width: usize,
        rows: usize,
    ) -> HashMap<(usize, usize), Vec<f32>> {
        let mut taps: HashMap<(usize, usize), Vec<f32>> = HashMap::new();
        if let (Some(machine), Some(compiled)) = (machine, &state.fill.taps) {
            let planes: Vec<Plane<'_>> = compiled.planes.iter().map(|slot| self.plane(slot, before)).collect();
            machine.tile(&planes, width, rows, &mut |root, channel, _, row| {
                taps.entry((root, channel)).or_default().extend_from_slice(row);
            });
        }
        taps
    }

    /// Contiguous copies of the inputs that do not already lie row by row over the stage's window.
    fn copies(&self, state: &FillState<'_>, before: &[FillState<'_>], window: Window) -> HashMap<Slot, Vec<f32>> {
        let mut copies = HashMap::new();
        let feeds = state.fill.inputs.iter().flat_map(|(_, connections)| connections).flatten();
        for slot in feeds.filter_map(|feed| if let Feed::Slot(slot) = feed { Some(slot) } else { None }) {
            let plane = self.plane(slot, before);
            let (width, height) = (window.width(), window.height());
            if plane.start != 0 || (plane.stride != width && height > 1) || plane.samples.len() != window.area() {
                let rows = (0..height).flat_map(|y| plane.row(y, width));
                copies.insert(*slot, rows.copied().collect());
            }
        }
        copies
    }
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
