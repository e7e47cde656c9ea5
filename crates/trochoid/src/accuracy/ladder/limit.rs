//! The reason that no settings meet a tolerance.

use super::{Request, TargetError};
use crate::accuracy::unbounded;
use std::fmt;
use trochoid_engine::{Buffers, Cache, Certifier, Limiting, Monitor};
use trochoid_graph::CheckedGraph;
use trochoid_image::Window;

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

/// Returns what limits the certified error of a graph at its worst pixel.
pub(super) fn limit(
    graph: &CheckedGraph,
    request: &Request<'_>,
    regions: &[Window],
    monitor: &dyn Monitor,
) -> Result<Limit, TargetError> {
    let mut cache = Cache::new();
    let mut worst: Option<(f64, usize, [i64; 2])> = None;
    let mut all = Vec::new();
    for region in regions {
        let mut settings = request.settings.clone();
        settings.region = Some(*region);
        let certifier = Certifier::new(graph, request.outputs, request.frame, &[], &settings)?;
        for certified in certifier.certify(&Buffers::new(), &mut cache, monitor)? {
            let max = certified.clear.max();
            if let Some(pixel) = certified.worst.filter(|_| worst.is_none_or(|(most, ..)| max > most)) {
                worst = Some((max, certified.output, pixel));
            }
            all.push(certified);
        }
    }
    let named = |id| {
        let node = graph.node(id);
        (node.name.clone(), node.ty.declaration().name)
    };
    let Some((_, output, pixel)) = worst.filter(|_| all.iter().any(|certified| certified.clear.total() > 0)) else {
        return Ok(unbounded(graph, &all).map_or(Limit::Unseen, |(id, why)| {
            let (node, ty) = named(id);
            Limit::Unbounded { node, ty, why }
        }));
    };
    let certifier = Certifier::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let Limiting { stage, .. } = certifier.limiting(output, pixel, &Buffers::new(), &mut cache, monitor)?;
    Ok(stage.map_or(Limit::Rounding, |id| {
        let (node, ty) = named(id);
        Limit::Pass { node, ty }
    }))
}
