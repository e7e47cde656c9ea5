//! Failures of decoding a chunk.

/// Reason that a chunk cannot be decoded.
#[derive(Debug)]
pub(super) enum Failure {
    Invalid {
        found: String,
        expected: String,
    },
    Unsupported(&'static str),
    /// This many bytes of memory are not available.
    Memory(u64),
}

impl Failure {
    pub(super) fn invalid(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Invalid { found: found.into(), expected: expected.into() }
    }
}

/// Expectation for every chunk, for messages.
pub(super) const WHOLE: &str = "a chunk that decodes to its pixels";

impl From<exr::error::Error> for Failure {
    fn from(error: exr::error::Error) -> Self {
        match error {
            exr::error::Error::NotSupported(_) => Self::Unsupported("a chunk of a kind that is not known"),
            // The library's own message does not say what to do.
            _ => Self::invalid("bytes that do not decode", WHOLE),
        }
    }
}
