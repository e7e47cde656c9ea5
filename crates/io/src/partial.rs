//! Files on their way, under temporary names: locked as long as somebody writes them, and removed once nobody does.

use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError as FileLockError};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::time::Duration;

const PREFIX: &str = ".trochoid-";
const SUFFIX: &str = ".partial";
/// What a file system without locks leaves as the sign that nobody writes a file any more.
const LONG_AGO: Duration = Duration::from_secs(24 * 60 * 60);
/// New names that are tried, should others clear up in the same moments.
const ATTEMPTS: usize = 64;

/// What this process writes. Whoever makes, renames or removes a temporary file holds the lock meanwhile.
struct Ours {
    names: BTreeSet<PathBuf>,
    /// Folders in which it has cleared up.
    cleared: BTreeSet<PathBuf>,
}

static OURS: Mutex<Ours> = Mutex::new(Ours { names: BTreeSet::new(), cleared: BTreeSet::new() });

fn ours() -> MutexGuard<'static, Ours> {
    OURS.lock().unwrap_or_else(|error| error.into_inner())
}

/// What this process writes, once nobody holds it, unless that takes long.
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

/// Removes every file that is still being written, for a process that is about to exit without unwinding.
///
/// From then on no file appears: threads that would begin or complete one wait for ever. Completed files stay as they are.
/// Where a thread holds what it would need for longer than a second, as the one that calls this may, the next run into the
/// folder removes them.
pub fn discard_partial_files() {
    let Some(ours) = soon() else { return };
    for name in &ours.names {
        // Nobody is left to be told of a file that cannot be removed.
        let _ = fs::remove_file(name);
    }
    // Unlocked, another thread could begin the next file before the process ends.
    std::mem::forget(ours);
}

/// Removes from a folder what processes left half written that are dead, whatever machine they ran on.
///
/// Whoever writes holds the lock of the file, and the file system knows whether he lives. Where it has no locks, files
/// stay for a day. Links and whatever else bears such a name are left alone.
pub fn clear_partial_files(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(is_partial) {
            // What cannot be removed disturbs nobody.
            let _ = remove_if_dead(&entry.path());
        }
    }
}

fn is_partial(name: &str) -> bool {
    let middle = name.strip_prefix(PREFIX).and_then(|rest| rest.strip_suffix(SUFFIX));
    middle.is_some_and(|middle| !middle.is_empty() && middle.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

fn remove_if_dead(path: &Path) -> std::io::Result<()> {
    // Some file systems grant a process the locks that it has already.
    if ours().names.contains(path) {
        return Ok(());
    }
    // Locks across machines are granted to those alone who may write.
    let file = OpenOptions::new().read(true).write(true).open(path)?;
    let is_dead = match file.try_lock() {
        Ok(()) => true,
        Err(FileLockError::WouldBlock) => false,
        Err(FileLockError::Error(_)) => file.metadata()?.modified()?.elapsed().is_ok_and(|age| age > LONG_AGO),
    };
    // A link that took the name meanwhile is another file.
    if is_dead && stands_at(&file, path) {
        fs::remove_file(path)?;
    }
    Ok(())
}

/// Whether an open file is what stands under a name, which is no link.
fn stands_at(file: &File, path: &Path) -> bool {
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

/// The name of a temporary file, registered as long as there is such a file.
pub(crate) struct Temporary {
    name: PathBuf,
    /// `None` once the file has another name.
    file: Option<tempfile::TempPath>,
}

impl Temporary {
    /// A new file in a folder; first, and once in each, what the dead left there goes.
    ///
    /// The file is locked: as long as it is open, nobody clears it up.
    pub(crate) fn create(folder: &Path) -> std::io::Result<(File, Self)> {
        if ours().cleared.insert(folder.into()) {
            clear_partial_files(folder);
        }
        for _ in 0..ATTEMPTS {
            let (file, temporary) = Self::unlocked(folder)?;
            // Before it was locked it may have looked dead, and then it is gone, or about to go.
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
            // A temporary file is private by default; a picture is as readable as the user's other files (umask applies).
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut ours = ours();
        let (file, temporary) = builder.tempfile_in(folder)?.into_parts();
        let name = temporary.to_path_buf();
        ours.names.insert(name.clone());
        Ok((file, Self { name, file: Some(temporary) }))
    }

    /// Gives the file its name.
    pub(crate) fn persist(mut self, target: &Path) -> std::io::Result<()> {
        let _ours = ours();
        // What cannot be renamed is handed back, and removed when `self` goes.
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
        // The same where the link takes a file's name while that is looked at.
        assert!(!stands_at(&File::open(&link).unwrap(), &link));
    }

    #[test]
    fn files_are_made_while_others_clear_up() {
        let folder = tempfile::tempdir().unwrap();
        let stop = std::sync::atomic::AtomicBool::new(false);
        let made = std::thread::scope(|scope| {
            // As another process does, which does not know the names of this one.
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
