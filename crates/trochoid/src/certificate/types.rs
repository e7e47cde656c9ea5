//! Fields of a certificate: the digest, the signature, then all others in alphabetical order.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

/// Certificate of one image file.
///
/// Everything in it is derived again by [`verify`](super::verify), except for names that lead to files
/// ([`ImageHashes::file`], [`DocumentText::folder`]) and for [`trochoid`](Self::trochoid).
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// BLAKE3 hash of the certificate's text without white space and without `signature`, with zeros in place of these
    /// 64 digits.
    pub digest: String,
    /// Signature of the digest, if it is signed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signature: Option<SignatureText>,
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
    /// Outputs in the image.
    pub outputs: Vec<CertifiedOutput>,
    /// States of the document's nodes in an optimized plan of these outputs, sorted by name.
    pub plan: Vec<PlannedNode>,
    /// Version of Trochoid that made the certificate, as it says itself.
    pub trochoid: String,
    /// Version of the format: [`VERSION`].
    pub version: u32,
}

/// Version of the certificate format that is written and read.
pub const VERSION: u32 = 2;

/// Signature of a certificate's digest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignatureText {
    /// Ed25519 public key, in 64 hexadecimal digits.
    pub key: String,
    /// Signature of the text `trochoid certificate `, followed by the digits of the digest; in 128 hexadecimal digits.
    pub value: String,
}

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
    /// Tolerance of adaptive sampling; none if every sample is taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<String>,
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
    /// Channels of the output in the image.
    pub channels: Vec<String>,
    /// Control colors that a color is mixed from.
    pub controls: Option<Controls>,
    /// Counts on the pixels of the image.
    pub counts: PixelCounts,
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

/// Counts on the pixels of an output, as the image stores them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelCounts {
    /// Number of pixels with an infinite channel, and no NaN.
    pub infinite: u64,
    /// Number of pixels with a NaN in any channel.
    pub nan: u64,
    /// Number of finite pixels outside: of colors, outside of the hull by more than the margin and the rounding of the
    /// file's format; of weights, less than 0, more than 1, or with another sum than 1. 0 for fields.
    pub outside: u64,
    /// Largest distance of such a color from the hull, in units of the working space; 0 if there is none.
    pub outside_by: f64,
    /// Number of all pixels.
    pub pixels: u64,
}

/// Control colors of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controls {
    /// Number of corners of the hull of all colors that the document could mix into the output at this frame.
    pub corners: u64,
    /// BLAKE3 hash of those corners, sorted, each as three little-endian f32.
    pub hash: String,
    /// Margin of rounding around the hull, in units of the working space.
    pub margin: f64,
    /// Those corners, sorted; none if there are more than [`LISTED`].
    pub values: Vec<[f32; 3]>,
}

/// Maximum number of control colors that a certificate lists.
pub const LISTED: u64 = 64;

/// Guarantee on a color output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuaranteeText {
    /// Guarantee of the output's operations.
    pub class: String,
    /// Guarantee that was found to hold on all pixels of the image, if any.
    pub held: Option<String>,
    /// Guarantee that the document requires, if any.
    pub required: Option<String>,
}

/// Error bounds of an output against its f64 references.
///
/// All bounds are rounded up to [levels](ChannelBounds::map). The picture is compared before its values are rounded to
/// the file's format.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedError {
    /// Pixels with a sample whose side of a threshold or whose visibility is not certain.
    pub ambiguous: Ambiguous,
    /// Bounds of the largest channel of a color or of weights, or of each channel of a field.
    pub channels: Vec<ChannelBounds>,
    /// Bounds of a color in display values.
    pub display: Option<DisplayBounds>,
    /// Unit of the bounds in `channels`.
    pub unit: String,
}

/// Ambiguous pixels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ambiguous {
    /// One bit per pixel, row by row, the first in the lowest bit of a byte; deflated, in base64.
    pub map: String,
    /// Number of these pixels.
    pub pixels: u64,
}

/// Error bounds of the pixels of one or several channels, of the largest of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelBounds {
    /// Bounds of all pixels.
    pub all: BoundSummary,
    /// Level of byte 0 of the map.
    pub base: i32,
    /// Bounds of the pixels that are not ambiguous.
    pub clear: BoundSummary,
    /// One byte per pixel, row by row; deflated, in base64. Byte 0 is an error of 0; b from 1 to 253 the level
    /// `base` + b; 254 an infinite value that equals its reference; 255 no known bound. Level l is a bound of
    /// 2^(l/8), the smallest that is large enough: l = ⌈8·log₂ bound⌉. The largest level of a map has the byte 253;
    /// levels that would have a byte less than 1 have the byte 1.
    pub map: String,
    /// Names of the channels in the image.
    pub names: Vec<String>,
}

/// Error bounds of the colors that a display shows: of the largest channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DisplayBounds {
    /// Bounds of all pixels.
    pub all: BoundSummary,
    /// Bounds of the pixels that are not ambiguous.
    pub clear: BoundSummary,
    /// Unit of the bounds.
    pub unit: String,
}

/// Error bounds of some pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoundSummary {
    /// Number of pixels with a finite value and a bound.
    pub bounded: u64,
    /// Number of pixels with an infinite value, which equals that of the reference, such as the depth of the sky.
    pub infinite: u64,
    /// Largest bound of the `bounded` pixels.
    pub max: Option<BoundAt>,
    /// Bound that at most one in a thousand of them exceeds.
    pub p999: Option<BoundAt>,
    /// Number of pixels without a known bound.
    pub unbounded: u64,
}

/// A bound, and the first pixel that has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoundAt {
    /// The bound.
    pub bound: f64,
    /// Column and row of the pixel.
    pub pixel: [i64; 2],
}

/// Bounds of all pixels, and of those that are not ambiguous.
pub(super) struct Summaries {
    pub(super) all: BoundSummary,
    pub(super) clear: BoundSummary,
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
