//! Keys that sign certificates and that signatures are checked with: Ed25519, in files as OpenSSL makes them.

use ed25519_dalek::pkcs8::{DecodePrivateKey, DecodePublicKey};
use ed25519_dalek::{Signature, Signer, SigningKey, VerifyingKey};
use std::fmt;
use std::path::{Path, PathBuf};

/// Maximum size of a file with a key, in bytes.
const MAX_BYTES: u64 = 1 << 16;

/// Start of what is signed, before the digits of the digest: no other text that someone signs looks like this.
const SIGNED: &str = "trochoid certificate ";

/// Private key, which signs certificates. It is never shown.
pub struct PrivateKey(SigningKey);

/// Public key, which checks the signatures of one private key. It is shown as 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct PublicKey(VerifyingKey);

/// Reason that a file gives no key.
#[derive(Debug, thiserror::Error)]
pub enum KeyError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(trochoid_io::Error),
    /// The file holds something else.
    #[error("{}: found {found}; expected {expected}\n  remedy: {remedy}", path.display())]
    NoKey {
        /// Path of the file.
        path: PathBuf,
        /// What it holds.
        found: &'static str,
        /// The kind of key that is needed.
        expected: &'static str,
        /// How to get one.
        remedy: &'static str,
    },
}

/// A kind of key, in words for errors.
struct KeyKind {
    expected: &'static str,
    remedy: &'static str,
}

const PRIVATE: KeyKind = KeyKind {
    expected: "an unencrypted Ed25519 private key, as PEM of PKCS #8",
    remedy: "make one: openssl genpkey -algorithm ed25519 -out mine.pem",
};
const PUBLIC: KeyKind = KeyKind {
    expected: "an Ed25519 public key, as PEM",
    remedy: "take it from the private key: openssl pkey -in mine.pem -pubout -out mine.pub.pem",
};

/// Reads a file with a key, and decodes it.
fn read<K>(path: &Path, kind: &KeyKind, decode: impl FnOnce(&str) -> Option<K>) -> Result<K, KeyError> {
    let none = |found| KeyError::NoKey { path: path.into(), found, expected: kind.expected, remedy: kind.remedy };
    let text = trochoid_io::read_text(path, MAX_BYTES).map_err(|error| match error {
        trochoid_io::Error::NotText { .. } => none("bytes that are not text"),
        error => KeyError::Read(error),
    })?;
    // Whoever takes one file for the other should know, but nothing of a private key may be shown.
    let found = match text.lines().find(|line| line.starts_with("-----BEGIN ")) {
        Some("-----BEGIN PRIVATE KEY-----") => "a private key of another kind",
        Some("-----BEGIN PUBLIC KEY-----") => "a public key of another kind",
        Some("-----BEGIN ENCRYPTED PRIVATE KEY-----") => "an encrypted private key",
        Some("-----BEGIN OPENSSH PRIVATE KEY-----") => "a private key of OpenSSH",
        Some("-----BEGIN CERTIFICATE-----") => "an X.509 certificate",
        Some(_) => "PEM of another kind",
        None => "no PEM",
    };
    let other = match (found, decode(&text)) {
        (_, Some(key)) => return Ok(key),
        ("a private key of another kind", None) if SigningKey::from_pkcs8_pem(&text).is_ok() => "a private key",
        ("a public key of another kind", None) if VerifyingKey::from_public_key_pem(&text).is_ok() => "a public key",
        (found, None) => found,
    };
    Err(none(other))
}

impl PrivateKey {
    /// Reads a private key: PEM of PKCS #8, as `openssl genpkey -algorithm ed25519` writes it.
    ///
    /// # Errors
    /// The file cannot be read, or holds no such key.
    pub fn read(path: &Path) -> Result<Self, KeyError> {
        read(path, &PRIVATE, |text| SigningKey::from_pkcs8_pem(text).ok().map(Self))
    }

    /// Returns the public key that checks its signatures.
    pub fn public(&self) -> PublicKey {
        PublicKey(self.0.verifying_key())
    }

    /// Signs a digest; the signature is in hexadecimal digits.
    pub(super) fn sign(&self, digest: &str) -> String {
        in_hex(&self.0.sign(signed(digest).as_bytes()).to_bytes())
    }
}

impl PublicKey {
    /// Reads a public key: PEM, as `openssl pkey -pubout` writes it.
    ///
    /// # Errors
    /// The file cannot be read, or holds no such key.
    pub fn read(path: &Path) -> Result<Self, KeyError> {
        read(path, &PUBLIC, |text| VerifyingKey::from_public_key_pem(text).ok().map(Self))
    }

    /// Reads a key of 64 hexadecimal digits; `None` if they are not those of a key.
    pub(super) fn parse(digits: &str) -> Option<Self> {
        VerifyingKey::from_bytes(&from_hex(digits)?).ok().map(Self)
    }

    /// Returns whether its private key signed a digest.
    pub(super) fn has_signed(&self, digest: &str, signature: &str) -> bool {
        let signature = from_hex(signature).map(|bytes| Signature::from_bytes(&bytes));
        // Strictly, so that no signature fits several keys or texts.
        signature.is_some_and(|signature| self.0.verify_strict(signed(digest).as_bytes(), &signature).is_ok())
    }
}

/// Returns the text that is signed for a digest.
fn signed(digest: &str) -> String {
    format!("{SIGNED}{digest}")
}

fn in_hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn from_hex<const N: usize>(digits: &str) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    if digits.len() != 2 * N || !digits.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f')) {
        return None;
    }
    for (byte, at) in bytes.iter_mut().zip((0..).step_by(2)) {
        *byte = u8::from_str_radix(&digits[at..at + 2], 16).ok()?;
    }
    Some(bytes)
}

impl fmt::Display for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&in_hex(self.0.as_bytes()))
    }
}

impl fmt::Debug for PublicKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PublicKey({self})")
    }
}

impl fmt::Debug for PrivateKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "PrivateKey of {}", self.public())
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Keys of RFC 8410, 10.1 and 10.3, as OpenSSL writes them.
    pub(in crate::certificate) const PRIVATE_PEM: &str = "-----BEGIN PRIVATE KEY-----\n\
        MC4CAQAwBQYDK2VwBCIEINTuctv5E1hK1bbY8fdp+K06/nwoy/HU++CXqI9EdVhC\n-----END PRIVATE KEY-----\n";
    pub(in crate::certificate) const PUBLIC_PEM: &str = "-----BEGIN PUBLIC KEY-----\n\
        MCowBQYDK2VwAyEAGb9ECWmEzf6FQbrBZ9w7lshQhqowtrbLDFw4rXAxZuE=\n-----END PUBLIC KEY-----\n";

    #[test]
    fn keys_of_openssl_are_read_and_fit_each_other() {
        let folder = tempfile::tempdir().expect("a folder");
        let [private, public] = ["a.pem", "b.pem"].map(|name| folder.path().join(name));
        std::fs::write(&private, PRIVATE_PEM).expect("written");
        std::fs::write(&public, PUBLIC_PEM).expect("written");
        let (key, known) = (PrivateKey::read(&private).expect("a key"), PublicKey::read(&public).expect("a key"));
        assert_eq!(key.public(), known);
        assert_eq!(known.to_string(), "19bf44096984cdfe8541bac167dc3b96c85086aa30b6b6cb0c5c38ad703166e1");
        assert_eq!(PublicKey::parse(&known.to_string()), Some(known));
        let signature = key.sign("5");
        assert!(known.has_signed("5", &signature) && !known.has_signed("6", &signature));
        assert!(!format!("{key:?}").contains("d4ee72db"), "the private key begins with these bytes");
        for (path, kind) in [(&private, "a private key;"), (&public, "a public key;")] {
            let told = [PrivateKey::read(path).err(), PublicKey::read(path).err()];
            let told: Vec<String> = told.into_iter().flatten().map(|error| error.to_string()).collect();
            assert!(told.len() == 1 && told[0].contains(kind), "{told:?}");
            assert!(told[0].contains("expected an") && told[0].contains("remedy: "), "{told:?}");
        }
        for (text, kind) in [("MC4CAQ", "no PEM"), ("-----BEGIN OPENSSH PRIVATE KEY-----", "a private key of OpenSSH")]
        {
            std::fs::write(&private, text).expect("written");
            let told = PrivateKey::read(&private).expect_err("no key").to_string();
            assert!(told.contains(kind) && !told.contains("MC4"), "{told}");
        }
        std::fs::write(&private, [0xff]).expect("written");
        assert!(PrivateKey::read(&private).expect_err("no key").to_string().contains("not text"));
        assert!(matches!(PrivateKey::read(&folder.path().join("none")), Err(KeyError::Read(_))));
    }

    #[test]
    fn hexadecimal_digits_come_back_and_others_do_not() {
        assert_eq!(from_hex::<3>(&in_hex(&[0, 171, 255])), Some([0, 171, 255]));
        for text in ["", "0g", "+1", "AB", "éé", "123"] {
            assert_eq!(from_hex::<1>(text), None, "{text}");
        }
        // A number that is no point of the curve, and one of small order.
        assert_eq!(PublicKey::parse(&format!("02{}", "0".repeat(62))), None);
    }
}
