//! The reason that no settings meet a tolerance.

use super::{Request, TargetError};
use crate::accuracy::unbounded;
use std::fmt;
use trochoid_engine::{AccuracyLimit, Buffers, Cache, Certifier, Monitor};
use trochoid_graph::{CheckedGraph, NodeId};

/// What limits the certified error of the most accurate settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The pass with the largest share of the error at the worst pixel.
    Pass {
        /// Name of the node.
        node: String,
        /// Type of the node.
        ty: &'static str,
    },
    /// f32 rounding in all passes together.
    Rounding,
    /// No sample has a certified error, because a pass has no error bound.
    Unbounded {
        /// Name of the node.
        node: String,
        /// Type of the node.
        ty: &'static str,
        /// Reason that it has no error bound.
        why: &'static str,
    },
    /// No sample has a certified error, because visibility is not certain anywhere.
    Unseen,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pass { node, ty } => write!(f, "limited by \"{node}\" ({ty})"),
            Self::Rounding => write!(f, "limited by f32 rounding"),
            Self::Unbounded { node, ty, .. } => write!(f, "\"{node}\" ({ty}) has no error bound"),
            Self::Unseen => write!(f, "visibility is not certain anywhere"),
        }
    }
}

/// Returns what limits the certified error of a graph at its worst pixel without ambiguous samples; `None` for this pixel
/// means that there is no such pixel.
pub(super) fn limit(
    graph: &CheckedGraph,
    request: &Request<'_>,
    worst: Option<[i64; 2]>,
    known: &[(NodeId, &'static str)],
    cache: &mut Cache,
    monitor: &dyn Monitor,
) -> Result<Limit, TargetError> {
    let named = |id| {
        let node = graph.node(id);
        (node.name.clone(), node.ty.declaration().name)
    };
    let Some(pixel) = worst else {
        return Ok(unbounded(graph, known.iter().copied()).map_or(Limit::Unseen, |(id, why)| {
            let (node, ty) = named(id);
            Limit::Unbounded { node, ty, why }
        }));
    };
    let certifier = Certifier::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let output = output(graph, request);
    let AccuracyLimit { stage, .. } = certifier.limiting(output, pixel, &Buffers::new(), cache, monitor)?;
    Ok(stage.map_or(Limit::Rounding, |id| {
        let (node, ty) = named(id);
        Limit::Pass { node, ty }
    }))
}

/// Returns the index of the output that is measured.
pub(super) fn output(graph: &CheckedGraph, request: &Request<'_>) -> usize {
    graph.outputs().iter().position(|output| output.name == request.outputs[0]).unwrap_or(0)
}
