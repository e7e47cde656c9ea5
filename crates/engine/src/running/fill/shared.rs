//! Stages whose results the samples of a pixel share: after the first sample, only the pixels that differ are filled.

use super::masks::Mask;
use super::runner::Runner;
use super::samples::{PortSamples, Samples};
use super::tapped::Taps;
use super::{FillState, Fills};
use crate::planning::plan::{Feed, Fill};
use crate::planning::schedule::Reach;
use crate::planning::shading::{SHARING_CHANNELS, sharing_slot};
use crate::running::certify::{Found, Ports, fill_with_bounds};
use std::collections::HashMap;
use trochoid_graph::{Block, Bound, Connection, Inputs, NodeError, NodeId, Outputs, Slot};
use trochoid_image::{Shading, Window};
use trochoid_kernel::Plane;
use trochoid_memory::Scratch;

/// What a view sees at the samples of the current tile.
pub(super) struct SharingView {
    pub(super) node: NodeId,
    /// Index of the fill that holds the view's surface and depth.
    fill: usize,
    /// Surface and depth that the first sample sees, over the window `all`.
    first: [Vec<f32>; 2],
    all: Window,
    /// Whether the current sample sees something else, over `window`.
    differs: Vec<bool>,
    window: Window,
    /// Bounds on what the first sample sees, if bounds are requested, and whether the reference may decide
    /// differently about sharing.
    first_bounds: [Vec<f32>; 2],
    doubtful: Vec<bool>,
}

/// Pixels of a window at which the current sample does not share, according to some views.
#[derive(Default)]
pub(super) struct UnsharedPixels {
    views: Scratch<NodeId>,
    window: Window,
    /// How far around the pixels whose samples are taken they were looked for; `None` for the whole window.
    margin: Option<Reach>,
    /// Indices into planes over the window.
    pub(super) indices: Scratch<usize>,
    pub(super) pixels: Scratch<[i64; 2]>,
    /// Pixels at which the reference may decide differently.
    doubtful: Scratch<[i64; 2]>,
}

/// Results of the first sample, by plane, at the pixels where the results of another sample replace them.
#[derive(Default)]
pub(super) struct ReplacedValues {
    /// Indices into the planes.
    pub(super) indices: Vec<usize>,
    values: Vec<Vec<f32>>,
}

impl SharingView {
    /// Returns the views by which stages share.
    pub(super) fn of(fills: &[Fill], by_slot: &HashMap<Slot, usize>) -> Vec<Self> {
        let mut nodes: Vec<NodeId> = fills.iter().flat_map(|fill| fill.shared.iter().flatten().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let view = |node: NodeId| {
            let fill = *by_slot.get(&sharing_slot(node, SHARING_CHANNELS[0]))?;
            let (all, window) = (Window::default(), Window::default());
            Some(Self {
                node,
                fill,
                first: Default::default(),
                all,
                differs: Vec::new(),
                window,
                first_bounds: Default::default(),
                doubtful: Vec::new(),
            })
        };
        nodes.into_iter().filter_map(view).collect()
    }

    /// Returns, for a row of a window within the view's own, where the sample differs.
    fn row(&self, window: Window, y: i64) -> &[bool] {
        &self.differs[self.index([window.x0, y])..][..window.width()]
    }

    /// Returns whether the reference may decide differently at a pixel.
    fn is_doubtful(&self, pixel: [i64; 2]) -> bool {
        self.doubtful.get(self.index(pixel)).is_some_and(|doubtful| *doubtful)
    }

    /// Returns whether the sample differs at a pixel of the view's window.
    pub(super) fn differs_at(&self, pixel: [i64; 2]) -> bool {
        self.differs[self.index(pixel)]
    }

    fn index(&self, [x, y]: [i64; 2]) -> usize {
        (y - self.window.y0) as usize * self.window.width() + (x - self.window.x0) as usize
    }

    /// Compares what a sample sees with what the first sample saw, which covers at least the same pixels.
    fn compare(&mut self, sample: usize, window: Window, [surfaces, depths]: [&[f32]; 2]) {
        if sample == 0 {
            self.all = window;
            for (first, now) in self.first.iter_mut().zip([surfaces, depths]) {
                first.clear();
                first.extend_from_slice(now);
            }
            return;
        }
        self.window = window;
        self.differs.resize(surfaces.len(), false);
        let width = window.width();
        let samples = surfaces.chunks_exact(width).zip(depths.chunks_exact(width));
        for ((differs, (surfaces, depths)), y) in self.differs.chunks_exact_mut(width).zip(samples).zip(window.y0..) {
            let start = (y - self.all.y0) as usize * self.all.width() + (window.x0 - self.all.x0) as usize;
            let first = self.first[0][start..start + width].iter().zip(&self.first[1][start..start + width]);
            for ((differs, first), sample) in differs.iter_mut().zip(first).zip(surfaces.iter().zip(depths)) {
                let pair = |(surface, depth): (&f32, &f32)| (f64::from(*surface), f64::from(*depth));
                *differs = !Shading::is_shared(pair(first), pair(sample));
            }
        }
    }

    /// Finds the pixels in doubt, after [`compare`](Self::compare), from the bounds on what is compared.
    fn doubt(&mut self, sample: usize, [surfaces, depths]: [&[f32]; 2], bounds: [&[f32]; 2]) {
        if sample == 0 {
            self.first_bounds = bounds.map(<[f32]>::to_vec);
            return;
        }
        let width = self.window.width();
        let doubtful = |index: usize| {
            let (x, y) = (self.window.x0 + (index % width) as i64, self.window.y0 + (index / width) as i64);
            let start = (y - self.all.y0) as usize * self.all.width() + (x - self.all.x0) as usize;
            let first = [&self.first, &self.first_bounds].map(|planes| [planes[0][start], planes[1][start]]);
            let here = [[surfaces[index], depths[index]], [bounds[0][index], bounds[1][index]]];
            is_doubtful(first, here)
        };
        self.doubtful = (0..surfaces.len()).map(doubtful).collect();
    }
}

/// Returns whether it is in doubt that samples share which see these surfaces and depths, each within bounds.
fn is_doubtful([first, first_bounds]: [[f32; 2]; 2], [here, bounds]: [[f32; 2]; 2]) -> bool {
    let [first_bounds, bounds] = [first_bounds, bounds].map(|bounds| bounds.map(Bound::decode));
    let is_certain = |[surface, depth]: [Bound; 2]| surface.clear && depth.clear && surface.size == 0.0;
    if !is_certain(first_bounds) || !is_certain(bounds) {
        return true;
    }
    let ([surface, first], [other, depth]) = (first.map(f64::from), here.map(f64::from));
    let (off_first, off) = (first_bounds[1].size, bounds[1].size + first_bounds[1].size);
    if surface != other || (first == depth && off == 0.0) {
        return false;
    }
    // For infinite depths this is NaN, which counts as in doubt.
    let apart = (depth - first).abs();
    let limit = |first: f64| Shading::SAME_DEPTH * first.max(0.0);
    let is_shared = apart + off <= limit(first.abs() - off_first);
    let is_apart = apart - off > limit(first.abs() + off_first);
    !(is_shared || is_apart)
}

impl UnsharedPixels {
    /// Begins with none of another window.
    pub(super) fn begin(&mut self, window: Window) {
        self.window = window;
        self.indices.clear();
        self.pixels.clear();
    }

    /// Adds pixels of a row from one on, and their indices in planes over the window.
    pub(super) fn extend(&mut self, index: usize, [x, y]: [i64; 2], count: usize) {
        self.indices.extend(index..index + count);
        self.pixels.extend((x..x + count as i64).map(|x| [x, y]));
    }

    /// Makes those of a window with these indices.
    pub(super) fn at(window: Window, indices: Scratch<usize>) -> Self {
        let width = window.width();
        let pixel = |index: &usize| [window.x0 + (index % width) as i64, window.y0 + (index / width) as i64];
        let pixels = indices.iter().map(pixel).collect();
        Self { window, indices, pixels, ..Self::default() }
    }
}

impl<'p> Fills<'p> {
    /// Compares what a stage has seen, if it is a view that decides sharing.
    pub(super) fn compare_sample(&mut self, index: usize, sample: usize) {
        if !self.views.iter().any(|view| view.fill == index) {
            return;
        }
        let known: Option<[Scratch<f32>; 2]> = self.known(index).map(|_| {
            let state = &self.fills[index];
            SHARING_CHANNELS.map(|channel| {
                let plane = self.plane(&sharing_slot(state.fill.node, channel), state.window, &self.fills);
                (0..state.window.height()).flat_map(|y| plane.row(y, state.window.width())).copied().collect()
            })
        });
        for view in self.views.iter_mut().filter(|view| view.fill == index) {
            let state = &self.fills[index];
            if let Some([surfaces, depths]) = &known {
                view.compare(sample, state.window, [surfaces, depths]);
                continue;
            }
            let planes = SHARING_CHANNELS.map(|channel| &state.planes[0][channel as usize][..]);
            view.compare(sample, state.window, planes);
            if self.plan.settings.bounds() {
                let behind = state.planes[0].len() / 2;
                let bounds = SHARING_CHANNELS.map(|channel| &state.planes[0][behind + channel as usize][..]);
                view.doubt(sample, planes, bounds);
            }
        }
    }

    /// Fills a stage where the current sample does not share with the first one, and keeps the first sample's results
    /// elsewhere. If only some pixels of its window count, others may get any value.
    pub(super) fn fill_unshared(
        &mut self,
        index: usize,
        views: &[NodeId],
        offset: [f64; 2],
        only: Option<&Mask>,
    ) -> Result<(), NodeError> {
        let margin = only.map(|mask| mask.margin);
        let (window, held) = (self.fills[index].need, self.fills[index].window);
        let is_known = |unshared: &UnsharedPixels| {
            unshared.window == window && unshared.margin == margin && unshared.views[..] == *views
        };
        let known = self.unshared.iter().position(is_known);
        let unshared = match known {
            Some(known) => self.unshared.swap_remove(known),
            None => self.unshared_pixels(views, window, only),
        };
        let state = &mut self.fills[index];
        let mut replaced = std::mem::take(&mut state.replaced);
        let mut own = std::mem::take(&mut state.planes);
        let mut machine = state.taps.take();
        let mut planes: Scratch<&mut Vec<f32>> = own.iter_mut().flatten().filter(|plane| !plane.is_empty()).collect();
        for (plane, values) in planes.iter_mut().zip(&replaced.values) {
            replaced.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = *value);
        }
        replaced.indices.clear();
        let place = |[x, y]: &[i64; 2]| (y - held.y0) as usize * held.width() + (x - held.x0) as usize;
        if window == held {
            replaced.indices.extend_from_slice(&unshared.indices);
        } else {
            replaced.indices.extend(unshared.pixels.iter().map(place));
        }
        // After the pixels that will get new results.
        let doubtful: Scratch<usize> = unshared.doubtful.iter().map(place).collect();
        replaced.indices.extend_from_slice(&doubtful);
        replaced.values.resize_with(planes.len(), Vec::new);
        for (plane, values) in planes.iter().zip(&mut replaced.values) {
            values.clear();
            values.extend(replaced.indices.iter().map(|index| plane[*index]));
        }
        let mut filled = Ok(());
        if !unshared.indices.is_empty() {
            filled = self.fill_pixels(index, &unshared, offset, machine.as_mut()).map(|found| {
                for (plane, values) in planes.iter_mut().zip(&found) {
                    replaced.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = *value);
                }
            });
        }
        drop(planes);
        for planes in own.iter_mut().filter(|_| !doubtful.is_empty()) {
            let bounds = planes.len() / 2;
            for plane in planes[bounds..].iter_mut().filter(|plane| !plane.is_empty()) {
                doubtful.iter().for_each(|place| plane[*place] = Bound::UNKNOWN.encode());
            }
        }
        let state = &mut self.fills[index];
        (state.planes, state.replaced, state.taps) = (own, replaced, machine);
        self.unshared.push(unshared);
        filled
    }

    /// Finds the pixels of a window at which some view sees something else than at the first sample.
    fn unshared_pixels(&self, views: &[NodeId], window: Window, only: Option<&Mask>) -> UnsharedPixels {
        let asked: Scratch<&SharingView> = self.views.iter().filter(|view| views.contains(&view.node)).collect();
        let (mut indices, mut pixels, mut doubtful) = (Scratch::new(), Scratch::new(), Scratch::new());
        for (y, first) in (window.y0..window.y1).zip((0..).step_by(window.width())) {
            let rows: Scratch<&[bool]> = asked.iter().map(|view| view.row(window, y)).collect();
            let counts = |x: &usize| only.is_none_or(|only| only.is_near[first + x]);
            for x in (0..window.width()).filter(|x| counts(x) && rows.iter().any(|row| row[*x])) {
                indices.push(first + x);
                pixels.push([window.x0 + x as i64, y]);
            }
            if self.plan.settings.bounds() {
                let pixels = (window.x0..window.x1).map(|x| [x, y]);
                doubtful.extend(pixels.filter(|pixel| asked.iter().any(|view| view.is_doubtful(*pixel))));
            }
        }
        let margin = only.map(|mask| mask.margin);
        UnsharedPixels { views: views.iter().copied().collect(), window, margin, indices, pixels, doubtful }
    }

    /// Computes the stage's planes at single pixels of its window.
    pub(super) fn fill_pixels(
        &self,
        index: usize,
        unshared: &UnsharedPixels,
        offset: [f64; 2],
        machine: Option<&mut Runner<'p>>,
    ) -> Result<Scratch<Scratch<f32>>, NodeError> {
        self.fill_channels(index, &self.fills[index].fill.wanted, unshared, offset, machine)
    }

    /// Computes some of the stage's planes at single pixels of its window.
    pub(super) fn fill_channels(
        &self,
        index: usize,
        wanted: &[Vec<bool>],
        unshared: &UnsharedPixels,
        offset: [f64; 2],
        machine: Option<&mut Runner<'p>>,
    ) -> Result<Scratch<Scratch<f32>>, NodeError> {
        let planes = wanted.iter().flatten().filter(|wanted| **wanted);
        let mut found: Scratch<Scratch<f32>> = planes.map(|_| Scratch::of(0.0, unshared.indices.len())).collect();
        let targets = found.iter_mut().map(|values| values.as_mut_slice());
        let before = &self.fills[..index];
        let read = |slot: &Slot| Samples::Copied(self.gather(slot, unshared, before));
        self.fill_pixels_into(index, wanted, &unshared.pixels, offset, machine, targets, &read)?;
        Ok(found)
    }

    /// Computes some of the stage's planes at single pixels, given how to read others there.
    #[expect(clippy::too_many_arguments, reason = "what is known of a stage")]
    pub(super) fn fill_pixels_into<'t, 's>(
        &self,
        index: usize,
        wanted: &[Vec<bool>],
        pixels: &[[i64; 2]],
        offset: [f64; 2],
        machine: Option<&mut Runner<'p>>,
        mut targets: impl Iterator<Item = &'t mut [f32]>,
        read: &dyn Fn(&Slot) -> Samples<'s>,
    ) -> Result<(), NodeError> {
        let state = &self.fills[index];
        let Some(ready) = self.ready.get(&state.fill.node) else { return Ok(()) };
        let count = pixels.len();
        let taps = Self::tap_pixels(state, count, machine, read);
        let gather = |feed: &Feed| -> Option<Samples<'_>> {
            Some(match feed {
                Feed::Nothing => return None,
                Feed::Constant(value) => Samples::Copied(Scratch::of(*value, count)),
                Feed::Tap(root, channel) => Samples::InPlace(taps.get(*root, *channel)?),
                Feed::Slot(slot) => read(slot),
            })
        };
        let block = Block::scattered(pixels, offset);
        let held: PortSamples<'_> = state
            .fill
            .inputs
            .iter()
            .map(|(_, connections)| connections.iter().map(|feeds| feeds.iter().map(gather).collect()).collect())
            .collect();
        let ports: Ports<'_> = held
            .iter()
            .map(|connections| {
                let connections = connections.iter().map(|held| Connection {
                    planes: held.iter().map(Option::as_deref).collect(),
                    window: block.window,
                    extent: block.window,
                });
                connections.collect()
            })
            .collect();
        let mut target = |wanted: &bool| wanted.then(|| targets.next()).flatten();
        let mut outputs: Scratch<Scratch<Option<&mut [f32]>>> =
            wanted.iter().map(|channels| channels.iter().map(&mut target).collect()).collect();
        let outputs = outputs.iter_mut().map(|channels| channels.drain(..));
        let cancelled = || self.monitor.cancelled();
        if self.plan.settings.bounds() {
            let exact = self.plan.settings.exact == Some(state.fill.node);
            let before = Found::Before(None);
            let (none, _) = fill_with_bounds(&*ready.prepared, exact, &block, &ports, &cancelled, before, outputs)?;
            state.unbounded.set(none);
            return Ok(());
        }
        let inputs = Inputs::new(&ports).with_cancellation(&cancelled);
        ready.prepared.fill(&block, &inputs, &mut Outputs::new(outputs))
    }

    /// Reads a plane at single pixels.
    pub(super) fn gather(&self, slot: &Slot, unshared: &UnsharedPixels, before: &[FillState<'_>]) -> Scratch<f32> {
        let (plane, window) = (self.plane(slot, unshared.window, before), unshared.window);
        if plane.stride == window.width() {
            let samples = &plane.samples[plane.start..];
            return unshared.indices.iter().map(|index| samples[*index]).collect();
        }
        let at = |[x, y]: &[i64; 2]| plane.start + (y - window.y0) as usize * plane.stride + (x - window.x0) as usize;
        unshared.pixels.iter().map(|pixel| plane.samples[at(pixel)]).collect()
    }

    /// Runs the pointwise program before a stage at some pixels, given how to read planes there.
    pub(super) fn tap_pixels<'s>(
        state: &FillState<'_>,
        count: usize,
        machine: Option<&mut Runner<'p>>,
        read: &dyn Fn(&Slot) -> Samples<'s>,
    ) -> Taps {
        let mut taps = Taps::default();
        if let (Some(machine), Some(compiled)) = (machine, &state.fill.taps) {
            let planes: Scratch<Samples<'_>> = compiled.planes.iter().map(read).collect();
            let stride = count;
            let planes: Scratch<Plane<'_>> = planes.iter().map(|samples| Plane { samples, start: 0, stride }).collect();
            machine.tile(&planes, stride, 1, &mut |root, channel, _, row| {
                taps.of(root, channel).extend_from_slice(row);
            });
        }
        taps
    }
}
