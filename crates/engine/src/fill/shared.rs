//! Stages whose results the samples of a pixel share: of all but the first sample, only what differs is filled.

use super::{FillState, Fills};
use crate::kernel::{Machine, Plane};
use crate::plan::{Feed, Fill};
use crate::shading::TELLING;
use std::collections::HashMap;
use trochoid_graph::{Block, Connection, Inputs, NodeError, NodeId, Outputs, Slot, ViewChannel};
use trochoid_image::{Shading, Window};

/// What a view tells of the samples of the current tile.
pub(super) struct View {
    node: NodeId,
    /// The fill that holds what it tells.
    fill: usize,
    window: Window,
    /// Of the first sample: surface and depth.
    first: [Vec<f32>; 2],
    /// Whether the current sample sees something else there.
    differs: Vec<bool>,
}

/// Results of the first sample, by plane, at the pixels where those of another stand in their place.
#[derive(Default)]
pub(super) struct Kept {
    /// As indices into the planes.
    pub(super) pixels: Vec<usize>,
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
            Some(Self { node, fill, window: Window::default(), first: Default::default(), differs: Vec::new() })
        };
        nodes.into_iter().filter_map(view).collect()
    }

    /// Compares what a sample sees with what the first one saw.
    fn compare(&mut self, sample: usize, window: Window, [surfaces, depths]: [&[f32]; 2]) {
        if sample == 0 {
            self.window = window;
            self.first = [surfaces.to_vec(), depths.to_vec()];
            return;
        }
        let first = self.first[0].iter().zip(&self.first[1]);
        self.differs.clear();
        self.differs.extend(first.zip(surfaces.iter().zip(depths)).map(|(first, sample)| {
            let pair = |(surface, depth): (&f32, &f32)| (f64::from(*surface), f64::from(*depth));
            !Shading::is_shared(pair(first), pair(sample))
        }));
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
        let mut kept = std::mem::take(&mut self.fills[index].kept);
        let mut own = std::mem::take(&mut self.fills[index].planes);
        let mut planes: Vec<&mut Vec<f32>> = own.iter_mut().flatten().filter(|plane| !plane.is_empty()).collect();
        for (plane, values) in planes.iter_mut().zip(&kept.values) {
            kept.pixels.iter().zip(values).for_each(|(pixel, value)| plane[*pixel] = *value);
        }
        self.differing(views, self.fills[index].window, &mut kept.pixels);
        kept.values.resize_with(planes.len(), Vec::new);
        for (plane, values) in planes.iter().zip(&mut kept.values) {
            values.clear();
            values.extend(kept.pixels.iter().map(|pixel| plane[*pixel]));
        }
        let mut filled = Ok(());
        if !kept.pixels.is_empty() {
            let mut machine = self.fills[index].taps.take();
            let found = self.fill_pixels(index, &kept.pixels, offset, machine.as_mut());
            self.fills[index].taps = machine;
            filled = found.map(|found| {
                for (plane, values) in planes.iter_mut().zip(found) {
                    kept.pixels.iter().zip(values).for_each(|(pixel, value)| plane[*pixel] = value);
                }
            });
        }
        let state = &mut self.fills[index];
        (state.planes, state.kept) = (own, kept);
        filled
    }

    /// The pixels of a window, by index, at which some view sees something else than at the first sample.
    fn differing(&self, views: &[NodeId], window: Window, pixels: &mut Vec<usize>) {
        pixels.clear();
        let width = window.width();
        let views: Vec<&View> = self.views.iter().filter(|view| views.contains(&view.node)).collect();
        for y in window.y0..window.y1 {
            let row = |view: &&View| {
                let start = (y - view.window.y0) as usize * view.window.width() + (window.x0 - view.window.x0) as usize;
                start..start + width
            };
            let first = (y - window.y0) as usize * width;
            match views[..] {
                [view] => {
                    let row = &view.differs[row(&view)];
                    pixels.extend(row.iter().enumerate().filter(|(_, differs)| **differs).map(|(x, _)| first + x));
                }
                _ => pixels.extend(
                    (0..width)
                        .filter(|x| views.iter().any(|view| view.differs[row(view).start + x]))
                        .map(|x| first + x),
                ),
            }
        }
    }

    /// The stage's planes at single pixels of its window.
    fn fill_pixels(
        &self,
        index: usize,
        pixels: &[usize],
        offset: [f64; 2],
        machine: Option<&mut Machine<'p>>,
    ) -> Result<Vec<Vec<f32>>, NodeError> {
        let (state, before) = (&self.fills[index], &self.fills[..index]);
        let Some(ready) = self.ready.get(&state.fill.node) else { return Ok(Vec::new()) };
        let taps = self.tap_pixels(state, pixels, before, machine);
        let gather = |feed: &Feed| -> Option<Vec<f32>> {
            Some(match feed {
                Feed::Nothing => return None,
                Feed::Constant(value) => vec![*value; pixels.len()],
                Feed::Tap(root, channel) => taps.get(&(*root, *channel))?.clone(),
                Feed::Slot(slot) => self.gather(slot, state.window, pixels, before),
            })
        };
        let held: Vec<Vec<Vec<Option<Vec<f32>>>>> = state
            .fill
            .inputs
            .iter()
            .map(|(_, connections)| connections.iter().map(|feeds| feeds.iter().map(gather).collect()).collect())
            .collect();
        let places: Vec<[i64; 2]> = pixels
            .iter()
            .map(|pixel| {
                let (x, y) = (pixel % state.window.width(), pixel / state.window.width());
                [state.window.x0 + x as i64, state.window.y0 + y as i64]
            })
            .collect();
        let block = Block::scattered(&places, offset);
        let ports: Vec<(&'static str, Vec<Connection<'_>>)> = state
            .fill
            .inputs
            .iter()
            .zip(&held)
            .map(|((port, _), held)| {
                let connections = held.iter().map(|held| Connection {
                    planes: held.iter().map(Option::as_deref).collect(),
                    window: block.window,
                    extent: block.window,
                });
                (*port, connections.collect())
            })
            .collect();
        let wanted = || state.fill.wanted.iter().flatten();
        let mut found = vec![vec![0.0; pixels.len()]; wanted().filter(|wanted| **wanted).count()];
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
        let inputs = Inputs::new(&ports).with_cancellation(&cancelled);
        ready.prepared.fill(&block, &inputs, &mut Outputs::new(outputs))?;
        Ok(found)
    }

    /// A plane at single pixels of a window.
    fn gather(&self, slot: &Slot, window: Window, pixels: &[usize], before: &[FillState<'_>]) -> Vec<f32> {
        let (plane, width) = (self.plane(slot, window, before), window.width());
        pixels.iter().map(|pixel| plane.samples[plane.start + pixel / width * plane.stride + pixel % width]).collect()
    }

    /// Runs the pointwise program before a stage at single pixels of its window.
    fn tap_pixels(
        &self,
        state: &FillState<'_>,
        pixels: &[usize],
        before: &[FillState<'_>],
        machine: Option<&mut Machine<'p>>,
    ) -> super::Taps {
        let mut taps = super::Taps::new();
        if let (Some(machine), Some(compiled)) = (machine, &state.fill.taps) {
            let planes: Vec<Vec<f32>> =
                compiled.planes.iter().map(|slot| self.gather(slot, state.window, pixels, before)).collect();
            let stride = pixels.len();
            let planes: Vec<Plane<'_>> = planes.iter().map(|samples| Plane { samples, start: 0, stride }).collect();
            machine.tile(&planes, stride, 1, &mut |root, channel, _, row| {
                taps.entry((root, channel)).or_default().extend_from_slice(row);
            });
        }
        taps
    }
}
