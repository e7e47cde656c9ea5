//! What a document may read and write, and what may be written over.

use crate::failure::{Failure, once};
use crate::remedies;
use std::path::{Path, PathBuf};
use std::sync::Once;
use trochoid::io::Target;
use trochoid::{
    Access, CheckedGraph, Diagnostic, Form, InputFiles, LoadError, Loaded, Refused, check_destination,
    check_replaced_by, quoted_path, refusals, refused_files,
};

/// Options of what a document may reach.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Reach {
    /// Let the document read and write this file, or what lies beneath this folder; may be repeated [default: beneath its own
    /// folder and, where that lies beneath the current one, beneath that]
    #[arg(long, value_name = "PATH")]
    pub(crate) allow: Vec<PathBuf>,
    /// Let the document read and write beneath its own folder alone: for documents of strangers
    #[arg(long)]
    pub(crate) strict: bool,
}

impl Reach {
    /// What a document of a folder may reach.
    pub(crate) fn access(&self, folder: &Path) -> Access {
        let own = if self.strict { Access::beneath(folder) } else { Access::usual(folder) };
        self.allow.iter().fold(own, |access, path| access.allowing(path))
    }

    /// Loads a document as [`trochoid::load`] does, under this rule.
    ///
    /// # Errors
    /// As [`trochoid::load`].
    pub(crate) fn load(&self, path: &Path, set: &[String]) -> Result<Loaded, LoadError> {
        self.warn();
        let Loaded { graph, warnings } = trochoid::load(path, set)?;
        let access = self.access(graph.folder());
        Ok(Loaded { graph: graph.with_access(access), warnings })
    }

    /// Warns of what is allowed and not there, once, however often a document is loaded.
    pub(crate) fn warn(&self) {
        static WARNED: Once = Once::new();
        WARNED.call_once(|| trochoid_terminal::warn_of_missing(&self.allow));
    }

    /// The faults of files that a document may not reach, each with the remedy for all.
    pub(crate) fn faults(&self, graph: &CheckedGraph, refused: &[Refused]) -> Vec<Diagnostic> {
        let mut faults = refusals(refused);
        if self.strict {
            let usual = Self { strict: false, ..self.clone() }.access(graph.folder());
            let is_usual = |refused: &Refused| usual.check(&refused.outside.leads_to).is_ok();
            let without = if refused.iter().all(is_usual) {
                "; or leave --strict out, so that it reaches all beneath the current folder"
            } else {
                ""
            };
            let allowed = remedies::allow(refused.iter().map(|refused| &refused.outside));
            let remedy = format!("--strict leaves the document its own folder alone: add {allowed}{without}");
            faults.iter_mut().for_each(|fault| (fault.remedy, fault.means) = (remedy.clone(), None));
        }
        faults
    }

    /// What is wrong with the files that some outputs read at some frames, and with `more`: the document may not reach them.
    pub(crate) fn refused(
        &self,
        graph: &CheckedGraph,
        outputs: &[usize],
        frames: &[i64],
        more: Vec<Refused>,
    ) -> Option<Failure> {
        let refused = [refused_files(graph, outputs, frames), more].concat();
        (!refused.is_empty()).then(|| LoadError::Invalid(once(self.faults(graph, &refused))).into())
    }
}

/// The same, and what may be written over.
#[derive(Clone, Debug, Default, clap::Args)]
pub(crate) struct Files {
    #[command(flatten)]
    pub(crate) reach: Reach,
    #[command(flatten)]
    pub(crate) over: Over,
}

/// Options of what may be written over.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct Over {
    /// Replace files that Trochoid did not write, or wrote as another kind of file, or with outputs that this run leaves out; inputs of the document are never replaced
    #[arg(long)]
    pub(crate) overwrite: bool,
}

impl Files {
    /// As [`Reach::load`].
    ///
    /// # Errors
    /// As [`Reach::load`].
    pub(crate) fn load(&self, path: &Path, set: &[String]) -> Result<Loaded, LoadError> {
        let Loaded { graph, warnings } = self.reach.load(path, set)?;
        let access = graph.access().clone().overwriting(self.over.overwrite);
        Ok(Loaded { graph: graph.with_access(access), warnings })
    }
}

impl Over {
    /// What is wrong with writing a file there, as far as can be told beforehand: it cannot be made, is an input, or somebody
    /// else's.
    pub(crate) fn refusal(self, path: &Path, form: Form, inputs: &InputFiles) -> Option<Failure> {
        let cannot = || check_destination(path).err().map(Failure::from);
        input(path, inputs).or_else(|| self.foreign(path, form)).or_else(cannot)
    }

    /// A file to be written.
    pub(crate) fn target(self, path: &Path, form: Form) -> Target {
        trochoid::target(path, form, self.overwrite)
    }

    /// What is wrong with replacing what is there.
    pub(crate) fn foreign(self, path: &Path, form: Form) -> Option<Failure> {
        check_replaced_by(path, form, self.overwrite).err().map(Failure::from)
    }
}

/// What a document reads, as it stands and as `--set` has it, with itself and other files that a run reads.
pub(crate) fn inputs(graph: &CheckedGraph, path: &Path, set: &[String], also: &[&Path]) -> InputFiles {
    let inputs = InputFiles::new(graph, &[&[path], also].concat());
    if set.is_empty() {
        return inputs;
    }
    // One that is valid by `--set` alone reads nothing without it.
    match trochoid::load(path, &[]) {
        Ok(plain) => inputs.and(InputFiles::new(&plain.graph, &[])),
        Err(_) => inputs,
    }
}

/// What is wrong with the ending of a file's name, unless it is a device or a pipe.
pub(crate) fn ending(option: &str, path: &Path, known: &str) -> Option<Failure> {
    let is_known = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(known));
    // Of a folder it is said that it is one.
    let is_other = std::fs::metadata(path).is_ok_and(|found| !found.is_file());
    (!is_known && !is_other).then(|| {
        let found = path.extension().map_or("no ending".into(), |ending| format!("the ending .{}", ending.display()));
        let message = format!("{option} {}: found {found}; expected .{known}", quoted_path(path));
        Failure::usage(message, format!("name it {}", quoted_path(&path.with_extension(known))))
    })
}

/// What is wrong with writing over an input.
pub(crate) fn input(path: &Path, inputs: &InputFiles) -> Option<Failure> {
    inputs.contains(path).then(|| written_over(path))
}

/// What to do about that.
pub(crate) const ANOTHER_NAME: &str = "give the output another name";

/// That an input would be written over.
pub(crate) fn written_over(path: &Path) -> Failure {
    let message = format!("{}: is an input of the document, and would be written over", path.display());
    Failure::usage(message, ANOTHER_NAME)
}

impl From<Diagnostic> for Failure {
    fn from(fault: Diagnostic) -> Self {
        LoadError::Invalid(vec![fault]).into()
    }
}
