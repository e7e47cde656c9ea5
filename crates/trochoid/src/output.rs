//! From evaluated frames to files.

use crate::files::target;
use crate::marks::with_mark;
use crate::stream::reserved;
use std::path::{Component, Path, PathBuf};
use trochoid_engine::{Frame, Picture};
use trochoid_graph::{CheckedGraph, Kind, OutputSpec, Precision, Refused, escape_frame, expand_frame};
use trochoid_image::{Plane, Window, WorkingSpace};
use trochoid_io::{ExrChannel, ExrImage, PngImage, SampleType, Samples, write_exr, write_png8, write_png16};

/// A file to be written for one frame, and the outputs that go into it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    /// Where.
    pub path: PathBuf,
    /// Indices of outputs of the graph, each a layer of the file.
    pub outputs: Vec<usize>,
}

/// Why files cannot be named or written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Files cannot be named so: everything that is wrong, such as one name for several pictures.
    #[error("{}", .0.join("\n"))]
    Pattern(Vec<String>),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] trochoid_io::Error),
    /// The document wants it where it may not write.
    #[error("{}", .0.diagnostic())]
    Refused(Box<Refused>),
    /// Trochoid did not write the file that is there, or so little of it is left that nobody can tell.
    #[error(
        "{}: is there already, and is truncated or not written by Trochoid\n  remedy: give another name, or replace it with --overwrite",
        path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// No file can be written there.
    #[error("{}: {reason}", path.display())]
    Destination {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// The folder cannot be made.
    #[error("{}: the folder cannot be made: {reason}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

/// Names the files of some outputs at a frame.
///
/// `pattern` is relative to the current folder and knows `{output}` and `####` or `%04d`; without one, each
/// output's own `file` counts, relative to the document, or else `{output}.####.exr`. Outputs of a document
/// that name the same file share it as layers.
///
/// # Errors
/// A pattern that gives several outputs, or several frames, one name; an ending that cannot be written; a file of the
/// document where it may not write.
pub fn output_files(
    graph: &CheckedGraph,
    outputs: &[usize],
    frame: i64,
    several_frames: bool,
    pattern: Option<&str>,
) -> Result<Vec<OutputFile>, OutputError> {
    let mut faults: Vec<String> = Vec::new();
    // What is wrong with a pattern is said once, however many outputs it names.
    let mut refuse = |text: String| {
        if !faults.contains(&text) {
            faults.push(text);
        }
    };
    if let Some(pattern) = pattern
        && outputs.len() > 1
        && !pattern.contains("{output}")
    {
        refuse(format!(
            "the pattern \"{pattern}\" gives {} outputs one name: add {{output}}, or choose one with --output",
            outputs.len()
        ));
    }
    let mut files: Vec<OutputFile> = Vec::new();
    let mut refused = None;
    for &index in outputs {
        let spec = &graph.outputs()[index];
        let own = spec.file.as_deref();
        let written = pattern.or(own).unwrap_or("{output}.####.exr");
        let template = written.replace("{output}", &escape_frame(&spec.name));
        let lower = template.to_lowercase();
        let is_png = lower.ends_with(".png");
        if let Some(fault) = placeholder_fault(written, &template) {
            refuse(fault);
        } else if !lower.ends_with(".exr") && !is_png {
            refuse(format!("\"{written}\" has an ending that cannot be written: use .exr or .png"));
        }
        if several_frames && is_same_at_all_frames(&template) {
            refuse(format!("\"{written}\" gives all frames one name: add #### or %04d"));
        }
        if is_png && !matches!(spec.kind, Kind::Color | Kind::Weights(2)) {
            refuse(format!("output \"{}\" is a {}, which PNG cannot hold: write it as .exr", spec.name, spec.kind));
        }
        let asked = if pattern.is_none() { own_file(graph, spec, frame) } else { None };
        if let Some(path) = asked.as_ref().filter(|_| refused.is_none()) {
            refused = graph.check_written(spec, path).err();
        }
        let path = normalized(&asked.unwrap_or_else(|| expand_frame(&template, frame).into()));
        match files.iter_mut().find(|file| file.path == path) {
            Some(file) => {
                // A pattern without {output} was refused already.
                if is_png && pattern.is_none() {
                    refuse(format!("\"{written}\" is the file of several outputs; PNG holds one: use .exr"));
                }
                file.outputs.push(index);
            }
            None => files.push(OutputFile { path, outputs: vec![index] }),
        }
    }
    for file in &files {
        let mut layers: Vec<&str> = file.outputs.iter().map(|index| layer(&graph.outputs()[*index], file)).collect();
        layers.sort_unstable();
        if let Some(pair) = layers.windows(2).find(|pair| pair[0] == pair[1]) {
            refuse(format!("{}: two outputs are the layer \"{}\": name another", file.path.display(), pair[0]));
        }
    }
    match refused {
        _ if !faults.is_empty() => Err(OutputError::Pattern(faults)),
        Some(refused) => Err(OutputError::Refused(refused)),
        None => Ok(files),
    }
}

/// Where the document itself wants an output.
pub(crate) fn own_file(graph: &CheckedGraph, spec: &OutputSpec, frame: i64) -> Option<PathBuf> {
    let template = spec.file.as_ref()?.replace("{output}", &escape_frame(&spec.name));
    Some(graph.folder().join(expand_frame(&template, frame)))
}

/// Names a further file for each file of a frame, such as its certificate.
///
/// `pattern` is relative to the current folder and knows `{output}` (the names of a file's outputs, with `+` between them)
/// and `####` or `%04d`; `ending` is what the names must end with, such as ".json".
///
/// # Errors
/// A pattern that gives several files, or several frames, one name; another ending.
pub fn companion_files(
    graph: &CheckedGraph,
    files: &[OutputFile],
    frame: i64,
    several_frames: bool,
    pattern: &str,
    ending: &str,
) -> Result<Vec<PathBuf>, OutputError> {
    let mut faults = Vec::new();
    if files.len() > 1 && !pattern.contains("{output}") {
        faults.push(format!(
            "the pattern \"{pattern}\" gives {} files one name: add {{output}}, or choose one output with --output",
            files.len()
        ));
    }
    let bare = pattern.replace("{output}", "");
    faults.extend(placeholder_fault(pattern, &bare));
    if !pattern.to_lowercase().ends_with(ending) {
        faults.push(format!("\"{pattern}\" has another ending than {ending}: add it"));
    }
    if several_frames && is_same_at_all_frames(&bare) {
        faults.push(format!("\"{pattern}\" gives all frames one name: add #### or %04d"));
    }
    if !faults.is_empty() {
        return Err(OutputError::Pattern(faults));
    }
    let name = |file: &OutputFile| {
        let names: Vec<&str> = file.outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
        normalized(Path::new(&expand_frame(&pattern.replace("{output}", &escape_frame(&names.join("+"))), frame)))
    };
    Ok(files.iter().map(name).collect())
}

/// What is wrong with a pattern of which the known placeholders are filled in already, if anything.
fn placeholder_fault(written: &str, template: &str) -> Option<String> {
    let (_, rest) = template.split_once('{')?;
    let found = rest.split_once('}').map_or(rest, |(name, _)| name);
    Some(format!("\"{written}\" has the unknown placeholder {{{found}}}: {{output}}, #### and %04d are known"))
}

fn is_same_at_all_frames(template: &str) -> bool {
    expand_frame(template, 0) == expand_frame(template, 1)
}

/// The path without `.` and without `folder/..`, so that two spellings of one file are one.
fn normalized(path: &Path) -> PathBuf {
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

/// The layer of an output: its own name for one, else the output's name where several share the file.
fn layer<'s>(spec: &'s OutputSpec, file: &OutputFile) -> &'s str {
    match &spec.layer {
        Some(layer) => layer,
        None if file.outputs.len() > 1 => &spec.name,
        None => "",
    }
}

/// Writes one file of an evaluated frame; it appears whole or not at all. Folders are made.
///
/// EXR holds linear light in the primaries of the working space (a display-encoded `srgb` is decoded), so that
/// any reader shows it right. PNG is encoded as sRGB. Either says in its metadata that Trochoid made it, and takes the place
/// of no other file unless the graph's [rule](trochoid_graph::Access::overwrites) says so.
///
/// # Errors
/// A value that the file's precision cannot hold, or input and output; a file of others is there.
pub fn write_output(
    graph: &CheckedGraph,
    frame: &Frame,
    file: &OutputFile,
    metadata: &[(String, String)],
) -> Result<(), OutputError> {
    folder_of_file(&file.path)?;
    let is_png = file.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let metadata = &with_mark(metadata);
    if is_png { write_png(graph, frame, file, metadata) } else { write_layers(graph, frame, file, metadata) }
}

/// Makes the folder of a file.
pub(crate) fn folder_of_file(path: &Path) -> Result<(), OutputError> {
    match path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        Some(folder) => std::fs::create_dir_all(folder)
            .map_err(|error| OutputError::Folder { path: folder.into(), reason: error.to_string() }),
        None => Ok(()),
    }
}

/// Names of an output's channels in an EXR file, and how their samples are stored.
pub(crate) fn file_channels(graph: &CheckedGraph, spec: &OutputSpec, file: &OutputFile) -> Vec<(String, SampleType)> {
    let layer = layer(spec, file);
    // Fields are measures: half would round a depth of a kilometer to half a meter.
    let default = if matches!(spec.kind, Kind::Field(_)) { Precision::Float } else { Precision::Half };
    let float = spec.precision.unwrap_or(default) == Precision::Float;
    let named = |name: String| if layer.is_empty() { name } else { format!("{layer}.{name}") };
    let sample_type = if float { SampleType::Float } else { SampleType::Half };
    channel_names(graph, spec).into_iter().map(|name| (named(name), sample_type)).collect()
}

fn pictures<'f>(graph: &'f CheckedGraph, frame: &'f Frame, file: &OutputFile) -> Vec<(&'f OutputSpec, &'f Picture)> {
    let chosen = frame.pictures.iter().filter(|picture| file.outputs.contains(&picture.output));
    chosen.map(|picture| (&graph.outputs()[picture.output], picture)).collect()
}

fn write_layers(
    graph: &CheckedGraph,
    frame: &Frame,
    file: &OutputFile,
    metadata: &[(String, String)],
) -> Result<(), OutputError> {
    let chosen = pictures(graph, frame, file);
    let encoded = graph.space() == WorkingSpace::Srgb;
    let linear: Vec<Option<[Vec<f32>; 3]>> = chosen
        .iter()
        .map(|(_, picture)| {
            let rgb = color_rows(&picture.planes).filter(|_| picture.kind == Kind::Color && encoded)?;
            Some(convert(rgb, |color| graph.space().to_linear_srgb(color)))
        })
        .collect();
    let mut channels = Vec::new();
    for ((spec, picture), linear) in chosen.iter().zip(&linear) {
        let names = file_channels(graph, spec, file);
        for ((name, sample_type), samples) in names.into_iter().zip(samples_of(&picture.planes, linear.as_ref())) {
            let float = sample_type == SampleType::Float;
            channels.push(if float { ExrChannel::float(name, samples) } else { ExrChannel::half(name, samples) });
        }
    }
    let image = ExrImage {
        display: graph.format().window(),
        data: frame.window,
        channels,
        metadata: metadata.to_vec(),
        // As in a file that is written while its rows are made: which way it came about must not show.
        reserved: reserved(chosen.iter().map(|(spec, _)| *spec)),
        chromaticities: chosen.iter().any(|(_, p)| p.kind == Kind::Color).then(|| graph.space().chromaticities()),
    };
    Ok(write_exr(target(&file.path, graph.access().overwrites()), &image)?)
}

fn write_png(
    graph: &CheckedGraph,
    frame: &Frame,
    file: &OutputFile,
    metadata: &[(String, String)],
) -> Result<(), OutputError> {
    let Some((spec, picture)) = pictures(graph, frame, file).into_iter().next() else { return Ok(()) };
    let space = graph.space();
    let linear = picture.kind == Kind::Color && space != WorkingSpace::Srgb;
    let rgb = color_rows(&picture.planes).filter(|_| linear);
    let encoded = rgb.map(|rgb| convert(rgb, |color| space.to_display(color)));
    let window: Window = frame.window;
    let channels = samples_of(&picture.planes, encoded.as_ref());
    let mut image = PngImage::new(window.width() as u32, window.height() as u32, channels);
    image.metadata = metadata.to_vec();
    let target = target(&file.path, graph.access().overwrites());
    match spec.precision {
        Some(Precision::Uint16) => write_png16(target, &image)?,
        _ => write_png8(target, &image)?,
    }
    Ok(())
}

/// The channels of a color.
fn color_rows(planes: &[Plane]) -> Option<[&[f32]; 3]> {
    match planes {
        [r, g, b] => Some([r.samples(), g.samples(), b.samples()]),
        _ => None,
    }
}

/// What is written of planes: their samples, or what these were converted to.
fn samples_of<'s>(planes: &'s [Plane], converted: Option<&'s [Vec<f32>; 3]>) -> Vec<Samples<'s>> {
    match converted {
        Some(color) => color.iter().map(|channel| Samples::contiguous(channel)).collect(),
        None => planes.iter().map(Samples::plane).collect(),
    }
}

/// Colors with every pixel converted in f64, a run of equal ones once: flat tones are cheap.
pub(crate) fn convert([r, g, b]: [&[f32]; 3], f: impl Fn([f64; 3]) -> [f64; 3]) -> [Vec<f32>; 3] {
    let mut converted = [0; 3].map(|_| Vec::with_capacity(r.len()));
    let mut last = None;
    for ((r, g), b) in r.iter().zip(g).zip(b) {
        let color = [*r, *g, *b];
        let bits = color.map(f32::to_bits);
        let values = match last {
            Some((same, values)) if same == bits => values,
            _ => f(color.map(f64::from)).map(|value| value as f32),
        };
        last = Some((bits, values));
        for (channel, value) in converted.iter_mut().zip(values) {
            channel.push(value);
        }
    }
    converted
}

/// EXR's names of an output's channels: as declared, such as `Z` for depth; `Y` is what viewers show as gray.
fn channel_names(graph: &CheckedGraph, spec: &OutputSpec) -> Vec<String> {
    let outputs = graph.node(spec.node).ty.declaration().outputs;
    let stored = outputs.get(spec.output).map(|output| output.stored).unwrap_or_default();
    match spec.kind {
        Kind::Color => ["R", "G", "B"].map(String::from).into(),
        kind if stored.len() == kind.channels() => stored.iter().map(|name| (*name).into()).collect(),
        Kind::Weights(2) | Kind::Field(1) => vec!["Y".into()],
        Kind::Field(n) => ["X", "Y", "Z", "W"].iter().take(n).map(|name| (*name).into()).collect(),
        Kind::Weights(n) => (0..n).map(|i| format!("w{i}")).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
#[path = "output_tests.rs"]
mod tests;
