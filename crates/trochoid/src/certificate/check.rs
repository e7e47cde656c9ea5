//! Checks of certificates: everything that document, inputs and image determine, then pixels against the references.

use super::failed_claim::FailedClaim;
use super::image::StoredImage;
use super::inputs::{files, folder_of, hashed, is_same, plain};
use super::make::{channels_of, format_of, plan_of};
use super::pixels::PixelCheck;
use super::words::{Contents, Size, Words};
use super::*;
use crate::{LoadError, OutputFile};
use std::path::Path;
use trochoid_engine::{Cache, Monitor, ReferenceFrame};
use trochoid_graph::{Access, CheckedGraph, Guarantee, Kind, refusals};
use trochoid_io::{FileKind, SampleType};

/// Choice of the pixels that the references evaluate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// All pixels.
    All,
    /// This many pixels, selected by the certificate's digest; all if the picture has fewer.
    Some(u64),
}

impl Default for Choice {
    /// Returns a choice of 10,000 pixels.
    fn default() -> Self {
        Self::Some(10_000)
    }
}

/// Certificate and image to check.
#[derive(Clone, Copy, Debug)]
pub struct Request<'r> {
    /// Path of the certificate.
    pub certificate: &'r Path,
    /// Path of the image that the certificate is claimed to cover.
    pub image: &'r Path,
    /// Pixels to evaluate.
    pub choice: Choice,
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
    /// Number of pixels evaluated by the references.
    pub looked_at: u64,
    /// Number of all pixels.
    pub pixels: u64,
    /// Number of evaluated pixels that are ambiguous.
    pub ambiguous: u64,
    /// Whether the hull was checked, which applies to colors that the certificate claims to be inside.
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
    /// Version of Trochoid that made the certificate.
    pub trochoid: String,
    /// Number of input files checked.
    pub inputs: usize,
    /// Number of blocks of pixels checked.
    pub blocks: usize,
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

/// Maximum number of blocks and nodes that are named one by one; further ones are counted.
const NAMED: usize = 8;

/// Checks a certificate and the image that it is claimed to cover.
///
/// Pixels are evaluated only if the certificate is unchanged, and document, inputs and image are the certified ones.
/// For an unambiguous pixel, the file must contain the rounded form of a value within the certified error of the
/// reference; for an ambiguous pixel, within the bound of ambiguous pixels. At most one pixel in a thousand may exceed
/// the certified 99.9th percentile: exactly if all pixels are evaluated, otherwise with a margin for chance (a correct
/// certificate is rejected at most once in 10⁹ times). Up to the rounding of the format, colors must lie in the hull of
/// their controls, weights in [0, 1], and partitions must sum to 1.
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
    let folder = folder_of(request.certificate);
    let name = format!("{}: document", request.certificate.display());
    let text = certificate.document.canonical.get();
    let graph = crate::parse(&name, text, &plain(&folder.join(&certificate.document.folder)), &[])?.graph;
    let graph = graph.with_access(request.access.cloned().unwrap_or_else(|| Access::usual(&folder)));
    document(&mut found, request, &certificate, &graph, &name);
    let Some(outputs) = outputs(&mut found, &certificate, &graph) else { return Ok(found) };
    let refused = crate::refused_files(&graph, &outputs, &[certificate.frame]);
    if !refused.is_empty() {
        return Err(CertificateError::Document(LoadError::Invalid(refusals(&refused))));
    }
    let plan = plan_of(&graph, &outputs, certificate.frame, certificate.optimized)?;
    if certificate.plan.len() != plan.len() {
        found.fail("plan", format!("{} nodes", certificate.plan.len()), format!("{} nodes", plan.len()));
    }
    let differing = certificate.plan.iter().zip(&plan).filter(|(written, planned)| written != planned);
    for (written, planned) in differing.take(NAMED) {
        found.same(format!("plan, node \"{}\"", planned.name), written, planned);
    }
    inputs(&mut found, &certificate, &graph, &outputs, &folder)?;
    let file = OutputFile { path: request.image.into(), outputs };
    let image = StoredImage::read(request.image)?;
    pixels_of_file(&mut found, &certificate, request.certificate.display(), &graph, &file, &image);
    let mut checks = Vec::new();
    for (written, index) in certificate.outputs.iter().zip(&file.outputs) {
        checks.extend(PixelCheck::new(&mut found, &certificate, written, &graph, *index, &image));
    }
    if !found.holds() {
        return Ok(found);
    }
    let mut cache = Cache::new();
    let total = checks.iter().map(|check| check.count(request.choice)).sum();
    let mut done = 0;
    for check in checks {
        let reference = ReferenceFrame::prepared(&graph, check.name(), certificate.frame, &mut cache, monitor)?;
        let count = check.count(request.choice);
        let findings = check.run(&mut found, &reference, count, &OutputMonitor { monitor, before: done, total })?;
        found.outputs.push(findings);
        done += count;
    }
    Ok(found)
}

fn document(
    found: &mut Verification,
    request: &Request<'_>,
    certificate: &Certificate,
    graph: &CheckedGraph,
    name: &str,
) {
    found.same(name, &graph.document_hash(), &certificate.document.hash);
    if let Some(given) = request.document {
        let place = format!("{}: hash of the document", given.name());
        found.same(place, &given.document_hash(), &certificate.document.hash);
    }
    found.same("format", &certificate.format, &format_of(graph));
    let nodes = certificate.outputs.iter().flat_map(|output| &output.unbounded);
    for stage in nodes.filter(|stage| graph.find(&stage.node).is_none()) {
        found.fail("unbounded", format!("\"{}\"", stage.node), "a node of the document");
    }
}

/// Returns the indices of a certificate's outputs after checking their kinds and guarantees; `None` if they are wrong.
fn outputs(found: &mut Verification, certificate: &Certificate, graph: &CheckedGraph) -> Option<Vec<usize>> {
    let mut indices = Vec::new();
    for written in &certificate.outputs {
        let place = format!("output \"{}\"", written.name);
        match graph.outputs().iter().position(|output| output.name == written.name) {
            Some(index) if !indices.contains(&index) => indices.push(index),
            Some(_) => {
                found.fail(place, "two entries", "one entry");
                return None;
            }
            None => {
                found.fail(place, "an unknown output", "an output of the document");
                return None;
            }
        }
    }
    if indices.is_empty() {
        found.fail("outputs", "none", "at least one");
        return None;
    }
    for (written, index) in certificate.outputs.iter().zip(&indices) {
        let spec = &graph.outputs()[*index];
        let place = |field: &str| format!("output \"{}\", {field}", spec.name);
        found.same(place("kind"), &written.kind, &spec.kind.to_string());
        let [controls, expected] = [written.controls.is_some(), spec.kind == Kind::Color].map(named);
        found.same(place("controls"), &controls, &expected);
        let class = crate::guarantee(spec).map(Guarantee::name);
        found.same(place("guarantee.class"), &written.guarantee.as_ref().map(|g| g.class.as_str()), &class);
        let Some(guarantee) = &written.guarantee else { continue };
        let clean = written.audit.outside == 0 && written.audit.nan == 0;
        let held = class.filter(|_| clean);
        found.same(place("guarantee.held"), &guarantee.held.as_deref(), &held);
        let asked = guarantee.asked.as_deref().map(Guarantee::from_name);
        let strict = asked.flatten() >= spec.require && asked != Some(None);
        if !strict || asked.flatten() > guarantee.held.as_deref().and_then(Guarantee::from_name) {
            let expected = "at least what the document requires, and at most what holds";
            found.fail(place("guarantee.asked"), guarantee.asked.words(), expected);
        }
    }
    Some(indices)
}

fn inputs(
    found: &mut Verification,
    certificate: &Certificate,
    graph: &CheckedGraph,
    outputs: &[usize],
    folder: &Path,
) -> Result<(), CertificateError> {
    let needed = files(graph, outputs, certificate.frame);
    found.inputs = needed.len();
    let mut known = vec![false; certificate.inputs.len()];
    for path in &needed {
        if !path.exists() {
            return Err(CertificateError::NoInput { path: path.clone(), folder: folder.into() });
        }
        let now = hashed(path, folder)?;
        let written = certificate.inputs.iter().position(|input| is_same(&folder.join(&input.path), path));
        match written.map(|index| (&certificate.inputs[index], &mut known[index])) {
            Some((input, known)) => {
                *known = true;
                let place = format!("{}: input", path.display());
                found.same(&place, &Contents::of(&now), &Contents::of(input));
            }
            None => found.fail(format!("{}: input", path.display()), "no hash", "a hash in the certificate"),
        }
    }
    for (input, _) in certificate.inputs.iter().zip(known).filter(|(_, known)| !known) {
        found.fail(format!("input {}", input.path), "a file that the document does not need", "no other file");
    }
    Ok(())
}

/// Compares the size, the channels and the block hashes of the image with those of the certificate.
fn pixels_of_file(
    found: &mut Verification,
    certificate: &Certificate,
    name: std::path::Display<'_>,
    graph: &CheckedGraph,
    file: &OutputFile,
    image: &StoredImage,
) {
    let at = |what: &str| format!("{}: {what}", file.path.display());
    let within = |field: &str| format!("{name}: image.{field}");
    let written = &certificate.image;
    let now = image.hashes(written.file.clone());
    found.same(at("kind of file"), &now.kind, &written.kind);
    found.same(at("parts"), &image.parts, &1);
    found.same(at("pixels"), &image.window.to_string(), &graph.format().window().to_string());
    found.same(at("width and height"), &Size([now.width, now.height]), &Size([written.width, written.height]));
    found.same(at("channels"), &now.channels, &written.channels);
    // Claims of the certificate on its own file, which may be another file than this one.
    let png = written.kind == FileKind::Png.to_string();
    let of = |index: &usize| channels_of(graph, &graph.outputs()[*index], file, png);
    let mut channels: Vec<(String, SampleType)> = file.outputs.iter().flat_map(of).collect();
    channels.sort_by(|a, b| a.0.cmp(&b.0));
    let channels: Vec<ChannelText> =
        channels.into_iter().map(|(name, stored)| ChannelText { name, stored: stored.to_string() }).collect();
    found.same(within("channels"), &written.channels, &channels);
    for (output, index) in certificate.outputs.iter().zip(&file.outputs) {
        let names: Vec<String> = of(index).into_iter().map(|(name, _)| name).collect();
        found.same(format!("output \"{}\", channels", output.name), &output.channels, &names);
    }
    metadata(found, certificate, image, &at);
    if !found.holds() {
        return;
    }
    found.blocks = now.blocks.len();
    found.same(within("block"), &written.block, &now.block);
    found.same(within("blocks, their number"), &written.blocks.len(), &now.blocks.len());
    let blocks = image.window.tiles(now.block as usize, now.block as usize);
    let pairs = now.blocks.iter().zip(&written.blocks).zip(blocks).enumerate();
    let changed: Vec<_> = pairs.filter(|(_, ((now, written), _))| now != written).collect();
    for (index, ((now, written), block)) in changed.iter().take(NAMED) {
        let place =
            at(&format!("block {index}, x {} to {}, y {} to {}", block.x0, block.x1 - 1, block.y0, block.y1 - 1));
        found.fail(place, format!("pixels of hash {now}"), written);
    }
    if changed.len() > NAMED {
        found.fail(at("further blocks"), format!("{} changed", changed.len() - NAMED), "none");
    }
    if changed.is_empty() {
        found.same(within("pixels"), &written.pixels, &now.pixels);
    }
}

/// Compares the metadata of the image with the certificate. Metadata may be missing, for example if another program
/// stored the file.
fn metadata(found: &mut Verification, certificate: &Certificate, image: &StoredImage, at: &dyn Fn(&str) -> String) {
    let expected = [
        ("version", certificate.trochoid.clone()),
        ("document", certificate.document.hash.clone()),
        ("frame", certificate.frame.to_string()),
        ("workingSpace", certificate.format.working_space.clone()),
        ("fingerprint", certificate.fingerprint.clone()),
    ];
    for (name, expected) in expected {
        let key = format!("trochoid:{name}");
        if let Some((_, said)) = image.metadata.iter().find(|(known, _)| *known == key) {
            found.same(at(&format!("metadata {key}")), said, &expected);
        }
    }
}

/// Returns words for the presence of control colors.
fn named(controls: bool) -> &'static str {
    if controls { "control colors" } else { "none" }
}

/// Monitor of one output's share of the work.
struct OutputMonitor<'m> {
    monitor: &'m dyn Monitor,
    /// Pixels done before, and pixels in total.
    before: usize,
    total: usize,
}

impl Monitor for OutputMonitor<'_> {
    fn preparing(&self, node: &str) {
        self.monitor.preparing(node);
    }

    fn progress(&self, done: usize, _: usize) {
        self.monitor.progress(self.before + done, self.total);
    }

    fn cancelled(&self) -> bool {
        self.monitor.cancelled()
    }
}
