//! Filter nodes, and what they share: kernels, bilinear weights, and access to images of any kind as planes and as
//! numbers.
//!
//! Every filter is a weighted mean. Its weights are ≥ 0, sum to exactly 1 and are the same for all channels, so results
//! stay between the input values, and colors within their convex hull.

mod bilinear;
mod blur;
mod bounded;
mod values;
mod warp;

pub(crate) use bilinear::{LANES, blended_together, weights_together};
#[cfg(feature = "io")]
pub(crate) use bilinear::{blended, weights};
pub(crate) use bounded::{BoundedChannel, BoundedSum};
pub(crate) use values::{fill, fill_together, kind, mean, numbers, value};

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[NodeType::of::<blur::Blur>(), NodeType::of::<warp::Warp>()];
