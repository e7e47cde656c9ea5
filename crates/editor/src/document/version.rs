//! The format version of a document, compared with the one this program supports.

use super::change::Edit;
use super::json::{Op, Path};
use serde_json::Value;
use trochoid::FORMAT_VERSION;

/// Relation between a document's format version and the supported one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum VersionStatus {
    /// The supported version.
    Current,
    /// A newer version, as written in the document; its meaning is unknown to this program.
    Newer(String),
    /// A number that was never a version, or a missing version.
    Unknown(Option<String>),
}

impl VersionStatus {
    /// Reads the version from a parsed document.
    pub fn of(document: &Value) -> Self {
        let Some(entries) = document.as_object() else { return Self::Current };
        match entries.get("trochoid") {
            Some(Value::Number(version)) => match version.as_f64() {
                Some(number) if number == f64::from(FORMAT_VERSION) => Self::Current,
                Some(number) if number > f64::from(FORMAT_VERSION) => Self::Newer(version.to_string()),
                _ => Self::Unknown(Some(version.to_string())),
            },
            other => Self::Unknown(other.map(Value::to_string)),
        }
    }

    /// Returns whether the document's version is newer than this program supports.
    pub fn is_newer(&self) -> bool {
        matches!(self, Self::Newer(_))
    }

    /// Returns the message for the user; `None` if the version is current.
    pub fn notice(&self) -> Option<String> {
        let expected = format!("expected {FORMAT_VERSION}, the version of the document format");
        match self {
            Self::Current => None,
            Self::Newer(found) => Some(format!(
                "This document uses format version {found}; this editor supports version {FORMAT_VERSION}. It is shown \
                 as far as it is understood, but not evaluated. The file stays unchanged unless you save. Open it with \
                 a newer version of Trochoid."
            )),
            Self::Unknown(None) => {
                Some(format!("Found no \"trochoid\" entry at the top level of the document; {expected}."))
            }
            Self::Unknown(Some(found)) => Some(format!("Found \"trochoid\": {found}; {expected}.")),
        }
    }

    /// Returns the edit that sets the current version in a document with an unknown one. This is also the only place
    /// for upgrading documents of older versions, once there are any.
    pub fn remedy(&self) -> Option<Edit> {
        let Self::Unknown(_) = self else { return None };
        let place = Path::default().to("trochoid");
        Some(Edit::new("Set the format version", vec![Op::Set(place, FORMAT_VERSION.to_string())]))
    }
}
