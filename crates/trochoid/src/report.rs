//! The report of a run, as JSON.

use serde_json::{Value, json};
use trochoid_engine::{Frame, State};
use trochoid_graph::{CheckedGraph, GroupUse};

/// Result of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunStatus {
    /// All frames are complete.
    Done,
    /// A frame could not be evaluated or written.
    Failed,
    /// All frames are complete, but a required guarantee was missed.
    Missed,
    /// The user stopped the run.
    Interrupted,
}

impl RunStatus {
    /// Returns the name of the status in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Failed => "failed",
            Self::Missed => "guarantee missed",
            Self::Interrupted => "interrupted",
        }
    }
}

/// Report of a run, with one entry per frame.
#[derive(Clone, Debug)]
pub struct RunReport {
    document: String,
    hash: String,
    frames: Vec<Value>,
}

impl RunReport {
    /// Creates a report of a run without frames.
    pub fn new(graph: &CheckedGraph) -> Self {
        Self { document: graph.name().into(), hash: graph.document_hash(), frames: Vec::new() }
    }

    /// Adds the report of a frame, made by [`frame_report`].
    pub fn push(&mut self, frame: Value) {
        self.frames.push(frame);
    }

    /// Returns the whole report as JSON.
    pub fn to_json(&self, status: RunStatus) -> Value {
        json!({
            "trochoid": crate::VERSION,
            "document": self.document,
            "document_hash": self.hash,
            "status": status.name(),
            "frames": self.frames,
            "peak_memory_bytes": peak_memory_bytes(),
        })
    }
}

/// Returns what an output is mixed from: the colors that the document names or writes, and the nodes with images.
fn controls(graph: &CheckedGraph, output: usize, frame: i64) -> Value {
    let (controls, images) = graph.controls(output);
    json!({
        "count": controls.len(),
        "names": controls.iter().map(|control| &control.name).collect::<Vec<_>>(),
        "values": controls.iter().map(|control| control.color.at(frame as f64)).collect::<Vec<_>>(),
        "images": images,
    })
}

/// Returns, for each use of a group, sums over its nodes, also those of groups within it.
fn groups(graph: &CheckedGraph, frame: &Frame) -> serde_json::Map<String, Value> {
    let of_use = |used: &GroupUse| {
        let holds = |name: &str| name.strip_prefix(&used.path).is_some_and(|rest| rest.starts_with('/'));
        let nodes: Vec<_> = frame.nodes.iter().filter(|node| holds(&node.name)).collect();
        let value = json!({
            "group": used.group,
            "nodes": nodes.len(),
            "left_out": nodes.iter().filter(|node| matches!(node.state, State::LeftOut(_))).count(),
            "seconds": nodes.iter().map(|node| node.seconds).sum::<f64>(),
            "bytes": nodes.iter().map(|node| node.bytes).sum::<usize>(),
            "repaired": nodes.iter().map(|node| node.repaired).sum::<u64>(),
        });
        (used.path.clone(), value)
    };
    graph.groups().iter().map(of_use).collect()
}

/// Returns the report of a frame: outputs with their guarantees and counts, nodes with their states and times, and uses of
/// groups with the sums of theirs.
pub fn frame_report(graph: &CheckedGraph, frame: &Frame, write_seconds: f64) -> Value {
    let repaired: u64 = frame.nodes.iter().map(|node| node.repaired).sum();
    let outputs: serde_json::Map<String, Value> = frame
        .pictures
        .iter()
        .map(|picture| {
            let audit = &picture.audit;
            let value = json!({
                "kind": picture.kind.to_string(),
                "guarantee": picture.guarantee.map(trochoid_graph::Guarantee::name),
                "control_colors": controls(graph, picture.output, frame.number),
                "hull_exits": audit.hull_exits,
                "worst_exit": number(audit.worst_exit),
                "margin": picture.margin,
                "weight_sum_max_deviation": number(audit.weight_sum_max_deviation),
                "weight_min": number(audit.weight_min),
                "nan_count": audit.nan_count,
                "repaired": repaired,
                "pixels": audit.pixels,
                "judged": audit.judged,
            });
            (graph.outputs()[picture.output].name.clone(), value)
        })
        .collect();
    let nodes: serde_json::Map<String, Value> = frame
        .nodes
        .iter()
        .map(|node| {
            let why = if let State::LeftOut(why) = &node.state { Some(why.to_string()) } else { None };
            let value = json!({
                "type": node.ty,
                "state": node.state.name(),
                "why": why,
                "seconds": node.seconds,
                "estimated": node.estimated,
                "pixels": node.pixels,
                "bytes": node.bytes,
                "repaired": node.repaired,
                "kept": node.kept,
                "first_repaired": node.first_repaired.as_ref().map(|first| json!({ "pixel": first.pixel, "cause": first.cause })),
                "unseen": node.unseen,
            });
            (node.name.clone(), value)
        })
        .collect();
    json!({
        "frame": frame.number,
        "outputs": outputs,
        "nodes": nodes,
        "groups": groups(graph, frame),
        "seconds": {
            "prepare": frame.seconds.prepare,
            "hull": frame.seconds.hull,
            "tiles": frame.seconds.tiles,
            "write": write_seconds,
        },
        "threads": frame.threads,
    })
}

/// Summarizes the needed and omitted nodes for a picture's metadata, without anything that depends on the state of a
/// cache, so that equal renders make equal files.
#[cfg(feature = "io")]
pub(crate) fn plan_summary(frame: &Frame) -> String {
    summary_of(frame.nodes.iter().map(|node| matches!(node.state, State::LeftOut(_))))
}

/// Summarizes the nodes of a plan; the iterator tells for each whether it is left out.
#[cfg(feature = "io")]
pub(crate) fn summary_of(left_out: impl Iterator<Item = bool>) -> String {
    let (out, kept): (Vec<bool>, Vec<bool>) = left_out.partition(|out| *out);
    format!("{} nodes evaluated, {} left out", kept.len(), out.len())
}

/// Returns a number as JSON, or null if it is infinite, such as the smallest weight of a picture without weights.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

/// Returns the peak memory of this process in bytes; `None` if the system does not report it.
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}
