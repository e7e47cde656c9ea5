//! Destinations of files: checked before anything is evaluated, and written whole or not at all.

use crate::output_file::{ForeignFile, NoDestination, OutputError, OutputFile};
use crate::{Form, is_ours};
use std::collections::HashSet;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use trochoid_graph::resolved;
use trochoid_io::{Claim, Claims, Target};

/// Returns the folder of a file: the current one for a bare name.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn refuse(path: &Path, reason: NoDestination) -> OutputError {
    OutputError::Destination { path: path.into(), reason }
}

/// Checks whether a file can be written to a path, as far as that is possible in advance; changes nothing.
///
/// If the folder does not exist, its nearest existing ancestor is checked.
///
/// # Errors
/// The path is a folder, a file cannot have that name, or the folder does not accept files.
pub fn check_destination(path: &Path) -> Result<(), OutputError> {
    check_destinations([path]).pop().map_or(Ok(()), Err)
}

/// Checks many files like [`check_destination`]: every name, and every folder once.
pub fn check_destinations<'p>(paths: impl IntoIterator<Item = &'p Path>) -> Vec<OutputError> {
    let mut folders = HashSet::new();
    let fault = |path: &'p Path| {
        // The final location of the file is checked: a link to a file that does not exist yet is followed.
        let leads_to = if path.is_symlink() { resolved(path) } else { path.into() };
        let checked = check_name(path, &leads_to).and_then(|folder| match folders.insert(folder.clone()) {
            true => check_folder(path, &folder),
            false => Ok(()),
        });
        checked.err()
    };
    paths.into_iter().filter_map(fault).collect()
}

/// Checks the name of a file; returns its nearest existing ancestor.
fn check_name(path: &Path, leads_to: &Path) -> Result<PathBuf, OutputError> {
    if path.is_dir() {
        return Err(refuse(path, NoDestination::Folder));
    }
    if leads_to.is_symlink() {
        return Err(refuse(path, NoDestination::Loop));
    }
    let mut folder: PathBuf = folder_of(leads_to).into();
    let mut names = vec![leads_to.file_name().unwrap_or_default().to_owned()];
    while fs::symlink_metadata(&folder).is_err() {
        names.extend(folder.file_name().map(ToOwned::to_owned));
        // A relative path of missing folders starts at the current folder.
        folder = match folder.parent() {
            Some(above) if !above.as_os_str().is_empty() => above.into(),
            _ => ".".into(),
        };
    }
    // Looking a name up tells whether the system accepts it.
    let lookups = names.iter().map(|name| folder.join(name)).chain([leads_to.into()]);
    for error in lookups.filter_map(|path| fs::symlink_metadata(path).err()) {
        if matches!(error.kind(), ErrorKind::InvalidFilename | ErrorKind::InvalidInput) {
            return Err(refuse(path, NoDestination::Name(error)));
        }
    }
    Ok(folder)
}

fn check_folder(path: &Path, folder: &Path) -> Result<(), OutputError> {
    if !folder.is_dir() {
        return Err(refuse(path, NoDestination::NoFolder(folder.into())));
    }
    let cannot = |source| refuse(path, NoDestination::Closed { folder: folder.into(), source });
    tempfile::tempfile_in(folder).map(drop).map_err(cannot)
}

/// Checks whether a picture may be written to a path: if nothing is there, or a picture of the same kind that Trochoid
/// [wrote](is_ours), or, with `overwrites`, any file.
///
/// # Errors
/// Another file is there.
pub fn check_replaced(path: &Path, overwrites: bool) -> Result<(), OutputError> {
    check_replaced_by(path, Form::of_picture(path), overwrites)
}

/// Checks a file of any form like [`check_replaced`]: a file that Trochoid wrote in another form needs `overwrites`,
/// too.
///
/// # Errors
/// As [`check_replaced`].
pub fn check_replaced_by(path: &Path, form: Form, overwrites: bool) -> Result<(), OutputError> {
    let is_file = fs::metadata(path).is_ok_and(|found| found.is_file());
    if overwrites || !is_file || is_ours(path, form) {
        Ok(())
    } else {
        Err(OutputError::Foreign(ForeignFile { path: path.into() }))
    }
}

/// Returns a target that replaces only [our own files](is_ours) of the same form, unless `overwrites` is set. This is
/// checked when the file is complete.
pub fn target(path: &Path, form: Form, overwrites: bool) -> Target {
    let target = Target::from(path);
    if overwrites { target } else { target.replacing(move |found| is_ours(found, form)) }
}

/// Writes a file like [`write_whole`], replacing only [our own files](is_ours) of the same form unless `overwrites` is
/// set.
///
/// # Errors
/// As [`write_whole`], or another file is there.
pub fn write_guarded(path: &Path, bytes: &[u8], form: Form, overwrites: bool) -> Result<(), OutputError> {
    write(path, bytes, target(path, form, overwrites))
}

/// Creates the folder of a file; if the path is a link, the folder of its destination.
pub(crate) fn make_folder_of(path: &Path) -> std::io::Result<()> {
    let leads_to = if fs::metadata(path).is_err() { resolved(path) } else { path.into() };
    fs::create_dir_all(folder_of(&leads_to))
}

/// Claims a file that several runs may write, and makes its folder; `None` if another run has claimed it.
///
/// # Errors
/// The folder cannot be made, or accepts no files.
pub fn claim(claims: &Claims, file: &OutputFile) -> Result<Option<Claim>, OutputError> {
    folder_of_file(&file.path)?;
    Ok(claims.claim(&file.path)?)
}

/// Creates the folder of a file; the error names the folder.
pub(crate) fn folder_of_file(path: &Path) -> Result<(), OutputError> {
    make_folder_of(path).map_err(|source| OutputError::Folder { path: path.parent().unwrap_or(path).into(), source })
}

/// Writes a file, which appears whole or not at all, and creates missing folders. A pipe or a device is written to
/// directly.
///
/// # Errors
/// The folder cannot be created, or the file cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write(path, bytes, path.into())
}

fn write(path: &Path, bytes: &[u8], target: Target) -> Result<(), OutputError> {
    let cannot = |error: std::io::Error| refuse(path, NoDestination::Write(error));
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => fs::write(path, bytes).map_err(cannot),
        found => {
            if found.is_err() {
                make_folder_of(path).map_err(cannot)?;
            }
            Ok(trochoid_io::write_bytes(target, bytes)?)
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
        assert!(error.to_string().contains("is not a folder"), "{error}");
    }

    #[test]
    fn names_that_a_system_does_not_take_are_told_without_a_trace() {
        let folder = tempfile::tempdir().expect("a folder");
        let long = "n".repeat(300);
        for name in [format!("{long}.exr"), format!("new/{long}.exr"), format!("new/{long}/a.exr")] {
            let error = check_destination(&folder.path().join(&name)).expect_err(&name).to_string();
            assert!(error.contains("shorter"), "{error}");
        }
        check_destination(&folder.path().join(format!("new/{}.exr", "n".repeat(200)))).expect("can be made");
        let deep = folder.path().join("deep/".repeat(1000)).join("a.exr");
        assert!(check_destination(&deep).is_err());
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 0);
    }

    #[test]
    fn files_of_others_are_not_replaced_unasked() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.json");
        fs::write(&path, "theirs").expect("written");
        assert!(matches!(check_replaced_by(&path, Form::Report, false), Err(OutputError::Foreign(_))));
        check_replaced_by(&path, Form::Report, true).expect("asked for");
        let error = write_guarded(&path, b"{}", Form::Report, false).expect_err("theirs").to_string();
        assert!(error.ends_with("move the existing file away"), "{error}");
        assert_eq!(fs::read_to_string(&path).expect("there"), "theirs");
        let ours = format!("{{\"status\": \"done\", \"trochoid\": \"{}\"}}", crate::VERSION);
        write_guarded(&path, ours.as_bytes(), Form::Report, true).expect("asked for");
        write_guarded(&path, ours.as_bytes(), Form::Report, false).expect("ours");
        assert!(write_guarded(&path, ours.as_bytes(), Form::Plan, false).is_err(), "ours, but no plan");
        assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 1);
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
