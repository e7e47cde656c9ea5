//! Files that appear whole or not at all.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

use crate::Error;

/// The temporary files of this process. Whoever makes, renames or removes one holds the lock meanwhile.
static PARTIAL: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn partial() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PARTIAL.lock().unwrap_or_else(|error| error.into_inner())
}

/// Removes every file that is still being written, for a process that is about to exit without unwinding.
///
/// From then on no file appears: threads that would begin or complete one wait for ever, and so do further calls.
/// Completed files stay as they are.
pub fn discard_partial_files() {
    let files = partial();
    for file in files.iter() {
        // Nobody is left to be told of a file that cannot be removed.
        let _ = fs::remove_file(file);
    }
    // Unlocked, another thread could begin the next file before the process ends.
    std::mem::forget(files);
}

/// A file on its way: written under a temporary name in the same folder, until it takes its place.
///
/// Whoever looks at the path sees the old file or the new one. Dropped, it leaves the old file and nothing else.
pub(crate) struct AtomicFile {
    path: PathBuf,
    target: PathBuf,
    pub(crate) writer: BufWriter<File>,
    temporary: Temporary,
}

/// The name of a temporary file, registered as long as there is such a file.
struct Temporary {
    name: PathBuf,
    /// `None` once the file has another name.
    file: Option<tempfile::TempPath>,
}

impl Temporary {
    fn create(folder: &Path) -> std::io::Result<(File, Self)> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(".trochoid-").suffix(".partial");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // A temporary file is private by default; a picture is as readable as the user's other files (umask applies).
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut names = partial();
        let (file, temporary) = builder.tempfile_in(folder)?.into_parts();
        let name = temporary.to_path_buf();
        names.insert(name.clone());
        Ok((file, Self { name, file: Some(temporary) }))
    }

    fn persist(mut self, target: &Path) -> std::io::Result<()> {
        let _names = partial();
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
        let mut names = partial();
        drop(self.file.take());
        names.remove(&self.name);
    }
}

impl AtomicFile {
    /// Starts an empty file.
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let target = destination(path)?;
        let (file, temporary) =
            Temporary::create(folder(&target)).map_err(Error::io(path, "create a file in the folder"))?;
        Ok(Self { path: path.into(), target, writer: BufWriter::new(file), temporary })
    }

    /// Puts the finished file in its place.
    pub(crate) fn commit(self) -> Result<(), Error> {
        let Self { path, target, mut writer, temporary } = self;
        writer.flush().map_err(Error::io(&path, "write the file"))?;
        // On disk before the name changes: after a power cut the name must not lead to missing bytes.
        writer.get_ref().sync_all().map_err(Error::io(&path, "write the file to disk"))?;
        drop(writer);
        temporary.persist(&target).map_err(Error::io(&path, "rename the finished file"))?;
        #[cfg(unix)]
        if let Ok(folder) = File::open(folder(&target)) {
            // Makes the new name itself durable. Some file systems refuse; the picture is complete either way.
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

/// Writes a whole [`AtomicFile`]. If `fill` or any step fails, the old file is untouched.
pub(crate) fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut file = AtomicFile::create(path)?;
    fill(&mut file.writer)?;
    file.commit()
}

/// Writes bytes into a file that appears whole or not at all.
///
/// # Errors
/// Something that is no regular file stands there, or the file cannot be written; the old one is untouched then.
pub fn write_bytes(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), Error> {
    let path = path.as_ref();
    write_atomically(path, |writer| writer.write_all(bytes).map_err(Error::io(path, "write the file")))
}

fn folder(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Where the file really goes: a link keeps pointing at its target, and only a regular file is ever replaced.
fn destination(path: &Path) -> Result<PathBuf, Error> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => fs::canonicalize(path).map_err(Error::io(path, "follow the path")),
        // A rename would replace a device such as /dev/null by a file.
        Ok(_) => Err(Error::unwritable(path, "something that is not a regular file", "give the path of a file")),
        Err(_) => Ok(path.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, "old").unwrap();
        let failed = write_atomically(&path, |writer| {
            writer.write_all(b"half").unwrap();
            Err(Error::unwritable(&path, "x", "y"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.bin"]);
        write_atomically(&path, |writer| writer.write_all(b"new").map_err(Error::io(&path, "write"))).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn folders_and_missing_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(write_atomically(folder.path(), |_| Ok(())), Err(Error::Unwritable { .. })));
        let missing = folder.path().join("no/such/a.bin");
        assert!(matches!(write_atomically(&missing, |_| Ok(())), Err(Error::Io { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_files_are_as_readable_as_others() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_atomically(&link, |writer| writer.write_all(b"new").map_err(Error::io(&link, "write"))).unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&target), mode(&plain));
    }
}
