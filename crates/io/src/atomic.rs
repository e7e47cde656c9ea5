//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::Error;
use crate::partial::Temporary;

/// Destination of a file, and the files that it may replace: by default, any.
///
/// ```
/// use trochoid_io::{Target, read_bytes, write_bytes};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.txt");
/// let careful = || Target::from(&path).replacing(|found| read_bytes(found, 3).is_ok_and(|bytes| bytes == b"old"));
/// write_bytes(careful(), b"old")?;
/// write_bytes(careful(), b"new")?;
/// assert!(write_bytes(careful(), b"newer").is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Target {
    path: PathBuf,
    may_replace: Option<MayReplace>,
}

/// Function that tells whether the file at a path may be replaced.
type MayReplace = Arc<dyn Fn(&Path) -> bool + Send + Sync>;

impl std::fmt::Debug for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Target").field("path", &self.path).finish_non_exhaustive()
    }
}

impl<P: AsRef<Path>> From<P> for Target {
    fn from(path: P) -> Self {
        Self { path: path.as_ref().into(), may_replace: None }
    }
}

impl Target {
    /// Returns the target with a condition: a file is replaced only if `may_replace` allows it, which is called as late
    /// as possible.
    #[must_use]
    pub fn replacing(self, may_replace: impl Fn(&Path) -> bool + Send + Sync + 'static) -> Self {
        Self { may_replace: Some(Arc::new(may_replace)), ..self }
    }

    /// Returns the path of the target.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Unfinished file, which has a temporary name in the same folder until it takes its place.
///
/// At any time the path has the old file or the new one. If the value is dropped, the old file stays and nothing else.
pub(crate) struct AtomicFile {
    path: PathBuf,
    target: PathBuf,
    may_replace: Option<MayReplace>,
    pub(crate) writer: BufWriter<File>,
    temporary: Temporary,
}

impl AtomicFile {
    /// Creates an empty temporary file.
    pub(crate) fn create(to: &Target) -> Result<Self, Error> {
        let path = to.path();
        let target = destination(path)?;
        let (file, temporary) =
            Temporary::create(folder(&target)).map_err(Error::io(path, "create a file in the folder"))?;
        Ok(Self {
            path: path.into(),
            target,
            may_replace: to.may_replace.clone(),
            writer: BufWriter::new(file),
            temporary,
        })
    }

    /// Moves the finished file to its place.
    pub(crate) fn commit(self) -> Result<(), Error> {
        let Self { path, target, may_replace, mut writer, temporary } = self;
        writer.flush().map_err(Error::io(&path, "write the file"))?;
        // Synced before the name changes: after a power failure the name must not lead to missing bytes.
        writer.get_ref().sync_all().map_err(Error::io(&path, "write the file to disk"))?;
        if let Some(may_replace) = may_replace
            && fs::metadata(&target).is_ok_and(|found| found.is_file())
            && !may_replace(&target)
        {
            return Err(Error::Foreign { path });
        }
        // The file stays open until it has its name: a locked file is not taken for an abandoned one.
        temporary.persist(&target).map_err(Error::io(&path, "rename the finished file"))?;
        drop(writer);
        #[cfg(unix)]
        if let Ok(folder) = File::open(folder(&target)) {
            // Makes the new name durable. Some file systems refuse this; the picture is complete either way.
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

/// Writes a whole [`AtomicFile`]. If `fill` or any step fails, the old file is untouched.
pub(crate) fn write_atomically(
    to: &Target,
    fill: impl FnOnce(&mut BufWriter<File>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut file = AtomicFile::create(to)?;
    fill(&mut file.writer)?;
    file.commit()
}

/// Writes bytes to a file, which appears whole or not at all.
///
/// # Errors
/// The path is not a regular file, or the file cannot be written; an existing file is untouched then.
pub fn write_bytes(to: impl Into<Target>, bytes: &[u8]) -> Result<(), Error> {
    write_parts(to, &[bytes])
}

/// Writes bytes that lie in several places to a file, like [`write_bytes`].
///
/// # Errors
/// As [`write_bytes`].
pub fn write_parts(to: impl Into<Target>, parts: &[&[u8]]) -> Result<(), Error> {
    let to = to.into();
    write_atomically(&to, |writer| {
        parts.iter().try_for_each(|part| writer.write_all(part)).map_err(Error::io(to.path(), "write the file"))
    })
}

/// Lets another program write a file, which appears whole or not at all: `write` is called with a temporary name, of an
/// empty file that the program replaces or fills. Then `end` is added.
///
/// # Errors
/// `write` fails, or the file cannot be written; an existing file is untouched then.
pub fn write_by<E: From<Error>>(
    to: impl Into<Target>,
    end: &[u8],
    write: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
    let to = to.into();
    let mut file = AtomicFile::create(&to)?;
    write(file.temporary.name())?;
    let ended = file.writer.seek(SeekFrom::End(0)).and_then(|_| file.writer.write_all(end));
    ended.map_err(Error::io(to.path(), "write the file"))?;
    Ok(file.commit()?)
}

/// Copies a regular file with its time of change; the copy appears whole or not at all.
///
/// # Errors
/// The file cannot be read or is not a regular file, or the copy cannot be written.
pub fn copy_file(from: impl AsRef<Path>, to: impl Into<Target>) -> Result<(), Error> {
    let (from, to) = (from.as_ref(), to.into());
    let mut source = crate::open_file(from)?.file;
    let changed = source.metadata().and_then(|found| found.modified()).map_err(Error::io(from, "read the file"))?;
    write_atomically(&to, |writer| {
        let written = std::io::copy(&mut source, writer).map(drop).and_then(|()| writer.flush());
        written.and_then(|()| writer.get_ref().set_modified(changed)).map_err(Error::io(to.path(), "write the file"))
    })
}

fn folder(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Maximum number of dangling links that are followed one after another.
const MOST_LINKS: usize = 40;

/// Returns the actual destination: links are followed and stay, and only regular files are replaced.
fn destination(path: &Path) -> Result<PathBuf, Error> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => return fs::canonicalize(path).map_err(Error::io(path, "follow the path")),
        // Renaming would replace a device such as /dev/null with a file.
        Ok(_) => {
            return Err(Error::unwritable(path, "something that is not a regular file", "give the path of a file"));
        }
        Err(_) => {}
    }
    // A dangling link stays, and the file is created where it leads.
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&target) {
            Ok(link) => target = folder(&target).join(link),
            Err(_) => return Ok(target),
        }
    }
    Err(Error::unwritable(path, "a link that leads to itself", "remove the link, or give another name"))
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
        let failed = write_atomically(&Target::from(&path), |writer| {
            writer.write_all(b"half").unwrap();
            Err(Error::unwritable(&path, "x", "y"))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.bin"]);
        write_atomically(&Target::from(&path), |writer| writer.write_all(b"new").map_err(Error::io(&path, "write")))
            .unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn copies_have_the_time_of_change_and_are_whole_or_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let [from, to] = ["a.bin", "b.bin"].map(|name| folder.path().join(name));
        fs::write(&from, [7; 100_000]).unwrap();
        let then = std::time::UNIX_EPOCH + std::time::Duration::from_secs(1);
        File::options().write(true).open(&from).unwrap().set_modified(then).unwrap();
        copy_file(&from, &to).unwrap();
        assert_eq!(fs::read(&to).unwrap(), [7; 100_000]);
        assert_eq!(fs::metadata(&to).unwrap().modified().unwrap(), then);
        assert!(copy_file(folder.path(), &to).is_err() && copy_file(folder.path().join("none"), &to).is_err());
        assert_eq!(fs::read(&to).unwrap().len(), 100_000);
        copy_file(&to, &to).unwrap();
        assert_eq!(fs::read(&to).unwrap(), [7; 100_000]);
        assert_eq!(names(folder.path()).len(), 2);
    }

    #[test]
    fn folders_and_missing_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(write_atomically(&folder.path().into(), |_| Ok(())), Err(Error::Unwritable { .. })));
        let missing = folder.path().join("no/such/a.bin");
        assert!(matches!(write_atomically(&Target::from(&missing), |_| Ok(())), Err(Error::Io { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_files_are_as_readable_as_others() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (target, link) = (folder.path().join("target"), folder.path().join("link"));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_atomically(&Target::from(&link), |writer| writer.write_all(b"new").map_err(Error::io(&link, "write")))
            .unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        // So are dangling links, one after another.
        fs::remove_file(&target).unwrap();
        std::os::unix::fs::symlink("link", folder.path().join("second")).unwrap();
        write_bytes(folder.path().join("second"), b"made").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"made");
        assert!(["link", "second"].iter().all(|name| folder.path().join(name).is_symlink()));
        std::os::unix::fs::symlink("loop", folder.path().join("loop")).unwrap();
        assert!(matches!(write_bytes(folder.path().join("loop"), b""), Err(Error::Unwritable { .. })));
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&target), mode(&plain));
    }
}
