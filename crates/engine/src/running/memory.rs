//! Estimates how much memory a plan takes before any of it is allocated.

use super::tile::channel_count;
use super::tile_size::Load;
use crate::planning::plan::{Feed, Fill, Pass};
use crate::{EvalError, Plan};
use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use trochoid_graph::{MemoryContext, MemoryUse, NodeId, Stage, Variance, in_bytes};
use trochoid_image::Window;

/// Most consumers that a message names.
const NAMED: usize = 4;

/// Something that takes memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryConsumer {
    /// Data that a node prepared.
    Node(NodeId),
    /// Pictures of the outputs, if they are not handed on row by row.
    Pictures,
    /// Copies of passes of the caller whose samples do not lie one after another.
    Passes,
    /// Buffers needed while one picture is written to its file.
    Writing,
    /// Tiles that threads work on.
    Tiles,
    /// Most memory that one node needs while it prepares.
    Preparing(NodeId),
}

/// Destination of the pictures of the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pictures {
    /// Kept in memory, as by [`Plan::evaluate`].
    Whole,
    /// Kept in memory, and then written to files one after the other.
    Files,
    /// Handed on row by row, as by [`Plan::evaluate_to`].
    Rows,
}

/// Additional bytes per sample while its picture is converted, encoded and compressed, as a whole or by rows.
const ENCODED: u64 = 9;
const ENCODED_ROWS: u64 = 5;

/// Most rows that files take at once.
const ROWS: usize = 32;

/// Estimate of the memory that a plan takes at its frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MemoryAccount {
    /// Everything that takes memory, the largest first: the consumer, its bytes, and what to do if that is too much.
    pub consumers: Vec<(MemoryConsumer, u64, &'static str)>,
    /// Nodes whose memory is shared, and counted by another node.
    shared: Vec<NodeId>,
    /// Number of threads that work on tiles at once.
    workers: usize,
}

impl MemoryAccount {
    /// Returns the sum of all consumers, in bytes.
    pub fn total(&self) -> u64 {
        self.consumers.iter().fold(0, |sum, (_, bytes, _)| sum.saturating_add(*bytes))
    }

    /// Returns the number of threads that work on tiles at once: the number in the settings, or fewer if memory is
    /// short.
    pub fn workers(&self) -> usize {
        self.workers
    }

    /// Returns the bytes that nodes hold.
    pub(crate) fn held(&self) -> u64 {
        let nodes = self.consumers.iter().filter(|(consumer, ..)| matches!(consumer, MemoryConsumer::Node(_)));
        nodes.fold(0, |sum, (_, bytes, _)| sum.saturating_add(*bytes))
    }

    /// Returns the bytes of the tiles that threads work on.
    pub(crate) fn tiles(&self) -> u64 {
        let tiles = self.consumers.iter().find(|(consumer, ..)| *consumer == MemoryConsumer::Tiles);
        tiles.map_or(0, |(_, bytes, _)| *bytes)
    }

    /// Raises a node's share to the bytes that it really holds, if that is more.
    pub(crate) fn raise_to(&mut self, id: NodeId, bytes: u64) {
        if self.shared.contains(&id) {
            return;
        }
        match self.consumers.iter_mut().find(|(consumer, ..)| *consumer == MemoryConsumer::Node(id)) {
            Some((_, held, _)) => *held = bytes.max(*held),
            None => {
                self.consumers.push((MemoryConsumer::Node(id), bytes, "lower the format's \"width\" and \"height\""));
            }
        }
    }

    /// Lets fewer threads work on tiles at once if all of them together exceed a limit: this is slower, but does not
    /// change the picture.
    pub(crate) fn shrink_to(&mut self, limit: u64) {
        let total = self.total();
        if let Some((_, tiles, _)) = self.consumers.iter_mut().find(|(consumer, ..)| *consumer == MemoryConsumer::Tiles)
        {
            let room = limit.saturating_sub(total - *tiles);
            let each = *tiles / self.workers as u64;
            self.workers = usize::try_from(room / each.max(1)).unwrap_or(usize::MAX).clamp(1, self.workers);
            *tiles = each * self.workers as u64;
        }
        self.consumers.retain(|(_, bytes, _)| *bytes > 0);
        self.consumers.sort_by_key(|(_, bytes, _)| std::cmp::Reverse(*bytes));
    }
}

impl Plan<'_> {
    /// Estimates how much memory the plan takes: the data that its nodes hold, the most that one of them needs while
    /// it prepares, tiles, and the pictures, if they stay in memory. Reads only headers of files.
    pub fn memory(&self, pictures: Pictures) -> MemoryAccount {
        self.account(pictures, &HashMap::new())
    }

    /// Does the same as [`Plan::memory`], given the bytes of nodes that are already prepared.
    pub(crate) fn account(&self, pictures: Pictures, known: &HashMap<NodeId, u64>) -> MemoryAccount {
        let mut uses: HashMap<NodeId, MemoryUse> = HashMap::new();
        let mut account = MemoryAccount { consumers: Vec::new(), shared: Vec::new(), workers: 1 };
        let consumers = &mut account.consumers;
        let mut preparing = None;
        let mut shared = HashSet::new();
        for (id, wanted) in &self.prepares {
            let Some(stage) = self.stage(*id) else { continue };
            let of = |id: NodeId| uses.get(&id).copied().unwrap_or_default();
            let mut taken =
                stage.memory(&MemoryContext::new(&self.context, wanted, &of).with_purpose(self.settings.purpose));
            if let Some(bytes) = known.get(id) {
                (taken.held, taken.working) = (*bytes, 0);
            }
            if taken.remedy.is_empty() {
                taken.remedy = "lower the format's \"width\" and \"height\"";
            }
            if taken.shared.is_none_or(|key| shared.insert(key)) {
                consumers.push((MemoryConsumer::Node(*id), taken.held, taken.remedy));
            } else {
                account.shared.push(*id);
            }
            if preparing.is_none_or(|(_, bytes, _)| taken.working > bytes) {
                preparing = Some((MemoryConsumer::Preparing(*id), taken.working, taken.remedy));
            }
            uses.insert(*id, taken);
        }
        consumers.extend(preparing);
        let channels = || self.outputs.iter().map(|output| output.kind.channels());
        if pictures != Pictures::Rows {
            let size = [self.window.width(), self.window.height()];
            let bytes = samples(channels().sum(), size).saturating_mul(size_of::<f32>() as u64);
            let remedy = "write only EXR, whose rows are not kept in memory, lower the format's \"width\" and \
                          \"height\", or render fewer outputs at once";
            consumers.push((MemoryConsumer::Pictures, bytes, remedy));
            if pictures == Pictures::Files {
                // Those of PNG: EXR is written band by band.
                let bytes = samples(channels().max().unwrap_or(0).min(4), size).saturating_mul(ENCODED);
                consumers.push((MemoryConsumer::Writing, bytes, remedy));
            }
        }
        let remedy = "hand over passes whose samples lie one after another, or make a smaller picture";
        consumers.push((MemoryConsumer::Passes, self.settings.copies, remedy));
        let tiles = self.passes.iter().map(|pass| self.scratch(pass, &uses)).fold(0, u64::saturating_add);
        // A band that is handed on is as wide as the picture.
        let band = match pictures {
            Pictures::Rows => {
                let rows = self.passes.iter().map(|pass| self.tile_before(pass)[1]).max().unwrap_or(0);
                let rows = rows.next_multiple_of(ROWS).min(self.window.height());
                samples(channels().sum(), [self.window.width(), rows])
            }
            Pictures::Whole | Pictures::Files => 0,
        };
        let tiles = tiles.saturating_add(band.saturating_mul(size_of::<f32>() as u64 + ENCODED_ROWS));
        // Tiles that are narrower than the picture are computed beside their band.
        let tile =
            self.passes.iter().map(|pass| self.tile_before(pass)).filter(|[width, _]| *width < self.window.width());
        let beside = tile.map(|tile| samples(channels().sum(), tile)).max().unwrap_or(0);
        let tiles = tiles.saturating_add(beside.saturating_mul(size_of::<f32>() as u64));
        let remedy = "lower the format's \"width\", or reduce the reach of filters";
        account.workers = self.threads();
        account.consumers.push((MemoryConsumer::Tiles, tiles.saturating_mul(account.workers as u64), remedy));
        account.shrink_to(self.settings.memory_limit);
        account
    }

    /// Refuses a frame that takes more memory than the settings allow; an evaluation does this before it prepares
    /// anything.
    ///
    /// # Errors
    /// [`EvalError::TooMuchMemory`], with the largest consumers.
    pub fn check_memory(&self, account: &MemoryAccount) -> Result<(), EvalError> {
        let limit = self.settings.memory_limit;
        if account.total() <= limit {
            return Ok(());
        }
        Err(EvalError::TooMuchMemory {
            place: Box::new(match account.consumers.first() {
                Some((MemoryConsumer::Node(id) | MemoryConsumer::Preparing(id), ..)) => self.graph.place_of(*id, None),
                _ => self.graph.place_of_format(),
            }),
            found: self.named(account),
            total: account.total(),
            limit,
            remedy: account.consumers.first().map_or("", |(_, _, remedy)| remedy),
        })
    }

    /// Names the largest consumers, for a message.
    fn named(&self, account: &MemoryAccount) -> String {
        let mut text = String::new();
        for (consumer, bytes, _) in account.consumers.iter().take(NAMED) {
            let name = |id: &NodeId| {
                let node = self.graph.node(*id);
                format!("\"{}\" ({})", node.name, node.ty.declaration().name)
            };
            let what = match consumer {
                MemoryConsumer::Node(id) => name(id),
                MemoryConsumer::Pictures => "pictures".into(),
                MemoryConsumer::Passes => "copies of passes".into(),
                MemoryConsumer::Writing => "writing pictures".into(),
                MemoryConsumer::Tiles if account.workers == 1 => "tiles of one thread".into(),
                MemoryConsumer::Tiles => format!("tiles of {} threads", account.workers),
                MemoryConsumer::Preparing(id) => format!("preparing {}", name(id)),
            };
            let comma = if text.is_empty() { "" } else { ", " };
            let _ = write!(text, "{comma}{what} {}", in_bytes(*bytes));
        }
        let rest = account.consumers.iter().skip(NAMED);
        let (count, bytes) = rest.fold((0, 0), |(count, sum), (_, bytes, _)| (count + 1, sum + bytes));
        if count > 0 {
            let _ = write!(text, ", {count} more {}", in_bytes(bytes));
        }
        text
    }

    /// Returns the number of threads that the settings request.
    pub(crate) fn threads(&self) -> usize {
        if self.settings.threads == 0 { rayon::current_num_threads() } else { self.settings.threads }
    }

    /// Returns the bytes that one thread needs for a tile of a pass: every stage's planes over the window that its
    /// readers need, sums of samples, the first sample's surface and depth for each view, the temporary data of the
    /// stage that needs most, and the data that nodes hold per thread.
    fn scratch(&self, pass: &Pass, uses: &HashMap<NodeId, MemoryUse>) -> u64 {
        let tile = self.tile_before(pass);
        let (sizes, passing) = self.sizes(pass, tile);
        let of_thread = pass.fills.iter().zip(&sizes).map(|(fill, size)| {
            let [pixel, most] = uses.get(&fill.node).copied().unwrap_or_default().thread;
            samples(1, *size).saturating_mul(pixel).min(most)
        });
        let of_thread = of_thread.max().unwrap_or_default();
        let planes = pass.fills.iter().zip(sizes).map(|(fill, [width, height])| {
            let channels = fill.wanted.iter().flatten().filter(|wanted| **wanted).count();
            let rows = if fill.variance <= Variance::Column { height.min(1) } else { height };
            samples(channels, [width, rows])
        });
        let views: HashSet<NodeId> = pass.fills.iter().flat_map(|fill| fill.shared.iter().flatten()).copied().collect();
        let held = planes.sum::<u64>() + samples(3 * views.len(), tile) + passing;
        let sums = if pass.offsets.len() > 1 { samples(channel_count(pass), tile) } else { 0 };
        let sums = sums.saturating_mul(size_of::<f64>() as u64).saturating_add(of_thread);
        held.saturating_mul(size_of::<f32>() as u64).saturating_add(sums)
    }

    /// Returns the largest size of a tile, as far as it is known before files are open.
    fn tile_before(&self, pass: &Pass) -> [usize; 2] {
        let reads = |fill: &Fill| self.stage(fill.node).is_some_and(|stage| !stage.files(&self.context).is_empty());
        let (width, height) = self.tile_for(pass.fills.iter().any(reads).then_some(1), &Load::of(self.halo()));
        [width.min(self.window.width()), height.min(self.window.height())]
    }

    /// Returns the width and height that each stage of a pass fills for a tile, without what lies beyond the picture,
    /// and the largest number of temporary samples: of any stage its inputs, of which it gets copies and makes about as
    /// much again, and the planes of the programs before stages, which share their memory unless samples share results.
    fn sizes(&self, pass: &Pass, tile: [usize; 2]) -> (Vec<[usize; 2]>, u64) {
        let mut sizes: Vec<[usize; 2]> = pass.fills.iter().map(|fill| if fill.read { tile } else { [0, 0] }).collect();
        let (mut most, mut taps, mut tapped, mut kept) = (0, HashSet::new(), [0, 0], 0_u64);
        for (index, fill) in pass.fills.iter().enumerate().rev() {
            let Some(stage) = self.stage(fill.node) else { continue };
            let [width, height] = sizes[index];
            let own = Window::new(0, 0, width as i64, height as i64);
            let (mut passing, mut own_taps) = (0_u64, [0, 0]);
            for (port, connections) in &fill.inputs {
                let asked = stage.regions_of_interest(*port, own, self.graph.format());
                let asked = [asked.width().min(self.window.width()), asked.height().min(self.window.height())];
                let mut need = |node: NodeId| {
                    let readers = pass.fills[..index].iter().zip(&mut sizes).filter(|(fill, _)| fill.node == node);
                    readers.for_each(|(_, size)| *size = larger(*size, asked));
                };
                for feed in connections.iter().flatten().filter(|feed| **feed != Feed::Nothing) {
                    passing = passing.saturating_add(samples(2, asked));
                    match feed {
                        Feed::Slot(slot) => need(slot.node),
                        Feed::Tap(root, channel) => {
                            own_taps = larger(own_taps, asked);
                            if !fill.steady {
                                taps.insert((*root, *channel));
                                tapped = larger(tapped, asked);
                            }
                            fill.taps.iter().flat_map(|taps| &taps.planes).for_each(|slot| need(slot.node));
                        }
                        Feed::Nothing | Feed::Constant(_) => {}
                    }
                }
            }
            most = most.max(passing);
            if let Some(program) = fill.taps.as_ref().filter(|_| fill.steady) {
                kept = kept.saturating_add(samples(program.roots.iter().sum(), own_taps));
            }
        }
        (sizes, most.saturating_add(samples(taps.len(), tapped)).saturating_add(kept))
    }

    /// Returns a node's stage, if it is needed and not filled from outside.
    pub(crate) fn stage(&self, id: NodeId) -> Option<&dyn Stage> {
        self.settled[id.0].as_ref().filter(|_| !self.bound[id.0])?.stage()
    }
}

/// Returns the larger of two sizes, along each axis.
fn larger(a: [usize; 2], b: [usize; 2]) -> [usize; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// Returns the number of samples in some planes.
fn samples(planes: usize, [width, height]: [usize; 2]) -> u64 {
    (planes as u64).saturating_mul(width as u64).saturating_mul(height as u64)
}
