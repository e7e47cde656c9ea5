//! From evaluated frames to files.

use crate::files::{make_folder_of, target};
use crate::marks::with_mark;
use crate::stream::reserved;
use crate::{Form, NameFault};
use std::path::{Path, PathBuf};
use trochoid_engine::{Frame, Picture};
use trochoid_graph::{CheckedGraph, Kind, OutputSpec, Precision, Refused};
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
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Pattern(Vec<NameFault>),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] trochoid_io::Error),
    /// The document wants it where it may not write.
    #[error("{}", .0.diagnostic())]
    Refused(Box<Refused>),
    /// Trochoid did not write the file that is there, or as another kind of file, or so little is left that nobody can tell.
    #[error(
        "{}: is there already, and does not bear Trochoid's mark of such a file: not written by it, of another kind, or cut off\n  \
         remedy: give another name, or replace it with --overwrite",
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

/// The layer of an output: its own name for one, else the output's name where several share the file.
pub(crate) fn layer<'s>(spec: &'s OutputSpec, file: &OutputFile) -> &'s str {
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
    make_folder_of(path)
        .map_err(|error| OutputError::Folder { path: path.parent().unwrap_or(path).into(), reason: error.to_string() })
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
    Ok(write_exr(target(&file.path, Form::Exr, graph.access().overwrites()), &image)?)
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
    let target = target(&file.path, Form::Png, graph.access().overwrites());
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
