//! Opening of files for reading, which all other code uses.
//!
//! A path may lead to anything: a pipe without a writer, an endless device, a folder. The type of the file is checked
//! before it is opened, since opening a device can have effects, and again afterward, since another file may have taken
//! its place. Files are opened without waiting, so that nothing blocks even then.

use std::fs::{File, FileType, Metadata, OpenOptions};
use std::io::Read;
use std::path::Path;

use crate::Error;
use crate::error::OPEN;

const READ: &str = "read the file";

/// Regular file opened for reading.
#[derive(Debug)]
pub struct OpenFile {
    /// The open file, at its start.
    pub file: File,
    /// Length in bytes when the file was opened, which is all that need be read of a growing file.
    pub length: u64,
}

impl OpenFile {
    /// Returns a reader of the bytes that the file had when it was opened.
    pub fn reader(self) -> std::io::Take<File> {
        self.file.take(self.length)
    }
}

/// Opens a regular file for reading, or a link to one; never waits.
///
/// # Errors
/// The file cannot be opened, or is a folder, a pipe, a device or a socket.
pub fn open_file(path: impl AsRef<Path>) -> Result<OpenFile, Error> {
    let path = path.as_ref();
    regular(path, &std::fs::metadata(path).map_err(Error::io(path, OPEN))?)?;
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOCTTY);
    let file = options.open(path).map_err(Error::io(path, OPEN))?;
    let found = file.metadata().map_err(Error::io(path, OPEN))?;
    regular(path, &found)?;
    Ok(OpenFile { file, length: found.len() })
}

/// Reads a whole file of at most `at_most` bytes.
///
/// # Errors
/// As [`open_file`], or the file has more than `at_most` bytes.
pub fn read_bytes(path: impl AsRef<Path>, at_most: u64) -> Result<Vec<u8>, Error> {
    let path = path.as_ref();
    let OpenFile { file, length } = open_file(path)?;
    let too_long = |found| Error::TooLong { path: path.into(), found, limit: at_most };
    if length > at_most {
        return Err(too_long(length));
    }
    let mut bytes = Vec::new();
    file.take(at_most.saturating_add(1)).read_to_end(&mut bytes).map_err(Error::io(path, READ))?;
    // The file has grown since, or does not report its length.
    if bytes.len() as u64 > at_most { Err(too_long(bytes.len() as u64)) } else { Ok(bytes) }
}

/// Reads a whole file as text.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("a.json");
/// std::fs::write(&path, "{}")?;
/// assert_eq!(trochoid_io::read_text(&path, 2)?, "{}");
/// let error = trochoid_io::read_text(&path, 1).expect_err("too long").to_string();
/// assert!(error.ends_with("found 2 bytes, expected at most 1: make the file smaller, or name another"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`read_bytes`], or the file is not UTF-8.
pub fn read_text(path: impl AsRef<Path>, at_most: u64) -> Result<String, Error> {
    let path = path.as_ref();
    String::from_utf8(read_bytes(path, at_most)?).map_err(|error| {
        let (valid, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
        let line = valid.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let start = valid.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let column = String::from_utf8_lossy(&valid[start..]).chars().count() + 1;
        Error::NotText { path: path.into(), line, column, byte: rest[0] }
    })
}

fn regular(path: &Path, found: &Metadata) -> Result<(), Error> {
    if found.is_file() {
        return Ok(());
    }
    Err(Error::NotAFile { path: path.into(), found: described(found.file_type()) })
}

fn described(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    if kind.is_dir() { "a folder" } else { "something else" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |path: &Path| open_file(path).unwrap_err().to_string();
        assert!(refused(folder.path()).ends_with("found a folder, expected a file: name a file in it"));
        assert!(refused(&folder.path().join("none")).contains("correct the path"));
        #[cfg(unix)]
        {
            let pipe = folder.path().join("pipe");
            assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
            assert!(refused(&pipe).contains("found a pipe, expected a file"));
            let _listener = std::os::unix::net::UnixListener::bind(folder.path().join("socket")).unwrap();
            assert!(refused(&folder.path().join("socket")).contains("found a socket"));
            assert!(refused(Path::new("/dev/zero")).contains("found a device"));
            std::os::unix::fs::symlink(&pipe, folder.path().join("link")).unwrap();
            assert!(refused(&folder.path().join("link")).contains("found a pipe"));
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_pipe_that_takes_the_place_of_a_file_does_not_block() {
        let folder = tempfile::tempdir().unwrap();
        let (file, pipe) = (folder.path().join("file"), folder.path().join("pipe"));
        std::fs::write(&file, "text").unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = folder.path().join("link");
        let stop = std::sync::atomic::AtomicBool::new(false);
        let swap = |to: &Path| {
            let fresh = folder.path().join("fresh");
            std::os::unix::fs::symlink(to, &fresh).unwrap();
            std::fs::rename(&fresh, &link).unwrap();
        };
        swap(&file);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                    swap(&pipe);
                    swap(&file);
                }
            });
            for _ in 0..2000 {
                match read_text(&link, 10) {
                    Ok(text) => assert_eq!(text, "text"),
                    Err(error) => assert!(matches!(error, Error::NotAFile { found: "a pipe", .. }), "{error}"),
                }
            }
            stop.store(true, std::sync::atomic::Ordering::Relaxed);
        });
    }

    #[test]
    fn files_without_a_length_are_held_to_the_limit() {
        if cfg!(target_os = "linux") {
            // The system reports a length of 0 for this file.
            assert!(matches!(read_bytes("/proc/self/status", 10), Err(Error::TooLong { found: 11, limit: 10, .. })));
            assert!(read_text("/proc/self/status", 1 << 20).unwrap().contains("VmPeak"));
        }
    }

    #[test]
    fn what_is_no_text_is_told_by_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        std::fs::write(&path, b"one\n\xc3\xa4\xff").unwrap();
        let error = read_text(&path, 100).unwrap_err();
        assert!(matches!(error, Error::NotText { line: 2, column: 2, byte: 0xff, .. }), "{error}");
    }
}
