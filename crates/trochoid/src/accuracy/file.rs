//! Plan files: settings that meet a tolerance, as JSON.

use super::{PlannedSettings, displayed_of};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trochoid_graph::{CheckedGraph, MAX_BYTES, Tolerance};

/// Settings that meet a tolerance, for use at other frames or on other machines.
///
/// ```
/// use trochoid::accuracy::PlanFile;
///
/// let text = r#"{"trochoid_plan": 1, "document_hash": "", "frame": 1, "tolerance": "1/64", "set": {"view.points": "surface"},
///                "predicted_seconds": 2.5, "certified": {}}"#;
/// assert_eq!(PlanFile::parse(text)?.assignments(), ["view.points=surface"]);
/// # Ok::<(), trochoid::accuracy::NoPlan>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// Version of the format: 1.
    pub trochoid_plan: u32,
    /// Hash of the document that the plan was made for, without the plan's settings.
    pub document_hash: String,
    /// Frame that the plan was made at.
    pub frame: i64,
    /// Requested tolerance.
    pub tolerance: String,
    /// Values by `NODE.KNOB`.
    pub set: BTreeMap<String, String>,
    /// Predicted seconds for rendering the frame on the machine that made the plan.
    pub predicted_seconds: f64,
    /// Certified errors by output.
    pub certified: BTreeMap<String, CertifiedText>,
}

/// Certified errors of an output, in units of the working space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedText {
    /// Largest bound of a sample that is not ambiguous; `None` if there is no bound.
    pub max: Option<f64>,
    /// 99.9th percentile of those bounds; `None` if there is no bound.
    pub p999: Option<f64>,
    /// Bound of the displayed values of a sample that is not ambiguous; `None` for outputs that are not displayed.
    #[serde(default)]
    pub displayed_max: Option<f64>,
    /// Share of ambiguous samples.
    pub ambiguous_share: f64,
}

/// Reason that a plan cannot be read from a file.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(trochoid_io::Error),
    /// The file holds something else.
    #[error("{}: {source}", path.display())]
    NoPlan {
        /// Path of the file.
        path: PathBuf,
        /// What was found, and what was expected.
        source: NoPlan,
    },
}

/// Error in a plan file.
#[derive(Debug, thiserror::Error)]
pub enum NoPlan {
    /// Not text.
    #[error("found bytes that are not UTF-8; expected a plan")]
    NotText(#[source] Box<trochoid_io::Error>),
    /// Not JSON.
    #[error("found no JSON ({0}); {EXPECTED}")]
    NotJson(#[source] serde_json::Error),
    /// A document instead of a plan.
    #[error("found a document; {EXPECTED}")]
    Document,
    /// JSON of another kind.
    #[error("found JSON without \"trochoid_plan\"; {EXPECTED}")]
    OtherJson,
    /// A plan of an unknown version.
    #[error("found a plan of version {0}; expected version {VERSION}")]
    Version(Value),
    /// Missing or invalid fields.
    #[error("found a plan with faults ({0}); {EXPECTED}")]
    Fields(#[source] serde_json::Error),
    /// An invalid tolerance.
    #[error("found the tolerance \"{found}\"; expected {}", Tolerance::EXPECTED)]
    Tolerance {
        /// Text of the tolerance.
        found: String,
    },
}

const VERSION: u32 = 1;
const EXPECTED: &str = "expected a plan as `trochoid plan --out` writes it";

impl PlanFile {
    /// Creates the plan file of a document.
    pub fn new(graph: &CheckedGraph, frame: i64, tolerance: Tolerance, planned: &PlannedSettings) -> Self {
        let finite = |value: f64| value.is_finite().then_some(value);
        let certified = planned.certified.iter().map(|certified| {
            let all = certified.clear.total() + certified.unclear.total();
            let text = CertifiedText {
                max: finite(certified.clear.max()),
                p999: finite(certified.clear.quantile(0.999)),
                displayed_max: displayed_of(certified.kind, certified.clear.max(), graph.space()),
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

    /// Parses a plan.
    ///
    /// # Errors
    /// It is no plan; what was found, and what was expected.
    pub fn parse(text: &str) -> Result<Self, NoPlan> {
        let value: Value = serde_json::from_str(text).map_err(NoPlan::NotJson)?;
        // What it is says more than which of a plan's fields it lacks.
        match value.get("trochoid_plan") {
            None if value.get("trochoid").is_some() && value.get("nodes").is_some() => {
                return Err(NoPlan::Document);
            }
            None => return Err(NoPlan::OtherJson),
            Some(version) if version.as_u64() != Some(VERSION.into()) => return Err(NoPlan::Version(version.clone())),
            Some(_) => {}
        }
        let plan: Self = serde_json::from_str(text).map_err(NoPlan::Fields)?;
        if Tolerance::parse(&plan.tolerance).is_none() {
            return Err(NoPlan::Tolerance { found: plan.tolerance });
        }
        Ok(plan)
    }

    /// Reads a plan from a file.
    ///
    /// # Errors
    /// The file cannot be read, or is not a plan.
    pub fn read(path: &Path) -> Result<Self, PlanFileError> {
        let none = |source: NoPlan| PlanFileError::NoPlan { path: path.into(), source };
        let text = trochoid_io::read_text(path, MAX_BYTES as u64).map_err(|error| match error {
            error @ trochoid_io::Error::NotText { .. } => none(NoPlan::NotText(error.into())),
            error => PlanFileError::Read(error),
        })?;
        Self::parse(&text).map_err(none)
    }

    /// Returns the plan as JSON.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Returns the assignments `NODE.KNOB=VALUE` for [`load`](crate::load()).
    pub fn assignments(&self) -> Vec<String> {
        self.set.iter().map(|(knob, value)| format!("{knob}={value}")).collect()
    }
}
