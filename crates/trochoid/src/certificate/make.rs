//! Creation of certificates.

use super::image::StoredImage;
use super::inputs::{files, folder_of, hashed, seen_from};
use super::map::PixelMap;
use super::*;
use crate::exr_layer::file_channels;
use crate::files::folder_of_file;
use crate::{Fingerprints, OutputFile, held, requirement};
use serde_json::value::RawValue;
use std::path::Path;
use trochoid_engine::{Certified, Distribution, Frame, Picture, Plan, PlanError, Settings, Switches};
use trochoid_graph::{CheckedGraph, Guarantee, Kind, OutputSpec, Precision};
use trochoid_image::Rgb;
use trochoid_io::{FileKind, SampleType};

/// Data that a certificate is made from.
#[derive(Clone, Copy, Debug)]
pub struct CertificateInputs<'m> {
    /// Graph of the document.
    pub graph: &'m CheckedGraph,
    /// Image file, which must be written already, because its pixels are read from it.
    pub file: &'m OutputFile,
    /// Frame that the image was written from.
    pub frame: &'m Frame,
    /// Certified errors of each of the file's outputs.
    pub certified: &'m [Certified],
    /// Settings of the frame's plan.
    pub settings: &'m Settings,
    /// Guarantee that was required of all colors.
    pub required: Option<Guarantee>,
}

/// Returns the certificate of an image. Its paths are relative to the folder of `path`, where it is to be written;
/// missing folders are created.
///
/// # Errors
/// The image or an input cannot be read.
pub fn certify(inputs: &CertificateInputs<'_>, path: &Path) -> Result<Certificate, CertificateError> {
    let CertificateInputs { graph, file, frame, .. } = *inputs;
    let optimized = inputs.settings.switches != Switches::NONE;
    folder_of_file(path)?;
    let folder = folder_of(path);
    let paths = files(graph, &file.outputs, frame.number);
    let hashes: Result<Vec<InputHash>, CertificateError> = paths.iter().map(|path| hashed(path, &folder)).collect();
    let canonical = RawValue::from_string(graph.canonical().into());
    let canonical = canonical.map_err(|error| CertificateError::NoCertificate {
        path: path.into(),
        found: NoCertificate::Document(error),
    })?;
    let image = StoredImage::read(&file.path)?;
    let outputs = frame.pictures.iter().filter(|picture| file.outputs.contains(&picture.output));
    let outputs = outputs.filter_map(|picture| {
        let certified = inputs.certified.iter().find(|certified| certified.output == picture.output)?;
        Some(output(inputs, picture, certified, image.kind == FileKind::Png))
    });
    Ok(Certificate {
        digest: String::new(),
        document: DocumentText { canonical, folder: seen_from(&folder, graph.folder()), hash: graph.document_hash() },
        fingerprint: fingerprint_of(inputs, &image),
        format: format_of(graph),
        frame: frame.number,
        image: image.hashes(seen_from(&folder, &file.path)),
        inputs: hashes?,
        optimized,
        outputs: outputs.collect(),
        plan: plan_of(graph, &file.outputs, frame.number, optimized)?,
        trochoid: crate::VERSION.into(),
        version: VERSION,
    })
}

/// Returns the fingerprint in the image's own metadata, so that image and certificate agree.
fn fingerprint_of(inputs: &CertificateInputs<'_>, image: &StoredImage) -> String {
    let said = image.metadata.iter().find(|(key, _)| key == crate::resume::KEY).map(|(_, value)| value.clone());
    said.unwrap_or_else(|| Fingerprints::with(inputs.settings).of(inputs.graph, inputs.file, inputs.frame.number))
}

/// Returns the format that a document requests.
pub(super) fn format_of(graph: &CheckedGraph) -> FormatText {
    let format = graph.format();
    FormatText {
        height: format.height(),
        samples: format.samples(),
        shading: format.shading().name().into(),
        width: format.width(),
        working_space: graph.space().name().into(),
    }
}

/// Returns the state of each node if only these outputs are planned.
pub(super) fn plan_of(
    graph: &CheckedGraph,
    outputs: &[usize],
    frame: i64,
    optimized: bool,
) -> Result<Vec<PlannedNode>, PlanError> {
    let names: Vec<&str> = outputs.iter().map(|index| graph.outputs()[*index].name.as_str()).collect();
    let switches = if optimized { Switches::ALL } else { Switches::NONE };
    let mut settings = Settings::default();
    settings.switches = switches;
    let plan = Plan::new(graph, &names, frame, &[], &settings)?;
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
pub(super) fn hash_of_corners(corners: &[Rgb]) -> String {
    let mut corners = corners.to_vec();
    corners.sort_by(|a, b| a.iter().zip(b).fold(std::cmp::Ordering::Equal, |o, (a, b)| o.then(a.total_cmp(b))));
    let mut hasher = blake3::Hasher::new();
    corners.iter().flatten().for_each(|value| {
        hasher.update(&value.to_le_bytes());
    });
    hasher.finalize().to_hex().to_string()
}

fn output(inputs: &CertificateInputs<'_>, picture: &Picture, certified: &Certified, png: bool) -> CertifiedOutput {
    let graph = inputs.graph;
    let spec = &graph.outputs()[picture.output];
    let audit = &picture.audit;
    let name = |guarantee: Guarantee| guarantee.name().to_string();
    CertifiedOutput {
        audit: AuditText {
            judged: audit.judged,
            margin: picture.margin,
            nan: audit.nan_count,
            outside: audit.hull_exits,
            pixels: audit.pixels,
            weight_min: finite(audit.weight_min),
            weight_sum_max_deviation: audit.weight_sum_max_deviation,
            worst: finite(audit.worst_exit),
        },
        channels: channels_of(graph, spec, inputs.file, png).into_iter().map(|(name, _)| name).collect(),
        controls: picture.guarantee.map(|_| Controls {
            count: picture.control_count as u64,
            corners: certified.palette.len() as u64,
            hash: hash_of_corners(&certified.palette),
            values: picture.control_colors.clone(),
        }),
        error: error(certified),
        guarantee: picture.guarantee.map(|class| GuaranteeText {
            asked: requirement(spec, inputs.required).map(name),
            class: name(class),
            held: held(picture).map(name),
        }),
        kind: spec.kind.to_string(),
        name: spec.name.clone(),
        unbounded: certified
            .unbounded
            .iter()
            .map(|(id, why)| Unbounded { node: graph.node(*id).name.clone(), why: (*why).into() })
            .collect(),
    }
}

fn error(certified: &Certified) -> CertifiedError {
    let area = certified.window.area();
    let largest = |pixel: usize| certified.errors.iter().fold(0.0_f32, |largest, errors| largest.max(errors[pixel]));
    let is_ambiguous = |pixel: usize| certified.doubt[pixel] > 0.0;
    let map = PixelMap::new((0..area).map(is_ambiguous));
    let (mut clear, mut max_ambiguous) = (Vec::new(), 0.0_f32);
    for pixel in 0..area {
        if is_ambiguous(pixel) {
            max_ambiguous = max_ambiguous.max(largest(pixel));
        } else {
            clear.push(largest(pixel));
        }
    }
    clear.sort_unstable_by(f32::total_cmp);
    // One pixel in a thousand exceeds this one.
    let rank = clear.len().saturating_sub(1 + clear.len() / 1000);
    let at = |index: Option<&f32>| finite(index.map_or(0.0, |bound| f64::from(*bound)));
    let total = certified.clear.total() + certified.unclear.total();
    let of = |samples: &Distribution| SampleBounds {
        count: samples.total(),
        max: finite(samples.max()),
        p999: finite(samples.quantile(0.999)),
    };
    CertifiedError {
        ambiguous: Ambiguous {
            map: map.encode(),
            max: at(Some(&max_ambiguous)),
            pixels: map.count(),
            samples: certified.unclear.total(),
            share: certified.unclear.total() as f64 / total.max(1) as f64,
            share_beyond_8_bit: certified.in_doubt(1.0 / 255.0),
        },
        pixels: PixelBounds { count: clear.len() as u64, max: at(clear.last()), p999: at(clear.get(rank)) },
        samples: of(&certified.clear),
    }
}

/// Returns a number, or `None` if it is infinite, which JSON cannot represent.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
