//! Temporary files for writing: locked as long as a process writes them, and removed afterward.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError as FileLockError};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;

const PREFIX: &str = ".trochoid-";
const SUFFIX: &str = ".partial";
/// Age at which a file counts as abandoned on file systems without locks.
const LONG_AGO: Duration = Duration::from_secs(24 * 60 * 60);
/// Maximum number of new names to try if other processes clean up at the same time.
const ATTEMPTS: usize = 64;

/// Temporary files of this process. The lock is held while one is created, renamed or removed.
struct Ours {
    names: BTreeSet<PathBuf>,
    /// Folders that the process has cleaned up.
    cleared: BTreeSet<PathBuf>,
}

static OURS: Mutex<Ours> = Mutex::new(Ours { names: BTreeSet::new(), cleared: BTreeSet::new() });

fn ours() -> MutexGuard<'static, Ours> {
    OURS.lock().unwrap_or_else(|error| error.into_inner())
}

/// Locks the temporary files of this process; `None` if that takes too long.
fn soon() -> Option<MutexGuard<'static, Ours>> {
    for _ in 0..100 {
        match OURS.try_lock() {
            Ok(ours) => return Some(ours),
            Err(TryLockError::Poisoned(ours)) => return Some(ours.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
    None
}

/// Removes all files that are still being written, for a process that is about to exit without unwinding.
///
/// Afterward no file appears: threads that would begin or complete one wait forever. Completed files stay unchanged. If
/// a thread, possibly the calling one, holds the lock for longer than a second, the files stay, and the next run that
/// writes to the folder removes them.
pub fn discard_partial_files() {
    let Some(ours) = soon() else { return };
    for name in &ours.names {
        // A file that cannot be removed is ignored, because the process ends.
        let _ = fs::remove_file(name);
    }
    // The lock is never released: another thread could begin a file before the process ends.
    std::mem::forget(ours);
}

/// Removes the partial files of dead processes from a folder, on whatever machine they ran.
///
/// A process that writes a file holds its lock, so the file system knows whether the process is alive. Without locks,
/// files stay for a day. Links and other things with such names are left alone.
pub fn clear_partial_files(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(is_partial) {
            // A file that cannot be removed is harmless.
            let _ = remove_if_dead(&entry.path());
        }
    }
}

fn is_partial(name: &str) -> bool {
    let middle = name.strip_prefix(PREFIX).and_then(|rest| rest.strip_suffix(SUFFIX));
    middle.is_some_and(|middle| !middle.is_empty() && middle.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

fn remove_if_dead(path: &Path) -> std::io::Result<()> {
    // Some file systems grant a process locks that it holds already.
    if ours().names.contains(path) {
        return Ok(());
    }
    // Locks across machines are granted only to processes that may write.
    let file = OpenOptions::new().read(true).write(true).open(path)?;
    let is_dead = match file.try_lock() {
        Ok(()) => true,
        Err(FileLockError::WouldBlock) => false,
        Err(FileLockError::Error(_)) => file.metadata()?.modified()?.elapsed().is_ok_and(|age| age > LONG_AGO),
    };
    // The name may have become a link to another file meanwhile.
    if is_dead && stands_at(&file, path) {
        fs::remove_file(path)?;
    }
    Ok(())
}

/// Returns whether a name, which is not a link, leads to an open file.
pub(crate) fn stands_at(file: &File, path: &Path) -> bool {
    let (Ok(open), Ok(named)) = (file.metadata(), fs::symlink_metadata(path)) else { return false };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        (open.dev(), open.ino()) == (named.dev(), named.ino())
    }
    #[cfg(not(unix))]
    {
        open.is_file() && named.is_file()
    }
}

/// File of this process that is removed if it ends without unwinding, until this is dropped.
#[derive(Debug)]
pub(crate) struct Registered(PathBuf);

impl Registered {
    /// Registers a file; `None` if the process has registered it already.
    pub(crate) fn new(path: &Path) -> Option<Self> {
        ours().names.insert(path.into()).then(|| Self(path.into()))
    }
}

impl Drop for Registered {
    fn drop(&mut self) {
        ours().names.remove(&self.0);
    }
}

/// Name of a temporary file, which is registered as long as the file exists.
pub(crate) struct Temporary {
    name: PathBuf,
    /// Guard that removes the file when dropped; `None` once the file has its final name.
    file: Option<tempfile::TempPath>,
}

impl Temporary {
    /// Creates a file in a folder. On the first use of a folder, partial files of dead processes are removed from it.
    ///
    /// The file is locked, so that no process removes it while it is open.
    pub(crate) fn create(folder: &Path) -> std::io::Result<(File, Self)> {
        if ours().cleared.insert(folder.into()) {
            clear_partial_files(folder);
        }
        for _ in 0..ATTEMPTS {
            let (file, temporary) = Self::unlocked(folder)?;
            // Before it was locked, the file may have looked abandoned and been removed.
            let taken = matches!(file.try_lock(), Err(FileLockError::WouldBlock));
            if !taken && stands_at(&file, &temporary.name) {
                return Ok((file, temporary));
            }
        }
        Err(std::io::Error::other("files are removed there as soon as they are made"))
    }

    fn unlocked(folder: &Path) -> std::io::Result<(File, Self)> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Temporary files are private by default, but a picture gets the permissions of the user's other files
            // (umask applies).
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut ours = ours();
        let (file, temporary) = builder.tempfile_in(folder)?.into_parts();
        let name = temporary.to_path_buf();
        ours.names.insert(name.clone());
        Ok((file, Self { name, file: Some(temporary) }))
    }

    /// Returns the name of the unfinished file.
    pub(crate) fn name(&self) -> &Path {
        &self.name
    }

    /// Gives the file its final name.
    pub(crate) fn persist(mut self, target: &Path) -> std::io::Result<()> {
        let _ours = ours();
        // A file that cannot be renamed is returned, and removed when `self` is dropped.
        match self.file.take().map(|file| file.persist(target)) {
            Some(Err(failed)) => {
                self.file = Some(failed.path);
                Err(failed.error)
            }
            _ => Ok(()),
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut ours = ours();
        drop(self.file.take());
        ours.names.remove(&self.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path) -> File {
        fs::write(path, "half").unwrap();
        OpenOptions::new().read(true).write(true).open(path).unwrap()
    }

    #[test]
    fn what_the_dead_left_goes_and_what_somebody_writes_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for dead in [".trochoid-dead01.partial", ".trochoid-x.partial"] {
            write(&at(dead));
        }
        let living = write(&at(".trochoid-living.partial"));
        living.try_lock().unwrap();
        let others =
            [".trochoid-.partial", ".trochoid-a-b.partial", "trochoid-a.partial", ".trochoid-a.exr", "a.partial"];
        others.iter().for_each(|name| drop(write(&at(name))));
        fs::create_dir(at(".trochoid-folder.partial")).unwrap();
        let (open, own) = Temporary::create(folder.path()).unwrap();
        clear_partial_files(folder.path());
        let mut names: Vec<String> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        let mut expected: Vec<String> = others.iter().map(ToString::to_string).collect();
        expected.extend([".trochoid-living.partial".into(), ".trochoid-folder.partial".into()]);
        expected.push(own.name.file_name().unwrap().to_str().unwrap().into());
        expected.sort();
        assert_eq!(names, expected);
        drop((living, open));
        clear_partial_files(folder.path());
        assert!(!at(".trochoid-living.partial").exists(), "nobody writes it any more");
        assert!(own.name.exists(), "this process does");
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("kept"), folder.path().join(".trochoid-link.partial"));
        fs::write(&target, "kept").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        clear_partial_files(folder.path());
        assert!(target.exists() && fs::symlink_metadata(&link).is_ok());
        // The same if the link takes a file's name while that is checked.
        assert!(!stands_at(&File::open(&link).unwrap(), &link));
    }

    #[test]
    fn files_are_made_while_others_clear_up() {
        let folder = tempfile::tempdir().unwrap();
        let stop = std::sync::atomic::AtomicBool::new(false);
        let made = std::thread::scope(|scope| {
            // As in another process, which does not know the names of this one.
            scope.spawn(|| {
                while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                    for entry in fs::read_dir(folder.path()).unwrap().flatten() {
                        let Ok(file) = OpenOptions::new().read(true).write(true).open(entry.path()) else { continue };
                        if file.try_lock().is_ok() && stands_at(&file, &entry.path()) {
                            let _ = fs::remove_file(entry.path());
                        }
                    }
                }
            });
            let made: Vec<_> = (0..300).map(|_| Temporary::create(folder.path()).unwrap()).collect();
            std::thread::sleep(Duration::from_millis(20));
            stop.store(true, std::sync::atomic::Ordering::Relaxed);
            made
        });
        assert!(made.iter().all(|(file, temporary)| stands_at(file, &temporary.name)));
    }
}
