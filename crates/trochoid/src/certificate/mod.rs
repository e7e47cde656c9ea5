//! Certificates: the guaranteed properties of a finished picture, as JSON, and an independent check of them.
//!
//! [`certify`] records for one image file the document that it was made from, the hashes of its inputs and of its
//! pixels, the counts on these pixels, the error bound of each pixel against the f64 references, and what the plan left
//! out.
//!
//! [`verify`] needs only the certificate and the image, and believes nothing that it can compute. It parses the document
//! again, counts again, and looks at pixels: all of them, or one in each of many equal parts of the picture, drawn by a
//! seed that a forger does not know. At each pixel, the [`Certifier`](crate::Certifier) derives value, bound and
//! ambiguity again, and the references ([`ReferenceFrame`](crate::ReferenceFrame)) are evaluated. The file must hold
//! that value, the certificate that bound, and the reference must lie within it. No kernel or machine code takes part,
//! and the references know neither programs nor planes. Both ways share the reading of the document and its input
//! files, the preparation of stages, which happens once per frame, and the definition of the working spaces.
//!
//! ```
//! use trochoid::certificate::{self, Choice, CertificateInputs, Request};
//! use trochoid::{Buffers, Cache, Certifier, OutputFile, Plan, Settings, Silent, write_output};
//!
//! let folder = tempfile::tempdir()?;
//! let text = r##"{ "trochoid": 1, "format": { "width": 16, "height": 9 },
//!                  "nodes": { "across": { "type": "ScreenX" },
//!                             "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" } },
//!                  "outputs": { "beauty": { "color": "mix" } } }"##;
//! let graph = trochoid::parse("a.json", text, folder.path(), &[])?.graph;
//! let (settings, mut cache) = (Settings::default(), Cache::new());
//! let frame = Plan::new(&graph, &[], 1, &[], &settings)?.evaluate(&Buffers::new(), &mut cache, &Silent)?;
//! let file = OutputFile { path: folder.path().join("a.png"), outputs: vec![0] };
//! write_output(&graph, &frame, &file, &[])?;
//!
//! let certified = Certifier::new(&graph, &[], 1, &[], &settings)?.certify(&Buffers::new(), &mut cache, &Silent)?;
//! let made = CertificateInputs { graph: &graph, file: &file, frame: 1, certified: &certified, settings: &settings };
//! let path = folder.path().join("a.certificate.json");
//! let certificate = certificate::certify(&made, &path)?;
//! assert!(certificate.outputs[0].error.channels[0].all.max.is_some_and(|max| max.bound < 1e-6));
//! certificate.write(&path, None)?;
//!
//! let seed = certificate::random_seed();
//! let request = Request { certificate: &path, image: &file.path, choice: Choice::All, seed, key: None, document: None, access: None };
//! let found = certificate::verify(&request, &Silent)?;
//! assert!(found.holds(), "{:?}", found.failures);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bounds;
mod check;
mod choice;
mod claims;
mod color;
mod counts;
mod failed_claim;
mod image;
mod inputs;
mod keys;
mod level;
mod make;
mod map;
mod pixels;
mod seal;
mod storage;
#[cfg(test)]
mod tests;
mod types;
mod words;

pub use bounds::unit;
pub use check::{Findings, Request, Verification, verify};
pub use choice::{Choice, random_seed};
pub use failed_claim::FailedClaim;
pub use image::error_image;
pub use keys::{KeyError, PrivateKey, PublicKey};
pub use make::{CertificateInputs, certify};
pub use seal::{CertificateError, NoCertificate, NoSignature, OtherDigest};
pub use types::*;
