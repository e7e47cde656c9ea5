//! Which version of the document format a document is of.

use super::change::Edit;
use super::json::{Op, Path};
use serde_json::Value;
use trochoid::FORMAT_VERSION;

/// How a document's version stands to the one that is known here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum VersionStatus {
    /// It is the same.
    Current,
    /// It is a newer one, as the document writes it: what it means is not known here.
    Newer(String),
    /// It is none that there ever was, or the document names none.
    Unknown(Option<String>),
}

impl VersionStatus {
    /// Reads it from a document's value.
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

    /// Whether the document is of a version newer than this program.
    pub fn is_newer(&self) -> bool {
        matches!(self, Self::Newer(_))
    }

    /// What was found, what is expected and what is to be done; `None` where all is well.
    pub fn notice(&self) -> Option<String> {
        let expected = format!("expected {FORMAT_VERSION}, the version of the document format");
        match self {
            Self::Current => None,
            Self::Newer(found) => Some(format!(
                "This document is of version {found} of the format, and this editor knows version {FORMAT_VERSION}. It is \
                 shown as far as it is understood, and not evaluated; its file stays as it is unless you save it. Open it with \
                 a newer Trochoid."
            )),
            Self::Unknown(None) => Some(format!("Found no \"trochoid\" at the top of the document; {expected}.")),
            Self::Unknown(Some(found)) => Some(format!("Found \"trochoid\": {found}; {expected}.")),
        }
    }

    /// The change that makes a document one of the present version. There is one for documents that lack it; a document of
    /// an older version, once there are any, is brought up to date here and nowhere else.
    pub fn remedy(&self) -> Option<Edit> {
        let Self::Unknown(_) = self else { return None };
        let place = Path::default().to("trochoid");
        Some(Edit::new("Write the version", vec![Op::Set(place, FORMAT_VERSION.to_string())]))
    }
}
