//! An output as a layer of an EXR file: its channels, space for late metadata, and conversion of its colors.

use crate::output_file::{OutputError, OutputFile, layer};
use crate::recipe::{LATE as LATE_OF_RECIPE, RecipeInfo, RecipeRows};
use trochoid_engine::Storing;
use trochoid_graph::{CheckedGraph, Kind, OutputSpec, Precision};
use trochoid_image::WorkingSpace;
use trochoid_io::SampleType;

/// Bytes reserved in a header for metadata that are known only at the end, and for each output in addition to its name.
const LATE: (usize, usize) = (2048, 64);

/// How the channels of an output become those of its file.
pub(crate) enum Conversion {
    /// As they are.
    None,
    /// Display-encoded colors are decoded to linear light.
    Linear(WorkingSpace),
    /// The layers of a color are rounded to weights whose sum is exact.
    Recipe(Box<RecipeRows>),
}

impl Conversion {
    /// # Errors
    /// The output is a recipe, but the graph has none.
    pub(crate) fn of(
        graph: &CheckedGraph,
        spec: &OutputSpec,
        file: &OutputFile,
        frame: i64,
    ) -> Result<Self, OutputError> {
        if spec.is_recipe {
            let info = recipe(graph, spec, file, frame).ok_or_else(|| OutputError::NoRecipe(spec.name.clone()))?;
            return Ok(Self::Recipe(Box::new(RecipeRows::new(info))));
        }
        let is_encoded = spec.kind == Kind::Color && graph.space() == WorkingSpace::Srgb;
        Ok(if is_encoded { Self::Linear(graph.space()) } else { Self::None })
    }

    /// Returns the channels of the file for some pixels of the output; those that differ are computed in `converted`.
    pub(crate) fn channels<'r>(&self, rows: &[&'r [f32]], converted: &'r mut Vec<Vec<f32>>) -> Vec<&'r [f32]> {
        match (self, rows) {
            (Self::Linear(space), [r, g, b]) => {
                *converted = convert([r, g, b], |color| space.to_linear_srgb(color)).into();
            }
            (Self::Recipe(recipe), _) => recipe.store(rows, converted),
            _ => return rows.to_vec(),
        }
        converted.iter().map(Vec::as_slice).collect()
    }

    /// Returns the metadata that are known when all pixels are converted.
    pub(crate) fn metadata(&self) -> Option<(String, String)> {
        if let Self::Recipe(recipe) = self { Some(recipe.metadata()) } else { None }
    }
}

/// Returns the bytes to reserve in the header of a file with these outputs.
pub(crate) fn reserved<'s>(
    outputs: impl Iterator<Item = &'s OutputSpec>,
    conversions: impl Iterator<Item = &'s Conversion>,
) -> usize {
    let recipe = |conversion: &Conversion| {
        conversion.metadata().map_or(0, |(key, text)| key.len() + text.len() + LATE_OF_RECIPE)
    };
    LATE.0 + outputs.map(|spec| spec.name.len() + LATE.1).sum::<usize>() + conversions.map(recipe).sum::<usize>()
}

fn is_float(spec: &OutputSpec) -> bool {
    // Fields are measurements: half would round a depth of a kilometer to half a meter.
    let default = if matches!(spec.kind, Kind::Field(_)) { Precision::Float } else { Precision::Half };
    spec.precision.unwrap_or(default) == Precision::Float
}

/// Returns the description of an output that is a recipe.
fn recipe(graph: &CheckedGraph, spec: &OutputSpec, file: &OutputFile, frame: i64) -> Option<RecipeInfo> {
    let storing = if is_float(spec) { Storing::Float } else { Storing::Half };
    RecipeInfo::of(graph, layer(spec, file), storing, frame)
}

/// Returns the names of an output's channels in an EXR file, with the types of their samples.
pub(crate) fn file_channels(graph: &CheckedGraph, spec: &OutputSpec, file: &OutputFile) -> Vec<(String, SampleType)> {
    let layer = layer(spec, file);
    let named = |name: String| if layer.is_empty() { name } else { format!("{layer}.{name}") };
    let sample_type = if is_float(spec) { SampleType::Float } else { SampleType::Half };
    let names: Vec<String> = match recipe(graph, spec, file, 0).filter(|_| spec.is_recipe) {
        Some(recipe) => recipe.channels(),
        None => channel_names(graph, spec).into_iter().map(named).collect(),
    };
    names.into_iter().map(|name| (name, sample_type)).collect()
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
