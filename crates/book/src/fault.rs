//! What can be wrong with the book.

use std::path::PathBuf;
use trochoid::{Diagnostic, EvalError, LoadError, OutputError, PlanError};

/// What is wrong with the book: each with its place.
pub(crate) type Faults = Vec<Fault>;

/// One thing that is wrong with the book.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Fault {
    #[error(transparent)]
    Read(#[from] trochoid::io::Error),
    /// A file or folder cannot be written, copied, removed or entered.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error("the node {node} has no document that shows it: {source}")]
    NoDocument { node: &'static str, source: Box<trochoid::io::Error> },
    #[error(transparent)]
    Document(#[from] LoadError),
    /// A document of the book is an example: it has no warnings either.
    #[error("{0}")]
    Warning(Box<Diagnostic>),
    #[error("{document}: no output")]
    NoOutput { document: String },
    #[error("{document}: {source}")]
    Plan { document: String, source: Box<PlanError> },
    #[error("{document}: {source}")]
    Evaluation { document: String, source: Box<EvalError> },
    #[error("{document}: {pixels} pixels outside the hull of the control colors")]
    Outside { document: String, pixels: u64 },
    #[error("{document}: {source}")]
    Picture { document: String, source: Box<OutputError> },
    #[error(
        "{stored}: is not what the document {document} makes\n  remedy: look at it, then `cp {rendered} {stored}`",
        stored = stored.display(), rendered = rendered.display()
    )]
    OtherPicture { stored: PathBuf, document: String, rendered: PathBuf },
    #[error("{page}: stands in no line of SUMMARY.md")]
    Unlisted { page: String },
    #[error("{}: {target} is no page of the book", page.display())]
    NoPage { page: PathBuf, target: String },
    #[error("{page}: found a link to {target}; expected {}", fault.expected())]
    Link { page: String, target: String, fault: LinkFault },
    /// mdBook fails.
    #[cfg(feature = "html")]
    #[error("{0:#}")]
    Html(#[source] mdbook_driver::errors::Error),
    /// mdBook warns, in these words.
    #[cfg(feature = "html")]
    #[error("{0}")]
    Warned(String),
}

impl Fault {
    /// The fault as it is printed: those of documents say themselves whether they are errors.
    pub(crate) fn told(&self) -> String {
        match self {
            Self::Document(LoadError::Invalid(_)) | Self::Warning(_) => self.to_string(),
            fault => format!("error: {fault}"),
        }
    }
}

/// What a link leads to in vain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LinkFault {
    Page,
    Heading,
}

impl LinkFault {
    fn expected(self) -> &'static str {
        match self {
            Self::Page => "one to a page or file of the book",
            Self::Heading => "a heading of that page",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_fault_is_called_an_error_once() {
        let document = r#"{ "trochoid": 1, "format": { "width": 4 } }"#;
        let invalid: Fault = trochoid::parse("a.json", document, Path::new("."), &[]).expect_err("faulty").into();
        let told = invalid.told();
        assert!(told.starts_with("error: a.json:1:"), "{told}");
        assert!(told.lines().all(|line| line.matches("error:").count() < 2), "{told}");
        let page = Fault::Unlisted { page: "a.md".into() };
        assert_eq!(page.told(), "error: a.md: stands in no line of SUMMARY.md");
    }
}
