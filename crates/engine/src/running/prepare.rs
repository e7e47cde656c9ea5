//! Prepares stages once per frame, and keeps what the next frame can use.

use super::keep::StagePlanes;
use super::memory::{MemoryAccount, Pictures};
use crate::planning::plan::{Fill, Pass};
use crate::{EvalError, Monitor, Plan};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;
use trochoid_graph::{
    ContentKey, FileState, Handle, Key, NodeError, NodeId, Pool, Prepare, Prepared, Settled, Store, file_states,
};
use trochoid_memory::Heap;

/// Prepared stages by content key, so that what does not change from frame to frame is not prepared again; with
/// [`Settings::keep`](crate::Settings::keep) also the planes that stages filled.
///
/// The cache is limited in bytes, as counted by the planes and by [`Prepared::bytes`]. It drops the entries that were
/// not used for the longest time, both when an evaluation prepares and when it is done, since files keep blocks
/// decoded in the meantime. Whatever a running evaluation uses stays alive until then, even if the cache drops it.
pub struct Cache {
    kept: HashMap<Key, CacheEntry>,
    limit: usize,
    /// Share of the limit that the current frame leaves free.
    room: usize,
    clock: u64,
    /// Value of the clock at the last call of `forget_unused`.
    mark: u64,
    pool: Pool,
    store: Option<Arc<dyn Store>>,
}

struct CacheEntry {
    data: CachedData,
    used: u64,
}

#[derive(Clone)]
enum CachedData {
    Prepared(Arc<dyn Prepared>),
    Planes(Arc<StagePlanes>),
}

impl CachedData {
    fn bytes(&self) -> usize {
        match self {
            Self::Prepared(prepared) => prepared.bytes(),
            Self::Planes(planes) => planes.bytes(),
        }
    }
}

/// Default limit of a cache, in bytes.
const LIMIT: usize = 1 << 30;

/// Most prepared stages that a cache holds: few of them are limited by their bytes, but each may keep a file open.
const ENTRIES: usize = 256;

impl Default for Cache {
    fn default() -> Self {
        Self::with_limit(LIMIT.min(Heap::allowed() / 4))
    }
}

impl Cache {
    /// Returns an empty cache of 1 GiB, or of a quarter of the limit of the program's [`Heap`] if that is less.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns an empty cache of at most `bytes` bytes.
    pub fn with_limit(bytes: usize) -> Self {
        Self { kept: HashMap::new(), limit: bytes, room: bytes, clock: 0, mark: 0, pool: Pool::new(), store: None }
    }

    /// Returns the cache with a store, in which stages leave what took them long for other processes.
    #[must_use]
    pub fn with_store(self, store: Arc<dyn Store>) -> Self {
        Self { store: Some(store), ..self }
    }

    /// Returns the memory held, in bytes.
    pub fn bytes(&self) -> usize {
        self.kept.values().map(|entry| entry.data.bytes()).sum()
    }

    /// Drops everything that was not used since the last call: between the frames of a sequence, whatever only the
    /// previous frame needed.
    pub fn forget_unused(&mut self) {
        let mark = std::mem::replace(&mut self.mark, self.clock);
        self.kept.retain(|_, entry| entry.used > mark);
    }

    /// Changes the limit, and drops what goes beyond it.
    pub fn limit_to(&mut self, bytes: usize) {
        (self.limit, self.room) = (bytes, bytes);
        self.trim();
    }

    /// Returns the memory of what was used since the last call of [`forget_unused`](Self::forget_unused): prepared stages,
    /// and planes of pictures with fewer pixels than `area`.
    pub(crate) fn recent(&self, area: usize) -> usize {
        let is_counted = |data: &CachedData| match data {
            CachedData::Prepared(_) => true,
            CachedData::Planes(planes) => planes.is_smaller(area),
        };
        let recent = self.kept.values().filter(|entry| entry.used > self.mark && is_counted(&entry.data));
        recent.map(|entry| entry.data.bytes()).sum()
    }

    pub(crate) fn limit(&self) -> usize {
        self.limit
    }

    /// Limits the cache to `bytes`, while a frame needs the rest.
    fn make_room(&mut self, bytes: u64) {
        self.room = self.limit.min(usize::try_from(bytes).unwrap_or(usize::MAX));
    }

    /// Returns the entry of a key, which then counts as used.
    fn touch(&mut self, key: &Key) -> Option<CachedData> {
        self.clock += 1;
        let entry = self.kept.get_mut(key)?;
        entry.used = self.clock;
        Some(entry.data.clone())
    }

    fn prepared(&mut self, key: &Key) -> Option<Arc<dyn Prepared>> {
        match self.touch(key)? {
            CachedData::Prepared(prepared) => Some(prepared),
            CachedData::Planes(_) => None,
        }
    }

    pub(crate) fn planes(&mut self, key: &Key) -> Option<Arc<StagePlanes>> {
        match self.touch(key)? {
            CachedData::Planes(planes) => Some(planes),
            CachedData::Prepared(_) => None,
        }
    }

    fn keep(&mut self, key: Key, prepared: Arc<dyn Prepared>) {
        self.insert(key, CachedData::Prepared(prepared));
        self.trim();
    }

    /// Keeps the planes that a stage filled; call [`trim`](Self::trim) after the last one.
    pub(crate) fn keep_planes(&mut self, key: Key, planes: Arc<StagePlanes>) {
        self.insert(key, CachedData::Planes(planes));
    }

    fn insert(&mut self, key: Key, data: CachedData) {
        self.clock += 1;
        self.kept.insert(key, CacheEntry { data, used: self.clock });
    }

    /// Drops entries that are too large by themselves, then the oldest entries until the rest is within the limits.
    pub(crate) fn trim(&mut self) {
        self.trim_to(self.room);
    }

    /// Drops already now what [`trim`](Self::trim) would drop once `bytes` more are kept.
    pub(crate) fn make_way(&mut self, bytes: usize) {
        self.trim_to(self.room.saturating_sub(bytes));
    }

    fn trim_to(&mut self, limit: usize) {
        self.kept.retain(|_, entry| entry.data.bytes() <= limit);
        let mut ages: Vec<(u64, usize, bool, Key)> = self
            .kept
            .iter()
            .map(|(key, entry)| (entry.used, entry.data.bytes(), matches!(entry.data, CachedData::Prepared(_)), *key))
            .collect();
        ages.sort_by_key(|age| std::cmp::Reverse(age.0));
        let (mut held, mut stages) = (0_usize, 0);
        for (_, bytes, is_prepared, key) in ages {
            held = held.saturating_add(bytes);
            stages += usize::from(is_prepared);
            if held > limit || (is_prepared && stages > ENTRIES) {
                self.kept.remove(&key);
            }
        }
    }
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Cache of {} nodes", self.kept.len())
    }
}

/// A prepared stage, with the time that it took.
pub(crate) struct PreparedStage {
    pub(crate) prepared: Arc<dyn Prepared>,
    pub(crate) seconds: f64,
    pub(crate) cached: bool,
    /// Key of the files that it depends on.
    files: Key,
}

/// Prepares every stage of a plan, inputs first, unless that takes more memory than allowed. Returns the memory
/// account too.
pub(crate) fn prepare(
    plan: &Plan<'_>,
    cache: &mut Cache,
    monitor: &dyn Monitor,
    pictures: Pictures,
) -> Result<(HashMap<NodeId, PreparedStage>, MemoryAccount), EvalError> {
    let mut ready: HashMap<NodeId, PreparedStage> = HashMap::new();
    let keys = keys(plan);
    // Look up everything that this frame uses before anything is dropped.
    let mut known: Vec<Option<Arc<dyn Prepared>>> = keys.iter().map(|(key, _)| cache.prepared(key)).collect();
    let there = plan.prepares.iter().zip(&known);
    let there = there.filter_map(|((id, _), known)| Some((*id, known.as_ref()?.bytes() as u64))).collect();
    let mut account = plan.account(pictures, &there);
    plan.check_memory(&account)?;
    cache.make_room((plan.settings.memory_limit - account.total()).saturating_add(account.held()));
    cache.trim();
    // Cached stages are checked too: another graph may have been allowed to read the file.
    for (id, _) in &plan.prepares {
        if let Some(refused) = plan.graph.refused(*id, &plan.context) {
            return Err(EvalError::of(plan.graph, *id, refused.into()));
        }
    }
    for (((id, wanted), (key, files)), known) in plan.prepares.iter().zip(keys).zip(&mut known) {
        if monitor.cancelled() {
            return Err(EvalError::Cancelled);
        }
        let node = plan.graph.node(*id);
        let Some(stage) = plan.settled[id.0].as_ref().and_then(Settled::stage) else { continue };
        let entry = match known.take() {
            Some(prepared) => PreparedStage { prepared, seconds: 0.0, cached: true, files },
            None => {
                monitor.preparing(&node.name);
                let started = Instant::now();
                let handles = |id: NodeId| -> Option<Handle> { ready.get(&id)?.prepared.handle() };
                let cancelled = || monitor.cancelled();
                let prepare = Prepare::new(&plan.context, &node.kinds, wanted, &handles, &cancelled, &cache.pool)
                    .with_purpose(plan.settings.purpose)
                    .with_store(cache.store.as_ref())
                    .with_part(plan.part());
                let prepared = stage.prepare(&prepare).map_err(|error| node_error(plan, *id, error, monitor))?;
                let prepared: Arc<dyn Prepared> = prepared.into();
                // If the estimate was too low, count the real size.
                account.raise_to(*id, prepared.bytes() as u64);
                account.shrink_to(plan.settings.memory_limit);
                plan.check_memory(&account)?;
                cache.keep(key, prepared.clone());
                PreparedStage { prepared, seconds: started.elapsed().as_secs_f64(), cached: false, files }
            }
        };
        ready.insert(*id, entry);
    }
    Ok((ready, account))
}

/// Returns the key of the planes that a stage fills over the picture: its content key, its channels, the picture's format,
/// where in pixels its samples are, and by which views they share. Fields have one sample where colors have several.
pub(crate) fn key_of_planes(plan: &Plan<'_>, pass: &Pass, fill: &Fill, ready: &PreparedStage) -> Key {
    let views = fill.shared.as_ref().map(|views| views.iter().map(|view| plan.keys[view.0]).collect::<Vec<_>>());
    let sharing = (pass.sharing, &pass.offsets, views).key();
    let purpose = (plan.settings.purpose, ready.files, sharing);
    ("filled", plan.keys[fill.node.0], &fill.wanted, plan.context.format, purpose).key()
}

/// Returns the keys of all stages that a plan prepares, each with the key of the files that it depends on. Files are
/// looked at again, since a plan may be evaluated long after it was made.
fn keys(plan: &Plan<'_>) -> Vec<(Key, Key)> {
    let mut files: HashMap<NodeId, Key> = HashMap::new();
    let mut keys = Vec::new();
    for (id, wanted) in &plan.prepares {
        let mut read: (Vec<FileState>, Vec<Option<Key>>) = Default::default();
        if let Some(settled) = &plan.settled[id.0]
            && let Some(stage) = settled.stage()
        {
            read.0 = file_states(&stage.files(&plan.context));
            settled.each_node(|node| read.1.push(files.get(&node).copied()));
        }
        let read = read.key();
        files.insert(*id, read);
        // Stages prepared for bounds or references are cached separately.
        let key = ("prepared", plan.keys[id.0], wanted, (plan.settings.purpose, read)).key();
        let key = plan.part().map_or(key, |part| (key, part).key());
        keys.push((key, read));
    }
    keys
}

/// Adds the node's name to its error; a node that stopped on cancellation has no error of its own.
pub(crate) fn node_error(plan: &Plan<'_>, id: NodeId, error: NodeError, monitor: &dyn Monitor) -> EvalError {
    if monitor.cancelled() {
        return EvalError::Cancelled;
    }
    EvalError::of(plan.graph, id, error)
}
