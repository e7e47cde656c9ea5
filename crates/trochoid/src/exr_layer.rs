//! An output as a layer of an EXR file: its channels, space for late metadata, and conversion of its colors.

use crate::output_file::{OutputFile, layer};
use trochoid_graph::{CheckedGraph, Kind, OutputSpec, Precision};
use trochoid_io::SampleType;

/// Bytes reserved in a header for metadata that are known only at the end, and for each output in addition to its name.
const LATE: (usize, usize) = (2048, 64);

/// Returns the bytes to reserve in the header of a file with these outputs.
pub(crate) fn reserved<'s>(outputs: impl Iterator<Item = &'s OutputSpec>) -> usize {
    LATE.0 + outputs.map(|spec| spec.name.len() + LATE.1).sum::<usize>()
}

/// Returns the names of an output's channels in an EXR file, with the types of their samples.
pub(crate) fn file_channels(graph: &CheckedGraph, spec: &OutputSpec, file: &OutputFile) -> Vec<(String, SampleType)> {
    let layer = layer(spec, file);
    // Fields are measurements: half would round a depth of a kilometer to half a meter.
    let default = if matches!(spec.kind, Kind::Field(_)) { Precision::Float } else { Precision::Half };
    let float = spec.precision.unwrap_or(default) == Precision::Float;
    let named = |name: String| if layer.is_empty() { name } else { format!("{layer}.{name}") };
    let sample_type = if float { SampleType::Float } else { SampleType::Half };
    channel_names(graph, spec).into_iter().map(|name| (named(name), sample_type)).collect()
}

/// Converts every pixel in f64. A run of equal pixels is converted once, so that flat areas are cheap.
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

/// Returns the names of an output's channels in EXR: those of the declaration, such as `Z` for depth, or else `Y`,
/// which viewers show as gray.
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
