//! Omitted work, and the growth of run time with work.

use super::rung::timed;
use super::{Request, TargetError};
use crate::LoadError;
use crate::accuracy::knobs;
use trochoid_engine::{Buffers, Cache, Monitor, Plan, State};
use trochoid_graph::CheckedGraph;

/// Node, or part of its work, that is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Saving {
    /// Name of the node.
    pub node: String,
    /// Type of the node.
    pub ty: &'static str,
    /// Reason that it is left out, or the part that is.
    pub why: String,
    /// Seconds saved; `None` if not measured.
    pub seconds: Option<f64>,
}

/// Run time by the values of a knob.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// Knob, as `NODE.KNOB`.
    pub knob: String,
    /// Values with the median seconds for the frame.
    pub points: Vec<(f64, f64)>,
}

/// Factors for knobs that increase work.
const WORK: [f64; 4] = [0.25, 0.5, 1.0, 2.0];

/// Returns the work that is left out of a document.
pub(super) fn savings(
    graph: &CheckedGraph,
    request: &Request<'_>,
    monitor: &dyn Monitor,
) -> Result<Vec<Saving>, TargetError> {
    let costs =
        crate::measure(graph, request.outputs[0], request.frame, u32::MAX, monitor).map_err(|error| match error {
            crate::MeasureError::Plan(error) => TargetError::from(error),
            crate::MeasureError::Evaluate(error) => error.into(),
        })?;
    let plan = Plan::new(graph, request.outputs, request.frame, &[], request.settings)?;
    let mut cache = Cache::new();
    let frame = plan.evaluate(&Buffers::new(), &mut cache, monitor)?;
    let mut savings: Vec<Saving> = Vec::new();
    for (report, cost) in frame.nodes.iter().zip(&costs.nodes) {
        if let State::LeftOut(why) = &report.state {
            let (node, ty, why) = (report.name.clone(), report.ty, why.to_string());
            savings.push(Saving { node, ty, why, seconds: cost.saved() });
        }
    }
    for (id, omissions) in plan.omissions(&mut cache, monitor)? {
        for omission in omissions {
            let node = graph.node(id);
            let why = format!("{:.0} of {:.0} {}: {}", omission.count, omission.of, omission.what, omission.why);
            savings.push(Saving { node: node.name.clone(), ty: node.ty.declaration().name, why, seconds: None });
        }
    }
    Ok(savings)
}

/// Measures run times by the values of knobs that increase work.
pub(super) fn scalings(
    graph: &CheckedGraph,
    request: &Request<'_>,
    sized: &dyn Fn(&[String]) -> Result<CheckedGraph, LoadError>,
    monitor: &dyn Monitor,
) -> Result<Vec<Scaling>, TargetError> {
    let mut scalings = Vec::new();
    for number in knobs::numbers(graph, request.outputs, request.frame, |knob| knob.affects_cost || knob.accuracy) {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for factor in WORK {
            let value = number.value(factor);
            if points.iter().any(|(known, _)| *known == value) {
                continue;
            }
            // Some values are not valid together with the rest of the document.
            let Ok(graph) = sized(&[number.assignment(factor)]) else { continue };
            points.push((value, timed(&graph, request, monitor)?.1));
        }
        scalings.push(Scaling { knob: number.path(), points });
    }
    Ok(scalings)
}
