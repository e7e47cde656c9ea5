//! A certificate as text, and the digest over itself.

use super::{Certificate, VERSION};
use crate::{LoadError, OutputError};
use std::path::{Path, PathBuf};
use trochoid_engine::{EvalError, PlanError, ReferenceError};

/// Most bytes of a certificate: its document, a hash for each block of the largest picture, and a bit for each sample.
const MAX_BYTES: u64 = 1 << 30;

/// Why a certificate could not be made or checked; that one does not hold is no error.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    /// The file is no certificate.
    #[error("{}: found {found}; expected a certificate of version {VERSION}, as `trochoid render --certificate` writes it", path.display())]
    NoCertificate {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: NoCertificate,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Read(trochoid_io::Error),
    /// A file that its document reads is not where the certificate's folder says.
    #[error(
        "{}: cannot open the file: there is none; it is an input of the certificate, and sought from the certificate's folder, \
         {}\n  remedy: put the input there, or the certificate back into the folder that it was written into",
        path.display(), folder.display()
    )]
    NoInput {
        /// The input.
        path: PathBuf,
        /// The certificate's folder.
        folder: PathBuf,
    },
    /// The certificate cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The image cannot be read.
    #[error(transparent)]
    Image(#[from] trochoid_io::Error),
    /// The certificate's document is none of this version of Trochoid.
    #[error(transparent)]
    Document(#[from] LoadError),
    /// The references cannot be had.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
}

/// A digest that is not the one of the text around it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherDigest {
    /// The digest in the certificate.
    pub found: String,
    /// The digest of its text.
    pub expected: String,
}

/// What a file is that is no certificate.
#[derive(Debug, thiserror::Error)]
pub enum NoCertificate {
    /// No text.
    #[error("bytes that are no UTF-8")]
    NotText(#[source] Box<trochoid_io::Error>),
    /// No JSON.
    #[error("no JSON ({0})")]
    NotJson(#[source] serde_json::Error),
    /// One whose document is no JSON.
    #[error("a document that is no JSON ({0})")]
    Document(#[source] serde_json::Error),
    /// Other JSON.
    #[error("JSON that does not begin with a digest")]
    NoDigest,
    /// JSON with other fields than a certificate.
    #[error("other fields ({0})")]
    Fields(#[source] serde_json::Error),
    /// A certificate of another version.
    #[error("version {0}")]
    Version(u32),
}

impl From<PlanError> for CertificateError {
    fn from(error: PlanError) -> Self {
        Self::Reference(error.into())
    }
}

impl From<EvalError> for CertificateError {
    fn from(error: EvalError) -> Self {
        Self::Reference(error.into())
    }
}

impl CertificateError {
    /// Whether the monitor asked to stop.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Reference(ReferenceError::Eval(EvalError::Cancelled)))
    }
}

/// How every certificate begins, up to its digest's digits; without white space.
const BEGINNING: &str = "{\"digest\":\"";
/// Hexadecimal digits of a digest.
pub(super) const DIGITS: usize = 64;

impl Certificate {
    /// The text, with the digest that it should have.
    pub fn sealed(&self) -> String {
        let blank = Self { digest: "0".repeat(DIGITS), ..self.clone() };
        // Strings, numbers and lists alone: nothing that JSON could not hold.
        let text = serde_json::to_string_pretty(&blank).unwrap_or_default();
        let digest = digest_of(&compact(&text));
        text.replacen(&blank.digest, &digest, 1) + "\n"
    }

    /// Writes the certificate, sealed; the file appears whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        crate::write_whole(path, self.sealed().as_bytes())
    }

    /// Reads a certificate whose digest holds; or says what digest was found where which was expected.
    ///
    /// # Errors
    /// The file cannot be read, or is no certificate.
    pub fn read(path: &Path) -> Result<Result<Self, OtherDigest>, CertificateError> {
        let none = |found: NoCertificate| CertificateError::NoCertificate { path: path.into(), found };
        let text = trochoid_io::read_text(path, MAX_BYTES).map_err(|error| match error {
            error @ trochoid_io::Error::NotText { .. } => none(NoCertificate::NotText(error.into())),
            error => CertificateError::Read(error),
        })?;
        if let Err(error) = serde_json::from_str::<serde::de::IgnoredAny>(&text) {
            return Err(none(NoCertificate::NotJson(error)));
        }
        let compact = compact(&text);
        let rest = compact.strip_prefix(BEGINNING).filter(|rest| rest.get(..DIGITS).is_some_and(is_digest));
        let Some(rest) = rest else { return Err(none(NoCertificate::NoDigest)) };
        let (found, rest) = rest.split_at(DIGITS);
        let expected = digest_of(&[BEGINNING, &"0".repeat(DIGITS), rest].concat());
        if found != expected {
            return Ok(Err(OtherDigest { found: found.into(), expected }));
        }
        let certificate: Self = serde_json::from_str(&text).map_err(|error| none(NoCertificate::Fields(error)))?;
        if certificate.version != VERSION {
            return Err(none(NoCertificate::Version(certificate.version)));
        }
        Ok(Ok(certificate))
    }

    /// Whether a file holds a certificate of the picture of this fingerprint, unchanged since it was written.
    pub fn is_current(path: &Path, fingerprint: &str) -> bool {
        matches!(Self::read(path), Ok(Ok(certificate)) if certificate.fingerprint == fingerprint)
    }
}

/// Whether a text is 64 hexadecimal digits.
fn is_digest(text: &str) -> bool {
    text.len() == DIGITS && text.bytes().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte))
}

fn digest_of(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

/// JSON without the white space between its tokens.
fn compact(text: &str) -> String {
    let (mut quoted, mut escaped) = (false, false);
    let mut kept = |c: &char| {
        if quoted {
            quoted = escaped || *c != '"';
            escaped = !escaped && *c == '\\';
            return true;
        }
        quoted = *c == '"';
        !matches!(c, ' ' | '\t' | '\n' | '\r')
    };
    text.chars().filter(|c| kept(c)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_space_goes_only_between_tokens() {
        let text = "{ \"a b\" : [ 1,\n\t\"c \\\" d\\\\\" , 2 ] }";
        assert_eq!(compact(text), "{\"a b\":[1,\"c \\\" d\\\\\",2]}");
    }
}
