//! Stages that are filled only where they show.

use super::runner::Runner;
use super::shared::UnsharedPixels;
use super::{Chunk, Fills};
use crate::planning::gates::{Condition, Gates};
use crate::planning::plan::{Fill, Pass, Sample};
use crate::running::keep::PlaneKeeper;
use trochoid_graph::{NodeError, Rate};
use trochoid_image::Window;
use trochoid_kernel::Plane;

/// Share of a tile from which on a stage is filled everywhere: pixels by themselves cost more.
const MOST: f64 = 0.6;

/// Where stages show at the current sample.
pub(super) struct Gated<'p> {
    fills: &'p [Fill],
    gates: &'p Gates,
    machine: Runner<'p>,
    /// Planes of the program's roots.
    roots: Vec<Vec<f32>>,
    /// By set of conditions, the pixels of the tile at which all of them hold.
    open: Vec<UnsharedPixels>,
    /// Tile and sample of which this is known.
    known: Option<(Window, usize)>,
    /// Fills of which whole planes are kept, or which those read: what does not show now may show after an edit.
    kept: Vec<bool>,
}

impl<'p> Gated<'p> {
    pub(super) fn of(pass: &'p Pass, chunks: &mut &'p mut [Chunk]) -> Option<Self> {
        let gates = pass.gates.as_ref()?;
        Some(Self {
            fills: &pass.fills,
            gates,
            machine: Runner::new(&gates.program, false, chunks),
            roots: vec![Vec::new(); gates.program.roots.len()],
            open: Vec::new(),
            known: None,
            kept: vec![false; pass.fills.len()],
        })
    }

    /// Returns the same for evaluations that keep planes.
    pub(super) fn with_keeper(self, keeper: &PlaneKeeper) -> Self {
        let fills = self.fills;
        let mut kept: Vec<bool> = (0..fills.len()).map(|fill| keeper.wants(fill)).collect();
        for index in (0..fills.len()).rev() {
            if kept[index] {
                let (before, _) = fills.split_at(index);
                for (before, kept) in before.iter().zip(&mut kept) {
                    *kept |= fills[index].slots().any(|slot| before.fills(slot));
                }
            }
        }
        Self { kept, ..self }
    }

    /// Finds the pixels of a tile at which each set of conditions holds.
    fn look(&mut self, planes: &[Plane<'_>], tile: Window) {
        self.roots.iter_mut().for_each(Vec::clear);
        let roots = &mut self.roots;
        self.machine.tile(planes, tile.width(), tile.height(), &mut |root, _, _, row| {
            roots[root].extend_from_slice(row);
        });
        let holds = |condition: &Condition, index: usize| self.roots[condition.root][index] != condition.hides;
        self.open.clear();
        self.open.extend(self.gates.sets.iter().map(|set| {
            let open = (0..tile.area()).filter(|index| set.iter().all(|condition| holds(condition, *index)));
            UnsharedPixels::at(tile, open.collect())
        }));
    }
}

impl<'p> Fills<'p> {
    /// Fills a stage where it shows at the current sample, and 0 elsewhere, unless it shows in most places or is kept; returns
    /// whether it did.
    pub(super) fn fill_gated(&mut self, index: usize, sample: Sample) -> Result<bool, NodeError> {
        let state = &self.fills[index];
        let (Some(set), Some(stage)) = (state.fill.gates, state.stage) else { return Ok(false) };
        if self.known(index).is_some() || state.window != self.tile || state.need != self.tile {
            return Ok(false);
        }
        let is_scattered = stage.rate() != Rate::Sample;
        if self.gated.as_ref().is_some_and(|gated| gated.kept[index]) {
            return Ok(false);
        }
        let Some(mut gated) = self.gated.take() else { return Ok(false) };
        let now = Some((self.tile, sample.index));
        if gated.known != now {
            let planes = self.planes(&gated.gates.program);
            gated.look(&planes, self.tile);
            gated.known = now;
        }
        let open = &gated.open[set];
        let share = open.indices.len() as f64 / self.tile.area() as f64;
        let filled = if share > MOST || (share > 0.0 && !is_scattered) {
            Ok(false)
        } else {
            self.fill_open(index, open, sample.offset).map(|()| true)
        };
        self.gated = Some(gated);
        filled
    }

    /// Fills a stage at some pixels of the tile, and 0 elsewhere.
    fn fill_open(&mut self, index: usize, open: &UnsharedPixels, offset: [f64; 2]) -> Result<(), NodeError> {
        let state = &mut self.fills[index];
        let area = state.window.area();
        let (mut planes, mut machine) = (std::mem::take(&mut state.planes), state.taps.take());
        for (plane, wanted) in planes.iter_mut().flatten().zip(state.fill.wanted.iter().flatten()) {
            plane.clear();
            plane.resize(if *wanted { area } else { 0 }, 0.0);
        }
        let mut filled = Ok(());
        if !open.indices.is_empty() {
            filled = self.fill_pixels(index, open, offset, machine.as_mut()).map(|found| {
                let planes = planes.iter_mut().flatten().filter(|plane| !plane.is_empty());
                for (plane, values) in planes.zip(found) {
                    open.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = value);
                }
            });
        }
        let state = &mut self.fills[index];
        (state.planes, state.taps, state.columns, state.found) = (planes, machine, None, None);
        state.replaced.indices.clear();
        filled
    }
}
