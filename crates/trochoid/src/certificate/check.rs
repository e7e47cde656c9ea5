//! Checks of certificates: everything that document, inputs and image determine, then pixels, which are derived again
//! and compared with the references.

use super::claims;
use super::failed_claim::FailedClaim;
use super::image::StoredImage;
use super::inputs::{folder_of, plain};
use super::pixels::OutputCheck;
use super::words::Words;
use super::*;
use crate::{LoadError, OutputFile};
use std::collections::BTreeSet;
use std::path::Path;
use trochoid_engine::{Buffers, Cache, Certifier, Monitor, ReferenceFrame, Settings};
use trochoid_graph::{Access, CheckedGraph, refusals};

/// Certificate and image to check.
#[derive(Clone, Copy, Debug)]
pub struct Request<'r> {
    /// Path of the certificate.
    pub certificate: &'r Path,
    /// Path of the image that the certificate is claimed to cover.
    pub image: &'r Path,
    /// Pixels to look at, besides those that the certificate names.
    pub choice: Choice,
    /// Number that decides which pixels these are. A forger must not know it: take [`random_seed`].
    pub seed: u64,
    /// Key that the certificate must be signed by, if any.
    pub key: Option<&'r PublicKey>,
    /// Document that the certificate is claimed to cover, if that is to be checked.
    pub document: Option<&'r CheckedGraph>,
    /// Files that the document in the certificate may access: by default the [usual](Access::usual) ones for the
    /// certificate's folder. The folder that the certificate gives for the document is not trusted.
    pub access: Option<&'r Access>,
}

/// Results of checking one output.
#[derive(Clone, Debug, PartialEq)]
pub struct Findings {
    /// Name of the output.
    pub output: String,
    /// Number of pixels that were derived again and evaluated by the references.
    pub looked_at: u64,
    /// Number of all pixels.
    pub pixels: u64,
    /// Number of evaluated pixels that are ambiguous.
    pub ambiguous: u64,
    /// Number of these whose reference was given up, because it takes too much effort: a surface is too rough there.
    pub given_up: u64,
    /// Whether colors were held against the hull, in which the certificate says that all are.
    pub hull: bool,
    /// Largest distance of an unambiguous pixel from its reference, beyond the rounding of the file's format, in units
    /// of the file.
    pub distance: f64,
    /// Largest such distance of an ambiguous pixel.
    pub distance_ambiguous: f64,
    /// Smallest weight of any node in the references; +∞ if there are no weights.
    pub weight_min: f64,
    /// Largest |Σω − 1| of any node in the references.
    pub weight_sum_max_deviation: f64,
}

/// Result of checking a certificate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verification {
    /// Frame of the certificate; `None` if its digest does not match.
    pub frame: Option<i64>,
    /// Version of Trochoid that made the certificate, as it says itself.
    pub trochoid: String,
    /// Key that the certificate is signed by; `None` if it is not signed.
    pub signed_by: Option<PublicKey>,
    /// Number of input files checked.
    pub inputs: usize,
    /// Number of blocks of pixels checked.
    pub blocks: usize,
    /// Share of the pixels that would have been found with a probability of 99 % if they had been changed; `None` if all
    /// were looked at.
    pub share_found: Option<f64>,
    /// Results for each output; empty unless document, inputs and image are as certified.
    pub outputs: Vec<Findings>,
    /// Everything that does not hold.
    pub failures: Vec<FailedClaim>,
}

impl Verification {
    /// Returns whether everything holds.
    pub fn holds(&self) -> bool {
        self.failures.is_empty()
    }

    pub(super) fn fail(&mut self, place: impl ToString, found: impl ToString, expected: impl ToString) {
        let [place, found, expected] = [place.to_string(), found.to_string(), expected.to_string()];
        self.failures.push(FailedClaim { place, found, expected });
    }

    /// Adds a failure unless both values are equal.
    pub(super) fn same<T: PartialEq + Words>(&mut self, place: impl ToString, found: &T, expected: &T) {
        if found != expected {
            self.fail(place, found.words(), expected.words());
        }
    }
}

/// Number of pixels evaluated by the references at once. Only their values are held.
const PIECE: usize = 8192;

/// Checks a certificate and the image that it is claimed to cover.
///
/// Nothing that can be computed is believed. Document, inputs and image must be the certified ones. Counts, largest
/// bounds and percentiles must follow from the image and from the bounds of all pixels in the certificate. At the chosen
/// pixels, and at those that the certificate names, value, bound and ambiguity of the picture are derived again: the
/// certificate must state them as they are, the file must contain the rounded form of the value, and the reference must
/// lie within the bound. Up to the rounding of the format, colors must lie in the hull of their controls, weights in
/// [0, 1], and partitions must sum to 1. Only at an ambiguous pixel may the reference be given up, where a surface is too
/// rough to find its first point on a ray with reasonable effort.
///
/// With [`Choice::All`], no false statement passes. Otherwise a change of some pixels, or of what is said about them, is
/// found with the probability that [`Choice::share_found`] explains.
///
/// # Errors
/// A file cannot be read, is of the wrong kind, or may not be accessed by the document; the document is not valid in
/// this version; the monitor asked to stop.
pub fn verify(request: &Request<'_>, monitor: &dyn Monitor) -> Result<Verification, CertificateError> {
    let mut found = Verification::default();
    let certificate = match Certificate::read(request.certificate)? {
        Ok(certificate) => certificate,
        Err(OtherDigest { found: digest, expected }) => {
            let place = format!("{}: digest", request.certificate.display());
            found.fail(place, digest, format!("{expected}: the certificate has been changed"));
            return Ok(found);
        }
    };
    (found.frame, found.trochoid) = (Some(certificate.frame), certificate.trochoid.clone());
    claims::signature(&mut found, request, &certificate);
    let folder = folder_of(request.certificate);
    let name = format!("{}: document", request.certificate.display());
    let text = certificate.document.canonical.get();
    let graph = crate::parse(&name, text, &plain(&folder.join(&certificate.document.folder)), &[])?.graph;
    let graph = graph.with_access(request.access.cloned().unwrap_or_else(|| Access::usual(&folder)));
    claims::document(&mut found, request, &certificate, &graph, &name);
    let Some(outputs) = claims::outputs(&mut found, &certificate, &graph) else { return Ok(found) };
    let refused = crate::refused_files(&graph, &outputs, &[certificate.frame]);
    if !refused.is_empty() {
        return Err(CertificateError::Document(LoadError::Invalid(refusals(&refused))));
    }
    claims::plan(&mut found, &certificate, &graph, &outputs)?;
    claims::inputs(&mut found, &certificate, &graph, &outputs, &folder)?;
    let file = OutputFile { path: request.image.into(), outputs };
    claims::fingerprint(&mut found, &certificate, &graph, &file);
    let image = StoredImage::read(request.image)?;
    claims::image(&mut found, &certificate, request.certificate.display(), &graph, &file, &image);
    let mut checks = Vec::new();
    for (written, index) in certificate.outputs.iter().zip(&file.outputs) {
        checks.extend(OutputCheck::new(&mut found, &certificate, written, &graph, *index, &image));
    }
    if found.holds() {
        pixels(&mut found, request, &certificate, &graph, checks, monitor)?;
    }
    Ok(found)
}

/// Derives the chosen pixels of all outputs again, and evaluates them by the references.
fn pixels(
    found: &mut Verification,
    request: &Request<'_>,
    certificate: &Certificate,
    graph: &CheckedGraph,
    mut checks: Vec<OutputCheck<'_>>,
    monitor: &dyn Monitor,
) -> Result<(), CertificateError> {
    let window = graph.format().window();
    found.share_found = request.choice.share_found(window.area() as u64);
    let mut chosen: BTreeSet<usize> =
        request.choice.pixels(request.seed, &certificate.digest, window.area()).into_iter().collect();
    chosen.extend(checks.iter().flat_map(OutputCheck::named));
    let chosen: Vec<usize> = chosen.into_iter().collect();
    let place = |pixel: &usize| {
        let (x, y) = (pixel % window.width(), pixel / window.width());
        [window.x0 + x as i64, window.y0 + y as i64]
    };
    let places: Vec<[i64; 2]> = chosen.iter().map(place).collect();
    let names: Vec<&str> = checks.iter().map(OutputCheck::name).collect();
    let mut cache = Cache::new();
    let certifier = Certifier::new(graph, &names, certificate.frame, &[], &Settings::default())?;
    let [deriving, evaluating] = [0, 1].map(|half| HalfMonitor { monitor, half, before: 0, total: 0 });
    let derived = certifier.certify_pixels(&places, &Buffers::new(), &mut cache, &deriving)?;
    let reference = ReferenceFrame::beside_bounds(graph, &names, certificate.frame, &mut cache, &evaluating)?;
    for (output, (check, derived)) in checks.iter_mut().zip(&derived).enumerate() {
        check.whole(found, derived, &reference.controls(output));
    }
    for (start, piece) in (0..).step_by(PIECE).zip(places.chunks(PIECE)) {
        let monitor = HalfMonitor { before: start, total: places.len(), ..evaluating };
        for (index, outputs) in (start..).zip(reference.pixels_in_reach(piece, &monitor)?) {
            for ((check, derived), reference) in checks.iter_mut().zip(&derived).zip(&outputs) {
                check.pixel(chosen[index], index, derived, reference.as_ref());
            }
        }
    }
    for check in checks {
        let findings = check.conclude(found, chosen.len());
        found.outputs.push(findings);
    }
    Ok(())
}

/// Steps of one half of the work, for progress.
const STEPS: usize = 1000;

/// Monitor of one half of the work: deriving bounds, then evaluating references.
#[derive(Clone, Copy)]
struct HalfMonitor<'m> {
    monitor: &'m dyn Monitor,
    half: usize,
    /// Pixels done before those that are counted, and pixels in total; 0 if all are counted.
    before: usize,
    total: usize,
}

impl Monitor for HalfMonitor<'_> {
    fn preparing(&self, node: &str) {
        self.monitor.preparing(node);
    }

    fn progress(&self, done: usize, total: usize) {
        let (done, total) = (self.before + done, self.total.max(total).max(1));
        self.monitor.progress(STEPS * self.half + STEPS * done / total, 2 * STEPS);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled()
    }
}
