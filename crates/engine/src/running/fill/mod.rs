//! Fills the stages of one pass, tile by tile.
//!
//! A stage is filled over its own window, which covers what its readers need from it. The program needs the tile; a
//! filter needs its region of interest, clamped to the extent of the image that it reads, so that no stage is ever
//! asked for pixels outside of its image.

mod crops;
mod extent;
mod gated;
mod masks;
mod parts;
mod places;
mod room;
mod runner;
mod samples;
mod shared;
mod spare;
mod sparse;
mod state;
mod tapped;
mod windows;

use crate::planning::plan::{Feed, Fill, Pass, Sample};
use crate::running::certify::{Found, Ports, fill_with_bounds};
use crate::running::keep::PlaneKeeper;
use crate::running::prepare::{PreparedStage, node_error};
use crate::running::steps::Whole;
use crate::{Buffers, EvalError, Monitor, Plan};
use crops::Crops;
pub(crate) use extent::extents;
use gated::Gated;
pub(crate) use places::{make_room, with_room};
pub(crate) use room::bytes_beside_planes;
use runner::Runner;
use samples::PortSamples;
use shared::{ReplacedValues, SharingView, UnsharedPixels};
use spare::Spare;
use sparse::Sparse;
use state::{FillState, Image};
use std::cell::Cell;
use std::collections::HashMap;
use std::time::Instant;
use tapped::Tapped;
use trochoid_graph::{Block, Connection, Inputs, NoBound, NodeError, NodeId, Outputs, SharedResult, Slot, Variance};
use trochoid_image::Window;
use trochoid_kernel::{Chunk, CompiledProgram, Plane, WeightAudit};
use trochoid_memory::Scratch;

/// All stages of a pass, with their planes over the current tile.
pub(crate) struct Fills<'p> {
    plan: &'p Plan<'p>,
    ready: &'p HashMap<NodeId, PreparedStage>,
    buffers: &'p Buffers<'p>,
    monitor: &'p dyn Monitor,
    fills: Vec<FillState<'p>>,
    /// Index of the fill that holds a plane.
    by_slot: HashMap<Slot, usize>,
    /// Views that decide whether samples share.
    views: Vec<SharingView>,
    /// Pixels at which the current sample does not share.
    unshared: Vec<UnsharedPixels>,
    /// The current tile, and the index of the current sample.
    tile: Window,
    sample: usize,
    /// Whether samples of a pixel share.
    sharing: bool,
    /// A row of bounds for the caller's buffers, which are exact by definition.
    exact: Vec<f32>,
    /// Planes that are known from an earlier evaluation, and planes to keep from this one.
    keeper: Option<&'p PlaneKeeper>,
    /// Planes of the programs before stages, whose memory is used again and again.
    tapped: Tapped,
    /// Parts of planes that several stages read at the current sample.
    crops: Crops,
    /// Where stages show.
    gated: Option<Gated<'p>>,
    /// Planes at single pixels.
    sparse: Option<Sparse>,
    /// Memory of planes that nothing reads any more, if there is only one sample.
    spare: Option<Spare>,
    /// By fill, the number of samples that it left out since they do not show.
    left_out: Vec<u64>,
}

impl<'p> Fills<'p> {
    pub(crate) fn new(
        plan: &'p Plan<'p>,
        ready: &'p HashMap<NodeId, PreparedStage>,
        buffers: &'p Buffers<'p>,
        pass: &'p Pass,
        monitor: &'p dyn Monitor,
        chunks: &mut &'p mut [Chunk],
    ) -> Self {
        let fills = &pass.fills[..];
        let by_slot = by_slot(fills);
        let views = SharingView::of(fills, &by_slot);
        let extents = extents(plan, ready, fills);
        let crops = Crops::new(fills);
        let gated = Gated::of(pass, chunks);
        let sparse = Sparse::of(plan, pass);
        let picture = plan.graph.format().window();
        let bounding = plan.settings.bounds();
        let image = |fill: &Fill, feeds: &Vec<Feed>| {
            let extent = match feeds.iter().find(|feed| **feed != Feed::Nothing) {
                Some(Feed::Slot(slot)) => extents.get(&slot.node),
                Some(Feed::Tap(..)) => None,
                // A literal extends as far as the stage does.
                _ => extents.get(&fill.node),
            };
            Image { extent: extent.copied().unwrap_or(picture), region: Window::default() }
        };
        let fills = fills
            .iter()
            .map(|fill| FillState {
                fill,
                stage: plan.stage(fill.node),
                taps: fill.taps.as_ref().map(|taps| Runner::new(taps, bounding, chunks)),
                planes: fill.wanted.iter().map(|channels| vec![Vec::new(); channels.len()]).collect(),
                one_row: fill.variance <= Variance::Column,
                columns: None,
                part: fill.wanted.iter().map(|channels| vec![Vec::new(); channels.len()]).collect(),
                images: fill
                    .inputs
                    .iter()
                    .map(|(_, connections)| connections.iter().map(|feeds| image(fill, feeds)).collect())
                    .collect(),
                window: Window::default(),
                tap_window: Window::default(),
                tapped: Tapped::default(),
                replaced: ReplacedValues::default(),
                found: None,
                need: Window::default(),
                only: Vec::new(),
                unbounded: Cell::new(None),
            })
            .collect();
        Self {
            plan,
            ready,
            buffers,
            monitor,
            left_out: vec![0; pass.fills.len()],
            fills,
            by_slot,
            views,
            unshared: Vec::new(),
            tile: Window::default(),
            sample: 0,
            sharing: pass.sharing,
            exact: if bounding { vec![0.0; picture.width()] } else { Vec::new() },
            keeper: None,
            tapped: Tapped::default(),
            crops,
            gated,
            sparse,
            spare: None,
        }
    }

    /// Uses planes that were filled before, and keeps planes that are not known yet.
    pub(crate) fn with_keeper(self, pass: &Pass, keeper: &'p PlaneKeeper) -> Self {
        let gated = self.gated.map(|gated| gated.with_keeper(keeper));
        let spare = Spare::of(pass, &self.by_slot, keeper);
        Self { keeper: Some(keeper), gated, spare, ..self }
    }

    /// Returns the planes of a fill for the current sample that an earlier evaluation filled, by output and channel.
    fn known(&self, fill: usize) -> Option<&'p [Vec<Vec<f32>>]> {
        self.keeper?.known(Whole::Fill(fill), self.sample)
    }

    /// Returns the results of the program before a fill for the current sample, if an earlier step holds them, by root and
    /// channel.
    fn known_taps(&self, fill: usize) -> Option<&'p [Vec<Vec<f32>>]> {
        self.keeper?.known(Whole::Taps(fill), self.sample)
    }

    /// Returns whether the current step fills some whole planes.
    fn holds(&self, whole: Whole) -> bool {
        self.keeper.is_some_and(|keeper| keeper.wants(whole))
    }

    /// Fills every stage over the window that a tile needs, for a sample, and adds the time of each stage to
    /// `seconds`. The first sample of a tile must come first, since the others may share its results.
    pub(crate) fn fill(&mut self, tile: Window, sample: Sample, seconds: &mut [f64]) -> Result<(), EvalError> {
        if sample.index == 0 || self.sharing || self.tile != tile {
            self.place_windows(tile, sample.index);
        }
        self.begin(sample);
        for index in 0..self.fills.len() {
            self.fill_one(index, sample, seconds)?;
            self.give_back(index);
        }
        Ok(())
    }

    /// Fills a stage if it takes part, over its window.
    fn fill_one(&mut self, index: usize, sample: Sample, seconds: &mut [f64]) -> Result<(), EvalError> {
        let holds_taps = self.holds(Whole::Taps(index));
        if self.fills[index].need.is_empty() && !holds_taps {
            return Ok(());
        }
        if self.monitor.cancelled() {
            return Err(EvalError::Cancelled);
        }
        let started = Instant::now();
        let id = self.fills[index].fill.node;
        if holds_taps {
            self.hold_taps(index, sample.index);
            seconds[id.0] += started.elapsed().as_secs_f64();
            return Ok(());
        }
        let filled = match &self.fills[index].fill.shared {
            Some(views) if sample.index > 0 && self.known(index).is_none() => {
                self.fill_unshared(index, views, sample.offset, None)
            }
            _ => self.fill_gated(index, sample).and_then(|is_filled| match is_filled {
                true => Ok(()),
                false => self.fill_stage(index, sample).map(|()| self.compare_sample(index, sample.index)),
            }),
        };
        filled.map_err(|error| node_error(self.plan, id, error, self.monitor))?;
        let whole = Whole::Fill(index);
        if let Some(keeper) = self.keeper.filter(|keeper| keeper.wants(whole)) {
            let state = &self.fills[index];
            let picture = self.plan.graph.format().window();
            keeper.take(
                whole,
                sample.index,
                self.tile,
                state.window,
                picture,
                state.planes.iter().flatten().map(|plane| &plane[..]),
            );
        }
        seconds[id.0] += started.elapsed().as_secs_f64();
        Ok(())
    }

    /// Begins with another sample.
    fn begin(&mut self, sample: Sample) {
        self.sample = sample.index;
        self.unshared.clear();
        self.gated.iter_mut().for_each(Gated::begin);
        self.crops.begin();
    }

    /// Returns the planes that a program reads over the current tile, in its order.
    pub(crate) fn planes(&self, program: &CompiledProgram) -> Scratch<Plane<'_>> {
        program.planes.iter().map(|slot| self.plane(slot, self.tile, &self.fills)).collect()
    }

    /// Lists the nodes of the fills with the number of samples that each left out since they do not show.
    pub(crate) fn left_out(&self) -> impl Iterator<Item = (NodeId, u64)> {
        self.fills.iter().zip(&self.left_out).map(|(state, left_out)| (state.fill.node, *left_out))
    }

    /// Lists the stages that know no bound on the planes that they filled last, with the reason.
    pub(crate) fn unbounded(&self) -> impl Iterator<Item = (NodeId, NoBound)> {
        self.fills.iter().filter_map(|state| Some((state.fill.node, state.unbounded.get()?)))
    }

    /// Returns the extremes of weights over all programs that ran before stages.
    pub(crate) fn audit(&self) -> WeightAudit {
        let machines = self.fills.iter().filter_map(|fill| fill.taps.as_ref());
        machines.map(Runner::audit).fold(WeightAudit::default(), WeightAudit::merge)
    }

    fn is_bound(&self, node: NodeId) -> bool {
        self.plan.bound[node.0]
    }

    /// Returns the plane of a slot over a window; a buffer of the caller is read in place, unless it is divided.
    fn plane<'a>(&'a self, slot: &Slot, over: Window, fills: &'a [FillState<'_>]) -> Plane<'a> {
        let start =
            |within: Window, stride: usize| (over.y0 - within.y0) as usize * stride + (over.x0 - within.x0) as usize;
        if self.is_bound(slot.node) && !self.is_divided(slot.node) {
            if slot.channel >= self.plan.graph.node(slot.node).kinds[slot.output].channels() {
                return Plane { samples: &self.exact, start: 0, stride: 0 };
            }
            let picture = self.plan.graph.format().window();
            let sources = self.buffers.get(&self.plan.graph.node(slot.node).name).unwrap_or_default();
            let samples: &[f32] = sources.get(slot.channel).copied().unwrap_or_default();
            let stride = picture.width();
            return Plane { samples, start: start(picture, stride), stride };
        }
        match self.by_slot.get(slot).and_then(|&index| Some((index, fills.get(index)?))) {
            Some((index, _)) if let Some(filled) = self.known(index) => {
                let picture = self.plan.graph.format().window();
                let stride = picture.width();
                Plane { samples: &filled[slot.output][slot.channel], start: start(picture, stride), stride }
            }
            Some((_, state)) => {
                let stride = if state.one_row { 0 } else { state.window.width() };
                let samples = &state.planes[slot.output][slot.channel];
                Plane { samples, start: start(state.window, stride), stride }
            }
            None => unreachable!("a plane is filled before it is read"),
        }
    }

    /// Fills one stage's planes.
    fn fill_stage(&mut self, index: usize, sample: Sample) -> Result<(), NodeError> {
        let node = self.fills[index].fill.node;
        if self.is_divided(node) {
            self.fill_parts(index);
        }
        if self.is_bound(node) || self.known(index).is_some() {
            return Ok(());
        }
        self.fills[index].replaced.indices.clear();
        // A plane that does not vary from row to row is reused if the previous tile had the same columns.
        let state = &mut self.fills[index];
        let columns = Some((state.window.x0, state.window.x1, sample.offset));
        if state.one_row && std::mem::replace(&mut state.columns, columns) == columns {
            return Ok(());
        }
        self.crop(index);
        self.lend(index, self.fills[index].own_window(self.fills[index].window).area());
        // Taken out, so that the stages before it can be read meanwhile.
        let state = &mut self.fills[index];
        let tapped_of = if state.fill.steady { &mut state.tapped } else { &mut self.tapped };
        let mut tapped = std::mem::take(tapped_of);
        let (mut planes, mut machine) = (std::mem::take(&mut state.planes), state.taps.take());
        let filled = self.fill_into(index, sample, &mut planes, machine.as_mut(), &mut tapped);
        let state = &mut self.fills[index];
        if filled.is_err() {
            state.columns = None;
        }
        (state.planes, state.taps) = (planes, machine);
        *(if state.fill.steady { &mut state.tapped } else { &mut self.tapped }) = tapped;
        state.found = filled?;
        Ok(())
    }

    /// Fills one stage's planes into `planes`, and returns what it found for all samples.
    fn fill_into(
        &self,
        index: usize,
        sample: Sample,
        planes: &mut [Vec<Vec<f32>>],
        machine: Option<&mut Runner<'p>>,
        tapped: &mut Tapped,
    ) -> Result<Option<SharedResult>, NodeError> {
        let state = &self.fills[index];
        let before = &self.fills[..index];
        let window = state.own_window(state.window);
        for (plane, wanted) in planes.iter_mut().flatten().zip(state.fill.wanted.iter().flatten()) {
            let samples = if *wanted { window.area() } else { 0 };
            make_room(plane, samples);
            plane.resize(samples, 0.0);
        }
        if self.known_taps(index).is_none() {
            self.run_taps(state, before, sample.index, machine, tapped);
        }
        let taps = &tapped.planes;
        let held: PortSamples<'_> = state
            .fill
            .inputs
            .iter()
            .zip(&state.images)
            .map(|((_, connections), images)| {
                let connections = connections.iter().zip(images);
                connections
                    .map(|(feeds, image)| {
                        let window = self.window_of(index, feeds, image.region);
                        feeds.iter().map(|feed| self.samples(feed, window, index, taps)).collect()
                    })
                    .collect()
            })
            .collect();
        let ports: Ports<'_> = (state.fill.inputs.iter().zip(&state.images).zip(&held))
            .map(|(((_, connections), images), held)| {
                let connections = connections.iter().zip(images).zip(held).map(|((feeds, image), held)| Connection {
                    planes: held.iter().map(Option::as_deref).collect(),
                    window: self.window_of(index, feeds, image.region),
                    extent: image.extent,
                });
                connections.collect()
            })
            .collect();
        let outputs = planes.iter_mut().zip(&state.fill.wanted).map(|(planes, wanted)| {
            planes.iter_mut().zip(wanted).map(|(plane, wanted)| wanted.then_some(plane.as_mut_slice()))
        });
        let Some(ready) = self.ready.get(&state.fill.node) else { return Ok(None) };
        let cancelled = || self.monitor.cancelled();
        let only = (state.only.len() == window.area()).then_some(&state.only[..]);
        let block = Block::of(window, sample.offset).with_only(only);
        if self.plan.settings.bounds() {
            let exact = self.plan.settings.exact == Some(state.fill.node);
            let found = match sample.index {
                0 if self.sharing => Found::Now,
                _ => Found::Before(state.found.as_ref()),
            };
            let (none, found) = fill_with_bounds(&*ready.prepared, exact, &block, &ports, &cancelled, found, outputs)?;
            state.unbounded.set(none);
            return Ok(found);
        }
        let inputs = Inputs::new(&ports).with_cancellation(&cancelled);
        let found = match sample.index {
            0 if self.sharing => ready.prepared.find(&block, &inputs)?,
            _ => state.found.clone(),
        };
        let inputs = inputs.with_found(found.as_ref());
        ready.prepared.fill(&block, &inputs, &mut Outputs::new(outputs))?;
        if state.fill.variance == Variance::Row {
            let width = state.window.width();
            for plane in planes.iter_mut().flatten().filter(|plane| !plane.is_empty()) {
                let rows = plane.len();
                plane.resize(rows * width, 0.0);
                // From the last row on, so that no value is overwritten before it is read.
                for row in (0..rows).rev() {
                    let value = plane[row];
                    plane[row * width..][..width].fill(value);
                }
            }
        }
        Ok(found)
    }
}

/// Returns the index of the fill that holds each plane.
pub(super) fn by_slot(fills: &[Fill]) -> HashMap<Slot, usize> {
    let mut by_slot = HashMap::new();
    for (index, fill) in fills.iter().enumerate() {
        for (output, channels) in fill.wanted.iter().enumerate() {
            for channel in (0..channels.len()).filter(|channel| channels[*channel]) {
                by_slot.insert(Slot { node: fill.node, output, channel }, index);
            }
        }
    }
    by_slot
}
