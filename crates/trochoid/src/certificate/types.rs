//! What a certificate says, field by field. Fields stand in the order of their names, and the digest comes first.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

/// What is certain of one image file.
///
/// Numbers that may be infinite are `None` (`null`) where they are: nothing is known.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// BLAKE3 of the certificate's text without white space, with zeros in place of these 64 digits.
    pub digest: String,
    /// What the picture was made from.
    pub document: DocumentText,
    /// What `--resume` knows the picture by: a hash of version, document, frame and inputs.
    pub fingerprint: String,
    /// The format that the document asks for.
    pub format: FormatText,
    /// The frame.
    pub frame: i64,
    /// The image file and the hashes of its pixels.
    pub image: ImageHashes,
    /// The files that the picture was made from.
    pub inputs: Vec<InputHash>,
    /// Whether the plan left out what makes no difference (`--unoptimized` does not).
    pub optimized: bool,
    /// The outputs in the image.
    pub outputs: Vec<CertifiedOutput>,
    /// What became of each node of the document, sorted by name.
    pub plan: Vec<PlannedNode>,
    /// The version of Trochoid that made it.
    pub trochoid: String,
    /// The version of this form: [`VERSION`].
    pub version: u32,
}

/// The version of certificates that is written and read.
pub const VERSION: u32 = 1;

/// A document.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DocumentText {
    /// Its canonical form: keys sorted, notes left out, `--set` applied.
    pub canonical: Box<RawValue>,
    /// The folder that its paths are relative to, as seen from the certificate's.
    pub folder: String,
    /// BLAKE3 of the canonical form.
    pub hash: String,
}

/// A picture's format.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FormatText {
    /// Pixels down.
    pub height: u32,
    /// Samples a pixel.
    pub samples: u32,
    /// How often pixels are shaded: "sample" or "pixel".
    pub shading: String,
    /// Pixels across.
    pub width: u32,
    /// The space in which colors mix.
    pub working_space: String,
}

/// An input file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputHash {
    /// Its length.
    pub bytes: u64,
    /// BLAKE3 of its bytes.
    pub hash: String,
    /// Where it lies, seen from the certificate's folder.
    pub path: String,
}

/// An image file by its pixels.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageHashes {
    /// Width and height of a block, pixels; those at the right and lower border may be smaller.
    pub block: u32,
    /// BLAKE3 of each block, row by row of blocks: channel by channel as listed, row by row, every stored sample as f32,
    /// little-endian.
    pub blocks: Vec<String>,
    /// The channels, sorted by name.
    pub channels: Vec<ChannelText>,
    /// Where it lies, seen from the certificate's folder.
    pub file: String,
    /// Pixels down.
    pub height: u32,
    /// The kind of file: "EXR" or "PNG".
    pub kind: String,
    /// BLAKE3 of the hashes of all blocks, in their order.
    pub pixels: String,
    /// Pixels across.
    pub width: u32,
}

/// A channel of an image file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelText {
    /// Its full name.
    pub name: String,
    /// How samples are stored: "half", "float", "u8" or "u16".
    pub stored: String,
}

/// One output in the image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedOutput {
    /// What was counted on its f32 pixels.
    pub audit: AuditText,
    /// Its channels in the image.
    pub channels: Vec<String>,
    /// Of a color, what it is mixed from.
    pub controls: Option<Controls>,
    /// How far it may lie from the references.
    pub error: CertifiedError,
    /// Of a color, what it cannot leave.
    pub guarantee: Option<GuaranteeText>,
    /// Its kind.
    pub kind: String,
    /// Its name in the document.
    pub name: String,
    /// Stages on the way to it that know no bound everywhere, and why; what depends on them is ambiguous.
    pub unbounded: Vec<Unbounded>,
}

/// What was counted on the pixels of an output, before anything was stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditText {
    /// Pixels held against the hull one by one.
    pub judged: u64,
    /// The margin of rounding within which a pixel counts as inside, in units of the working space.
    pub margin: f64,
    /// Pixels that are not a number.
    pub nan: u64,
    /// Pixels outside the hull by more than the margin.
    pub outside: u64,
    /// All pixels.
    pub pixels: u64,
    /// The smallest weight seen; `None` where there is none.
    pub weight_min: Option<f64>,
    /// The largest |Σω − 1| seen.
    pub weight_sum_max_deviation: f64,
    /// The largest distance of a pixel outside; 0 where there is none.
    pub worst: Option<f64>,
}

/// The control colors of an output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controls {
    /// How many the plan mixes.
    pub count: u64,
    /// Corners of the hull of all that the document could mix into the output at this frame.
    pub corners: u64,
    /// BLAKE3 of those corners, sorted, each as three f32, little-endian.
    pub hash: String,
    /// Those that the plan mixes: all of them where `count` is at most [`LISTED`], else as many.
    pub values: Vec<[f32; 3]>,
}

/// Control colors that a certificate lists at most.
pub const LISTED: u64 = 64;

/// What a color output cannot leave.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GuaranteeText {
    /// What was required, if anything.
    pub asked: Option<String>,
    /// What its operations guarantee.
    pub class: String,
    /// What was found to hold on all pixels, if anything.
    pub held: Option<String>,
}

/// How far an output may lie from its f64 references, in units of the working space, largest channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CertifiedError {
    /// What is ambiguous.
    pub ambiguous: Ambiguous,
    /// Bounds of pixels.
    pub pixels: PixelBounds,
    /// Bounds of samples.
    pub samples: SampleBounds,
}

/// Samples where a side of a threshold, or what is seen, is not certain, and the pixels that have such.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ambiguous {
    /// One bit a pixel, row by row, the first in the lowest bit of a byte: deflated, in base64.
    pub map: String,
    /// The largest bound of such pixels, which holds all the same.
    pub max: Option<f64>,
    /// Pixels with an ambiguous sample.
    pub pixels: u64,
    /// Ambiguous samples.
    pub samples: u64,
    /// Their share of all samples.
    pub share: f64,
    /// The share of all samples that are ambiguous and whose bound passes 1/255.
    pub share_beyond_8_bit: f64,
}

/// Bounds of the pixels without an ambiguous sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelBounds {
    /// How many they are.
    pub count: u64,
    /// The largest.
    pub max: Option<f64>,
    /// What at most one in a thousand passes.
    pub p999: Option<f64>,
}

/// Bounds of the samples that are not ambiguous.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleBounds {
    /// How many they are.
    pub count: u64,
    /// The largest.
    pub max: Option<f64>,
    /// What at most one in a thousand passes.
    pub p999: Option<f64>,
}

/// A stage that knows no bound.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unbounded {
    /// The node.
    pub node: String,
    /// Why.
    pub why: String,
}

/// What became of a node.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedNode {
    /// Its name.
    pub name: String,
    /// "evaluated" or "left_out".
    pub state: String,
    /// Its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Why it is left out.
    pub why: Option<String>,
}
