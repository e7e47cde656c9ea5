//! Memory of planes that no later stage reads, for the stages that follow: a tile with one sample for each pixel needs few
//! planes at a time.

use super::Fills;
use crate::planning::plan::Pass;
use crate::running::keep::PlaneKeeper;
use std::collections::HashMap;
use trochoid_graph::{Slot, Variance};

/// Memory of planes, and when it is free.
pub(super) struct Spare {
    /// By fill, those whose planes nothing reads after it, and the planes that no other stage reads after it.
    done: Vec<(Vec<usize>, Vec<Slot>)>,
    planes: Vec<Vec<f32>>,
}

impl Spare {
    /// Returns no memory yet; `None` if several samples read the same planes.
    pub(super) fn of(pass: &Pass, by_slot: &HashMap<Slot, usize>, keeper: &PlaneKeeper) -> Option<Self> {
        if pass.offsets.len() > 1 {
            return None;
        }
        let fills = &pass.fills;
        // Programs that decide where stages show run before the first of these, whichever that is.
        let gates = pass.gates.iter().flat_map(|gates| &gates.levels).flat_map(|level| &level.planes);
        let mut stays = vec![false; fills.len()];
        gates.filter_map(|slot| by_slot.get(slot)).for_each(|fill| stays[*fill] = true);
        let mut last: Vec<usize> = (0..fills.len()).collect();
        let mut last_of: HashMap<Slot, usize> = HashMap::new();
        for (index, fill) in fills.iter().enumerate() {
            // The pass's program reads it in the last step; a single row stays for the tiles below.
            stays[index] |= (fill.read && keeper.is_last_step()) || fill.variance <= Variance::Column;
            for slot in fill.slots() {
                last_of.insert(*slot, index);
                by_slot.get(slot).into_iter().for_each(|read| last[*read] = index);
            }
        }
        let mut done = vec![(Vec::new(), Vec::new()); fills.len()];
        for (fill, last) in last.into_iter().enumerate().filter(|(fill, _)| !stays[*fill]) {
            done[last].0.push(fill);
        }
        last_of.into_iter().for_each(|(slot, last)| done[last].1.push(slot));
        Some(Self { done, planes: Vec::new() })
    }

    /// Returns the smallest plane with room for some samples, if there is any.
    pub(super) fn take(&mut self, samples: usize) -> Option<Vec<f32>> {
        let planes = self.planes.iter().enumerate().filter(|(_, plane)| plane.capacity() >= samples);
        let (smallest, _) = planes.min_by_key(|(_, plane)| plane.capacity())?;
        Some(self.planes.swap_remove(smallest))
    }
}

impl Fills<'_> {
    /// Gives spare memory to the planes of a fill, whose windows have `samples` samples.
    pub(super) fn lend(&mut self, index: usize, samples: usize) {
        let Some(spare) = &mut self.spare else { return };
        let state = &mut self.fills[index];
        for (plane, wanted) in state.planes.iter_mut().flatten().zip(state.fill.wanted.iter().flatten()) {
            if *wanted
                && plane.capacity() < samples
                && let Some(memory) = spare.take(samples)
            {
                *plane = memory;
            }
        }
    }

    /// Takes the memory of planes, and of parts of planes, that nothing reads after a fill.
    pub(super) fn give_back(&mut self, index: usize) {
        let Some(spare) = &mut self.spare else { return };
        let Spare { done, planes } = spare;
        let (fills, slots) = &done[index];
        for done in fills {
            let free = self.fills[*done].planes.iter_mut().flatten();
            planes.extend(free.filter(|plane| plane.capacity() > 0).map(std::mem::take));
        }
        for slot in slots {
            planes.extend(self.crops.give_up(slot).filter(|part| part.capacity() > 0));
        }
    }
}
