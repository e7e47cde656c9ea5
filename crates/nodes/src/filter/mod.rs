//! Filters of images, and what they share: kernels, bilinear weights, and images of any kind as planes and as numbers.
//!
//! Every filter is a weighted mean whose weights are ≥ 0, sum to exactly 1 and are shared by all channels, so that its
//! results stay between the values that it takes, and colors in their hull.

mod bilinear;
mod blur;
mod bounded;
mod values;
mod warp;

pub(crate) use bilinear::{blended, weights};
pub(crate) use bounded::{Bounded, Summed};
pub(crate) use values::{fill, kind, mean, numbers, value};

use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[NodeType::of::<blur::Blur>(), NodeType::of::<warp::Warp>()];
