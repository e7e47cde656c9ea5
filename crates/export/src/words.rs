//! What a shader says of itself.

use crate::input::Inputs;
use crate::{Request, decodes};
use trochoid_graph::{CheckedGraph, Kind};
use trochoid_image::WorkingSpace;

/// Returns what a shader is, one sentence a line, in plain ASCII: what comes from documents is escaped, so that it cannot
/// end a comment.
pub(crate) fn heading(graph: &CheckedGraph, request: &Request<'_>, inputs: &Inputs, results: &[String]) -> Vec<String> {
    let spec = &graph.outputs()[request.output];
    let (output, document) = (spec.name.escape_default(), graph.name().escape_default());
    let kind = match spec.kind {
        Kind::Color => "color",
        Kind::MASK => "mask",
        Kind::Weights(_) => "weights",
        _ => "field",
    };
    let mut lines = vec![format!("The {kind} \"{output}\" of {document} at frame {}.", request.frame)];
    if spec.kind == Kind::Color || inputs.parameters().any(|parameter| parameter.is_color) {
        lines.push(format!("Colors are in the document's working space, {}.", space(graph.space())));
    }
    if spec.kind == Kind::Color {
        lines.push(
            "It mixes the colors in it, and those that it takes, with weights of at least 0 that sum to 1: it leaves their \
             hull by rounding alone."
                .into(),
        );
    }
    if decodes(graph, request) {
        lines.push("The result is decoded: linear light of Rec. 709 primaries, white D65.".into());
    }
    if results.len() > 1 {
        lines.push(format!("It has {} results.", results.len()));
    }
    lines
}

/// Returns a working space in words.
fn space(space: WorkingSpace) -> &'static str {
    match space {
        WorkingSpace::LinearSrgb => "linear-srgb: linear light of Rec. 709 primaries, white D65",
        WorkingSpace::AcesCg => "acescg: linear light of AP1 primaries, ACES white",
        WorkingSpace::Srgb => "srgb: encoded for display as sRGB, no linear light",
    }
}
