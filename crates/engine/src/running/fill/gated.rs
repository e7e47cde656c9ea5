//! Stages that are filled only where they show.

use super::extent::clamped;
use super::runner::Runner;
use super::shared::UnsharedPixels;
use super::{Chunk, FillState, Fills};
use crate::planning::gates::{Condition, GateSet, Gates};
use crate::planning::plan::{Feed, Fill, Pass, Sample};
use crate::running::keep::PlaneKeeper;
use crate::running::steps::Whole;
use trochoid_graph::{NodeError, Rate};
use trochoid_image::{Format, Window};
use trochoid_kernel::Plane;

/// Share of a tile from which on a stage is filled everywhere: pixels by themselves cost more.
const MOST: f64 = 0.6;

/// Where stages show at the current sample.
pub(super) struct Gated<'p> {
    fills: &'p [Fill],
    gates: &'p Gates,
    machines: Vec<Runner<'p>>,
    /// Planes of the programs' roots, by level.
    roots: Vec<Vec<Vec<f32>>>,
    /// Number of levels that have run.
    known: usize,
    /// By set of conditions, where in the tile all of them hold, as far as this was asked.
    open: Vec<Option<Open>>,
    /// Fills of which whole planes are kept, or which those read: what does not show now may show after an edit.
    kept: Vec<bool>,
}

/// Pixels at which something shows, and the smallest window around them.
#[derive(Default)]
struct Open {
    pixels: UnsharedPixels,
    bounds: Window,
}

impl<'p> Gated<'p> {
    pub(super) fn of(pass: &'p Pass, chunks: &mut &'p mut [Chunk]) -> Option<Self> {
        let gates = pass.gates.as_ref()?;
        Some(Self {
            fills: &pass.fills,
            gates,
            machines: gates.levels.iter().map(|level| Runner::new(level, false, chunks)).collect(),
            roots: gates.levels.iter().map(|level| vec![Vec::new(); level.roots.len()]).collect(),
            known: 0,
            open: gates.sets.iter().map(|_| None).collect(),
            kept: vec![false; pass.fills.len()],
        })
    }

    /// Begins with another sample or tile.
    pub(super) fn begin(&mut self) {
        self.known = 0;
        self.open.iter_mut().for_each(|open| *open = None);
    }

    /// Returns the same for evaluations that keep planes.
    pub(super) fn with_keeper(self, keeper: &PlaneKeeper) -> Self {
        let fills = self.fills;
        let mut kept: Vec<bool> = (0..fills.len()).map(|fill| keeper.wants(Whole::Fill(fill))).collect();
        for index in (0..fills.len()).rev() {
            if kept[index] || keeper.wants(Whole::Taps(index)) {
                let (before, _) = fills.split_at(index);
                for (before, kept) in before.iter().zip(&mut kept) {
                    *kept |= fills[index].slots().any(|slot| before.fills(slot));
                }
            }
        }
        Self { kept, ..self }
    }

    /// Runs the next level over a tile.
    fn look(&mut self, planes: &[Plane<'_>], tile: Window) {
        let roots = &mut self.roots[self.known];
        roots.iter_mut().for_each(Vec::clear);
        self.machines[self.known].tile(planes, tile.width(), tile.height(), &mut |root, _, _, row| {
            roots[root].extend_from_slice(row);
        });
        self.known += 1;
    }
}

impl Open {
    /// Finds the pixels of a tile at which all conditions hold.
    fn find(set: &[Condition], roots: &[Vec<Vec<f32>>], tile: Window) -> Self {
        let width = tile.width();
        let mut found = Self::default();
        found.pixels.begin(tile);
        let mut row = vec![true; width];
        for (y, start) in (tile.y0..tile.y1).zip((0..).step_by(width)) {
            row.fill(true);
            for condition in set {
                for (open, value) in row.iter_mut().zip(&roots[condition.level][condition.root][start..]) {
                    *open &= *value != condition.hides;
                }
            }
            let Some(first) = row.iter().position(|open| *open) else { continue };
            let last = row.iter().rposition(|open| *open).unwrap_or(first);
            let (x0, x1) = (tile.x0 + first as i64, tile.x0 + last as i64 + 1);
            found.bounds = found.bounds.union(Window::new(x0, y, x1, y + 1));
            for x in (first..=last).filter(|x| row[*x]) {
                found.pixels.push(start + x, [tile.x0 + x as i64, y]);
            }
        }
        found
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
        let GateSet { level, conditions } = &gated.gates.sets[set];
        while gated.known < *level {
            let planes = self.planes(&gated.gates.levels[gated.known]);
            gated.look(&planes, self.tile);
        }
        let roots = &gated.roots;
        let open = gated.open[set].get_or_insert_with(|| Open::find(conditions, roots, self.tile));
        let share = |pixels: usize| pixels as f64 / self.tile.area() as f64;
        let (count, around) = (open.pixels.indices.len(), open.bounds.area());
        let filled = if share(count) <= if is_scattered { MOST } else { 0.0 } {
            self.fill_open(index, &open.pixels, sample.offset).map(|()| Some(count))
        } else if share(around) <= MOST {
            self.fill_within(index, open.bounds, sample).map(|()| Some(around))
        } else {
            Ok(None)
        };
        let filled = filled.map(|filled| {
            let count = filled.unwrap_or(self.tile.area());
            self.left_out[index] += (self.tile.area() - count) as u64;
            filled.is_some()
        });
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

    /// Fills a stage within a window of the tile, and 0 elsewhere.
    fn fill_within(&mut self, index: usize, within: Window, sample: Sample) -> Result<(), NodeError> {
        let tile = self.tile;
        let state = &mut self.fills[index];
        let (mut planes, mut machine) = (std::mem::take(&mut state.planes), state.taps.take());
        let mut part: Vec<Vec<Vec<f32>>> =
            state.fill.wanted.iter().map(|channels| vec![Vec::new(); channels.len()]).collect();
        let (images, tap_window) = (state.images.clone(), state.tap_window);
        state.narrow(within, self.plan.graph.format());
        let mut tapped = std::mem::take(&mut self.tapped);
        let filled = self.fill_into(index, sample, &mut part, machine.as_mut(), &mut tapped).map(|_| ());
        self.tapped = tapped;
        let wanted = self.fills[index].fill.wanted.iter().flatten();
        for ((plane, part), wanted) in planes.iter_mut().flatten().zip(part.iter().flatten()).zip(wanted) {
            plane.clear();
            plane.resize(if *wanted { tile.area() } else { 0 }, 0.0);
            if *wanted && filled.is_ok() {
                for (y, row) in (within.y0..).zip(part.chunks_exact(within.width())) {
                    let start = (y - tile.y0) as usize * tile.width() + (within.x0 - tile.x0) as usize;
                    plane[start..start + row.len()].copy_from_slice(row);
                }
            }
        }
        let state = &mut self.fills[index];
        (state.planes, state.taps, state.columns, state.found) = (planes, machine, None, None);
        (state.window, state.images, state.tap_window) = (tile, images, tap_window);
        state.replaced.indices.clear();
        filled
    }
}

impl FillState<'_> {
    /// Makes the windows of a stage those that it has for a part of the tile.
    fn narrow(&mut self, to: Window, format: Format) {
        self.window = to;
        let Some(stage) = self.stage else { return };
        let mut taps = Window::default();
        for ((port, connections), images) in self.fill.inputs.iter().zip(&mut self.images) {
            let asked = stage.regions_of_interest(*port, to, format);
            for (feeds, image) in connections.iter().zip(images) {
                image.region = clamped(asked, image.extent);
                if feeds.iter().any(|feed| matches!(feed, Feed::Tap(..))) {
                    taps = taps.union(image.region);
                }
            }
        }
        self.tap_window = taps;
    }
}
