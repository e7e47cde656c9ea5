//! Plans as files.

use super::Planned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trochoid_graph::{CheckedGraph, MAX_BYTES, Tolerance};

/// Settings that meet a tolerance, to be used again: at other frames, on other machines.
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

/// Why there is no plan in a file.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(trochoid_io::Error),
    /// The file holds something else.
    #[error("{}: {source}", path.display())]
    NoPlan {
        /// The file.
        path: PathBuf,
        /// What was found, and what was expected.
        source: NoPlan,
    },
}

/// Why a text is no plan.
#[derive(Debug, thiserror::Error)]
pub enum NoPlan {
    /// It is no text.
    #[error("found bytes that are no UTF-8; expected a plan")]
    NotText(#[source] Box<trochoid_io::Error>),
    /// It is no JSON.
    #[error("found no JSON ({0}); {EXPECTED}")]
    NotJson(#[source] serde_json::Error),
    /// It is a document.
    #[error("found a document; {EXPECTED}")]
    Document,
    /// It is other JSON.
    #[error("found JSON without \"trochoid_plan\"; {EXPECTED}")]
    OtherJson,
    /// It is a plan of another version.
    #[error("found a plan of version {0}; expected version {VERSION}")]
    Version(Value),
    /// It has other fields than a plan.
    #[error("found a plan with faults ({0}); {EXPECTED}")]
    Fields(#[source] serde_json::Error),
    /// Its tolerance is none.
    #[error("found the tolerance \"{found}\"; expected {}", Tolerance::EXPECTED)]
    Tolerance {
        /// What it is.
        found: String,
    },
}

const VERSION: u32 = 1;
const EXPECTED: &str = "expected a plan as `trochoid plan --out` writes it";

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

    /// From a file.
    ///
    /// # Errors
    /// It cannot be read, or is no plan.
    pub fn read(path: &Path) -> Result<Self, PlanFileError> {
        let none = |source: NoPlan| PlanFileError::NoPlan { path: path.into(), source };
        let text = trochoid_io::read_text(path, MAX_BYTES as u64).map_err(|error| match error {
            error @ trochoid_io::Error::NotText { .. } => none(NoPlan::NotText(error.into())),
            error => PlanFileError::Read(error),
        })?;
        Self::parse(&text).map_err(none)
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
