//! A folder in which stages leave what took them long, for other processes and machines.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Instant, SystemTime};
use trochoid_graph::{Key, Store, StoredEntry};
use trochoid_io::{clear_partial_files, open_file, write_parts};

/// Beginning of an entry's file: its form and the form's version.
const MAGIC: &[u8; 16] = b"trochoid store 1";
/// Bytes before the data: the magic, the number, the seconds, and the hash.
const HEADER: usize = 16 + 8 + 8 + 32;
/// Ending of an entry's file.
const ENDING: &str = "entry";
/// Digits of the name of a series.
const DIGITS: usize = 32;
/// Least seconds of a use, whatever the size: opening and looking for files.
const LEAST: f64 = 0.01;
/// Seconds that a byte is expected to take before any was read or written: a disk, or a network of 2 Gbit/s.
const EXPECTED: f64 = 1.0 / 200e6;
/// Most share of the time of making something that keeping it takes.
const SHARE: f64 = 0.1;
/// Least times that making something takes as long as reading it, for it to be read.
const GAIN: f64 = 2.0;

/// [`Store`] in a folder that any number of processes and machines may use at once.
///
/// A series is a folder named by its key, and an entry a file named by its number. Files appear whole or not at all, and
/// two processes that keep the same entry write the same bytes. An entry has a hash of its data, its number and its key;
/// one that does not match is not used. When an entry is added and all files together exceed the limit, those not used
/// for the longest time are removed, except that one: so the limit may be exceeded by the entries that processes add at
/// the same moment. Other files in the folder are left alone.
///
/// Whether reading and keeping pay is measured: by the seconds that the last use took for a byte.
///
/// ```
/// use trochoid::{ContentKey, FolderStore, Store};
///
/// let folder = tempfile::tempdir()?;
/// let store = FolderStore::new(folder.path(), 1 << 30)?;
/// let sea = "a sea".key();
/// store.keep(sea, 480, 12.5, &[1, 2, 3]);
/// let entry = store.find(sea, 0, 500).expect("it is kept");
/// assert_eq!((entry.number, entry.bytes, entry.seconds), (480, 3, 12.5));
/// assert_eq!(store.read(sea, &entry).as_deref(), Some(&[1, 2, 3][..]));
/// assert!(store.reading_pays(entry.bytes, entry.seconds));
/// assert_eq!(store.find(sea, 0, 479), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FolderStore {
    folder: PathBuf,
    limit: u64,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// Seconds of a byte in the last use.
    read: f64,
    write: f64,
    uses: StoreUses,
}

/// What a process did with a store.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StoreUses {
    /// Number of entries read.
    pub read: u64,
    /// Number of entries kept.
    pub kept: u64,
    /// Number of entries that were damaged, and not used.
    pub damaged: u64,
    /// Why the last entry could not be kept, if one could not.
    pub refused: Option<String>,
}

/// The folder of a store cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", folder.display())]
pub struct NoStore {
    /// The folder.
    pub folder: PathBuf,
    /// What the system says.
    #[source]
    pub error: std::io::Error,
}

/// A file of an entry.
struct EntryFile {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

impl FolderStore {
    /// Opens a store of at most `limit` bytes; makes its folder if there is none.
    ///
    /// # Errors
    /// The path is no folder and cannot become one.
    pub fn new(folder: impl Into<PathBuf>, limit: u64) -> Result<Self, NoStore> {
        let folder = folder.into();
        let made = fs::create_dir_all(&folder).and_then(|()| fs::read_dir(&folder));
        if let Err(error) = made {
            return Err(NoStore { folder, error });
        }
        let state = State { read: EXPECTED, write: EXPECTED, uses: StoreUses::default() };
        Ok(Self { folder, limit, state: Mutex::new(state) })
    }

    /// Returns what this process did with the store so far.
    pub fn uses(&self) -> StoreUses {
        self.state().uses.clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn series(&self, series: Key) -> PathBuf {
        self.folder.join(&series.to_hex()[..DIGITS])
    }

    /// Removes the files that were not used for the longest time, except the newest one, until the rest is within the
    /// limit.
    fn trim(&self, newest: &Path) {
        let mut files = entries(&self.folder);
        let mut held: u64 = files.iter().map(|file| file.bytes).sum();
        files.sort_by_key(|file| file.used);
        for file in files.iter().filter(|file| file.path != newest) {
            if held <= self.limit {
                return;
            }
            // Another process may have removed it.
            let _ = fs::remove_file(&file.path);
            held -= file.bytes;
            // Only an empty folder is removed.
            let _ = file.path.parent().map(fs::remove_dir);
        }
    }
}

impl Store for FolderStore {
    fn find(&self, series: Key, least: u64, most: u64) -> Option<StoredEntry> {
        let names = fs::read_dir(self.series(series)).ok()?;
        let numbers = names.flatten().filter_map(|name| number(&name.path()));
        let number = numbers.filter(|number| (least + 1..=most).contains(number)).max()?;
        let file = open_file(file(&self.series(series), number)).ok()?;
        let bytes = file.length.checked_sub(HEADER as u64)?;
        let mut header = [0; HEADER];
        file.reader().read_exact(&mut header).ok()?;
        let seconds = seconds(&header).filter(|seconds| seconds.is_finite() && *seconds >= 0.0)?;
        Some(StoredEntry { number, bytes, seconds })
    }

    fn read(&self, series: Key, entry: &StoredEntry) -> Option<Vec<u8>> {
        let started = Instant::now();
        let file = open_file(file(&self.series(series), entry.number)).ok()?;
        let length = file.length;
        // Counts as used now. Only the owner of a file may change its time; others read it all the same.
        let _ = file.file.set_modified(SystemTime::now());
        let mut header = [0; HEADER];
        let mut data = vec![0; usize::try_from(entry.bytes).ok()?];
        let mut reader = file.reader();
        let read = reader.read_exact(&mut header).and_then(|()| reader.read_exact(&mut data));
        let whole = read.is_ok()
            && length == entry.bytes + HEADER as u64
            && seconds(&header).is_some_and(|seconds| header == head(series, entry.number, seconds, &data));
        let mut state = self.state();
        if !whole {
            state.uses.damaged += 1;
            return None;
        }
        state.uses.read += 1;
        state.read = started.elapsed().as_secs_f64() / entry.bytes.max(1) as f64;
        Some(data)
    }

    fn keep(&self, series: Key, number: u64, seconds: f64, data: &[u8]) {
        if data.len() as u64 + HEADER as u64 > self.limit {
            return;
        }
        let started = Instant::now();
        let folder = self.series(series);
        let path = file(&folder, number);
        let written = fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()));
        let written = written.and_then(|()| {
            // Processes that were killed while writing left partial files.
            clear_partial_files(&folder);
            let header = head(series, number, seconds, data);
            write_parts(&path, &[&header, data]).map_err(|error| error.to_string())
        });
        self.trim(&path);
        let mut state = self.state();
        state.write = started.elapsed().as_secs_f64() / data.len().max(1) as f64;
        match written {
            Ok(()) => state.uses.kept += 1,
            Err(error) => state.uses.refused = Some(error),
        }
    }

    fn reading_pays(&self, bytes: u64, seconds: f64) -> bool {
        seconds > GAIN * (LEAST + self.state().read * bytes as f64)
    }

    fn keeping_pays(&self, bytes: u64, seconds: f64) -> bool {
        seconds * SHARE > LEAST + self.state().write * bytes as f64
    }
}

/// Returns the path of an entry.
fn file(series: &Path, number: u64) -> PathBuf {
    series.join(format!("{number}.{ENDING}"))
}

/// Returns the number of the entry at a path, if it is one.
fn number(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?.strip_suffix(ENDING)?.strip_suffix('.')?;
    name.parse().ok().filter(|number: &u64| number.to_string() == name)
}

/// Returns the files of all entries.
fn entries(folder: &Path) -> Vec<EntryFile> {
    let is_series = |path: &Path| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.len() == DIGITS && name.bytes().all(|sign| matches!(sign, b'0'..=b'9' | b'a'..=b'f'))
    };
    let within = |folder: &Path| fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let series = within(folder).filter(|path| is_series(path));
    let files = series.flat_map(|series| within(&series).collect::<Vec<_>>()).filter(|path| number(path).is_some());
    let described = |path: PathBuf| {
        let found = fs::symlink_metadata(&path).ok().filter(|found| found.is_file())?;
        Some(EntryFile { path, bytes: found.len(), used: found.modified().ok()? })
    };
    files.filter_map(described).collect()
}

/// Returns what stands before an entry's data.
fn head(series: Key, number: u64, seconds: f64, data: &[u8]) -> [u8; HEADER] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(series.to_hex().as_bytes());
    hasher.update(&number.to_le_bytes());
    hasher.update(&seconds.to_le_bytes());
    hasher.update(data);
    let mut head = [0; HEADER];
    head[..16].copy_from_slice(MAGIC);
    head[16..24].copy_from_slice(&number.to_le_bytes());
    head[24..32].copy_from_slice(&seconds.to_le_bytes());
    head[32..].copy_from_slice(hasher.finalize().as_bytes());
    head
}

/// Returns the seconds of an entry, if its file is one of this form.
fn seconds(header: &[u8; HEADER]) -> Option<f64> {
    let rest = header.strip_prefix(MAGIC)?;
    rest.get(8..16)?.try_into().ok().map(f64::from_le_bytes)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use trochoid_graph::ContentKey;

    fn store(folder: &tempfile::TempDir, limit: u64) -> FolderStore {
        FolderStore::new(folder.path(), limit).unwrap()
    }

    fn find(store: &FolderStore, series: &str) -> Option<u64> {
        store.find(series.key(), 0, u64::MAX).map(|entry| entry.number)
    }

    #[test]
    fn the_entry_with_the_largest_number_in_a_span_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let kept = store(&folder, 1 << 20);
        [3, 10, 200].into_iter().for_each(|number| kept.keep("a".key(), number, number as f64, &[1; 9]));
        kept.keep("b".key(), 7, 0.5, &[]);
        // Files of others are not entries.
        let series = file(&kept.series("a".key()), 3).parent().unwrap().to_owned();
        for name in ["20.entry.bak", "020.entry", "x.entry", ".trochoid-ab.partial"] {
            fs::write(series.join(name), "").unwrap();
        }
        let found = |least, most| kept.find("a".key(), least, most).map(|entry| (entry.number, entry.bytes));
        assert_eq!(found(0, u64::MAX), Some((200, 9)));
        assert_eq!(found(0, 199), Some((10, 9)));
        assert_eq!((found(10, 199), found(10, 10), found(300, 200)), (None, None, None));
        assert_eq!(find(&kept, "b"), Some(7));
        assert_eq!(find(&kept, "c"), None);
        assert_eq!(kept.uses(), StoreUses { kept: 4, ..StoreUses::default() });
    }

    #[test]
    fn damaged_entries_are_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let kept = store(&folder, 1 << 20);
        let data: Vec<u8> = (0..=255).collect();
        kept.keep("a".key(), 5, 2.0, &data);
        let path = file(&kept.series("a".key()), 5);
        let whole = trochoid_io::read_bytes(&path, 1 << 20).unwrap();
        let entry = kept.find("a".key(), 0, 5).unwrap();
        for at in [0, 16, 24, 40, HEADER, whole.len() - 1] {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            fs::write(&path, bytes).unwrap();
            assert_eq!(kept.read("a".key(), &entry), None, "byte {at}");
        }
        for length in [0, 20, HEADER, whole.len() - 1] {
            fs::write(&path, &whole[..length]).unwrap();
            assert_eq!(kept.read("a".key(), &entry), None, "{length} bytes");
        }
        // What was kept for another series is another's.
        fs::create_dir_all(kept.series("b".key())).unwrap();
        fs::write(file(&kept.series("b".key()), 5), &whole).unwrap();
        assert_eq!(kept.read("b".key(), &entry), None);
        assert_eq!(kept.uses().damaged, 11);
        fs::write(&path, &whole).unwrap();
        assert_eq!(kept.read("a".key(), &entry), Some(data));
    }

    #[test]
    fn what_was_not_used_for_longest_is_removed_and_nothing_of_others() {
        let folder = tempfile::tempdir().unwrap();
        let kept = store(&folder, 3 * (100 + HEADER as u64));
        let foreign = [folder.path().join("mine.txt"), folder.path().join("0123456789abcdef0123456789abcdef.txt")];
        foreign.iter().for_each(|path| fs::write(path, [0; 1000]).unwrap());
        let age = |series: &str, seconds: u64| {
            let used = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(seconds);
            open_file(file(&kept.series(series.key()), 1)).unwrap().file.set_modified(used).unwrap();
        };
        for (at, series) in ["a", "b", "c"].into_iter().enumerate() {
            kept.keep(series.key(), 1, 1.0, &[7; 100]);
            age(series, at as u64);
        }
        // Reading counts as use.
        let entry = kept.find("a".key(), 0, 1).unwrap();
        assert!(kept.read("a".key(), &entry).is_some());
        kept.keep("d".key(), 1, 1.0, &[7; 100]);
        let there = ["a", "b", "c", "d"].map(|series| find(&kept, series).is_some());
        assert_eq!(there, [true, false, true, true]);
        assert!(!kept.series("b".key()).exists(), "its folder is gone, too");
        kept.keep("e".key(), 1, 1.0, &[7; 1000]);
        assert_eq!(find(&kept, "e"), None, "what is larger than the limit is not kept");
        assert!(foreign.iter().all(|path| path.exists()));
    }

    #[test]
    fn many_write_and_read_at_once() {
        let folder = tempfile::tempdir().unwrap();
        std::thread::scope(|scope| {
            for thread in 0..8_u64 {
                let folder = &folder;
                scope.spawn(move || {
                    let kept = store(folder, 40 * (1000 + HEADER as u64));
                    for round in 0..50 {
                        let number = (thread * 7 + round) % 16 + 1;
                        kept.keep("a".key(), number, 1.0, &[number as u8; 1000]);
                        if let Some(entry) = kept.find("a".key(), 0, 20)
                            && let Some(data) = kept.read("a".key(), &entry)
                        {
                            assert!(data == [entry.number as u8; 1000], "{}", entry.number);
                        }
                    }
                    assert_eq!((kept.uses().damaged, kept.uses().refused), (0, None));
                });
            }
        });
        assert!(entries(folder.path()).len() <= 16);
    }

    #[test]
    fn what_cannot_be_kept_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let kept = store(&folder, 1 << 20);
        fs::write(kept.series("a".key()), "a file in its place").unwrap();
        kept.keep("a".key(), 1, 1.0, &[1]);
        assert!(kept.uses().refused.is_some_and(|why| why.contains(folder.path().to_str().unwrap())));
        assert_eq!(find(&kept, "a"), None);
        let error = FolderStore::new(kept.series("a".key()), 1).unwrap_err();
        assert!(error.to_string().starts_with(folder.path().to_str().unwrap()), "{error}");
    }
}
