//! Fields of a certificate, in alphabetical order, so that the digest comes first.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

/// Certificate of one image file.
///
/// Numbers that may be infinite are `None` (`null`) if they are: there is no bound.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// BLAKE3 hash of the certificate's text without white space, with zeros in place of these 64 digits.
    pub digest: String,
    /// Document that the picture was made from.
    pub document: DocumentText,
    /// Fingerprint for `--resume`: a hash of version, document, frame and inputs.
    pub fingerprint: String,
    /// Format that the document requests.
    pub format: FormatText,
    /// Number of the frame.
    pub frame: i64,
    /// Image file with the hashes of its pixels.
    pub image: ImageHashes,
    /// Files that the picture was made from.
    pub inputs: Vec<InputHash>,
    /// Whether the plan left out work that makes no difference; `false` with `--unoptimized`.
    pub optimized: bool,
    /// Outputs in the image.
    pub outputs: Vec<CertifiedOutput>,
    /// States of the document's nodes, sorted by name.
    pub plan: Vec<PlannedNode>,
    /// Version of Trochoid that made the certificate.
    pub trochoid: String,
    /// Version of the format: [`VERSION`].
    pub version: u32,
}

/// Version of the certificate format that is written and read.
pub const VERSION: u32 = 1;

/// Document in a certificate.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DocumentText {
    /// Canonical form of the document: keys sorted, notes left out, `--set` applied.
    pub canonical: Box<RawValue>,
    /// Folder that the document's paths are relative to, relative to the certificate's folder.
    pub folder: String,
    /// BLAKE3 hash of the canonical form.
    pub hash: String,
}

/// Format of a picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FormatText {
    /// Height in pixels.
    pub height: u32,
    /// Number of samples per pixel.
    pub samples: u32,
    /// Shading rate: "sample" or "pixel".
    pub shading: String,
    /// Width in pixels.
    pub width: u32,
    /// Space in which colors are mixed.
    pub working_space: String,
}

/// Input file with its hash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputHash {
    /// Length of the file in bytes.
    pub bytes: u64,
    /// BLAKE3 hash of the file's bytes.
    pub hash: String,
    /// Path of the file, relative to the certificate's folder.
    pub path: String,
}

/// Image file with the hashes of its pixels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageHashes {
    /// Width and height of a block, in pixels; blocks at the right and lower border may be smaller.
    pub block: u32,
    /// BLAKE3 hash of each block, with blocks in row order. A hash covers the channels in the listed order, row by row,
    /// with every stored sample as a little-endian f32.
    pub blocks: Vec<String>,
    /// Channels, sorted by name.
    pub channels: Vec<ChannelText>,
    /// Path of the image file, relative to the certificate's folder.
    pub file: String,
    /// Height in pixels.
    pub height: u32,
    /// Kind of file: "EXR" or "PNG".
    pub kind: String,
    /// BLAKE3 hash of the hashes of all blocks in order.
    pub pixels: String,
    /// Width in pixels.
    pub width: u32,
}

/// Channel of an image file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelText {
    /// Full name of the channel.
    pub name: String,
    /// Type of the stored samples: "half", "float", "u8" or "u16".
    pub stored: String,
}

/// Output in an image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedOutput {
    /// Counts on the f32 pixels of the output.
    pub audit: AuditText,
    /// Channels of the output in the image.
    pub channels: Vec<String>,
    /// Control colors that a color is mixed from.
    pub controls: Option<Controls>,
    /// Error bounds against the references.
    pub error: CertifiedError,
    /// Guarantee on the values of a color.
    pub guarantee: Option<GuaranteeText>,
    /// Kind of the output.
    pub kind: String,
    /// Name of the output in the document.
    pub name: String,
    /// Stages upstream that have no error bound somewhere, and why; samples that depend on them there are ambiguous.
    pub unbounded: Vec<Unbounded>,
}

/// Counts on the pixels of an output before they were stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditText {
    /// Number of pixels that were compared with the hull one by one.
    pub judged: u64,
    /// Margin of rounding within which a pixel counts as inside, in units of the working space.
    pub margin: f64,
    /// Number of pixels that are NaN.
    pub nan: u64,
    /// Number of pixels outside the hull by more than the margin.
    pub outside: u64,
    /// Number of all pixels.
    pub pixels: u64,
    /// Smallest weight seen; `None` if there are no weights.
    pub weight_min: Option<f64>,
    /// Largest |Σω − 1| seen.
    pub weight_sum_max_deviation: f64,
    /// Largest distance of a pixel outside; 0 if there are none.
    pub worst: Option<f64>,
}

/// Control colors of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controls {
    /// Number of colors that the plan mixes.
    pub count: u64,
    /// Number of corners of the hull of all colors that the document could mix into the output at this frame.
    pub corners: u64,
    /// BLAKE3 hash of those corners, sorted, each as three little-endian f32.
    pub hash: String,
    /// Colors that the plan mixes: all of them if `count` is at most [`LISTED`], else [`LISTED`] of them.
    pub values: Vec<[f32; 3]>,
}

/// Maximum number of control colors that a certificate lists.
pub const LISTED: u64 = 64;

/// Guarantee on a color output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuaranteeText {
    /// Guarantee that was required, if any.
    pub asked: Option<String>,
    /// Guarantee of the output's operations.
    pub class: String,
    /// Guarantee that was found to hold on all pixels, if any.
    pub held: Option<String>,
}

/// Error bounds of an output against its f64 references, in units of the working space, of the largest channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedError {
    /// Ambiguous samples and pixels.
    pub ambiguous: Ambiguous,
    /// Error bounds of pixels.
    pub pixels: PixelBounds,
    /// Error bounds of samples.
    pub samples: SampleBounds,
}

/// Samples whose side of a threshold or whose visibility is not certain, and the pixels that contain them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ambiguous {
    /// One bit per pixel, row by row, the first in the lowest bit of a byte; deflated, in base64.
    pub map: String,
    /// Largest error bound of such pixels, which holds despite the ambiguity.
    pub max: Option<f64>,
    /// Number of pixels with an ambiguous sample.
    pub pixels: u64,
    /// Number of ambiguous samples.
    pub samples: u64,
    /// Share of ambiguous samples in all samples.
    pub share: f64,
    /// Share of ambiguous samples whose bound exceeds 1/255 in all samples.
    pub share_beyond_8_bit: f64,
}

/// Error bounds of the pixels without an ambiguous sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelBounds {
    /// Number of these pixels.
    pub count: u64,
    /// Largest bound.
    pub max: Option<f64>,
    /// Bound that at most one in a thousand exceeds.
    pub p999: Option<f64>,
}

/// Error bounds of the samples that are not ambiguous.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleBounds {
    /// Number of these samples.
    pub count: u64,
    /// Largest bound.
    pub max: Option<f64>,
    /// Bound that at most one in a thousand exceeds.
    pub p999: Option<f64>,
}

/// Stage without an error bound.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unbounded {
    /// Name of the node.
    pub node: String,
    /// Reason that there is no bound.
    pub why: String,
}

/// State of a node in the plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedNode {
    /// Name of the node.
    pub name: String,
    /// State: "evaluated" or "left_out".
    pub state: String,
    /// Type of the node.
    #[serde(rename = "type")]
    pub ty: String,
    /// Reason that the node is left out.
    pub why: Option<String>,
}
