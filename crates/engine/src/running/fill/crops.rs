//! Parts of planes that several stages read, copied once for a sample: rows of a plane that holds more than the part do not
//! follow one another.

use super::Fills;
use super::places::make_room;
use super::spare::Spare;
use crate::planning::plan::{Feed, Fill};
use std::collections::{HashMap, HashSet};
use trochoid_graph::Slot;
use trochoid_image::Window;

/// Copies of parts. They keep their memory from sample to sample.
#[derive(Default)]
pub(super) struct Crops {
    /// Planes that several stages read.
    shared: HashSet<Slot>,
    crops: Vec<Crop>,
    /// Number of those that hold parts of the current sample.
    used: usize,
}

struct Crop {
    slot: Slot,
    region: Window,
    samples: Vec<f32>,
}

impl Crops {
    pub(super) fn new(fills: &[Fill]) -> Self {
        let mut readers: HashMap<Slot, usize> = HashMap::new();
        for fill in fills {
            let feeds = fill.inputs.iter().flat_map(|(_, connections)| connections.iter().flatten());
            let slots: HashSet<Slot> = feeds.filter_map(slot_of).collect();
            slots.into_iter().for_each(|slot| *readers.entry(slot).or_default() += 1);
        }
        let shared = readers.into_iter().filter(|(_, count)| *count > 1).map(|(slot, _)| slot).collect();
        Self { shared, crops: Vec::new(), used: 0 }
    }

    /// Begins with another sample or tile.
    pub(super) fn begin(&mut self) {
        self.used = 0;
    }

    /// Returns a part of a plane, if it was copied.
    pub(super) fn get(&self, slot: &Slot, region: Window) -> Option<&[f32]> {
        let found = self.crops[..self.used].iter().find(|crop| crop.slot == *slot && crop.region == region);
        found.map(|crop| &crop.samples[..])
    }

    /// Returns the memory for a part, which may come from `spare`.
    fn add(&mut self, slot: Slot, region: Window, spare: Option<&mut Spare>) -> &mut Vec<f32> {
        if self.used == self.crops.len() {
            self.crops.push(Crop { slot, region, samples: Vec::new() });
        }
        let crop = &mut self.crops[self.used];
        self.used += 1;
        (crop.slot, crop.region) = (slot, region);
        if crop.samples.capacity() < region.area()
            && let Some(memory) = spare.and_then(|spare| spare.take(region.area()))
        {
            crop.samples = memory;
        }
        crop.samples.clear();
        make_room(&mut crop.samples, region.area());
        &mut crop.samples
    }

    /// Gives up the memory of the parts of a plane.
    pub(super) fn give_up(&mut self, slot: &Slot) -> impl Iterator<Item = Vec<f32>> {
        let parts = self.crops[..self.used].iter_mut().filter(move |crop| crop.slot == *slot);
        parts.map(|crop| {
            crop.region = Window::default();
            std::mem::take(&mut crop.samples)
        })
    }
}

impl Fills<'_> {
    /// Copies the parts of planes that a stage and others read.
    pub(super) fn crop(&mut self, index: usize) {
        // Taken out, so that planes can be read meanwhile.
        let (mut crops, mut spare) = (std::mem::take(&mut self.crops), self.spare.take());
        let state = &self.fills[index];
        for ((_, connections), images) in state.fill.inputs.iter().zip(&state.images) {
            for (feeds, image) in connections.iter().zip(images) {
                let (region, width) = (image.region, image.region.width());
                if self.window_of(index, feeds, region) != region {
                    continue;
                }
                for slot in feeds.iter().filter_map(slot_of) {
                    if !crops.shared.contains(&slot) {
                        continue;
                    }
                    let plane = self.plane(&slot, region, &self.fills[..index]);
                    let is_contiguous = plane.stride == width || region.height() == 1;
                    if !is_contiguous && crops.get(&slot, region).is_none() {
                        let samples = crops.add(slot, region, spare.as_mut());
                        (0..region.height()).for_each(|y| samples.extend_from_slice(plane.row(y, width)));
                    }
                }
            }
        }
        (self.crops, self.spare) = (crops, spare);
    }

    /// Returns the window over which a stage reads a connection: its region of interest, or whole rows around it that need
    /// no copy.
    pub(super) fn window_of(&self, index: usize, feeds: &[Feed], region: Window) -> Window {
        let state = &self.fills[index];
        let takes_rows = state.stage.is_some_and(|stage| stage.takes_whole_rows());
        if !takes_rows || region == state.own_window(state.window) || self.plan.settings.bounds() {
            return region;
        }
        let picture = self.plan.graph.format().window();
        let mut rows = None;
        for feed in feeds {
            let within = match feed {
                Feed::Nothing => continue,
                Feed::Constant(_) => return region,
                Feed::Tap(..) if self.known_taps(index).is_some() => picture,
                Feed::Tap(..) => state.tap_window,
                Feed::Slot(slot) => match self.by_slot.get(slot) {
                    Some(read) if self.known(*read).is_some() => picture,
                    Some(read) if !self.is_bound(slot.node) && !self.fills[*read].one_row => self.fills[*read].window,
                    _ => return region,
                },
            };
            let columns = (within.x0, within.x1);
            if rows.replace(columns).is_some_and(|before| before != columns) {
                return region;
            }
        }
        rows.map_or(region, |(x0, x1)| Window { x0, x1, ..region })
    }
}

fn slot_of(feed: &Feed) -> Option<Slot> {
    if let Feed::Slot(slot) = feed { Some(*slot) } else { None }
}
