//! Plans as files.

use super::Planned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trochoid_graph::{CheckedGraph, Tolerance};

/// Settings that meet a tolerance, to be used again: at other frames, on other machines.
///
/// ```
/// use trochoid::accuracy::PlanFile;
///
/// let text = r#"{"trochoid_plan": 1, "document_hash": "", "frame": 1, "tolerance": "1/64", "set": {"view.points": "surface"},
///                "predicted_seconds": 2.5, "certified": {}}"#;
/// assert_eq!(PlanFile::parse(text)?.assignments(), ["view.points=surface"]);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// The version of this form: 1.
    pub trochoid_plan: u32,
    /// The document that it was made for, as its own settings have it.
    pub document_hash: String,
    /// The frame at which it was found.
    pub frame: i64,
    /// What was asked for.
    pub tolerance: String,
    /// By `NODE.KNOB`, its value.
    pub set: BTreeMap<String, String>,
    /// Seconds that rendering the frame was to take on the machine where it was found.
    pub predicted_seconds: f64,
    /// By output, what is certain of it.
    pub certified: BTreeMap<String, CertifiedText>,
}

/// What is certain of an output's errors, in units of the working space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedText {
    /// The largest bound of a sample in no doubt; `None` where nothing is known.
    pub max: Option<f64>,
    /// What 99.9 % of those bounds do not pass.
    pub p999: Option<f64>,
    /// The share of samples in doubt.
    pub ambiguous_share: f64,
}

/// Why a plan cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct PlanFileError {
    /// The file.
    pub path: PathBuf,
    /// What was found, and what was expected.
    pub reason: String,
}

const VERSION: u32 = 1;

impl PlanFile {
    /// What was planned for a document.
    pub fn new(graph: &CheckedGraph, frame: i64, tolerance: Tolerance, planned: &Planned) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        let certified = planned.certified.iter().map(|certified| {
            let all = certified.clear.total() + certified.unclear.total();
            let text = CertifiedText {
                max: finite(certified.clear.max()),
                p999: finite(certified.clear.quantile(0.999)),
                ambiguous_share: certified.unclear.total() as f64 / all.max(1) as f64,
            };
            (graph.outputs()[certified.output].name.clone(), text)
        });
        let set = planned.set.iter().filter_map(|assignment| assignment.split_once('='));
        Self {
            trochoid_plan: VERSION,
            document_hash: graph.document_hash(),
            frame,
            tolerance: tolerance.to_string(),
            set: set.map(|(knob, value)| (knob.to_owned(), value.to_owned())).collect(),
            predicted_seconds: planned.predicted,
            certified: certified.collect(),
        }
    }

    /// From a text.
    ///
    /// # Errors
    /// It is no plan; what was found, and what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let plan: Self = serde_json::from_str(text)
            .map_err(|error| format!("found {error}; expected a plan as `trochoid plan` writes it"))?;
        if plan.trochoid_plan != VERSION {
            return Err(format!("found a plan of version {}; expected version {VERSION}", plan.trochoid_plan));
        }
        Ok(plan)
    }

    /// From a file.
    ///
    /// # Errors
    /// It cannot be read, or is no plan.
    pub fn read(path: &Path) -> Result<Self, PlanFileError> {
        let fault = |reason: String| PlanFileError { path: path.into(), reason };
        let text = std::fs::read_to_string(path).map_err(|error| fault(format!("cannot be read: {error}")))?;
        Self::parse(&text).map_err(fault)
    }

    /// As JSON.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Assignments for [`load`](crate::load()), `NODE.KNOB=VALUE`.
    pub fn assignments(&self) -> Vec<String> {
        self.set.iter().map(|(knob, value)| format!("{knob}={value}")).collect()
    }
}
