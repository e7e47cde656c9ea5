//! Text form of certificates, and their digests.

use super::{Certificate, VERSION};
use crate::{LoadError, OutputError};
use std::path::{Path, PathBuf};
use trochoid_engine::{EvalError, PlanError, ReferenceError};

/// Maximum size of a certificate in bytes: its document, a hash for each block of the largest picture, and a bit for
/// each sample.
const MAX_BYTES: u64 = 1 << 30;

/// Reason that a certificate could not be made or checked. A certificate that does not hold is not an error.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    /// The file is not a certificate.
    #[error("{}: found {found}; expected a certificate of version {VERSION}, as `trochoid render --certificate` writes it", path.display())]
    NoCertificate {
        /// Path of the file.
        path: PathBuf,
        /// What the file is instead.
        found: NoCertificate,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Read(trochoid_io::Error),
    /// A file that its document reads is not where the certificate's folder says.
    #[error(
        "{}: cannot open the file: it does not exist; it is an input of the certificate, sought from the certificate's \
         folder, {}\n  remedy: put the input there, or move the certificate back to the folder that it was written to",
        path.display(), folder.display()
    )]
    NoInput {
        /// Path of the input.
        path: PathBuf,
        /// Folder of the certificate.
        folder: PathBuf,
    },
    /// The certificate cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The image cannot be read.
    #[error(transparent)]
    Image(#[from] trochoid_io::Error),
    /// The certificate's document is not valid in this version of Trochoid.
    #[error(transparent)]
    Document(#[from] LoadError),
    /// The references cannot be evaluated.
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
    /// Returns whether the monitor asked to stop.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Reference(ReferenceError::Eval(EvalError::Cancelled)))
    }
}

/// Start of every certificate without white space, up to the digits of its digest.
const BEGINNING: &str = "{\"digest\":\"";
/// Number of hexadecimal digits in a digest.
pub(super) const DIGITS: usize = 64;

impl Certificate {
    /// Returns the text of the certificate with its digest.
    pub fn sealed(&self) -> String {
        let blank = Self { digest: "0".repeat(DIGITS), ..self.clone() };
        // The fields are strings, numbers and lists, which JSON can always represent.
        let text = serde_json::to_string_pretty(&blank).unwrap_or_default();
        let digest = digest_of(&compact(&text));
        text.replacen(&blank.digest, &digest, 1) + "\n"
    }

    /// Writes the certificate with its digest; the file appears whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        crate::write_whole(path, self.sealed().as_bytes())
    }

    /// Reads a certificate and checks its digest. If the digest does not match, the inner error has the digests that
    /// were found and expected.
    ///
    /// # Errors
    /// The file cannot be read, or is not a certificate.
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

    /// Returns whether a file is an unchanged certificate of the picture with this fingerprint.
    pub fn is_current(path: &Path, fingerprint: &str) -> bool {
        matches!(Self::read(path), Ok(Ok(certificate)) if certificate.fingerprint == fingerprint)
    }
}

/// Returns whether a text consists of 64 lowercase hexadecimal digits.
fn is_digest(text: &str) -> bool {
    text.len() == DIGITS && text.bytes().all(|byte| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte))
}

fn digest_of(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex().to_string()
}

/// Returns JSON text without white space between tokens.
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
