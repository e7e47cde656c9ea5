//! Signatures: those that are right hold, and no change, move or loss of one passes.

use super::*;

/// Certificates of [`SKY`]'s depth, signed by the key of RFC 8410; and that key's public key.
fn signed(studio: &Studio) -> (PathBuf, PathBuf, PublicKey) {
    std::fs::write(studio.path("mine.pem"), keys::tests::PRIVATE_PEM).expect("written");
    let key = PrivateKey::read(&studio.path("mine.pem")).expect("a key");
    studio.make(1);
    let (certificate, image) = (studio.path("depth.certificate.json"), studio.path("depth.exr"));
    let read = Certificate::read(&certificate).expect("read").expect("sealed");
    read.write(&certificate, Some(&key)).expect("written");
    (certificate, image, key.public())
}

/// Returns what does not hold of a certificate that must be signed by a key, or need not be signed.
fn failures_of(certificate: &Path, image: &Path, key: Option<&PublicKey>) -> Vec<String> {
    let choice = Choice::Some(9);
    let request = Request { certificate, image, choice, seed: 1, key, document: None, access: None };
    match verify(&request, &Silent) {
        Ok(found) => found.failures.iter().map(ToString::to_string).collect(),
        Err(error) => vec![error.to_string()],
    }
}

#[test]
fn signed_certificates_hold_with_their_key_and_with_none() {
    let studio = Studio::new(SKY);
    let (certificate, image, key) = signed(&studio);
    let read = Certificate::read(&certificate).expect("read").expect("sealed");
    assert_eq!(read.signed_by(), Ok(Some(key)));
    for key in [None, Some(&key)] {
        assert_eq!(failures_of(&certificate, &image, key), [""; 0]);
    }
    assert!(Certificate::is_current(&certificate, &read.fingerprint, Some(&key)));
    // White space says nothing, and the digest is that of the certificate without a signature.
    let text = std::fs::read_to_string(&certificate).expect("there");
    std::fs::write(studio.path("lines.json"), text.replace('\n', "\r\n ")).expect("written");
    assert_eq!(failures_of(&studio.path("lines.json"), &image, Some(&key)), [""; 0]);
    read.write(&studio.path("bare.json"), None).expect("written");
    let bare = Certificate::read(&studio.path("bare.json")).expect("read").expect("sealed");
    assert_eq!((bare.signed_by(), &bare.digest), (Ok(None), &read.digest));
    assert!(!Certificate::is_current(&studio.path("bare.json"), &bare.fingerprint, Some(&key)));
    assert!(Certificate::is_current(&studio.path("bare.json"), &bare.fingerprint, None));
}

#[test]
fn no_game_with_signatures_passes() {
    let studio = Studio::new(SKY);
    let (certificate, image, key) = signed(&studio);
    let text = std::fs::read_to_string(&certificate).expect("there");
    let read = Certificate::read(&certificate).expect("read").expect("sealed");
    let signature = read.signature.clone().expect("signed");
    let other = "b7".repeat(32);
    let fails = |text: &str, key: Option<&PublicKey>, words: &str| {
        std::fs::write(studio.path("forged.json"), text).expect("written");
        let failed = failures_of(&studio.path("forged.json"), &image, key);
        assert!(failed.iter().any(|failed| failed.contains(words)), "{words}: {failed:?}");
    };
    let flipped = |digits: &str| format!("{}{}", if digits.starts_with('0') { '1' } else { '0' }, &digits[1..]);
    // A signature that was changed, of another key, or of another certificate.
    fails(&text.replace(&signature.value, &flipped(&signature.value)), None, "did not make");
    fails(&text.replace(&signature.value, &signature.value.to_uppercase()), None, "did not make");
    fails(&text.replace(&signature.value, ""), None, "did not make");
    fails(&text.replace(&signature.key, &other), None, "signature");
    fails(&text.replace(&signature.key, "me"), None, "no Ed25519 key");
    let of_beauty = Certificate::read(&studio.path("beauty.certificate.json")).expect("read").expect("sealed");
    let private = PrivateKey::read(&studio.path("mine.pem")).expect("a key");
    fails(&text.replace(&signature.value, &private.sign(&of_beauty.digest)), None, "did not make");
    // One that was taken away where it is asked for, or moved to a changed certificate.
    let bare = read.sealed(None);
    fails(&bare, Some(&key), "found no signature; expected one by 19bf44096984cdfe");
    let changed = Certificate { frame: 2, ..read.clone() }.sealed(None);
    let digits = changed.split('"').nth(3).expect("a digest").to_string();
    let start = format!("\"digest\": \"{digits}\",");
    let moved = |signature: &str| changed.replacen(&start, &format!("{start}{signature}"), 1);
    let (key_text, value) = (&signature.key, &signature.value);
    fails(&moved(&format!("\"signature\":{{\"key\":\"{key_text}\",\"value\":\"{value}\"}},")), None, "did not make");
    // With the digest that was signed, or with fields hidden in the signature.
    fails(&text.replace("\"frame\": 1", "\"frame\": 2"), Some(&key), "has been changed");
    let more = format!("\"key\": \"{key_text}\",\n    \"frame\": 2");
    fails(&text.replace(&format!("\"key\": \"{key_text}\""), &more), Some(&key), "unknown field");
    let closed = format!("\"value\": \"{value}\"\n  }},\n  \"frame\": 2,");
    let open = format!("\"value\": \"{value}\"\n  }},");
    assert!(text.contains(&open), "{text:.400}");
    fails(&text.replace(&open, &closed), Some(&key), "has been changed");
    fails(&text.replace(&open, &format!("{open}\n  \"signature\": null,")), Some(&key), "has been changed");
    // Another key than the one that is asked for.
    let mut bytes = [7; 32];
    let asked = (0..=255).find_map(|first| {
        bytes[0] = first;
        PublicKey::parse(&bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>())
    });
    fails(&text, asked.as_ref(), "found one by 19bf44096984cdfe");
}
