//! Text form of certificates, and their digests.

use super::{Certificate, PrivateKey, PublicKey, SignatureText, VERSION};
use crate::{LoadError, OutputError};
use std::path::{Path, PathBuf};
use trochoid_engine::{EvalError, PlanError, ReferenceError};

/// Maximum size of a certificate in bytes: its document, a hash for each block of the largest picture, and a byte and a
/// bit for each pixel.
const MAX_BYTES: u64 = 1 << 30;

/// Reason that a certificate could not be made or checked. A certificate that does not hold is not an error.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    /// The file is not a certificate.
    #[error("{}: found {found}; expected a certificate of version {VERSION}, as `trochoid render --certificate` writes it", path.display())]
    NoCertificate {
        /// Path of the file.
        path: PathBuf,
        /// Content of the file.
        found: NoCertificate,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Read(trochoid_io::Error),
    /// The image is not a picture of an output that is certified.
    #[error(
        "{}: found other channels or pixels than those of output \"{output}\"; expected the image that was rendered from \
         the document",
        path.display()
    )]
    OtherImage {
        /// Path of the image.
        path: PathBuf,
        /// Name of the output.
        output: String,
    },
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

/// Mismatch between a certificate's digest and its text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherDigest {
    /// Digest in the certificate.
    pub found: String,
    /// Digest of the text.
    pub expected: String,
}

/// Reason that a certificate's signature is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoSignature {
    /// The key is not an Ed25519 key.
    #[error("a signature by something that is no Ed25519 key")]
    Key,
    /// The key did not make the signature.
    #[error("a signature that the key {0} did not make")]
    Value(Box<PublicKey>),
}

/// Content of a file that is not a certificate.
#[derive(Debug, thiserror::Error)]
pub enum NoCertificate {
    /// Not text.
    #[error("bytes that are not UTF-8")]
    NotText(#[source] Box<trochoid_io::Error>),
    /// Not JSON.
    #[error("no JSON ({0})")]
    NotJson(#[source] serde_json::Error),
    /// A certificate whose document is not JSON.
    #[error("a document that is not JSON ({0})")]
    Document(#[source] serde_json::Error),
    /// JSON of another kind.
    #[error("JSON that does not begin with a digest")]
    NoDigest,
    /// A certificate with missing or invalid fields.
    #[error("other fields ({0})")]
    Fields(#[source] serde_json::Error),
    /// A certificate of another version. Those of version 1 have no bounds of single pixels, so that most of what they
    /// say could not be derived again.
    #[error("version {0}; a certificate of another version must be made anew")]
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
/// What follows the digits if the certificate is signed, up to the end of the signature.
const SIGNATURE: [&str; 2] = ["\",\"signature\":{", "}"];
/// Number of hexadecimal digits in a digest.
pub(super) const DIGITS: usize = 64;

impl Certificate {
    /// Returns the text of the certificate with its digest, signed if a key is given.
    pub fn sealed(&self, key: Option<&PrivateKey>) -> String {
        // The fields are strings, numbers and lists, which JSON can always represent.
        let text = |certificate: &Self| serde_json::to_string_pretty(certificate).unwrap_or_default();
        let blank = Self { digest: "0".repeat(DIGITS), signature: None, ..self.clone() };
        let digest = digest_of(&compact(&text(&blank)));
        let sign = |key: &PrivateKey| SignatureText { key: key.public().to_string(), value: key.sign(&digest) };
        text(&Self { signature: key.map(sign), digest, ..blank }) + "\n"
    }

    /// Writes the certificate with its digest, signed if a key is given; the file appears whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path, key: Option<&PrivateKey>) -> Result<(), OutputError> {
        crate::write_whole(path, self.sealed(key).as_bytes())
    }

    /// Returns the key that signed the certificate; `None` if it is not signed.
    ///
    /// # Errors
    /// The signature is not one of the key that it names.
    pub fn signed_by(&self) -> Result<Option<PublicKey>, NoSignature> {
        let Some(SignatureText { key, value }) = &self.signature else { return Ok(None) };
        let public = PublicKey::parse(key).ok_or(NoSignature::Key)?;
        if public.has_signed(&self.digest, value) { Ok(Some(public)) } else { Err(NoSignature::Value(public.into())) }
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
        // The signature is made after the digest. Whatever stands there has no braces or is no signature.
        let [start, end] = SIGNATURE;
        let unsigned = rest.strip_prefix(start).and_then(|rest| Some(["\"", rest.split_once(end)?.1].concat()));
        let rest = unsigned.as_deref().unwrap_or(rest);
        let expected = digest_of(&[BEGINNING, &"0".repeat(DIGITS), rest].concat());
        if found != expected {
            return Ok(Err(OtherDigest { found: found.into(), expected }));
        }
        // Other versions have other fields.
        if let Ok(Versioned { version }) = serde_json::from_str(&text)
            && version != VERSION
        {
            return Err(none(NoCertificate::Version(version)));
        }
        let certificate = serde_json::from_str(&text).map_err(|error| none(NoCertificate::Fields(error)))?;
        Ok(Ok(certificate))
    }

    /// Returns whether a file is an unchanged certificate of the picture with this fingerprint, signed by this key, or
    /// by any or none.
    pub fn is_current(path: &Path, fingerprint: &str, key: Option<&PublicKey>) -> bool {
        let Ok(Ok(certificate)) = Self::read(path) else { return false };
        let signed = || certificate.signed_by().ok().flatten();
        certificate.fingerprint == fingerprint && key.is_none_or(|key| signed().as_ref() == Some(key))
    }
}

/// The one field that certificates of all versions have.
#[derive(serde::Deserialize)]
struct Versioned {
    version: u32,
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
