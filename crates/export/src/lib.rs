//! Writes the pointwise part of a graph as a shader for another program: a function of GLSL or WGSL, a shader of
//! OSL, or a node graph of MaterialX.
//!
//! What is written comes from the pointwise program of an output ([`PointwiseProgram`]), never from nodes, so that every
//! pointwise node can be written, and a new one needs nothing here. `translate` is the one place that knows all operations;
//! a `translate::Target` writes their parts in a language.
//!
//! Colors of the shader are as safe as those of a picture: masks that come from outside are clamped, weights are divided
//! by their sum, and only then are colors mixed. The shader computes in 32-bit floats in an order of its own, so its
//! colors differ from the picture's, and leave their hull, by rounding alone.

mod code;
mod glsl;
mod input;
mod materialx;
mod names;
mod osl;
mod translate;
mod wgsl;
mod words;

pub use input::{InputError, Unbound};

use input::Inputs;
use trochoid_engine::PointwiseProgram;
use trochoid_graph::{CheckedGraph, Kind};
use trochoid_image::WorkingSpace;

/// Language of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// A function of the OpenGL Shading Language, from version 1.30 or ES 3.00 on.
    Glsl,
    /// A shader of the Open Shading Language.
    Osl,
    /// A node graph of MaterialX 1.39, of nodes of its standard library.
    MaterialX,
    /// A function of the WebGPU Shading Language.
    Wgsl,
}

impl Language {
    /// Every language.
    pub const ALL: [Self; 4] = [Self::Glsl, Self::Osl, Self::MaterialX, Self::Wgsl];

    /// Returns the name as users write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glsl => "glsl",
            Self::Osl => "osl",
            Self::MaterialX => "materialx",
            Self::Wgsl => "wgsl",
        }
    }

    /// Returns the usual extension of files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Glsl => "glsl",
            Self::Osl => "osl",
            Self::MaterialX => "mtlx",
            Self::Wgsl => "wgsl",
        }
    }
}

/// What to export.
#[derive(Clone, Copy, Debug)]
pub struct Request<'r> {
    /// Index of the output in the graph.
    pub output: usize,
    /// Frame at which knobs with keys are taken.
    pub frame: i64,
    /// Names of the nodes that become inputs of the shader, in their order: `NODE` for its first output, or `NODE.OUTPUT`.
    pub bound: &'r [&'r str],
    /// Whether a color is returned as linear light, even if the document's working space is encoded for display.
    pub linear: bool,
    /// The language.
    pub language: Language,
    /// Name and version of the program that writes, for the comment at the top.
    pub by: &'r str,
}

/// A shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shader {
    /// Its text, which ends with a line break.
    pub text: String,
    /// Names of the function, of the shader or of the node graph's output, and of the inputs in their order.
    pub names: Vec<String>,
    /// Nodes of [`Request::bound`] that the output does not depend on. They are inputs, but not read.
    pub unread: Vec<String>,
}

/// Why an output cannot be exported.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ExportError {
    /// The output is a recipe, which is a file and no value at a point.
    #[error("output \"{output}\": found a recipe; expected a color, Weights or a Field: choose another output")]
    Recipe {
        /// Name of the output.
        output: String,
    },
    /// Inputs that do not exist, or are not values at a point.
    #[error("{}", lines(.0))]
    Inputs(Vec<InputError>),
    /// The output depends on nodes that a shader cannot compute.
    #[error("{}", lines(.0))]
    Unbound(Vec<Unbound>),
}

fn lines<T: ToString>(all: &[T]) -> String {
    all.iter().map(T::to_string).collect::<Vec<_>>().join("\n")
}

/// Exports an output of a graph.
///
/// # Errors
/// The output is a recipe, an input does not exist, or the output depends on a node that is neither pointwise nor an
/// input.
pub fn export(graph: &CheckedGraph, request: &Request<'_>) -> Result<Shader, ExportError> {
    let spec = &graph.outputs()[request.output];
    if spec.is_recipe {
        return Err(ExportError::Recipe { output: spec.name.clone() });
    }
    let name = names::identifier(&spec.name);
    let results = names::results(&name, spec.kind);
    let inputs = Inputs::new(graph, request.bound, &name, &results).map_err(ExportError::Inputs)?;
    let made = PointwiseProgram::new(graph, request.output, request.frame, &inputs.nodes());
    let unbound = inputs.missing(graph, &made.program);
    if !unbound.is_empty() {
        return Err(ExportError::Unbound(unbound));
    }
    let heading = words::heading(graph, request, &inputs, &results);
    let job = Job {
        name: &name,
        inputs: &inputs,
        results: &results,
        made: &made,
        decodes: decodes(graph, request),
        by: request.by,
        heading: &heading,
    };
    let text = match request.language {
        Language::Glsl => glsl::write(&job),
        Language::Osl => osl::write(&job),
        Language::MaterialX => materialx::write(&job, graph.space()),
        Language::Wgsl => wgsl::write(&job),
    };
    let names = std::iter::once(name.clone()).chain(inputs.identifiers().map(String::from)).collect();
    Ok(Shader { text, names, unread: inputs.unread(&made.program) })
}

/// All that a language needs to write a shader.
struct Job<'j> {
    name: &'j str,
    inputs: &'j Inputs,
    /// Names of what the shader returns: one for a color or a number, else one for each channel.
    results: &'j [String],
    made: &'j PointwiseProgram,
    /// Whether the color that it returns is decoded.
    decodes: bool,
    by: &'j str,
    /// What the shader is, in sentences, one a line.
    heading: &'j [String],
}

/// Whether the result has to be decoded to be linear light.
fn decodes(graph: &CheckedGraph, request: &Request<'_>) -> bool {
    request.linear && graph.outputs()[request.output].kind == Kind::Color && graph.space() == WorkingSpace::Srgb
}

/// Whether a kind is a value at a point, which a shader can take and return.
fn is_value(kind: Kind) -> bool {
    matches!(kind, Kind::Color | Kind::Weights(_) | Kind::Field(_))
}
