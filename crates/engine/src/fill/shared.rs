//! Stages whose results the samples of a pixel share: of all but the first sample, only what differs is filled.

use super::runner::Runner;
use super::{FillState, Fills, Held, Taps};
use crate::certify::fill_with_bounds;
use crate::kernel::Plane;
use crate::plan::{Feed, Fill};
use crate::shading::TELLING;
use std::borrow::Cow;
use std::collections::HashMap;
use trochoid_graph::{Block, Connection, Inputs, NodeError, NodeId, Outputs, Slot, ViewChannel};
use trochoid_image::{Shading, Window};

/// What a view tells of the samples of the current tile.
pub(super) struct View {
    node: NodeId,
    /// The fill that holds what it tells.
    fill: usize,
    /// Surface and depth that the first sample sees, and at which pixels.
    first: [Vec<f32>; 2],
    all: Window,
    /// Whether the current sample sees something else, and at which pixels that is known.
    differs: Vec<bool>,
    window: Window,
}

/// The pixels of a window at which the current sample does not share, by the views that say so.
pub(super) struct Apart {
    views: Vec<NodeId>,
    window: Window,
    /// As indices into planes over the window.
    indices: Vec<usize>,
    pixels: Vec<[i64; 2]>,
}

/// Results of the first sample, by plane, at the pixels where those of another stand in their place.
#[derive(Default)]
pub(super) struct Kept {
    /// As indices into the planes.
    pub(super) indices: Vec<usize>,
    values: Vec<Vec<f32>>,
}

/// The plane in which a view tells something.
pub(super) fn telling(node: NodeId, channel: ViewChannel) -> Slot {
    Slot { node, output: 0, channel: channel as usize }
}

impl View {
    /// The views by which stages share.
    pub(super) fn of(fills: &[Fill], by_slot: &HashMap<Slot, usize>) -> Vec<Self> {
        let mut nodes: Vec<NodeId> = fills.iter().flat_map(|fill| fill.shared.iter().flatten().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let view = |node: NodeId| {
            let fill = *by_slot.get(&telling(node, TELLING[0]))?;
            let (all, window) = (Window::default(), Window::default());
            Some(Self { node, fill, first: Default::default(), all, differs: Vec::new(), window })
        };
        nodes.into_iter().filter_map(view).collect()
    }

    /// Whether the sample differs, over a row of a window within its own.
    fn row(&self, window: Window, y: i64) -> &[bool] {
        let start = (y - self.window.y0) as usize * self.window.width() + (window.x0 - self.window.x0) as usize;
        &self.differs[start..start + window.width()]
    }

    /// Compares what a sample sees with what the first one saw, which was asked at as many pixels or more.
    fn compare(&mut self, sample: usize, window: Window, [surfaces, depths]: [&[f32]; 2]) {
        if sample == 0 {
            self.all = window;
            self.first = [surfaces.to_vec(), depths.to_vec()];
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
}

impl<'p> Fills<'p> {
    /// Looks at what a stage has told, if it is a view that is asked.
    pub(super) fn look(&mut self, index: usize, sample: usize) {
        for view in self.views.iter_mut().filter(|view| view.fill == index) {
            let state = &self.fills[index];
            let planes = TELLING.map(|channel| &state.planes[0][channel as usize][..]);
            view.compare(sample, state.window, planes);
        }
    }

    /// Fills a stage where the current sample does not share with the first one, and leaves the first one's results
    /// elsewhere.
    pub(super) fn stage_apart(&mut self, index: usize, views: &[NodeId], offset: [f64; 2]) -> Result<(), NodeError> {
        let (window, held) = (self.fills[index].need, self.fills[index].window);
        let known = self.apart.iter().position(|apart| apart.window == window && apart.views == views);
        let apart = match known {
            Some(known) => self.apart.swap_remove(known),
            None => self.differing(views, window),
        };
        let state = &mut self.fills[index];
        let mut kept = std::mem::take(&mut state.kept);
        let mut own = std::mem::take(&mut state.planes);
        let mut machine = state.taps.take();
        let mut planes: Vec<&mut Vec<f32>> = own.iter_mut().flatten().filter(|plane| !plane.is_empty()).collect();
        for (plane, values) in planes.iter_mut().zip(&kept.values) {
            kept.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = *value);
        }
        kept.indices.clear();
        if window == held {
            kept.indices.extend_from_slice(&apart.indices);
        } else {
            let index = |[x, y]: &[i64; 2]| (y - held.y0) as usize * held.width() + (x - held.x0) as usize;
            kept.indices.extend(apart.pixels.iter().map(index));
        }
        kept.values.resize_with(planes.len(), Vec::new);
        for (plane, values) in planes.iter().zip(&mut kept.values) {
            values.clear();
            values.extend(kept.indices.iter().map(|index| plane[*index]));
        }
        let mut filled = Ok(());
        if !apart.indices.is_empty() {
            filled = self.fill_pixels(index, &apart, offset, machine.as_mut()).map(|found| {
                for (plane, values) in planes.iter_mut().zip(found) {
                    kept.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = value);
                }
            });
        }
        let state = &mut self.fills[index];
        (state.planes, state.kept, state.taps) = (own, kept, machine);
        self.apart.push(apart);
        filled
    }

    /// The pixels of a window at which some view sees something else than at the first sample.
    fn differing(&self, views: &[NodeId], window: Window) -> Apart {
        let asked: Vec<&View> = self.views.iter().filter(|view| views.contains(&view.node)).collect();
        let (mut indices, mut pixels) = (Vec::new(), Vec::new());
        for (y, first) in (window.y0..window.y1).zip((0..).step_by(window.width())) {
            let rows: Vec<&[bool]> = asked.iter().map(|view| view.row(window, y)).collect();
            for x in (0..window.width()).filter(|x| rows.iter().any(|row| row[*x])) {
                indices.push(first + x);
                pixels.push([window.x0 + x as i64, y]);
            }
        }
        Apart { views: views.to_vec(), window, indices, pixels }
    }

    /// The stage's planes at single pixels of its window.
    fn fill_pixels(
        &self,
        index: usize,
        apart: &Apart,
        offset: [f64; 2],
        machine: Option<&mut Runner<'p>>,
    ) -> Result<Vec<Vec<f32>>, NodeError> {
        let (state, before) = (&self.fills[index], &self.fills[..index]);
        let Some(ready) = self.ready.get(&state.fill.node) else { return Ok(Vec::new()) };
        let taps = self.tap_pixels(state, apart, before, machine);
        let count = apart.indices.len();
        let gather = |feed: &Feed| -> Option<Cow<'_, [f32]>> {
            Some(match feed {
                Feed::Nothing => return None,
                Feed::Constant(value) => vec![*value; count].into(),
                Feed::Tap(root, channel) => taps.get(&(*root, *channel))?.into(),
                Feed::Slot(slot) => self.gather(slot, apart, before).into(),
            })
        };
        let block = Block::scattered(&apart.pixels, offset);
        let held: Vec<(&'static str, Vec<Held<'_>>)> = state
            .fill
            .inputs
            .iter()
            .map(|(port, connections)| {
                (*port, connections.iter().map(|feeds| feeds.iter().map(gather).collect()).collect())
            })
            .collect();
        let ports: Vec<(&'static str, Vec<Connection<'_>>)> = held
            .iter()
            .map(|(port, connections)| {
                let connections = connections.iter().map(|held| Connection {
                    planes: held.iter().map(Option::as_deref).collect(),
                    window: block.window,
                    extent: block.window,
                });
                (*port, connections.collect())
            })
            .collect();
        let wanted = state.fill.wanted.iter().flatten().filter(|wanted| **wanted);
        let mut found = vec![vec![0.0; count]; wanted.count()];
        let mut targets = found.iter_mut();
        let outputs = state
            .fill
            .wanted
            .iter()
            .map(|channels| {
                let target = |wanted: &bool| wanted.then(|| targets.next().map(Vec::as_mut_slice)).flatten();
                channels.iter().map(target).collect()
            })
            .collect();
        let cancelled = || self.monitor.cancelled();
        if self.plan.settings.bounds {
            fill_with_bounds(&*ready.prepared, &block, &ports, &cancelled, outputs)?;
            return Ok(found);
        }
        let inputs = Inputs::new(&ports).with_cancellation(&cancelled);
        ready.prepared.fill(&block, &inputs, &mut Outputs::new(outputs))?;
        Ok(found)
    }

    /// A plane at single pixels.
    fn gather(&self, slot: &Slot, apart: &Apart, before: &[FillState<'_>]) -> Vec<f32> {
        let (plane, window) = (self.plane(slot, apart.window, before), apart.window);
        if plane.stride == window.width() {
            let samples = &plane.samples[plane.start..];
            return apart.indices.iter().map(|index| samples[*index]).collect();
        }
        let at = |[x, y]: &[i64; 2]| plane.start + (y - window.y0) as usize * plane.stride + (x - window.x0) as usize;
        apart.pixels.iter().map(|pixel| plane.samples[at(pixel)]).collect()
    }

    /// Runs the pointwise program before a stage at single pixels of its window.
    fn tap_pixels(
        &self,
        state: &FillState<'_>,
        apart: &Apart,
        before: &[FillState<'_>],
        machine: Option<&mut Runner<'p>>,
    ) -> Taps {
        let mut taps = Taps::new();
        if let (Some(machine), Some(compiled)) = (machine, &state.fill.taps) {
            let planes: Vec<Vec<f32>> = compiled.planes.iter().map(|slot| self.gather(slot, apart, before)).collect();
            let stride = apart.indices.len();
            let planes: Vec<Plane<'_>> = planes.iter().map(|samples| Plane { samples, start: 0, stride }).collect();
            machine.tile(&planes, stride, 1, &mut |root, channel, _, row| {
                taps.entry((root, channel)).or_default().extend_from_slice(row);
            });
        }
        taps
    }
}
