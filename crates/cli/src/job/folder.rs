//! The folder of a job.

use super::Files;
use crate::failure::{FAILED, Failure};
use crate::{files, interrupt, remedies};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use trochoid::{InputFiles, check_destinations, io};

/// Name of the file that lists the files of a job, by which a folder is known as one.
const LIST: &str = "trochoid-job.json";

/// Most bytes of that file.
const LONGEST: u64 = 256 << 20;

/// Names of files which an engine reads, so that they may not stay when the job has none of that name.
pub(super) const SCRIPTS: [&str; 5] = ["template.json", "parameter_values.json", "job.sh", "join.sh", "submit.sh"];

/// What is written to a path.
#[derive(Clone, Debug)]
pub(super) enum Content {
    Text(String),
    /// A copy of this file.
    Copy(PathBuf),
}

/// A folder, and the files that a job has there.
pub(super) struct Folder<'a> {
    path: &'a Path,
    files: Files,
    /// Scripts of a former job of the folder, which this one does not have.
    former: Vec<PathBuf>,
}

impl<'a> Folder<'a> {
    /// Checks that a folder is new, empty, or one of a job, and that only files of a job are replaced in it.
    ///
    /// # Errors
    /// It has other files, or a file cannot be written.
    pub(super) fn check(path: &'a Path, files: Files, inputs: &InputFiles) -> Result<Self, Failure> {
        let listed = listed(path)?;
        let mut faults = Vec::new();
        for (name, _) in &files {
            let at = path.join(name);
            faults.extend(files::input(&at, inputs));
            if !listed.contains(name) && at.symlink_metadata().is_ok() {
                let message = format!("{}: exists already, and no job wrote it", at.display());
                faults.push(Failure::usage(message, "move it away, or name another folder"));
            }
        }
        let written: Vec<PathBuf> = files.iter().map(|(name, _)| path.join(name)).collect();
        faults.extend(check_destinations(written.iter().map(PathBuf::as_path)).into_iter().map(Failure::from));
        Failure::all(faults)?;
        let is_former = |name: &&str| listed.contains(*name) && !files.iter().any(|(file, _)| file == name);
        let former = SCRIPTS.into_iter().filter(is_former).map(|name| path.join(name)).collect();
        Ok(Self { path, files, former })
    }

    /// Writes all files, each whole or not at all; the list of them first, so that an interrupted job can be written
    /// again.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub(super) fn write(&self) -> Result<(), Failure> {
        let names: Vec<&str> = self.files.iter().map(|(name, _)| name.as_str()).collect();
        // What a former job copied stays, and may be replaced by the next one.
        let all: BTreeSet<String> =
            listed(self.path)?.into_iter().chain(names.iter().map(ToString::to_string)).collect();
        self.list(&all)?;
        for former in &self.former {
            match std::fs::remove_file(former) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(Failure::new(FAILED, format!("{}: cannot be removed: {error}", former.display())));
                }
                _ => {}
            }
        }
        for (name, content) in &self.files {
            if interrupt::asked() {
                return Err(Failure::interrupted());
            }
            let path = self.path.join(name);
            match content {
                Content::Text(text) => trochoid::write_whole(&path, text.as_bytes())?,
                Content::Copy(from) => {
                    let above = path.parent().unwrap_or(self.path);
                    std::fs::create_dir_all(above).map_err(|error| {
                        Failure::new(FAILED, format!("{}: the folder cannot be made: {error}", above.display()))
                    })?;
                    io::copy_file(from, &path).map_err(|error| Failure::new(FAILED, remedies::written(&error)))?;
                }
            }
        }
        Ok(())
    }

    fn list(&self, names: &BTreeSet<String>) -> Result<(), Failure> {
        let list = json!({ "trochoid_job": 1, "version": trochoid::VERSION, "files": names });
        Ok(trochoid::write_whole(&self.path.join(LIST), format!("{list:#}\n").as_bytes())?)
    }
}

/// Returns the files that jobs wrote to a folder: none if it is new or empty.
fn listed(path: &Path) -> Result<BTreeSet<String>, Failure> {
    let unreadable = |error: &dyn std::fmt::Display| Failure::new(FAILED, format!("{}: {error}", path.display()));
    match std::fs::read_dir(path) {
        Ok(mut entries) => {
            if entries.next().is_none() {
                return Ok(BTreeSet::new());
            }
        }
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(BTreeSet::new()),
        Err(error) if error.kind() == ErrorKind::NotADirectory => {
            let message = format!("{}: found a file; expected a folder", path.display());
            return Err(Failure::usage(message, "name a new folder"));
        }
        Err(error) => return Err(unreadable(&error)),
    }
    let list = path.join(LIST);
    let foreign = |found: &str| {
        let message = format!(
            "{}: found a folder with {found}; expected a new or empty one, or one that `trochoid job` wrote",
            path.display()
        );
        Failure::usage(message, "name another folder")
    };
    if !list.exists() {
        return Err(foreign("files of others"));
    }
    let text = io::read_text(&list, LONGEST).map_err(|error| unreadable(&error))?;
    let found: Value = serde_json::from_str(&text).unwrap_or_default();
    let files = found["files"].as_array().filter(|_| found["trochoid_job"] == 1);
    let names = files.ok_or_else(|| foreign(&format!("a {LIST} that lists no files")))?;
    Ok(names.iter().filter_map(Value::as_str).map(String::from).collect())
}
