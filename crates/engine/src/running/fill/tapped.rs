//! Planes of the pointwise program before a stage.

use super::places::make_room;
use super::runner::Runner;
use super::samples::Samples;
use super::shared::UnsharedPixels;
use super::{FillState, Fills};
use crate::running::steps::Whole;
use trochoid_graph::Slot;
use trochoid_image::Window;
use trochoid_kernel::{CompiledProgram, Plane};
use trochoid_memory::Scratch;

/// Planes of a program's roots, of which there are few.
#[derive(Default)]
pub(super) struct Taps(Scratch<((usize, usize), Scratch<f32>)>);

impl Taps {
    /// Returns the plane of a channel of a root.
    pub(super) fn get(&self, root: usize, channel: usize) -> Option<&[f32]> {
        self.0.iter().find(|(of, _)| *of == (root, channel)).map(|(_, plane)| &plane[..])
    }

    /// Returns the same, to change it; empty at first.
    pub(super) fn of(&mut self, root: usize, channel: usize) -> &mut Vec<f32> {
        let index = self.0.iter().position(|(of, _)| *of == (root, channel)).unwrap_or_else(|| {
            self.0.push(((root, channel), Scratch::new()));
            self.0.len() - 1
        });
        &mut self.0[index].1
    }

    /// Returns the planes of all channels of a program's roots, in order, with room for some samples; others are emptied.
    fn targets(&mut self, roots: &[usize], samples: usize) -> Scratch<&mut [f32]> {
        let channels =
            || roots.iter().enumerate().flat_map(|(root, count)| (0..*count).map(move |channel| (root, channel)));
        channels().for_each(|(root, channel)| _ = self.of(root, channel));
        self.0.sort_unstable_by_key(|(of, _)| *of);
        let is_own = |(root, channel): (usize, usize)| roots.get(root).is_some_and(|count| channel < *count);
        let planes = self.0.iter_mut().filter_map(|(of, plane)| {
            if !is_own(*of) {
                plane.clear();
                return None;
            }
            make_room(plane, samples);
            plane.resize(samples, 0.0);
            Some(&mut plane[..])
        });
        planes.collect()
    }

    /// Returns all of them.
    fn planes(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        self.0.iter_mut().map(|(_, plane)| &mut **plane)
    }
}

/// Results of a program over a window, and what is needed to update them for another sample.
#[derive(Default)]
pub(super) struct Tapped {
    pub(super) planes: Taps,
    window: Window,
    /// What the first sample read from stages that do not tell where samples differ.
    first: Scratch<(Slot, Scratch<f32>)>,
    /// Pixels of the window that do not hold the first sample's results.
    changed: Scratch<usize>,
}

impl Tapped {
    /// Leaves out the pixels outside of a window within the current one.
    fn crop(&mut self, to: Window) {
        let (from, width) = (self.window, to.width());
        if from == to {
            return;
        }
        let start = (to.y0 - from.y0) as usize * from.width() + (to.x0 - from.x0) as usize;
        for plane in self.planes.planes().chain(self.first.iter_mut().map(|(_, plane)| &mut **plane)) {
            for y in 0..to.height() {
                let at = start + y * from.width();
                plane.copy_within(at..at + width, y * width);
            }
            plane.truncate(to.area());
        }
        self.window = to;
    }
}

impl<'p> Fills<'p> {
    /// Runs the program before a stage over the current tile, for a step that holds its results over the whole picture.
    pub(super) fn hold_taps(&mut self, index: usize, sample: usize) {
        let Some(keeper) = self.keeper else { return };
        let state = &mut self.fills[index];
        let Some(compiled) = &state.fill.taps else { return };
        let tapped_of = if state.fill.steady { &mut state.tapped } else { &mut self.tapped };
        let (mut tapped, mut machine) = (std::mem::take(tapped_of), state.taps.take());
        self.run_taps(&self.fills[index], &self.fills[..index], sample, machine.as_mut(), &mut tapped);
        let roots = compiled.roots.iter().enumerate();
        let planes = roots.flat_map(|(root, channels)| (0..*channels).map(move |channel| (root, channel)));
        let planes = planes.filter_map(|(root, channel)| tapped.planes.get(root, channel));
        let picture = self.plan.graph.format().window();
        keeper.take(Whole::Taps(index), sample, self.tile, self.fills[index].tap_window, picture, planes);
        let state = &mut self.fills[index];
        state.taps = machine;
        *(if state.fill.steady { &mut state.tapped } else { &mut self.tapped }) = tapped;
    }

    /// Runs the pointwise program before a stage, and stores the planes of its roots.
    pub(super) fn run_taps(
        &self,
        state: &FillState<'_>,
        before: &[FillState<'_>],
        sample: usize,
        machine: Option<&mut Runner<'p>>,
        tapped: &mut Tapped,
    ) {
        let (Some(machine), Some(compiled)) = (machine, &state.fill.taps) else { return };
        let window = state.tap_window;
        let updates = state.fill.steady && !self.plan.settings.bounds();
        if sample > 0 && updates && tapped.window.intersect(window) == window {
            tapped.crop(window);
            self.update_taps(state, before, compiled, machine, tapped);
            return;
        }
        let planes: Scratch<Plane<'_>> = compiled.planes.iter().map(|slot| self.plane(slot, window, before)).collect();
        let (width, height) = (window.width(), window.height());
        match machine {
            Runner::Machine(machine) => {
                let mut targets = tapped.planes.targets(&compiled.roots, window.area());
                machine.fill(&planes, width, height, &mut targets);
            }
            Runner::Trace(trace) => {
                tapped.planes.planes().for_each(Vec::clear);
                trace.tile(&planes, width, height, &mut |root, channel, _, row| {
                    tapped.planes.of(root, channel).extend_from_slice(row);
                });
            }
        }
        tapped.changed.clear();
        tapped.first.clear();
        // Only the first sample's results can be updated.
        tapped.window = if sample == 0 { window } else { Window::default() };
        if sample == 0 && updates {
            let read = compiled.planes.iter().zip(&planes).filter(|(slot, _)| !self.tells_changes(slot, before));
            let rows =
                |plane: &Plane<'_>| (0..window.height()).flat_map(|y| plane.row(y, window.width())).copied().collect();
            tapped.first.extend(read.map(|(slot, plane)| (*slot, rows(plane))));
        }
    }

    /// Returns whether it is known where a plane differs from that of the first sample.
    fn tells_changes(&self, slot: &Slot, before: &[FillState<'_>]) -> bool {
        let fill = self.by_slot.get(slot).and_then(|&index| Some((index, before.get(index)?)));
        fill.is_none_or(|(index, state)| state.fill.shared.is_some() && self.known(index).is_none())
    }

    /// Updates the planes of the first sample, or one after it, for the current one.
    fn update_taps(
        &self,
        state: &FillState<'_>,
        before: &[FillState<'_>],
        compiled: &CompiledProgram,
        machine: &mut Runner<'p>,
        tapped: &mut Tapped,
    ) {
        let window = tapped.window;
        let width = window.width();
        let mut differs = Scratch::of(false, window.area());
        for state in compiled.planes.iter().filter_map(|slot| before.get(*self.by_slot.get(slot)?)) {
            let held = state.window;
            for index in &state.replaced.indices {
                let (x, y) = (held.x0 + (index % held.width()) as i64, held.y0 + (index / held.width()) as i64);
                if window.contains(x, y) {
                    differs[(y - window.y0) as usize * width + (x - window.x0) as usize] = true;
                }
            }
        }
        for (slot, first) in &tapped.first {
            let plane = self.plane(slot, window, before);
            for (y, (first, differs)) in first.chunks(width).zip(differs.chunks_mut(width)).enumerate() {
                let row = first.iter().zip(plane.row(y, width)).zip(differs);
                row.for_each(|((first, now), differs)| *differs |= first.to_bits() != now.to_bits());
            }
        }
        let changed: Scratch<usize> = (0..differs.len()).filter(|index| differs[*index]).collect();
        // Where only the sample before differed, the first sample's results come back.
        tapped.changed.iter().for_each(|index| differs[*index] = true);
        tapped.changed = changed;
        let indices: Scratch<usize> = (0..differs.len()).filter(|index| differs[*index]).collect();
        if indices.is_empty() {
            return;
        }
        let pixels = UnsharedPixels::at(window, indices);
        let read = |slot: &Slot| Samples::Copied(self.gather(slot, &pixels, before));
        for ((root, channel), values) in &Self::tap_pixels(state, pixels.indices.len(), Some(machine), &read).0 {
            let plane = tapped.planes.of(*root, *channel);
            pixels.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = *value);
        }
    }
}
