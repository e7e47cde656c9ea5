//! Partitions of unity and the arithmetic that keeps a blend inside the hull of its operands.
//!
//! The back end of Trochoid has one operation, `C = Σ ωᵢ Cᵢ` with `ωᵢ ≥ 0` and `Σ ωᵢ = 1`. This crate is the
//! audited part of that promise:
//!
//! - [`arithmetic`] holds the scalar f32 definitions that every kernel inlines, each with the proof that rounding
//!   cannot leave the operands' range; [`reference`](mod@reference) says the same in plain f64, independently.
//! - [`kernel`] filters images by weights that are such a partition, rounded so that their sum is exactly 1.
//! - [`Hull`] and [`BoxHull`] judge finished pixels against the control colors, without trusting any of the above.
//! - [`Audit`] is the count that comes of it.

pub mod arithmetic;
pub mod kernel;
pub mod reference;

mod audit;
mod hull;

pub use audit::Audit;
pub use hull::{BoxHull, Facet, Hull, HullBuilder, Witness};
