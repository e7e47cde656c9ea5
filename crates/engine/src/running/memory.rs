//! Estimates how much memory a plan takes before any of it is allocated.

use super::steps::{Steps, Whole};
use super::tile_memory::samples;
use crate::planning::plan::Pass;
use crate::{EvalError, Plan};
use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use trochoid_graph::{MemoryContext, MemoryUse, NodeId, Stage, in_bytes};

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
    /// Planes that are held over the whole picture, since filters read far around tiles.
    Whole,
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

/// Inverse of the share by which a thread's memory may exceed what it uses at once.
const UNEVEN: u64 = 16;

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
    /// Estimates of nodes.
    uses: HashMap<NodeId, MemoryUse>,
    /// Bytes of a sample in a band of rows that is handed on.
    bytes_in_bands: u64,
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

    /// Returns the bytes of planes that may be held over the whole picture.
    pub(crate) fn whole(&self) -> u64 {
        let whole = self.consumers.iter().find(|(consumer, ..)| *consumer == MemoryConsumer::Whole);
        whole.map_or(0, |(_, bytes, _)| *bytes)
    }

    /// Sets the bytes of the tiles of all threads.
    fn set_tiles(&mut self, each: u64, threads: usize) {
        self.workers = threads;
        self.consumers.retain(|(consumer, ..)| *consumer != MemoryConsumer::Tiles);
        let remedy = "lower the format's \"width\", or reduce the reach of filters";
        self.consumers.push((MemoryConsumer::Tiles, each.saturating_mul(threads as u64), remedy));
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
        let mut account = MemoryAccount {
            consumers: Vec::new(),
            shared: Vec::new(),
            workers: 1,
            uses: HashMap::new(),
            bytes_in_bands: 0,
        };
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
        account.uses = uses;
        account.bytes_in_bands = match pictures {
            Pictures::Rows => size_of::<f32>() as u64 + ENCODED_ROWS,
            Pictures::Whole | Pictures::Files => 0,
        };
        let threads = self.threads();
        let ways = self.ways(&account);
        // Whole planes may leave less memory for tiles, and so for threads.
        let left = self.settings.memory_limit.saturating_sub(account.total());
        let workers = |(each, whole): &(u64, u64)| (left.saturating_sub(*whole) / (*each).max(1)).min(threads as u64);
        // Of equally good ways the first one, and if none is possible, the one that takes the least.
        let least = |(each, whole): &(u64, u64)| std::cmp::Reverse(each.saturating_add(*whole));
        let way = ways.iter().copied().rev().max_by_key(|way| match workers(way) {
            0 => (0, Some(least(way))),
            workers => (workers, None),
        });
        let way = way.unwrap_or_default();
        let remedy = "lower the format's \"width\" or \"height\", or use fewer samples";
        account.consumers.push((MemoryConsumer::Whole, way.1, remedy));
        account.set_tiles(way.0, threads);
        account.shrink_to(self.settings.memory_limit);
        account
    }

    /// Returns the ways to fill tiles: the most bytes that the tile of a thread takes, and those of planes that are held over
    /// the whole picture; the way with the most such planes first, at least one.
    fn ways(&self, account: &MemoryAccount) -> Vec<(u64, u64)> {
        let Some(pass) = self.whole_pass() else {
            let each = self.passes.iter().map(|pass| self.bytes_of_tile(account, pass, None));
            return vec![(each.fold(0, u64::saturating_add), 0)];
        };
        // Not more than all tiles would take to be filled otherwise.
        let most = self.tile_memory(pass, &account.uses, None).filling.saturating_mul(self.threads() as u64);
        let can_hold = |planes: Whole| self.can_hold(pass, planes, &|_| true);
        let ways = Steps::ways(self, pass, &|_| false, &can_hold).filter_map(|steps| {
            let whole = steps.held(&|_| false, &|planes| self.bytes_of(pass, planes)) as u64;
            (whole <= most).then(|| (self.bytes_of_steps(account, pass, &steps), whole))
        });
        let mut found: Vec<(u64, u64)> = Vec::new();
        for way in ways {
            found.push(way);
            if way.1 == 0 {
                break;
            }
        }
        found
    }

    /// Returns the most bytes that the tile of a thread takes in any step.
    fn bytes_of_steps(&self, account: &MemoryAccount, pass: &Pass, steps: &Steps) -> u64 {
        let each = (0..steps.count()).map(|step| self.bytes_of_tile(account, pass, Some((steps, step))));
        each.max().unwrap_or(0)
    }

    /// Returns the bytes that the tile of a thread takes, with its rows of the pictures.
    fn bytes_of_tile(&self, account: &MemoryAccount, pass: &Pass, step: Option<(&Steps, usize)>) -> u64 {
        let memory = self.tile_memory(pass, &account.uses, step);
        let tile = memory.filling.saturating_add(memory.rest);
        // Memory that is used again is not always of the size that is asked for.
        let tile = tile.saturating_add(tile / UNEVEN);
        if step.is_some_and(|(_, step)| step > 0) {
            return tile;
        }
        let channels = self.outputs.iter().map(|output| output.kind.channels()).sum();
        let [width, height] = memory.tile;
        // A band that is handed on is as wide as the picture.
        let rows = height.next_multiple_of(ROWS).min(self.window.height());
        let band = samples(channels, [self.window.width(), rows]).saturating_mul(account.bytes_in_bands);
        // Tiles that are narrower than the picture are computed beside their band.
        let is_beside = width < self.window.width();
        let beside = if is_beside { samples(channels, [width, height]) * size_of::<f32>() as u64 } else { 0 };
        tile.saturating_add(band).saturating_add(beside)
    }

    /// Estimates tiles again once it is known how the evaluation is divided into steps, and lets fewer threads work if they
    /// are larger: images of files may have other sizes than the picture.
    pub(crate) fn account_for_steps(&self, account: &mut MemoryAccount, steps: &Steps) {
        let Some(pass) = self.whole_pass() else { return };
        let each = self.bytes_of_steps(account, pass, steps);
        account.set_tiles(each, self.threads());
        account.shrink_to(self.settings.memory_limit);
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
                MemoryConsumer::Whole => "planes of the whole picture".into(),
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

    /// Returns a node's stage, if it is needed and not filled from outside.
    pub(crate) fn stage(&self, id: NodeId) -> Option<&dyn Stage> {
        self.settled[id.0].as_ref().filter(|_| !self.bound[id.0])?.stage()
    }
}
