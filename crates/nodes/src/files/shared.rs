//! An EXR file that several nodes read on demand: it is opened once, and each block of rows is decoded once.

use super::limits;
use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use trochoid_graph::{NodeError, Prepare, file_states};
use trochoid_image::Window;
use trochoid_io::{BandBuffer, ExrReader, Selection};

/// Maximum size of the decoded blocks kept per file, in bytes.
pub(super) const KEPT: usize = 64 << 20;

/// Minimum number of rows in a block: bands of single rows are read faster several at a time.
const ROWS: usize = 16;

/// One part of an open file, with all channels that any node wants from it.
pub(crate) struct SharedFile {
    state: Mutex<State>,
    /// Decoding buffers, one for each decoding thread.
    scratch: Mutex<Vec<BandBuffer>>,
    data: Window,
    bands: usize,
    rows_per_band: usize,
    /// Number of bands in a block.
    group: usize,
    threads: usize,
}

struct State {
    reader: Arc<ExrReader>,
    kept: HashMap<usize, Kept>,
    clock: u64,
    /// Buffers of blocks that are no longer kept, for reuse.
    spare: Vec<Vec<BandBuffer>>,
}

struct Kept {
    slot: Arc<Slot>,
    used: u64,
}

/// A block that is being decoded, or has been.
#[derive(Default)]
pub(crate) struct Slot {
    decoded: OnceLock<Result<Decoded, NodeError>>,
}

/// The decoded rows of a block.
pub(crate) struct Decoded {
    bands: Vec<BandBuffer>,
    y0: i64,
    rows_per_band: usize,
}

impl Decoded {
    /// Copies the samples of row `y` from column `x0` on.
    pub(crate) fn row(&self, channel: usize, y: i64, x0: i64, out: &mut [f32]) {
        self.bands[(y - self.y0) as usize / self.rows_per_band].row_f32(channel, y, x0, out);
    }
}

impl Slot {
    /// Returns the rows, or the error that prevented their decoding.
    pub(crate) fn rows(&self) -> Result<&Decoded, NodeError> {
        match self.decoded.get() {
            Some(Ok(decoded)) => Ok(decoded),
            Some(Err(error)) => Err(error.clone()),
            None => unreachable!("slots are decoded before they are handed out"),
        }
    }
}

/// Opens an EXR with a selection.
pub(crate) fn open(prepare: &Prepare<'_>, path: &Path, selection: &Selection) -> Result<ExrReader, trochoid_io::Error> {
    ExrReader::open(path, selection, &limits(prepare.frame))
}

impl SharedFile {
    /// Returns the file that `reader` reads, shared with all nodes that read the same part of it, and the positions of
    /// the given channels of the reader in it.
    pub(crate) fn of(
        prepare: &Prepare<'_>,
        path: &Path,
        reader: &ExrReader,
        channels: &[usize],
    ) -> Result<(Arc<Self>, Vec<usize>), NodeError> {
        let name = path.canonicalize().unwrap_or_else(|_| path.into());
        let file = prepare.shared(&(file_states(&[name]), reader.info().part), || Self::new(reader))?;
        let places = file.add(reader, channels)?;
        Ok((file, places))
    }

    fn new(reader: &ExrReader) -> Result<Self, NodeError> {
        let state =
            State { reader: Arc::new(reader.narrowed(&[])?), kept: HashMap::new(), clock: 0, spare: Vec::new() };
        Ok(Self {
            state: Mutex::new(state),
            scratch: Mutex::default(),
            data: reader.info().data,
            bands: reader.bands(),
            rows_per_band: reader.rows_per_band(),
            group: ROWS.div_ceil(reader.rows_per_band()),
            threads: rayon::current_num_threads(),
        })
    }

    /// Adds channels. If any are new, blocks decoded without them are dropped.
    fn add(&self, reader: &ExrReader, channels: &[usize]) -> Result<Vec<usize>, NodeError> {
        let mut state = lock(&self.state);
        let (joined, places) = state.reader.joined(reader, channels)?;
        if joined.info().channels.len() > state.reader.info().channels.len() {
            state.reader = Arc::new(joined);
            state.kept.clear();
        }
        Ok(places)
    }

    /// Returns the number of rows in a block; the last block may have fewer.
    pub(crate) fn rows_per_block(&self) -> usize {
        self.group * self.rows_per_band
    }

    /// Returns the block that contains a row of the data window.
    pub(crate) fn block_at(&self, y: i64) -> usize {
        (y - self.data.y0) as usize / self.rows_per_block()
    }

    /// Returns a block of rows, decoded here or by the thread that requested it first.
    pub(crate) fn block(&self, index: usize) -> Arc<Slot> {
        let (slot, reader, spare) = {
            let mut state = lock(&self.state);
            state.clock += 1;
            let used = state.clock;
            let reader = state.reader.clone();
            if let Some(kept) = state.kept.get_mut(&index) {
                kept.used = used;
                (kept.slot.clone(), reader, Vec::new())
            } else {
                let most = (KEPT / (self.group * reader.band_bytes()).max(1)).max(self.threads + 1);
                while state.kept.len() >= most {
                    state.drop_oldest();
                }
                let slot = Arc::new(Slot::default());
                state.kept.insert(index, Kept { slot: slot.clone(), used });
                (slot, reader, state.spare.pop().unwrap_or_default())
            }
        };
        slot.decoded.get_or_init(|| self.decode(&reader, index, spare));
        slot
    }

    fn decode(&self, reader: &ExrReader, index: usize, mut spare: Vec<BandBuffer>) -> Result<Decoded, NodeError> {
        let first = index * self.group;
        let count = self.group.min(self.bands - first);
        spare.resize_with(count, BandBuffer::new);
        let mut scratch = lock(&self.scratch).pop().unwrap_or_default();
        for (band, buffer) in (first..).zip(&mut spare) {
            // Reuse the buffer of old samples for the new ones.
            scratch.exchange(buffer);
            reader.decode(band, &mut scratch)?;
            scratch.exchange(buffer);
        }
        lock(&self.scratch).push(scratch);
        Ok(Decoded { bands: spare, y0: reader.band_window(first).y0, rows_per_band: self.rows_per_band })
    }

    /// Returns the memory held, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let bytes = |bands: &[BandBuffer]| bands.iter().map(BandBuffer::bytes).sum::<usize>();
        let state = lock(&self.state);
        let kept = state.kept.values().filter_map(|kept| kept.slot.decoded.get()?.as_ref().ok());
        let kept: usize = kept.map(|decoded| bytes(&decoded.bands)).sum();
        let spare: usize = state.spare.iter().map(|bands| bytes(bands)).sum();
        kept + spare + bytes(&lock(&self.scratch))
    }
}

impl State {
    fn drop_oldest(&mut self) {
        let oldest = self.kept.iter().min_by_key(|(_, kept)| kept.used).map(|(index, _)| *index);
        let kept = oldest.and_then(|index| self.kept.remove(&index));
        // If a thread still reads the block, that thread frees it; otherwise its memory is reused.
        let slot = kept.and_then(|kept| Arc::into_inner(kept.slot));
        if let Some(Ok(decoded)) = slot.and_then(|slot| slot.decoded.into_inner())
            && self.spare.is_empty()
        {
            self.spare.push(decoded.bands);
        }
    }
}

/// Returns the guarded value, even after a panic elsewhere: everything guarded here changes in whole steps.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
