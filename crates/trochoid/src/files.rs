//! Where files go: looked at before anything is evaluated, and written whole or not at all.

use crate::OutputError;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of a file; the current one for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn refuse(path: &Path, reason: impl ToString) -> OutputError {
    OutputError::Destination { path: path.into(), reason: reason.to_string() }
}

/// Whether a file can be written there, as far as can be told beforehand; changes nothing.
///
/// Its folder need not exist: what counts then is the nearest one above that does.
///
/// # Errors
/// Something else stands in its place, or its folder takes no files.
pub fn check_destination(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Err(refuse(path, "is a folder; name a file"));
    }
    let mut folder: PathBuf = folder_of(path).into();
    while fs::symlink_metadata(&folder).is_err() {
        // A path of missing folders alone starts at the current one.
        folder = match folder.parent() {
            Some(above) if !above.as_os_str().is_empty() => above.into(),
            _ => ".".into(),
        };
    }
    if !folder.is_dir() {
        return Err(refuse(path, format!("{} is no folder", folder.display())));
    }
    match tempfile::tempfile_in(&folder) {
        Ok(_) => Ok(()),
        Err(error) => Err(refuse(path, format!("the folder {} takes no files: {error}", folder.display()))),
    }
}

/// Writes a file that appears whole or not at all; folders are made. What is no regular file (a pipe, a device) is
/// written to as it stands.
///
/// # Errors
/// The folder cannot be made, or the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let cannot = |error: std::io::Error| refuse(path, format!("cannot be written: {error}"));
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => fs::write(path, bytes).map_err(cannot),
        found => {
            if found.is_err() {
                fs::create_dir_all(folder_of(path)).map_err(cannot)?;
            }
            Ok(trochoid_io::write_bytes(path, bytes)?)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn destinations_are_looked_at_without_a_trace() {
        let folder = tempfile::tempdir().expect("a folder");
        check_destination(&folder.path().join("new/folders/a.exr")).expect("can be made");
        check_destination(Path::new("a.exr")).expect("the current folder");
        assert!(check_destination(folder.path()).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 0);
        fs::write(folder.path().join("file"), "").expect("written");
        let error = check_destination(&folder.path().join("file/a.exr")).expect_err("below a file");
        assert!(error.to_string().contains("is no folder"), "{error}");
    }

    #[test]
    fn whole_files_replace_old_ones() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sub/report.json");
        for text in ["old", "new"] {
            write_whole(&path, text.as_bytes()).expect("written");
            assert_eq!(fs::read_to_string(&path).expect("there"), text);
        }
        assert_eq!(fs::read_dir(folder.path().join("sub")).expect("there").count(), 1);
        assert!(write_whole(folder.path(), b"x").is_err());
    }
}
