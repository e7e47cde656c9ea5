//! Bilinear and bicubic Bézier patches, and the surfaces that are composed of them.
//!
//! Control points run row by row, u fastest: point `4·j + i` of a bicubic patch is at column i (u) and row j (v). The
//! normal is ∂P/∂u × ∂P/∂v, and points to the outer side.
//!
//! After CSE 167, *Toon Shading and Surface Patches*, and G. Farin, *Curves and Surfaces for CAGD*, 2002.

mod ball;
mod bicubic;
mod bilinear;
mod continuity;
mod curve;
mod edge;
mod model;
mod normal;
mod rails;
pub(crate) mod stitch;
mod surface;
mod tessellate;
mod trace;

pub use bicubic::Bicubic;
pub use bilinear::Bilinear;
pub use continuity::{Continuity, continuity};
pub use model::{MAX_PATCHES, MAX_SEGMENTS, Patch, PatchModel, Placement, Tessellation};
pub use normal::UnitNormal;
pub use rails::{MAX_RAIL_POINTS, Rails, RailsError};
