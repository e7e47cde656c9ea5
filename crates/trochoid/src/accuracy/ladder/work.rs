//! Omitted work, and the growth of run time with work.

use super::turns::timed;
use super::{Request, TargetError};
use crate::Cost;
use crate::LoadError;
use crate::accuracy::knobs;
use trochoid_engine::{Cache, Monitor, NodeReport, Plan, State};
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
    /// Whether the whole node is left out.
    pub is_node: bool,
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

/// Returns the work that is left out of a document, given the reports on its nodes; and the time that it would take, if
/// that is wanted.
pub(super) fn savings(
    graph: &CheckedGraph,
    request: &Request<'_>,
    nodes: &[NodeReport],
    is_timed: bool,
    monitor: &dyn Monitor,
) -> Result<Vec<Saving>, TargetError> {
    let measured = || {
        crate::measure(graph, request.outputs[0], request.frame, u32::MAX, monitor).map_err(|error| match error {
            crate::MeasureError::Plan(error) => TargetError::from(error),
            crate::MeasureError::Evaluate(error) => error.into(),
        })
    };
    let costs = if is_timed { measured()?.nodes } else { Vec::new() };
    let mut savings: Vec<Saving> = Vec::new();
    for (index, report) in nodes.iter().enumerate() {
        if let State::LeftOut(why) = &report.state {
            let (node, ty, why) = (report.name.clone(), report.ty, why.to_string());
            savings.push(Saving { node, ty, why, is_node: true, seconds: costs.get(index).and_then(Cost::saved) });
        }
    }
    let plan = Plan::new(graph, request.outputs, request.frame, &[], request.settings)?;
    for (id, omissions) in plan.omissions(&mut Cache::new(), monitor)? {
        for omission in omissions {
            let node = graph.node(id);
            let why = format!("{:.0} of {:.0} {}: {}", omission.count, omission.of, omission.what, omission.why);
            let (name, ty) = (node.name.clone(), node.ty.declaration().name);
            savings.push(Saving { node: name, ty, why, is_node: false, seconds: None });
        }
    }
    Ok(savings)
}

/// Returns the number of knobs that increase work.
pub(super) fn costly(graph: &CheckedGraph, request: &Request<'_>) -> usize {
    knobs::numbers(graph, request.outputs, request.frame, |knob| knob.affects_cost || knob.accuracy).len()
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
            points.push((value, timed(&graph, request, monitor)?));
        }
        scalings.push(Scaling { knob: number.path(), points });
    }
    Ok(scalings)
}
