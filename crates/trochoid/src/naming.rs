//! Names of the output files of frames, and checks of their patterns.

use crate::output_file::{NameFault, NamePlace, OutputError, OutputFile, layer};
use std::path::{Component, Path, PathBuf};
use trochoid_graph::{
    CheckedGraph, Kind, Means, OutputSpec, escape_frame, expand_frame, one_frame_pattern, quoted, resolved,
};

/// Faults without duplicates: the fault of a pattern is reported once, even if it names several outputs.
#[derive(Default)]
struct Faults(Vec<NameFault>);

impl Faults {
    fn add(&mut self, place: &NamePlace, found: impl Into<String>, remedy: impl Into<String>) {
        self.push(NameFault { place: place.clone(), found: found.into(), remedy: remedy.into(), means: None });
    }

    /// Adds the fault of one name for several outputs or files.
    fn add_shared(&mut self, place: &NamePlace, found: String) {
        let remedy = "add {output} to it, or choose one output".into();
        self.push(NameFault { place: place.clone(), found, remedy, means: Some(Means::ChooseOutput) });
    }

    fn push(&mut self, fault: NameFault) {
        if !self.0.contains(&fault) {
            self.0.push(fault);
        }
    }

    /// Adds the faults of a pattern. `written` is the pattern itself; `template` has the known placeholders replaced.
    fn of_pattern(&mut self, place: &NamePlace, written: &str, template: &str, several_frames: bool) {
        if let Some((_, rest)) = template.split_once('{') {
            let found = rest.split_once('}').map_or(rest, |(name, _)| name);
            let found = format!("\"{written}\" has the unknown placeholder {{{found}}}");
            self.add(place, found, "use {output}, #### or %04d");
        }
        if let Some(one) = one_frame_pattern(written) {
            let found = format!("found two frame patterns in \"{written}\"; expected one");
            let (json, word) = (serde_json::Value::from(one.as_str()), quoted(&one));
            let remedy = format!(
                "a # or % of the name itself has a backslash before it: such as {json} in a document, {word} in a shell"
            );
            self.add(place, found, remedy);
        }
        if several_frames && is_same_at_all_frames(template) {
            let remedy = format!("add #### or %04d to it, such as \"{}\"", with_frame(written));
            self.add(place, format!("\"{written}\" gives all frames one name"), remedy);
        }
    }
}

/// Pattern of the file of an output that names none.
pub const UNNAMED_FILE: &str = "{output}.####.exr";

/// Names the files of some outputs at a frame.
///
/// `pattern` is relative to the current folder and may contain `{output}` and `####` or `%04d`. Without a pattern, each
/// output's own `file` is used, relative to the document, or else [`UNNAMED_FILE`]. Outputs that lead to the same
/// file, even by different links and names, share it as layers.
///
/// # Errors
/// A pattern gives several outputs or several frames one name; an extension cannot be written; the document may not
/// write to a file that it names.
pub fn output_files(
    graph: &CheckedGraph,
    outputs: &[usize],
    frame: i64,
    several_frames: bool,
    pattern: Option<&str>,
) -> Result<Vec<OutputFile>, OutputError> {
    let mut faults = Faults::default();
    let given = pattern.map(|pattern| NamePlace::Pattern(pattern.into()));
    if let (Some(pattern), Some(place)) = (pattern, &given)
        && outputs.len() > 1
        && !pattern.contains("{output}")
    {
        let found = format!("the pattern \"{pattern}\" gives {} outputs one name", outputs.len());
        faults.add_shared(place, found);
    }
    let mut files: Vec<OutputFile> = Vec::new();
    let mut places: Vec<PathBuf> = Vec::new();
    let mut refused = None;
    for &index in outputs {
        let spec = &graph.outputs()[index];
        let place = given.clone().unwrap_or_else(|| place_of(graph, spec, "file"));
        let own = spec.file.as_deref();
        let written = pattern.or(own).unwrap_or(UNNAMED_FILE);
        let template = written.replace("{output}", &escape_frame(&spec.name));
        faults.of_pattern(&place, written, &template, several_frames);
        let lower = template.to_lowercase();
        let is_png = lower.ends_with(".png");
        if !lower.ends_with(".exr") && !is_png {
            let name = written.rsplit(['/', std::path::MAIN_SEPARATOR]).next().unwrap_or_default();
            let found = if pattern.is_some() && Path::new(written).is_dir() {
                format!("\"{written}\" is a folder, not a file")
            } else if name.contains('.') {
                format!("\"{written}\" has an extension that cannot be written")
            } else {
                format!("\"{written}\" has no extension, which names the format")
            };
            faults.add(&place, found, "let the name end with .exr or .png");
        }
        if is_png && (spec.is_recipe || !matches!(spec.kind, Kind::Color | Kind::Weights(2))) {
            let kind = if spec.is_recipe { "recipe".into() } else { spec.kind.to_string() };
            let found = format!("output \"{}\" is a {kind}, which PNG cannot hold", spec.name);
            faults.add(&place, found, "write it as .exr");
        }
        let asked = if pattern.is_none() { own_file(graph, spec, frame) } else { None };
        let is_asked = asked.is_some();
        let path = normalized(&asked.unwrap_or_else(|| expand_frame(&template, frame).into()));
        // The path is checked exactly as it is written.
        if is_asked && refused.is_none() {
            refused = graph.check_written(spec, &path).err();
        }
        // Links are followed, except for hard links: writing to one of them creates a new file.
        let leads_to = if outputs.len() > 1 { resolved(&path) } else { path.clone() };
        match places.iter().position(|place| *place == leads_to) {
            Some(at) => {
                let file = &mut files[at];
                // A pattern without {output} has been refused already.
                if is_png && pattern.is_none_or(|pattern| pattern.contains("{output}")) {
                    let other = &graph.outputs()[file.outputs[0]].name;
                    let found = format!(
                        "\"{written}\" is the file of several outputs, of \"{other}\" as well; expected one in a PNG"
                    );
                    faults.add(&place, found, "give it another name, or use .exr, which holds several");
                }
                file.outputs.push(index);
            }
            None => {
                files.push(OutputFile { path, outputs: vec![index] });
                places.push(leads_to);
            }
        }
    }
    files.iter().for_each(|file| refuse_same_layers(graph, file, &mut faults));
    match refused {
        _ if !faults.0.is_empty() => Err(OutputError::Pattern(faults.0)),
        Some(refused) => Err(OutputError::Refused(refused)),
        None => Ok(files),
    }
}

/// Refuses outputs that are the same layer of a file.
fn refuse_same_layers(graph: &CheckedGraph, file: &OutputFile, faults: &mut Faults) {
    let specs: Vec<&OutputSpec> = file.outputs.iter().map(|index| &graph.outputs()[*index]).collect();
    for (at, spec) in specs.iter().enumerate() {
        let name = layer(spec, file);
        if let Some(other) = specs[..at].iter().find(|other| other.is_recipe && spec.is_recipe) {
            let found = format!("two recipes are in {}, \"{}\" as well; expected one", file.path.display(), other.name);
            faults.add(&place_of(graph, spec, "file"), found, "give one of them another \"file\"");
            continue;
        }
        if let Some(other) = specs[..at].iter().find(|other| layer(other, file) == name) {
            let found =
                format!("two outputs are the layer \"{name}\" of {}, \"{}\" as well", file.path.display(), other.name);
            faults.add(
                &place_of(graph, spec, "layer"),
                found,
                "give one of them another \"layer\", or another \"file\"",
            );
        }
    }
}

/// Returns the place of an output's item in the document.
fn place_of(graph: &CheckedGraph, spec: &OutputSpec, item: &'static str) -> NamePlace {
    let [line, column] = spec.place;
    NamePlace::Output { place: format!("{}:{line}:{column}", graph.name()), output: spec.name.clone(), item }
}

/// Returns the path that the document itself gives to an output.
pub(crate) fn own_file(graph: &CheckedGraph, spec: &OutputSpec, frame: i64) -> Option<PathBuf> {
    let template = spec.file.as_ref()?.replace("{output}", &escape_frame(&spec.name));
    Some(graph.folder().join(expand_frame(&template, frame)))
}

/// Pattern that names the companions of files, such as certificates.
#[derive(Clone, Copy, Debug)]
pub struct CompanionPattern<'p> {
    /// Path relative to the current folder. It may contain `{output}` (the names of a file's outputs, joined by `+`)
    /// and `####` or `%04d`.
    pub pattern: &'p str,
    /// Required extension, such as ".json".
    pub ending: &'p str,
}

/// Names a companion for each file of a frame.
///
/// # Errors
/// The pattern gives several files or several frames one name, or has another extension.
pub fn companion_files(
    graph: &CheckedGraph,
    files: &[OutputFile],
    frame: i64,
    several_frames: bool,
    pattern: CompanionPattern<'_>,
) -> Result<Vec<PathBuf>, OutputError> {
    let CompanionPattern { pattern, ending } = pattern;
    let mut faults = Faults::default();
    let place = NamePlace::Pattern(pattern.into());
    if files.len() > 1 && !pattern.contains("{output}") {
        let found = format!("the pattern \"{pattern}\" gives {} files one name", files.len());
        faults.add_shared(&place, found);
    }
    if !pattern.to_lowercase().ends_with(ending) {
        faults.add(&place, format!("\"{pattern}\" has another extension than {ending}"), "add it");
    }
    faults.of_pattern(&place, pattern, &pattern.replace("{output}", ""), several_frames);
    if !faults.0.is_empty() {
        return Err(OutputError::Pattern(faults.0));
    }
    let name = |file: &OutputFile| {
        let names: Vec<&str> = file.outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        normalized(Path::new(&expand_frame(&pattern.replace("{output}", &escape_frame(&names.join("+"))), frame)))
    };
    Ok(files.iter().map(name).collect())
}

fn is_same_at_all_frames(template: &str) -> bool {
    expand_frame(template, 0) == expand_frame(template, 1)
}

/// Returns a name with the frame pattern before its extension.
fn with_frame(written: &str) -> String {
    match written.rsplit_once('.') {
        Some((name, ending)) if !name.is_empty() && !ending.contains('/') => format!("{name}.####.{ending}"),
        _ => format!("{written}.####"),
    }
}

/// Returns the path without `.` and without `folder/..`, so that all spellings of a file are equal. The path is
/// unchanged if the folder is a link, since `..` after a link leads elsewhere.
fn normalized(path: &Path) -> PathBuf {
    let short = shortened(path);
    let crosses_out = path.components().filter(|part| *part == Component::ParentDir).count()
        > short.components().filter(|part| *part == Component::ParentDir).count();
    if crosses_out && resolved(&short) != resolved(path) { path.into() } else { short }
}

fn shortened(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        let folder = matches!(out.components().next_back(), Some(Component::Normal(_)));
        match part {
            Component::CurDir => {}
            Component::ParentDir if folder => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

#[cfg(test)]
#[path = "naming_tests.rs"]
mod tests;
