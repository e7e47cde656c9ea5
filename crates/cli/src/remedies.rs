//! Options of the command line as remedies of the library's errors, which name no options themselves: they carry what can
//! be allowed, chosen or set.

use crate::failure::{FAILED, Failure};
use serde_json::Value;
use std::path::Path;
use trochoid::{
    AccessViolation, Diagnostic, EvalError, Means, MeasureError, NameFault, NamePlace, NodeError, RecipeError,
    RefusedFile, folders_to_allow, io, quoted, quoted_path,
};
use trochoid_terminal::enough_memory;

/// Remedy of an existing file that is not Trochoid's.
pub(crate) const REPLACE: &str = "give another name, or replace it with --overwrite";

/// Returns the options that allow some files.
pub(crate) fn allow<'o>(files: impl IntoIterator<Item = &'o AccessViolation>) -> String {
    let folders = folders_to_allow(files);
    folders.iter().map(|folder| format!("--allow {}", quoted_path(folder))).collect::<Vec<_>>().join(" ")
}

fn trusted(files: &[AccessViolation]) -> String {
    let what = if files.len() == 1 { "this file" } else { "these files" };
    format!("if you trust the document with {what}: {}", allow(files))
}

/// Returns a remedy with its option.
fn with_option(remedy: &str, means: &Means) -> String {
    match means {
        Means::Allow(files) => trusted(files),
        Means::EditDocument { key } => {
            format!("change \"{key}\" in the document itself: --set changes only nodes and the palette")
        }
        Means::ChooseOutput => format!("{remedy} with --output"),
        Means::Decompose { picture } => {
            let taken_apart = taken_apart(picture, "--graph repainted.json");
            format!("for a picture, make one first: {taken_apart}")
        }
        _ => remedy.into(),
    }
}

/// Returns commands that take a picture apart over a palette of its own.
fn taken_apart(picture: &Path, into: &str) -> String {
    let picture = quoted_path(picture);
    format!("trochoid palette {picture} --out inks.json && trochoid decompose {picture} --palette inks.json {into}")
}

/// Returns commands that make a recipe of a picture, beside it.
fn recipe_of(picture: &Path) -> String {
    taken_apart(picture, &format!("--out {}", quoted_path(&picture.with_extension("recipe.exr"))))
}

/// Returns the failure of a recipe that is not read.
pub(crate) fn recipe(error: &RecipeError) -> Failure {
    match error {
        RecipeError::Read(error) => Failure::new(FAILED, error),
        RecipeError::NoRecipe { path, .. } => {
            // Damaged recipes are EXR files, too, but have only weights.
            let has_colors = |channel: &io::ChannelInfo| matches!(channel.full_name.as_str(), "R" | "Y");
            let is_picture = io::info(path, &io::Limits::default())
                .is_ok_and(|found| found.parts.iter().flat_map(|part| &part.channels).any(has_colors));
            let render = "render its document with --recipe FILE";
            let remedy = if is_picture { format!("{render}, or make one: {}", recipe_of(path)) } else { render.into() };
            Failure::usage(error, remedy)
        }
    }
}

/// Returns commands that make a recipe over colors alone of one to which images contribute.
pub(crate) fn without_images(recipe: &Path) -> String {
    let picture = recipe.with_extension("png");
    let (from, to) = (quoted_path(recipe), quoted_path(&picture));
    format!("take the finished picture apart: trochoid recolor {from} --out {to} && {}", recipe_of(&picture))
}

/// Returns a diagnostic with the options that contain the fault and remedy it.
pub(crate) fn diagnostic(fault: &Diagnostic) -> Diagnostic {
    let mut fault = fault.clone();
    if std::mem::take(&mut fault.is_assigned) {
        fault.file = match fault.file.strip_prefix("view=") {
            Some(node) => format!("--view {}", quoted(node)),
            None => format!("--set {}", fault.file),
        };
    }
    if let Some(means) = fault.means.take() {
        fault.remedy = with_option(&fault.remedy, &means);
    }
    fault
}

/// Returns diagnostics as texts.
pub(crate) fn texts(faults: &[Diagnostic]) -> Vec<String> {
    faults.iter().map(|fault| diagnostic(fault).to_string()).collect()
}

/// Returns diagnostics as JSON.
pub(crate) fn values(faults: &[Diagnostic]) -> Vec<Value> {
    faults.iter().map(|fault| diagnostic(fault).to_json()).collect()
}

/// Returns the description of a fault in the names of files and its remedy; `option` gives their pattern.
pub(crate) fn name(fault: &NameFault, option: &str) -> (String, String) {
    let place = match &fault.place {
        NamePlace::Pattern(pattern) => format!("{option} {}", quoted(pattern)),
        place => place.to_string(),
    };
    let remedy = fault.means.as_ref().map_or_else(|| fault.remedy.clone(), |means| with_option(&fault.remedy, means));
    (format!("{place}: {}", fault.found), remedy)
}

/// Returns the message of an evaluation that failed, with its remedy in the same line.
pub(crate) fn evaluation(failed: &EvalError) -> String {
    match failed {
        EvalError::Node { node, error: NodeError::Missing { knob, .. }, .. } => {
            format!("{failed}, or to try it by --set {node}.{knob}=…")
        }
        EvalError::Node { place, node, ty, error } => match error.source().and_then(|error| error.downcast_ref()) {
            Some(refused @ RefusedFile { outside, .. }) => {
                let (found, expected) = (refused.found(), outside.expected());
                let remedy = trusted(std::slice::from_ref(outside));
                format!("{place}: node \"{node}\" ({ty}): found {found}; expected {expected}; {remedy}")
            }
            None => failed.to_string(),
        },
        EvalError::TooMuchMemory { total, .. } => {
            format!("{failed}; or allow more: --memory {}", enough_memory(*total))
        }
        _ => failed.to_string(),
    }
}

/// Returns the message of a measurement that failed, in the same way.
pub(crate) fn measuring(failed: &MeasureError) -> String {
    match failed {
        MeasureError::Evaluate(error) => evaluation(error),
        MeasureError::Plan(error) => error.to_string(),
    }
}

/// Returns the message of a file that was not written, in the same way.
pub(crate) fn written(failed: &io::Error) -> String {
    match failed {
        io::Error::Foreign { path } => {
            let path = path.display();
            format!(
                "{path}: the file cannot be written: the existing file is not Trochoid's: give another name, or use --overwrite"
            )
        }
        _ => failed.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_allow_each_folder_once_as_a_shell_takes_them() {
        let outside = |path: &str| AccessViolation { leads_to: path.into(), allowed: Vec::new() };
        let paths = ["/a b/x.png", "/c/d/y.png", "/c/z.png", "/c/z2.png", "/it's/#1/x"].map(outside);
        assert_eq!(allow(&paths), r##"--allow '/a b' --allow /c --allow "/it's/#1""##);
        assert_eq!(trusted(&paths[..1]), "if you trust the document with this file: --allow '/a b'");
    }

    #[test]
    fn a_file_of_somebody_else_is_replaced_by_an_option() {
        let told = written(&io::Error::Foreign { path: "a.png".into() });
        assert!(told.starts_with("a.png: ") && told.ends_with("or use --overwrite"), "{told}");
    }
}
