//! Estimates how much memory a thread takes for its tile.

use super::fill::{bytes_beside_planes, with_room};
use super::run::programs;
use super::steps::{Steps, Whole};
use super::tile::channel_count;
use super::tile_size::Load;
use crate::Plan;
use crate::planning::plan::{Feed, Fill, Pass};
use std::collections::{HashMap, HashSet};
use trochoid_graph::{MemoryUse, NodeId, Slot, Variance};
use trochoid_image::Window;
use trochoid_kernel::{Chunk, CompiledProgram};

/// Bytes that a thread takes for tiles of any size.
const THREAD: u64 = 128 << 10;

/// Estimate of the memory that a thread takes for a tile, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct TileMemory {
    /// Planes of stages, what they read, and what one of them needs meanwhile: less if planes are held over the whole picture.
    pub(super) filling: u64,
    /// All the rest.
    pub(super) rest: u64,
    /// Width and height of the tile.
    pub(super) tile: [usize; 2],
}

impl Plan<'_> {
    /// Returns the bytes that one thread needs for a tile of a pass: every stage's planes over the window that its
    /// readers need, sums of samples, the first sample's surface and depth for each view, the temporary data of the
    /// stage that needs most, what the fills keep beside their planes, and the data that nodes hold per thread.
    pub(super) fn tile_memory(
        &self,
        pass: &Pass,
        uses: &HashMap<NodeId, MemoryUse>,
        step: Option<(&Steps, usize)>,
    ) -> TileMemory {
        let own = self.tile_before(pass, step);
        // Adaptive sampling looks at the pixels beside it, too.
        let tile = if self.graph.format().adaptive().is_some() { own.map(|size| size + 2) } else { own };
        let Windows { sizes, reads, passing, copied } = self.windows(pass, tile, step);
        let filled = pass.fills.iter().zip(&sizes).map(|(fill, [width, height])| {
            let rows = if fill.variance <= Variance::Column { 1.min(*height) } else { *height };
            with_room(samples(fill.planes(), [*width, rows]))
        });
        let views: HashSet<NodeId> = pass.fills.iter().flat_map(|fill| fill.shared.iter().flatten()).copied().collect();
        let filled = filled.chain([samples(3 * views.len(), tile), passing]).fold(0, u64::saturating_add);
        let used = || pass.fills.iter().zip(&reads).filter_map(|(fill, read)| Some((uses.get(&fill.node)?, *read)));
        let working = used().map(|(taken, read)| {
            let [pixel, most] = taken.thread;
            read.saturating_mul(pixel).min(most)
        });
        let found = used().map(|(taken, read)| read.saturating_mul(taken.found));
        let sums = if pass.offsets.len() > 1 { samples(channel_count(pass), tile) } else { 0 };
        let areas: Vec<u64> = sizes.iter().map(|size| samples(1, *size)).collect();
        let chunks = programs(pass).map(CompiledProgram::chunks).sum::<usize>() * size_of::<Chunk>();
        let filling = [
            filled.saturating_mul(size_of::<f32>() as u64),
            sums.saturating_mul(size_of::<f64>() as u64),
            working.max().unwrap_or_default(),
        ];
        let rest = found.chain([
            with_room(copied).saturating_mul(size_of::<f32>() as u64),
            bytes_beside_planes(self, pass, samples(1, tile), &areas),
            THREAD + chunks as u64,
        ]);
        let sum = |all: u64, bytes: u64| all.saturating_add(bytes);
        TileMemory { filling: filling.into_iter().fold(0, sum), rest: rest.fold(0, sum), tile: own }
    }

    /// Returns the largest size of a tile, as far as it is known before files are open.
    fn tile_before(&self, pass: &Pass, step: Option<(&Steps, usize)>) -> [usize; 2] {
        let reads = |fill: &Fill| self.stage(fill.node).is_some_and(|stage| !stage.files(&self.context).is_empty());
        let load = step.map_or_else(|| Load::of(self.halo()), |(steps, step)| steps.load(step));
        let (width, height) = self.tile_for(pass.fills.iter().any(reads).then_some(1), &load);
        [width.min(self.window.width()), height.min(self.window.height())]
    }

    /// Returns what the stages of a pass fill and read for a tile, without what lies beyond the picture.
    fn windows(&self, pass: &Pass, tile: [usize; 2], step: Option<(&Steps, usize)>) -> Windows {
        let takes_part = |fill: usize| step.is_none_or(|(steps, step)| steps.takes_part(fill, step));
        // Planes that the step fills for others, and those that another one filled for it.
        let fills = |planes: Whole| step.is_some_and(|(steps, step)| steps.is_filled_by(planes, step));
        let knows = |planes: Whole| step.is_some_and(|(steps, step)| steps.is_filled_before(planes, step));
        let is_last = step.is_none_or(|(_, step)| step == 0);
        let own = |(index, fill): (usize, &Fill)| {
            let is_asked = (fill.read && is_last) || fills(Whole::Fill(index));
            if is_asked && takes_part(index) { tile } else { [0, 0] }
        };
        let mut sizes: Vec<[usize; 2]> = pass.fills.iter().enumerate().map(own).collect();
        let (mut most, mut taps, mut tapped, mut kept) = (0, HashSet::new(), [0, 0], 0_u64);
        let mut reads = vec![0; pass.fills.len()];
        let mut parts: HashMap<Slot, Vec<[usize; 2]>> = HashMap::new();
        for (index, fill) in pass.fills.iter().enumerate().rev() {
            let Some(stage) = self.stage(fill.node) else { continue };
            let need = |sizes: &mut [[usize; 2]], node: NodeId, asked: [usize; 2]| {
                let readers = pass.fills[..index].iter().zip(sizes).filter(|(fill, _)| fill.node == node);
                readers.for_each(|(_, size)| *size = larger(*size, asked));
            };
            if let Some(program) = fill.taps.as_ref().filter(|_| fills(Whole::Taps(index))) {
                program.planes.iter().for_each(|slot| need(&mut sizes, slot.node, tile));
                kept = kept.saturating_add(samples(program.roots.iter().sum(), tile));
            }
            if !takes_part(index) {
                sizes[index] = [0, 0];
                continue;
            }
            let [width, height] = sizes[index];
            let own = Window::new(0, 0, width as i64, height as i64);
            let (mut passing, mut own_taps, mut around) = (0_u64, [0, 0], sizes[index]);
            for (port, connections) in &fill.inputs {
                let asked = stage.regions_of_interest(*port, own, self.graph.format());
                let asked = [asked.width().min(self.window.width()), asked.height().min(self.window.height())];
                around = larger(around, asked);
                for feed in connections.iter().flatten().filter(|feed| **feed != Feed::Nothing) {
                    passing = passing.saturating_add(samples(2, asked));
                    match feed {
                        Feed::Slot(slot) => {
                            need(&mut sizes, slot.node, asked);
                            parts.entry(*slot).or_default().push(asked);
                        }
                        Feed::Tap(..) if knows(Whole::Taps(index)) => {}
                        Feed::Tap(root, channel) => {
                            own_taps = larger(own_taps, asked);
                            if !fill.steady {
                                taps.insert((*root, *channel));
                                tapped = larger(tapped, asked);
                            }
                            let read = fill.taps.iter().flat_map(|taps| &taps.planes);
                            read.for_each(|slot| need(&mut sizes, slot.node, asked));
                        }
                        Feed::Nothing | Feed::Constant(_) => {}
                    }
                }
            }
            most = most.max(passing);
            reads[index] = samples(1, around);
            if let Some(program) = fill.taps.as_ref().filter(|_| fill.steady) {
                kept = kept.saturating_add(samples(program.roots.iter().sum(), own_taps));
            }
        }
        // A plane that only one stage reads is copied by that stage.
        let several = parts.into_values().filter(|parts| parts.len() > 1);
        let copied = several.flat_map(|parts| parts.into_iter().collect::<HashSet<_>>());
        let copied = copied.map(|part| samples(1, part)).fold(0, u64::saturating_add);
        let programs = samples(taps.len(), tapped).saturating_add(kept);
        let passing = most.saturating_add(with_room(programs));
        Windows { sizes, reads, passing, copied }
    }
}

/// What the stages of a pass fill and read for a tile.
struct Windows {
    /// Width and height that each fill has.
    sizes: Vec<[usize; 2]>,
    /// Number of pixels that each fill reads, at least those that it fills.
    reads: Vec<u64>,
    /// Most temporary samples: of any stage its inputs, of which it gets copies and makes about as much again, and the planes
    /// of the programs before stages, which share their memory unless samples share results.
    passing: u64,
    /// Samples of the parts of planes that several stages read.
    copied: u64,
}

/// Returns the larger of two sizes, along each axis.
fn larger(a: [usize; 2], b: [usize; 2]) -> [usize; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// Returns the number of samples in some planes.
pub(super) fn samples(planes: usize, [width, height]: [usize; 2]) -> u64 {
    (planes as u64).saturating_mul(width as u64).saturating_mul(height as u64)
}
