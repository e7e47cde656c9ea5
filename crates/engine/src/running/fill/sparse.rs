//! Takes further samples at single pixels: stages that need nothing beside a pixel's own place are filled at these alone.
//!
//! The planes of such stages hold one value for each of the pixels, in their order. Other stages, such as filters and what
//! they read, are filled over a window around the pixels as always, and read from there.

use super::Fills;
use super::masks::Masks;
use super::places::{Places, make_room};
use super::samples::Samples;
use super::shared::UnsharedPixels;
use crate::planning::plan::{Fill, Pass, Sample};
use crate::planning::schedule::{Reach, Reads, larger, read_before};
use crate::running::keep::PlaneKeeper;
use crate::running::prepare::node_error;
use crate::{EvalError, Plan};
use std::collections::HashSet;
use std::time::Instant;
use trochoid_graph::{Kind, NodeError, Slot, Variance};
use trochoid_image::{Channel, Window};
use trochoid_kernel::{CompiledProgram, Plane};
use trochoid_memory::Scratch;

/// Share of a window's pixels from which on a stage is filled over all of it.
const MOST: f64 = 0.6;

/// Farthest that pixels are listed around those whose samples are taken.
const FAR: usize = 16;

/// Planes at some pixels of the current tile.
pub(super) struct Sparse {
    fills: Vec<SparseFill>,
    pixels: Vec<[i64; 2]>,
    /// The smallest window around the pixels.
    window: Window,
    places: Places,
    masks: Masks,
    /// Number of pixels of the tile.
    area: usize,
}

struct SparseFill {
    /// Whether the stage and all that read it need nothing beside a pixel's own place.
    is_local: bool,
    /// Whether the stage itself does not.
    is_pixelwise: bool,
    /// How far from the pixels it is read, horizontally and vertically; `None` if that is far, or if what is not filled could
    /// count.
    margin: Option<Reach>,
    /// How far from the pixels most planes are read, if that is nearer, and those that are read farther.
    nearer: Option<(Reach, Vec<Vec<bool>>)>,
    /// Planes that local stages and programs read, by output and channel.
    is_read: Vec<Vec<bool>>,
    planes: Vec<Vec<Vec<f32>>>,
}

impl Sparse {
    /// Returns `None` if the pass takes all samples over whole tiles.
    pub(super) fn of(plan: &Plan<'_>, pass: &Pass) -> Option<Self> {
        let scattered = pass.scattered.as_ref()?;
        let is_pixelwise = |fill: &Fill| plan.stage(fill.node).is_some_and(|stage| stage.is_pixelwise());
        let mut is_local: Vec<bool> = Vec::new();
        for (index, fill) in pass.fills.iter().enumerate().rev() {
            let own = is_pixelwise(fill) && fill.variance == Variance::Pixel && !plan.bound[fill.node.0];
            let is_read = |other: usize| {
                let reader = &pass.fills[other];
                let decides = reader.shared.as_ref().is_some_and(|views| views.contains(&fill.node));
                // Whether samples share is decided by whole planes.
                decides || (reader.slots().any(|slot| fill.fills(slot)) && !is_local[pass.fills.len() - 1 - other])
            };
            let is_own = own && !(index + 1..pass.fills.len()).any(is_read);
            is_local.push(is_own);
        }
        is_local.reverse();
        let margins = margins(plan, pass);
        // Planes that local stages and programs read.
        let local = pass.fills.iter().zip(&is_local).filter(|(_, is_local)| **is_local);
        let programs = pass.gates.iter().flat_map(|gates| &gates.levels).chain([scattered]);
        let read: HashSet<&Slot> =
            local.flat_map(|(fill, _)| fill.slots()).chain(programs.flat_map(|program| &program.planes)).collect();
        let fills = pass.fills.iter().enumerate().map(|(index, fill)| {
            let is_read = |output: usize, channel: usize| read.contains(&Slot { node: fill.node, output, channel });
            let wanted = fill.wanted.iter().enumerate();
            SparseFill {
                is_local: is_local[index],
                is_pixelwise: is_pixelwise(fill),
                margin: None,
                nearer: None,
                is_read: wanted
                    .map(|(output, channels)| {
                        channels
                            .iter()
                            .enumerate()
                            .map(|(channel, wanted)| *wanted && is_read(output, channel))
                            .collect()
                    })
                    .collect(),
                planes: fill.wanted.iter().map(|channels| vec![Vec::new(); channels.len()]).collect(),
            }
        });
        let mut fills: Vec<SparseFill> = fills.collect();
        for ((sparse, fill), margins) in fills.iter_mut().zip(&pass.fills).zip(&margins) {
            sparse.list(plan, fill, margins);
        }
        Some(Self {
            fills,
            pixels: Vec::new(),
            window: Window::default(),
            places: Places::default(),
            masks: Masks::default(),
            area: 0,
        })
    }

    /// Returns the number of planes at single pixels.
    pub(super) fn planes(&self) -> u64 {
        self.fills.iter().flat_map(|fill| &fill.is_read).flatten().filter(|is_read| **is_read).count() as u64
    }

    /// Returns by fill how far from the pixels others are listed, if they are.
    pub(super) fn margins(&self) -> impl Iterator<Item = Option<Reach>> {
        self.fills.iter().map(|fill| fill.margin)
    }
}

/// Returns by fill, output and channel how far from a pixel its readers need it.
fn margins(plan: &Plan<'_>, pass: &Pass) -> Vec<Vec<Vec<Reach>>> {
    let format = plan.graph.format();
    let none = |fill: &Fill| fill.wanted.iter().map(|channels| vec![(0, 0); channels.len()]).collect();
    let mut margins: Vec<Vec<Vec<Reach>>> = pass.fills.iter().map(none).collect();
    for (index, fill) in pass.fills.iter().enumerate().rev() {
        let (stage, own) = (plan.stage(fill.node), farthest(&margins[index]));
        let reads = match pass.sharing {
            true => Reads::after_find(fill, stage, format, own),
            false => Reads::of(fill, stage, format, own),
        };
        let before = read_before(fill).map(|slot| (slot, reads.taps));
        for (slot, reach) in reads.planes.iter().copied().chain(before) {
            for (other, margins) in pass.fills.iter().zip(&mut margins).take(index) {
                if other.fills(&slot) {
                    let margin = &mut margins[slot.output][slot.channel];
                    *margin = larger(*margin, reach);
                }
            }
        }
    }
    margins
}

fn farthest(margins: &[Vec<Reach>]) -> Reach {
    margins.iter().flatten().copied().fold((0, 0), larger)
}

impl SparseFill {
    /// Decides which pixels of a stage are listed.
    fn list(&mut self, plan: &Plan<'_>, fill: &Fill, margins: &[Vec<Reach>]) {
        let margin = farthest(margins);
        // Weights that are not filled would not sum to 1.
        let is_legal = |kind: &Kind| matches!(kind, Kind::Color | Kind::Field(_) | Kind::View | Kind::Weights(2));
        let is_near = margin.0.max(margin.1) <= FAR && fill.variance == Variance::Pixel && !plan.bound[fill.node.0];
        if !is_near || !plan.graph.node(fill.node).kinds.iter().all(is_legal) {
            return;
        }
        self.margin = Some(margin);
        let planes = || fill.wanted.iter().flatten().zip(margins.iter().flatten()).filter(|(wanted, _)| **wanted);
        let others = planes().map(|(_, reach)| *reach).filter(|reach| *reach != margin).reduce(larger);
        if let Some(reach) = others.filter(|reach| self.is_pixelwise && *reach != margin) {
            let is_farther = |wanted: &bool, own: &Reach| *wanted && larger(*own, reach) != reach;
            let of = |(wanted, margins): (&Vec<bool>, &Vec<Reach>)| {
                wanted.iter().zip(margins).map(|(wanted, own)| is_farther(wanted, own)).collect()
            };
            self.nearer = Some((reach, fill.wanted.iter().zip(margins).map(of).collect()));
        }
    }
}

/// Some of the pixels, by index; all of them for `None`.
type Part<'a> = Option<&'a [usize]>;

impl<'p> Fills<'p> {
    /// Returns whether further samples may be taken at single pixels.
    pub(crate) fn is_sparse(&self) -> bool {
        // Planes that are kept are needed everywhere.
        self.sparse.is_some() && !self.keeper.is_some_and(PlaneKeeper::wants_any)
    }

    /// Counts samples that are not taken, for every stage.
    pub(crate) fn leave_out(&mut self, samples: usize) {
        self.left_out.iter_mut().for_each(|left_out| *left_out += samples as u64);
    }

    /// Fills every stage at some pixels of a tile, given the smallest window around them, for a sample after the first one, and
    /// adds the time of each stage to `seconds`.
    pub(crate) fn fill_at(
        &mut self,
        pixels: &[[i64; 2]],
        window: Window,
        tile: Window,
        sample: Sample,
        seconds: &mut [f64],
    ) -> Result<(), EvalError> {
        let Some(mut sparse) = self.sparse.take() else { return Ok(()) };
        sparse.area = tile.area();
        // Mostly those of the sample before.
        if sparse.pixels != pixels {
            sparse.pixels.clear();
            make_room(&mut sparse.pixels, sparse.area);
            sparse.pixels.extend_from_slice(pixels);
            sparse.window = window;
            sparse.places.forget();
            sparse.masks.used = 0;
        }
        self.place_windows(window, sample.index);
        self.begin(sample);
        let mut filled = Ok(());
        for index in 0..self.fills.len() {
            if self.fills[index].need.is_empty() {
                continue;
            }
            if self.monitor.cancelled() {
                filled = Err(EvalError::Cancelled);
                break;
            }
            let started = Instant::now();
            let id = self.fills[index].fill.node;
            let is_local = sparse.fills[index].is_local && self.known(index).is_none();
            let done = match is_local {
                true => self.fill_local(index, &mut sparse, sample),
                false => self.fill_around(index, &mut sparse, sample),
            };
            seconds[id.0] += started.elapsed().as_secs_f64();
            if let Err(error) = done {
                filled = Err(node_error(self.plan, id, error, self.monitor));
                break;
            }
        }
        self.sparse = Some(sparse);
        filled
    }

    /// Returns the planes that a program reads, at the pixels.
    pub(crate) fn planes_at(&self, program: &CompiledProgram) -> Scratch<Plane<'_>> {
        let Some(sparse) = &self.sparse else { return Scratch::new() };
        let plane = |slot: &Slot| Plane { samples: self.at(sparse, slot), start: 0, stride: sparse.pixels.len() };
        program.planes.iter().map(plane).collect()
    }

    /// Returns a plane at the pixels.
    fn at<'a>(&self, sparse: &'a Sparse, slot: &Slot) -> &'a [f32] {
        match self.by_slot.get(slot) {
            Some(index) => &sparse.fills[*index].planes[slot.output][slot.channel],
            None => unreachable!("a plane is filled before it is read"),
        }
    }

    /// Fills a stage around the pixels as far as others read it, and reads it there.
    fn fill_around(&mut self, index: usize, sparse: &mut Sparse, sample: Sample) -> Result<(), NodeError> {
        let state = &self.fills[index];
        let (window, offset) = (state.window, sample.offset);
        let SparseFill { margin, is_pixelwise, ref nearer, .. } = sparse.fills[index];
        if let (None, Some(views)) = (self.known(index), &state.fill.shared) {
            let only = margin.map(|margin| sparse.masks.near(&sparse.pixels, margin, state.need));
            let only = only.map(|mask| &sparse.masks.all[mask]);
            self.fill_unshared(index, views, offset, only)?;
        } else if let Some(open) = self.open_at(index, sparse) {
            let open: Scratch<[i64; 2]> = open.iter().map(|pixel| sparse.pixels[*pixel]).collect();
            self.fill_open_at(index, &open, is_pixelwise, sample)?;
        } else if let (None, Some(margin)) = (self.known(index), margin) {
            let masks = &mut sparse.masks;
            let far = masks.near(&sparse.pixels, margin, window);
            let near = nearer.as_ref().map_or(far, |(reach, _)| masks.near(&sparse.pixels, *reach, window));
            let (far, near) = (&masks.all[far], &masks.all[near]);
            if near.indices.len() as f64 > MOST * window.area() as f64 {
                self.fill_stage(index, sample)?;
            } else if is_pixelwise {
                let Fill { wanted, .. } = self.fills[index].fill;
                self.fill_listed(index, wanted, &near.pixels(), offset)?;
                if let Some((_, rest)) = nearer {
                    self.fill_listed(index, rest, &far.pixels_without(near), offset)?;
                }
            } else {
                self.fill_counted(index, &far.is_near, |fills| fills.fill_stage(index, sample))?;
            }
            self.compare_sample(index, sample.index);
        } else {
            self.fill_stage(index, sample)?;
            self.compare_sample(index, sample.index);
        }
        self.read_around(index, sparse);
        Ok(())
    }

    /// Fills a stage at those of the pixels where it shows.
    fn fill_open_at(
        &mut self,
        index: usize,
        open: &[[i64; 2]],
        is_pixelwise: bool,
        sample: Sample,
    ) -> Result<(), NodeError> {
        let none = Window::new(i64::MAX, i64::MAX, i64::MIN, i64::MIN);
        let bounds = open.iter().fold(none, |all, [x, y]| {
            Window::new(all.x0.min(*x), all.y0.min(*y), all.x1.max(x + 1), all.y1.max(y + 1))
        });
        if open.is_empty() {
            self.clear(index);
        } else if is_pixelwise {
            let window = self.fills[index].window;
            let place = |[x, y]: &[i64; 2]| (y - window.y0) as usize * window.width() + (x - window.x0) as usize;
            let pixels = UnsharedPixels::at(window, open.iter().map(place).collect());
            self.clear(index);
            let Fill { wanted, .. } = self.fills[index].fill;
            self.fill_listed(index, wanted, &pixels, sample.offset)?;
        } else {
            let is_part = bounds.area() as f64 <= MOST * self.tile.area() as f64;
            let window = if is_part { bounds } else { self.tile };
            let mut only = Scratch::of(false, window.area());
            for [x, y] in open {
                only[(y - window.y0) as usize * window.width() + (x - window.x0) as usize] = true;
            }
            self.fill_counted(index, &only, |fills| match is_part {
                true => fills.fill_within(index, bounds, sample),
                false => fills.fill_stage(index, sample),
            })?;
        }
        Ok(())
    }

    /// Fills a stage of which only some pixels count.
    fn fill_counted(
        &mut self,
        index: usize,
        only: &[bool],
        fill: impl FnOnce(&mut Self) -> Result<(), NodeError>,
    ) -> Result<(), NodeError> {
        self.fills[index].only.extend_from_slice(only);
        let filled = fill(self);
        self.fills[index].only.clear();
        filled
    }

    /// Fills some planes of a stage at some pixels of its window; others keep whatever they have.
    fn fill_listed(
        &mut self,
        index: usize,
        wanted: &[Vec<bool>],
        pixels: &UnsharedPixels,
        offset: [f64; 2],
    ) -> Result<(), NodeError> {
        let state = &mut self.fills[index];
        let (mut planes, mut machine) = (std::mem::take(&mut state.planes), state.taps.take());
        let filled = self.fill_channels(index, wanted, pixels, offset, machine.as_mut()).map(|found| {
            let area = self.fills[index].window.area();
            let planes = planes.iter_mut().flatten().zip(wanted.iter().flatten()).filter(|(_, wanted)| **wanted);
            for ((plane, _), values) in planes.zip(&found) {
                plane.resize(area, 0.0);
                pixels.indices.iter().zip(values).for_each(|(index, value)| plane[*index] = *value);
            }
        });
        let state = &mut self.fills[index];
        (state.planes, state.taps, state.columns) = (planes, machine, None);
        state.replaced.indices.clear();
        filled
    }

    /// Reads the planes of a stage that is filled over a window around the pixels.
    fn read_around(&self, index: usize, sparse: &mut Sparse) {
        let state = &self.fills[index];
        let kinds = &self.plan.graph.node(state.fill.node).kinds;
        // −0 counts as 0, except in fields.
        let is_bound = self.is_bound(state.fill.node);
        let Sparse { fills, pixels, window, places, area, .. } = sparse;
        let SparseFill { is_read, planes, .. } = &mut fills[index];
        for (output, (is_read, planes)) in is_read.iter().zip(planes).enumerate() {
            let normalizes = is_bound && !matches!(kinds[output], Kind::Field(_));
            for (channel, (_, plane)) in is_read.iter().zip(planes).enumerate().filter(|(_, (is_read, _))| **is_read) {
                let slot = Slot { node: state.fill.node, output, channel };
                let from = self.plane(&slot, *window, &self.fills);
                let samples = &from.samples[from.start..];
                plane.clear();
                make_room(plane, *area);
                plane.extend(
                    places.of(pixels, *window, from.stride, *area).iter().map(|place| samples[*place as usize]),
                );
                if normalizes {
                    plane.iter_mut().for_each(|value| *value += 0.0);
                }
            }
        }
    }

    /// Returns the pixels at which a stage shows, by index; `None` if it may show everywhere.
    fn open_at(&mut self, index: usize, sparse: &Sparse) -> Option<Scratch<usize>> {
        let state = &self.fills[index];
        let set = state.fill.gates?;
        if self.known(index).is_some() || state.window != self.tile || state.need != self.tile {
            return None;
        }
        let mut gated = self.gated.take()?;
        let row = Window::new(0, 0, sparse.pixels.len() as i64, 1);
        let level = gated.gates.sets[set].level;
        while gated.known < level {
            let program = &gated.gates.levels[gated.known];
            let plane = |slot: &Slot| Plane { samples: self.at(sparse, slot), start: 0, stride: row.width() };
            let planes: Scratch<Plane<'_>> = program.planes.iter().map(plane).collect();
            gated.look(&planes, row);
        }
        let open = gated.open_in(set, row);
        let open = open.iter().enumerate().filter_map(|(pixel, is_open)| is_open.then_some(pixel)).collect();
        self.gated = Some(gated);
        Some(open)
    }

    /// Fills a stage at the pixels.
    fn fill_local(&mut self, index: usize, sparse: &mut Sparse, sample: Sample) -> Result<(), NodeError> {
        let mut planes = std::mem::take(&mut sparse.fills[index].planes);
        let count = sparse.pixels.len();
        let open: Option<Scratch<usize>> = match &self.fills[index].fill.shared {
            Some(views) => {
                // Where the sample shares, the first sample's results stay.
                let state = &self.fills[index];
                let (held, within) = (state.window, sparse.window);
                let first = (within.y0 - held.y0) as usize * held.width() + (within.x0 - held.x0) as usize;
                let places = sparse.places.of(&sparse.pixels, within, held.width(), sparse.area);
                for (plane, from) in planes.iter_mut().flatten().zip(state.planes.iter().flatten()) {
                    plane.clear();
                    if !from.is_empty() {
                        make_room(plane, sparse.area);
                        plane.extend(places.iter().map(|place| from[first..][*place as usize]));
                    }
                }
                let views = self.views.iter().filter(|view| views.contains(&view.node));
                let views: Scratch<_> = views.collect();
                let differs = |pixel: &[i64; 2]| views.iter().any(|view| view.differs_at(*pixel));
                Some((0..count).filter(|index| differs(&sparse.pixels[*index])).collect())
            }
            None => self.open_at(index, sparse),
        };
        let is_shared = self.fills[index].fill.shared.is_some();
        let part: Part<'_> = open.as_deref().map(|open| &open[..]).filter(|open| open.len() < count);
        self.left_out[index] += (count - part.map_or(count, <[usize]>::len)) as u64;
        let fill = self.fills[index].fill;
        let kinds = &self.plan.graph.node(fill.node).kinds;
        for ((kind, planes), wanted) in kinds.iter().zip(&mut planes).zip(&fill.wanted) {
            for (channel, (plane, wanted)) in planes.iter_mut().zip(wanted).enumerate() {
                if *wanted && !is_shared {
                    make_room(plane, sparse.area);
                }
                if part.is_some() && !is_shared {
                    // As where nothing of it shows.
                    plane.clear();
                    plane.resize(if *wanted { count } else { 0 }, nothing(*kind, channel));
                } else {
                    plane.resize(if *wanted { count } else { 0 }, 0.0);
                }
            }
        }
        let mut machine = self.fills[index].taps.take();
        let wanted = fill.wanted.iter().flatten();
        let own = planes.iter_mut().flatten().zip(wanted).filter_map(|(plane, wanted)| wanted.then_some(plane));
        let offset = sample.offset;
        let filled = match part {
            None => {
                let read = |slot: &Slot| Samples::InPlace(self.at(sparse, slot));
                let targets = own.map(|plane| plane.as_mut_slice());
                self.fill_pixels_into(index, &fill.wanted, &sparse.pixels, offset, machine.as_mut(), targets, &read)
            }
            Some([]) => Ok(()),
            Some(part) => {
                let read = |slot: &Slot| {
                    let samples = self.at(sparse, slot);
                    Samples::Copied(part.iter().map(|pixel| samples[*pixel]).collect())
                };
                let pixels: Scratch<[i64; 2]> = part.iter().map(|pixel| sparse.pixels[*pixel]).collect();
                let mut own: Scratch<&mut Vec<f32>> = own.collect();
                let mut found: Scratch<Scratch<f32>> = own.iter().map(|_| Scratch::of(0.0, part.len())).collect();
                let targets = found.iter_mut().map(|values| values.as_mut_slice());
                let filled =
                    self.fill_pixels_into(index, &fill.wanted, &pixels, offset, machine.as_mut(), targets, &read);
                for (plane, values) in own.iter_mut().zip(&found) {
                    part.iter().zip(values).for_each(|(pixel, value)| plane[*pixel] = *value);
                }
                filled
            }
        };
        self.fills[index].taps = machine;
        sparse.fills[index].planes = planes;
        filled
    }
}

/// What a channel has where nothing of a stage shows, or for a view where no surface is seen.
pub(super) fn nothing(kind: Kind, channel: usize) -> f32 {
    if kind == Kind::View { Channel::ALL[channel].background() } else { 0.0 }
}
