//! Stages that are filled only where they show.

use super::extent::clamped;
use super::places::make_room;
use super::shared::UnsharedPixels;
use super::sparse::nothing;
use super::state::Image;
use super::{Chunk, FillState, Fills};
use crate::planning::gates::{Condition, GateSet, Gates};
use crate::planning::plan::{Feed, Fill, Pass, Sample};
use crate::running::keep::PlaneKeeper;
use crate::running::steps::Whole;
use fearless_simd::{Level, Simd, dispatch};
use trochoid_graph::NodeError;
use trochoid_image::{Format, Window};
use trochoid_kernel::{Machine, Plane};
use trochoid_memory::Scratch;

/// Share of a tile from which on a stage is filled everywhere: pixels by themselves cost more.
pub(super) const MOST: f64 = 0.6;

/// Where stages show at the current sample.
pub(super) struct Gated<'p> {
    fills: &'p [Fill],
    pub(super) gates: &'p Gates,
    machines: Vec<Machine<'p>>,
    /// Planes of the programs' roots, by level.
    roots: Vec<Vec<Vec<f32>>>,
    /// Number of levels that have run.
    pub(super) known: usize,
    /// By set of conditions, where in the tile all of them hold, as far as this was asked.
    open: Vec<Open>,
    /// Fills of which whole planes are kept, or which those read: what does not show now may show after an edit.
    kept: Vec<bool>,
}

/// Where in a tile something shows. It keeps its memory from sample to sample.
#[derive(Default)]
struct Open {
    is_known: bool,
    /// By pixel, whether something shows there.
    is_open: Vec<bool>,
    count: usize,
    /// The smallest window around these pixels.
    bounds: Window,
    /// The pixels, listed when a stage is filled at them alone.
    pixels: UnsharedPixels,
    is_listed: bool,
}

impl<'p> Gated<'p> {
    pub(super) fn of(pass: &'p Pass, chunks: &mut &'p mut [Chunk]) -> Option<Self> {
        let gates = pass.gates.as_ref()?;
        Some(Self {
            fills: &pass.fills,
            gates,
            machines: gates.levels.iter().map(|level| Machine::new(level, chunks)).collect(),
            roots: gates.levels.iter().map(|level| vec![Vec::new(); level.roots.len()]).collect(),
            known: 0,
            open: gates.sets.iter().map(|_| Open::default()).collect(),
            kept: vec![false; pass.fills.len()],
        })
    }

    /// Begins with another sample or tile.
    pub(super) fn begin(&mut self) {
        self.known = 0;
        self.open.iter_mut().for_each(|open| open.is_known = false);
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

    /// Returns where in a tile all conditions of a set hold.
    pub(super) fn open_in(&mut self, set: usize, tile: Window) -> &[bool] {
        let open = &mut self.open[set];
        if !open.is_known {
            open.find(&self.gates.sets[set].conditions, &self.roots, tile);
        }
        &open.is_open
    }

    /// Runs the next level over a tile.
    pub(super) fn look(&mut self, planes: &[Plane<'_>], tile: Window) {
        let mut roots: Scratch<&mut [f32]> = (self.roots[self.known].iter_mut())
            .map(|plane| {
                make_room(plane, tile.area());
                plane.resize(tile.area(), 0.0);
                &mut plane[..]
            })
            .collect();
        self.machines[self.known].fill(planes, tile.width(), tile.height(), &mut roots);
        self.known += 1;
    }
}

impl Open {
    /// Finds the pixels of a tile at which all conditions hold.
    fn find(&mut self, set: &[Condition], roots: &[Vec<Vec<f32>>], tile: Window) {
        let Self { is_open, .. } = self;
        is_open.clear();
        is_open.resize(tile.area(), true);
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for condition in set {
                for (open, value) in is_open.iter_mut().zip(&roots[condition.level][condition.root]) {
                    *open &= *value != condition.hides;
                }
            }
        }));
        (self.count, self.bounds) = (0, Window::default());
        // Columns from the first open one to behind the last one.
        let [mut from, mut to] = [tile.width(), 0];
        for (y, row) in (tile.y0..).zip(is_open.chunks_exact(tile.width())) {
            let count = row.iter().map(|open| u32::from(*open)).sum::<u32>();
            if count > 0 {
                self.count += count as usize;
                from = row[..from].iter().position(|open| *open).unwrap_or(from);
                to += row[to..].iter().rposition(|open| *open).map_or(0, |last| last + 1);
                let y0 = if self.bounds.is_empty() { y } else { self.bounds.y0 };
                self.bounds = Window::new(tile.x0 + from as i64, y0, tile.x0 + to as i64, y + 1);
            }
        }
        (self.is_known, self.is_listed) = (true, false);
    }

    /// Lists the pixels.
    fn pixels(&mut self, tile: Window) -> &UnsharedPixels {
        let Self { is_open, bounds, pixels, is_listed, .. } = self;
        if !std::mem::replace(is_listed, true) {
            pixels.begin(tile);
            for y in bounds.y0..bounds.y1 {
                let start = (y - tile.y0) as usize * tile.width();
                let row = &is_open[start..start + tile.width()];
                let mut x = (bounds.x0 - tile.x0) as usize;
                // Open pixels mostly follow one another.
                for run in row[x..(bounds.x1 - tile.x0) as usize].chunk_by(|a, b| a == b) {
                    if run[0] {
                        pixels.extend(start + x, [tile.x0 + x as i64, y], run.len());
                    }
                    x += run.len();
                }
            }
        }
        pixels
    }
}

impl<'p> Fills<'p> {
    /// Fills a stage where it shows at the current sample, and nothing elsewhere, unless it shows in most places or is kept;
    /// returns whether it did.
    pub(super) fn fill_gated(&mut self, index: usize, sample: Sample) -> Result<bool, NodeError> {
        let state = &self.fills[index];
        let (Some(set), Some(stage)) = (state.fill.gates, state.stage) else { return Ok(false) };
        if self.known(index).is_some() || state.window != self.tile || state.need != self.tile {
            return Ok(false);
        }
        let is_scattered = stage.is_pixelwise();
        if self.gated.as_ref().is_some_and(|gated| gated.kept[index]) {
            return Ok(false);
        }
        let Some(mut gated) = self.gated.take() else { return Ok(false) };
        let GateSet { level, conditions } = &gated.gates.sets[set];
        while gated.known < *level {
            let planes = self.planes(&gated.gates.levels[gated.known]);
            gated.look(&planes, self.tile);
        }
        let open = &mut gated.open[set];
        if !open.is_known {
            open.find(conditions, &gated.roots, self.tile);
        }
        let share = |pixels: usize| pixels as f64 / self.tile.area() as f64;
        let (count, around) = (open.count, open.bounds.area());
        let filled = if share(count) <= if is_scattered { MOST } else { 0.0 } {
            self.fill_open(index, open.pixels(self.tile), sample.offset).map(|()| Some(count))
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

    /// Fills a stage at some pixels of the tile, and nothing elsewhere.
    fn fill_open(&mut self, index: usize, open: &UnsharedPixels, offset: [f64; 2]) -> Result<(), NodeError> {
        self.clear(index);
        let state = &mut self.fills[index];
        let (mut planes, mut machine) = (std::mem::take(&mut state.planes), state.taps.take());
        let mut filled = Ok(());
        if !open.indices.is_empty() {
            filled = self.fill_pixels(index, open, offset, machine.as_mut()).map(|found| {
                let planes = planes.iter_mut().flatten().filter(|plane| !plane.is_empty());
                for (plane, values) in planes.zip(&found) {
                    open.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = *value);
                }
            });
        }
        let state = &mut self.fills[index];
        (state.planes, state.taps, state.columns, state.found) = (planes, machine, None, None);
        state.replaced.indices.clear();
        filled
    }

    /// Makes the planes of a stage those of a place where nothing of it shows: 0, or for a view what it has where no surface
    /// is seen, since other stages may read it there.
    pub(super) fn clear(&mut self, index: usize) {
        self.lend(index, self.fills[index].window.area());
        let state = &mut self.fills[index];
        let area = state.window.area();
        let kinds = &self.plan.graph.node(state.fill.node).kinds;
        for ((kind, planes), wanted) in kinds.iter().zip(&mut state.planes).zip(&state.fill.wanted) {
            for (channel, (plane, wanted)) in planes.iter_mut().zip(wanted).enumerate() {
                plane.clear();
                plane.resize(if *wanted { area } else { 0 }, nothing(*kind, channel));
            }
        }
    }

    /// Fills a stage within a window of the tile, and nothing elsewhere.
    pub(super) fn fill_within(&mut self, index: usize, within: Window, sample: Sample) -> Result<(), NodeError> {
        let tile = self.tile;
        self.clear(index);
        let state = &mut self.fills[index];
        let (mut planes, mut machine) = (std::mem::take(&mut state.planes), state.taps.take());
        let mut part = std::mem::take(&mut state.part);
        let images: Scratch<Image> = state.images.iter().flatten().copied().collect();
        let tap_window = state.tap_window;
        state.narrow(within, self.plan.graph.format());
        let mut tapped = std::mem::take(&mut self.tapped);
        let filled = self.fill_into(index, sample, &mut part, machine.as_mut(), &mut tapped).map(|_| ());
        self.tapped = tapped;
        let wanted = self.fills[index].fill.wanted.iter().flatten();
        for ((plane, part), wanted) in planes.iter_mut().flatten().zip(part.iter().flatten()).zip(wanted) {
            if *wanted && filled.is_ok() {
                for (y, row) in (within.y0..).zip(part.chunks_exact(within.width())) {
                    let start = (y - tile.y0) as usize * tile.width() + (within.x0 - tile.x0) as usize;
                    plane[start..start + row.len()].copy_from_slice(row);
                }
            }
        }
        let state = &mut self.fills[index];
        (state.planes, state.taps, state.columns, state.found) = (planes, machine, None, None);
        (state.part, state.window, state.tap_window) = (part, tile, tap_window);
        state.images.iter_mut().flatten().zip(&images).for_each(|(image, whole)| *image = *whole);
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
