//! Checks of the files of a run before anything is evaluated.

use super::args::Args;
use super::certify::Companions;
use super::chosen::Chosen;
use super::written::Written;
use crate::failure::{FAILED, Failure};
use crate::files;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use trochoid::io::{Limits, info};
use trochoid::{
    Access, CheckedGraph, Form, OutputFile, Right, check_destinations, outputs_lost, quoted, quoted_path,
    refused_outputs, resolved,
};

/// Outputs and frames that a run is to write.
pub(super) struct RequestedFiles<'a> {
    pub(super) graph: &'a CheckedGraph,
    pub(super) chosen: &'a Chosen,
    pub(super) args: &'a Args,
    pub(super) outputs: &'a [usize],
    pub(super) frames: &'a [i64],
}

impl RequestedFiles<'_> {
    /// Checks that every file can be written, that none is an input or the document itself, that no two are the same,
    /// and that none replaces a foreign file, outputs that this run does not write, or, as a draft, a larger picture.
    /// Returns the folders of the files.
    pub(super) fn check(&self, faults: &mut Vec<Failure>) -> BTreeSet<PathBuf> {
        let Self { graph, args, .. } = *self;
        let (files, companions) = match self.named() {
            Ok(named) => named,
            // A fault in a pattern is the same at every frame.
            Err(fault) => {
                faults.push(fault);
                return BTreeSet::new();
            }
        };
        let outside = match args.out {
            Some(_) => Vec::new(),
            None => refused_outputs(graph, self.outputs, self.frames),
        };
        faults.extend(args.files.reach.refused(graph, self.outputs, self.frames, outside));
        let inputs = files::inputs(graph, &args.graph, &args.assignments(), args.plan.as_deref().as_slice());
        let mut written = Written::new();
        faults.extend(files.iter().filter_map(|(_, file)| files::input(&file.path, &inputs)));
        faults.extend(files.iter().filter_map(|(_, file)| no_file(&file.path)));
        faults.extend(files.iter().filter_map(|(_, file)| taken_twice(&file.path, &mut written)));
        faults.extend(companions.iter().flat_map(|companions| companions.refusals(&inputs, &mut written)));
        let report = args.report.as_ref().filter(|_| !args.report_on_stdout());
        if let Some(report) = report {
            faults.extend(files::ending("--report", report, "json"));
            if written.contains_key(&resolved(report)) || inputs.contains(report) {
                let message = format!("--report {}: is a file of the document or of the run", quoted_path(report));
                faults.push(Failure::usage(message, "give the report another name"));
            }
            written.entry(resolved(report)).or_insert((report.clone(), Form::Report));
        }
        let mut all: Vec<&(PathBuf, Form)> = written.values().filter(|(path, _)| !inputs.contains(path)).collect();
        all.sort_unstable_by_key(|(path, _)| path);
        faults.extend(all.iter().filter_map(|(path, form)| args.files.over.foreign(path, *form)));
        faults.extend(self.lost(&files));
        faults.extend(self.larger(&files));
        faults.extend(check_destinations(all.iter().map(|(path, _)| path.as_path())).into_iter().map(Failure::from));
        written.keys().filter_map(|path| path.parent()).map(Path::to_path_buf).collect()
    }

    /// Returns the files of all frames that the run may write, and the companions of all files.
    #[expect(clippy::type_complexity, reason = "a pair of lists")]
    fn named(&self) -> Result<(Vec<(i64, OutputFile)>, Vec<Companions>), Failure> {
        // Files that the document may not write are named as well, so that all faults are reported at once.
        let named = self.graph.clone().with_access(Access::everything());
        let pattern = self.args.out.as_deref();
        let may_write = |file: &OutputFile| {
            let is_given = pattern.is_some() || file.outputs.iter().any(|index| !self.outputs.contains(index));
            is_given || self.graph.access().check_for(&file.path, Right::Write).is_ok()
        };
        let several = self.frames.len() > 1;
        let (mut written, mut companions) = (Vec::new(), Vec::new());
        for &frame in self.frames {
            let files = self.chosen.files(&named, self.args, frame, several)?;
            companions.extend(Companions::of(self.graph, self.args, &files, frame, several)?);
            written.extend(files.into_iter().filter(may_write).map(|file| (frame, file)));
        }
        Ok((written, companions))
    }

    /// Returns failures for files with outputs of the document that this run would not write again. Of consecutive
    /// failures with the same remedy, only the last has it.
    fn lost(&self, files: &[(i64, OutputFile)]) -> Vec<Failure> {
        if self.args.files.over.overwrite {
            return Vec::new();
        }
        let named = self.graph.clone().with_access(Access::everything());
        let lost = |(frame, file): &(i64, OutputFile)| {
            let lost = outputs_lost(&named, file, *frame);
            (!lost.is_empty()).then(|| (self.message_of_lost(file, &lost), self.remedy_of_lost(&lost)))
        };
        with_remedies(&files.iter().filter_map(lost).collect::<Vec<_>>())
    }

    /// Returns failures for larger pictures that a draft would replace: finished ones, as a rule, which are of the same
    /// name. Of consecutive failures with the same remedy, only the last has it.
    fn larger(&self, files: &[(i64, OutputFile)]) -> Vec<Failure> {
        if self.args.scale.is_none() || self.args.files.over.overwrite {
            return Vec::new();
        }
        let own = [self.graph.format().width(), self.graph.format().height()].map(|side| side as usize);
        let larger = |(_, file): &(i64, OutputFile)| {
            let found = info(&file.path, &Limits::default()).ok()?.parts.first()?.display;
            let found = [found.width(), found.height()];
            let is_larger = found[0] > own[0] || found[1] > own[1];
            let is_recipe = file.outputs.iter().any(|index| !self.outputs.contains(index));
            let option = if is_recipe { "--recipe" } else { "--out" };
            let message = || {
                let (path, [[width, height], [own_width, own_height]]) = (file.path.display(), [found, own]);
                format!(
                    "{path}: found a picture of {width} × {height} pixels, which this draft of {own_width} × {own_height} \
                     would replace; expected none that is larger"
                )
            };
            let remedy =
                || format!("give the draft another name with {option}, or replace the picture with --overwrite");
            is_larger.then(|| (message(), remedy()))
        };
        with_remedies(&files.iter().filter_map(larger).collect::<Vec<_>>())
    }

    fn names(&self, outputs: &[usize]) -> Vec<&str> {
        outputs.iter().map(|index| self.graph.outputs()[*index].name.as_str()).collect()
    }

    fn message_of_lost(&self, file: &OutputFile, lost: &[usize]) -> String {
        let (path, held, made) = (file.path.display(), self.names(lost), self.names(&file.outputs));
        let plural = if held.len() == 1 { "" } else { "s" };
        format!(
            "{path}: found the output{plural} {} in it, which this run of {} would discard; expected a run of all outputs \
             in the file",
            held.join(", "),
            made.join(", ")
        )
    }

    fn remedy_of_lost(&self, lost: &[usize]) -> String {
        let all = self.names(&[self.outputs, lost].concat());
        let options: Vec<String> = all.iter().map(|name| format!("--output {}", quoted(name))).collect();
        let options = options.join(" ");
        match &self.args.out {
            Some(_) => format!("give --out another name, or omit it and give {options}; or allow it: --overwrite"),
            None => {
                let name = if self.outputs.len() == 1 { all[0].to_owned() } else { "{output}".to_owned() };
                let other = quoted(&format!("{name}.####.exr"));
                format!(
                    "render all of them: {options}; or give another name, such as --out {other}; or allow it: \
                     --overwrite"
                )
            }
        }
    }
}

/// Returns failures with these messages and remedies; of consecutive ones with the same remedy, only the last has it.
fn with_remedies(faults: &[(String, String)]) -> Vec<Failure> {
    let next = faults.iter().skip(1).map(Some).chain([None]);
    let failure = |((message, remedy), next): (&(String, String), Option<&(String, String)>)| {
        let is_last = next.is_none_or(|(_, next)| next != remedy);
        Failure::usage(message, if is_last { remedy } else { "" })
    };
    faults.iter().zip(next).map(failure).collect()
}

/// Returns a failure if the path of a picture is a device or a pipe.
fn no_file(path: &Path) -> Option<Failure> {
    let is_other = std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    let message = || format!("{}: found a device or a pipe; expected a file", path.display());
    is_other.then(|| Failure::new(FAILED, message() + "\n  remedy: give the path of a file"))
}

/// Returns a failure if a link makes the file of a picture the same as another file of the run.
fn taken_twice(path: &Path, written: &mut Written) -> Option<Failure> {
    let other = written.insert(resolved(path), (path.into(), Form::of_picture(path)))?;
    let (path, other) = (path.display(), other.0.display());
    let message = format!("{path}: is the same file as {other}, so one picture would be lost; expected two files");
    Some(Failure::usage(message, "remove the link between them, or give another name"))
}
