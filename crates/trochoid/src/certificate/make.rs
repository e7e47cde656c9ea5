//! Creation of certificates.

use super::bounds::PictureBounds;
use super::color::Coding;
use super::counts::{Palette, counts, sorted};
use super::image::{StoredChannel, StoredImage};
use super::inputs::{files, folder_of, hashed, seen_from};
use super::*;
use crate::exr_layer::file_channels;
use crate::files::folder_of_file;
use crate::{Fingerprints, OutputFile};
use serde_json::value::RawValue;
use std::path::Path;
use trochoid_engine::{Certified, Plan, PlanError, Settings};
use trochoid_graph::{CheckedGraph, Guarantee, Kind, NodeId, OutputSpec, Precision};
use trochoid_image::Rgb;
use trochoid_io::{FileKind, SampleType};

/// Data that a certificate is made from.
#[derive(Clone, Copy, Debug)]
pub struct CertificateInputs<'m> {
    /// Graph of the document.
    pub graph: &'m CheckedGraph,
    /// Image file, which must be written already, because its pixels are read from it.
    pub file: &'m OutputFile,
    /// Frame of the image.
    pub frame: i64,
    /// Certified errors of each of the file's outputs, over the whole picture.
    pub certified: &'m [Certified],
    /// Settings that the image was rendered with.
    pub settings: &'m Settings,
}

/// Returns the certificate of an image. Its paths are relative to the folder of `path`, where it is to be written;
/// missing folders are created.
///
/// # Errors
/// The image or an input cannot be read, or the image is not that of its outputs.
pub fn certify(inputs: &CertificateInputs<'_>, path: &Path) -> Result<Certificate, CertificateError> {
    let CertificateInputs { graph, file, frame, .. } = *inputs;
    folder_of_file(path)?;
    let folder = folder_of(path);
    let paths = files(graph, &file.outputs, frame);
    let hashes: Result<Vec<InputHash>, CertificateError> = paths.iter().map(|path| hashed(path, &folder)).collect();
    let canonical = RawValue::from_string(graph.canonical().into());
    let canonical = canonical.map_err(|error| CertificateError::NoCertificate {
        path: path.into(),
        found: NoCertificate::Document(error),
    })?;
    let image = StoredImage::read(&file.path)?;
    let outputs = file.outputs.iter().filter_map(|index| {
        let certified = inputs.certified.iter().find(|certified| certified.output == *index)?;
        Some(output(inputs, certified, &image))
    });
    Ok(Certificate {
        digest: String::new(),
        signature: None,
        outputs: outputs.collect::<Result<_, _>>()?,
        document: DocumentText { canonical, folder: seen_from(&folder, graph.folder()), hash: graph.document_hash() },
        fingerprint: fingerprint_of(inputs, &image),
        format: format_of(graph),
        frame,
        image: image.hashes(seen_from(&folder, &file.path)),
        inputs: hashes?,
        plan: plan_of(graph, &file.outputs, frame)?,
        trochoid: crate::VERSION.into(),
        version: VERSION,
    })
}

/// Returns the fingerprint in the image's own metadata, so that image and certificate agree.
fn fingerprint_of(inputs: &CertificateInputs<'_>, image: &StoredImage) -> String {
    let said = image.metadata.iter().find(|(key, _)| key == crate::resume::FINGERPRINT).map(|(_, value)| value.clone());
    said.unwrap_or_else(|| Fingerprints::with(inputs.settings).of(inputs.graph, inputs.file, inputs.frame))
}

/// Returns the format that a document requests.
pub(super) fn format_of(graph: &CheckedGraph) -> FormatText {
    let format = graph.format();
    FormatText {
        adaptive: format.adaptive().map(|tolerance| tolerance.to_string()),
        height: format.height(),
        samples: format.samples(),
        shading: format.shading().name().into(),
        width: format.width(),
        working_space: graph.space().name().into(),
    }
}

/// Returns the state of each node in an optimized plan of these outputs alone.
pub(super) fn plan_of(graph: &CheckedGraph, outputs: &[usize], frame: i64) -> Result<Vec<PlannedNode>, PlanError> {
    let names: Vec<&str> = outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
    let plan = Plan::new(graph, &names, frame, &[], &Settings::default())?;
    let nodes = graph.nodes().iter().zip(plan.left_out()).map(|(node, why)| PlannedNode {
        name: node.name.clone(),
        state: if why.is_some() { "left_out" } else { "evaluated" }.into(),
        ty: node.ty.declaration().name.into(),
        why: why.as_ref().map(ToString::to_string),
    });
    let mut nodes: Vec<PlannedNode> = nodes.collect();
    // Sorted as in the canonical document.
    nodes.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(nodes)
}

/// Returns the channels of an output in its file, with the types of their samples.
pub(super) fn channels_of(
    graph: &CheckedGraph,
    spec: &OutputSpec,
    file: &OutputFile,
    png: bool,
) -> Vec<(String, SampleType)> {
    if !png {
        return file_channels(graph, spec, file);
    }
    let stored = if spec.precision == Some(Precision::Uint16) { SampleType::U16 } else { SampleType::U8 };
    let names: &[&str] = if spec.kind == Kind::Color { &["R", "G", "B"] } else { &["Y"] };
    names.iter().map(|name| (name.to_string(), stored)).collect()
}

/// Returns the hash of a hull's corners, which does not depend on their order.
fn hash_of_corners(corners: &[Rgb]) -> String {
    let mut hasher = blake3::Hasher::new();
    sorted(corners).iter().flatten().for_each(|value| {
        hasher.update(&value.to_le_bytes());
    });
    hasher.finalize().to_hex().to_string()
}

/// Returns what a certificate says about the corners of a palette's hull.
pub(super) fn controls_of(corners: &[Rgb], margin: f64) -> Controls {
    Controls {
        corners: corners.len() as u64,
        hash: hash_of_corners(corners),
        margin,
        values: if corners.len() as u64 <= LISTED { sorted(corners) } else { Vec::new() },
    }
}

/// Returns the guarantee on an output, given the counts on its pixels.
pub(super) fn guarantee_of(spec: &OutputSpec, counts: &PixelCounts) -> Option<GuaranteeText> {
    let class = crate::guarantee(spec)?;
    let name = |guarantee: Guarantee| guarantee.name().to_string();
    let held = counts.outside == 0 && counts.nan == 0 && counts.infinite == 0;
    Some(GuaranteeText { class: name(class), held: held.then(|| name(class)), required: spec.require.map(name) })
}

/// Returns the stages without bounds upstream of an output.
pub(super) fn unbounded_of(graph: &CheckedGraph, stages: &[(NodeId, &'static str)]) -> Vec<Unbounded> {
    let stage =
        |(id, why): &(NodeId, &'static str)| Unbounded { node: graph.node(*id).name.clone(), why: (*why).into() };
    stages.iter().map(stage).collect()
}

/// Returns the channels of an image by their names; `None` if one of them is missing.
pub(super) fn stored_channels<'i>(image: &'i StoredImage, names: &[String]) -> Option<Vec<&'i StoredChannel>> {
    names.iter().map(|name| image.channel(name)).collect()
}

fn output(
    inputs: &CertificateInputs<'_>,
    certified: &Certified,
    image: &StoredImage,
) -> Result<CertifiedOutput, CertificateError> {
    let graph = inputs.graph;
    let spec = &graph.outputs()[certified.output];
    let png = image.kind == FileKind::Png;
    let names: Vec<String> = channels_of(graph, spec, inputs.file, png).into_iter().map(|(name, _)| name).collect();
    let other = || CertificateError::OtherImage { path: inputs.file.path.clone(), output: spec.name.clone() };
    let channels = stored_channels(image, &names).filter(|_| image.window == certified.window).ok_or_else(other)?;
    let coding = Coding::new(spec.kind, graph.space(), png);
    let palette = (spec.kind == Kind::Color).then(|| Palette::new(&certified.palette, certified.margin));
    let counts = counts(spec.kind, coding, &channels, palette.as_ref());
    Ok(CertifiedOutput {
        controls: palette.is_some().then(|| controls_of(&certified.palette, certified.margin)),
        error: PictureBounds::certified(certified).described(spec, graph.space(), coding, &channels),
        guarantee: guarantee_of(spec, &counts),
        counts,
        channels: names,
        kind: spec.kind.to_string(),
        name: spec.name.clone(),
        unbounded: unbounded_of(graph, &certified.unbounded),
    })
}
