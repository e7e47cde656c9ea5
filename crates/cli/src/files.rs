//! Files that a document may read and write, and files that a run may overwrite.

use crate::failure::{Failure, once};
use crate::{remedies, shell};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use trochoid::io::Target;
use trochoid::{
    Access, CheckedGraph, Diagnostic, Form, InputFiles, LoadError, Loaded, RefusedFile, check_destination,
    check_replaced_by, quoted_path, refusals, refused_files,
};

/// Whether this run has warned of `--allow` paths.
static WARNED: AtomicBool = AtomicBool::new(false);

/// Begins another run in this process.
pub(crate) fn warn_anew() {
    WARNED.store(false, Ordering::Relaxed);
}

/// Options for the files that a document may access.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct AccessOptions {
    /// Allow the document to read and write this file, or anything under this folder; may be repeated [default: its own
    /// folder and, if that lies under the current folder, the current folder]
    #[arg(long, value_name = "PATH")]
    pub(crate) allow: Vec<PathBuf>,
    /// Restrict the document to its own folder, for documents that you do not trust; --allow adds to that
    #[arg(long)]
    pub(crate) strict: bool,
}

impl AccessOptions {
    /// Returns the access rights of a document in this folder.
    pub(crate) fn access(&self, folder: &Path) -> Access {
        let own = if self.strict { Access::beneath(folder) } else { Access::usual(folder) };
        self.allow.iter().fold(own, |access, path| access.allowing(path))
    }

    /// Loads a document like [`trochoid::load`], with these access rights.
    ///
    /// # Errors
    /// As [`trochoid::load`].
    pub(crate) fn load(&self, path: &Path, set: &[String]) -> Result<Loaded, LoadError> {
        self.warn();
        trochoid::load_within(path, set, self.access(path.parent().unwrap_or(Path::new("."))))
    }

    /// Warns of `--allow` paths that do not exist, once per run.
    pub(crate) fn warn(&self) {
        if !WARNED.swap(true, Ordering::Relaxed) {
            shell::tell(&trochoid_terminal::missing(&self.allow));
        }
    }

    /// Returns the faults of files that a document may not access, each with a remedy that covers all of them.
    pub(crate) fn faults(&self, graph: &CheckedGraph, refused: &[RefusedFile]) -> Vec<Diagnostic> {
        let mut faults = refusals(refused);
        if self.strict {
            let usual = Self { strict: false, ..self.clone() }.access(graph.folder());
            let is_usual = |refused: &RefusedFile| usual.check(&refused.outside.leads_to).is_ok();
            let without = if refused.iter().all(is_usual) {
                "; or omit --strict, which allows everything under the current folder"
            } else {
                ""
            };
            let allowed = remedies::allow(refused.iter().map(|refused| &refused.outside));
            let remedy = format!("--strict restricts the document to its own folder: add {allowed}{without}");
            faults.iter_mut().for_each(|fault| (fault.remedy, fault.means) = (remedy.clone(), None));
        }
        faults
    }

    /// Returns a failure if the document may not access files that some outputs read at some frames, or if there are
    /// `more`.
    pub(crate) fn refused(
        &self,
        graph: &CheckedGraph,
        outputs: &[usize],
        frames: &[i64],
        more: Vec<RefusedFile>,
    ) -> Option<Failure> {
        let refused = [refused_files(graph, outputs, frames), more].concat();
        (!refused.is_empty()).then(|| LoadError::Invalid(once(self.faults(graph, &refused))).into())
    }
}

/// Options for the files that a document may access and that a run may overwrite.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct FileOptions {
    #[command(flatten)]
    pub(crate) reach: AccessOptions,
    #[command(flatten)]
    pub(crate) over: OverwriteOptions,
}

/// Options for overwriting files.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct OverwriteOptions {
    /// Also replace files that Trochoid did not write, that are of another kind, or that contain outputs which this
    /// run does not write; inputs of the document are never replaced
    #[arg(long)]
    pub(crate) overwrite: bool,
}

impl FileOptions {
    /// Loads a document like [`AccessOptions::load`], with the right to overwrite.
    ///
    /// # Errors
    /// As [`AccessOptions::load`].
    pub(crate) fn load(&self, path: &Path, set: &[String]) -> Result<Loaded, LoadError> {
        let Loaded { graph, warnings } = self.reach.load(path, set)?;
        let access = graph.access().clone().overwriting(self.over.overwrite);
        Ok(Loaded { graph: graph.with_access(access), warnings })
    }
}

impl OverwriteOptions {
    /// Returns why a file cannot be written to a path, as far as that can be checked in advance: the path is an input,
    /// has a foreign file, or cannot be created.
    pub(crate) fn refusal(self, path: &Path, form: Form, inputs: &InputFiles) -> Option<Failure> {
        let cannot = || check_destination(path).err().map(Failure::from);
        input(path, inputs).or_else(|| self.foreign(path, form)).or_else(cannot)
    }

    /// Returns the target for writing a file.
    pub(crate) fn target(self, path: &Path, form: Form) -> Target {
        trochoid::target(path, form, self.overwrite)
    }

    /// Returns why the existing file must not be replaced.
    pub(crate) fn foreign(self, path: &Path, form: Form) -> Option<Failure> {
        check_replaced_by(path, form, self.overwrite).err().map(Failure::from)
    }
}

/// Returns the files that a document reads with and without `--set`, the document itself, and the files in `also`.
pub(crate) fn inputs(graph: &CheckedGraph, path: &Path, set: &[String], also: &[&Path]) -> InputFiles {
    let inputs = InputFiles::new(graph, &[&[path], also].concat());
    if set.is_empty() {
        return inputs;
    }
    // A document that is valid only with `--set` reads nothing without it.
    match trochoid::load(path, &[]) {
        Ok(plain) => inputs.and(InputFiles::new(&plain.graph, &[])),
        Err(_) => inputs,
    }
}

/// Returns a failure if a path has an extension other than `known`, unless it is a folder, a device or a pipe.
pub(crate) fn ending(option: &str, path: &Path, known: &str) -> Option<Failure> {
    let is_known = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(known));
    // A folder is reported as a folder elsewhere.
    let is_other = std::fs::metadata(path).is_ok_and(|found| !found.is_file());
    (!is_known && !is_other).then(|| {
        let found =
            path.extension().map_or("no extension".into(), |ending| format!("the extension .{}", ending.display()));
        let message = format!("{option} {}: found {found}; expected .{known}", quoted_path(path));
        Failure::usage(message, format!("name it {}", quoted_path(&path.with_extension(known))))
    })
}

/// Returns a failure if a path is an input.
pub(crate) fn input(path: &Path, inputs: &InputFiles) -> Option<Failure> {
    inputs.contains(path).then(|| written_over(path))
}

/// Remedy for an output that would overwrite an input.
pub(crate) const ANOTHER_NAME: &str = "give the output another name";

/// Returns the failure of an output that would overwrite an input.
pub(crate) fn written_over(path: &Path) -> Failure {
    let message = format!("{}: is an input of the document and would be overwritten", path.display());
    Failure::usage(message, ANOTHER_NAME)
}

impl From<Diagnostic> for Failure {
    fn from(fault: Diagnostic) -> Self {
        LoadError::Invalid(vec![fault]).into()
    }
}
