//! Checks of what a certificate says about its document, its inputs and its image file: everything but the pixels.

use super::image::StoredImage;
use super::inputs::{files, hashed, is_same};
use super::make::{channels_of, format_of, guarantee_of, plan_of};
use super::words::{Contents, Size};
use super::*;
use crate::{Fingerprints, OutputFile};
use std::path::Path;
use trochoid_engine::{Settings, Switches};
use trochoid_graph::CheckedGraph;
use trochoid_io::{FileKind, SampleType};

/// Maximum number of blocks and nodes that are named one by one; further ones are counted.
const NAMED: usize = 8;

/// Checks the signature, and whose it is.
pub(super) fn signature(found: &mut Verification, request: &Request<'_>, certificate: &Certificate) {
    let place = format!("{}: signature", request.certificate.display());
    let signed = match certificate.signed_by() {
        Ok(signed) => signed,
        Err(none) => {
            found.fail(place, none, "a signature of the digest, or none");
            return;
        }
    };
    found.signed_by = signed;
    if request.key.is_some() && signed.as_ref() != request.key {
        let words = |key: Option<PublicKey>| key.map_or_else(|| "no signature".into(), |key| format!("one by {key}"));
        found.fail(place, words(signed), words(request.key.copied()));
    }
}

/// Checks what a certificate says about its document.
pub(super) fn document(
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
}

/// Returns the indices of a certificate's outputs after checking their kinds and guarantees; `None` if they are wrong.
pub(super) fn outputs(found: &mut Verification, certificate: &Certificate, graph: &CheckedGraph) -> Option<Vec<usize>> {
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
        found.same(place("guarantee"), &written.guarantee, &guarantee_of(spec, &written.counts));
    }
    Some(indices)
}

/// Checks the states of the nodes in the plan.
pub(super) fn plan(
    found: &mut Verification,
    certificate: &Certificate,
    graph: &CheckedGraph,
    outputs: &[usize],
) -> Result<(), CertificateError> {
    let plan = plan_of(graph, outputs, certificate.frame)?;
    if certificate.plan.len() != plan.len() {
        found.fail("plan", format!("{} nodes", certificate.plan.len()), format!("{} nodes", plan.len()));
    }
    let differing = certificate.plan.iter().zip(&plan).filter(|(written, planned)| written != planned);
    for (written, planned) in differing.take(NAMED) {
        found.same(format!("plan, node \"{}\"", planned.name), written, planned);
    }
    Ok(())
}

/// Checks the fingerprint, if this version made the certificate, because those of others are unknown, and if document and
/// inputs hold, because it changes with them.
pub(super) fn fingerprint(
    found: &mut Verification,
    certificate: &Certificate,
    graph: &CheckedGraph,
    file: &OutputFile,
) {
    if certificate.trochoid != crate::VERSION || !found.holds() {
        return;
    }
    let of = |(switches, by_reference): (Switches, bool)| {
        let mut settings = Settings::default();
        settings.switches = switches;
        Fingerprints::with(&settings).by_reference(by_reference).of(graph, file, certificate.frame)
    };
    // A picture may have been rendered in any of these ways, which make no difference to what is certified of it.
    let ways = [Switches::ALL, Switches::NONE].into_iter().flat_map(|switches| [(switches, false), (switches, true)]);
    let known: Vec<String> = ways.map(of).collect();
    if !known.contains(&certificate.fingerprint) {
        found.fail("fingerprint", &certificate.fingerprint, &known[0]);
    }
}

/// Compares the files that the document reads with their hashes.
pub(super) fn inputs(
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
pub(super) fn image(
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
        ("version", "the version that rendered it", certificate.trochoid.clone()),
        ("document", "the document that it was rendered from", certificate.document.hash.clone()),
        ("frame", "its frame", certificate.frame.to_string()),
        ("workingSpace", "its working space", certificate.format.working_space.clone()),
        ("fingerprint", "all that it was rendered from", certificate.fingerprint.clone()),
    ];
    for (name, meaning, expected) in expected {
        let key = format!("trochoid:{name}");
        if let Some((_, said)) = image.metadata.iter().find(|(known, _)| *known == key) {
            found.same(at(&format!("metadata {key}, {meaning}")), said, &expected);
        }
    }
}
