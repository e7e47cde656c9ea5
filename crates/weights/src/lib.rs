//! Partitions of unity, and arithmetic that keeps a blend inside the convex hull of its operands.
//!
//! The back end of Trochoid has one operation on colors, the convex combination `C = Σ ωᵢ Cᵢ` with `ωᵢ ≥ 0` and
//! `Σ ωᵢ = 1`. This crate guarantees that it stays convex, and checks results:
//!
//! - [`arithmetic`] has the scalar f32 definitions that every kernel inlines, each with the proof that rounding
//!   cannot leave the range of the operands; [`reference`](mod@reference) has independent definitions in plain f64.
//! - [`sums`] makes weights from outside sum to 1.
//! - [`Hull`] and [`BoxHull`] judge finished pixels against the control colors, independently of the arithmetic.
//! - [`Storing`] rounds weights for files so that their sum stays 1, [`Apportioner`] those of many pixels, and [`paint`]
//!   mixes colors with them.
//! - [`Audit`] counts the results.

pub mod arithmetic;
pub mod kernel;
pub mod reference;
pub mod sums;

mod apportion;
mod audit;
mod hull;
mod paint;
mod stored;

pub use apportion::{Apportioner, BLOCK};
pub use audit::Audit;
pub use hull::{BoxHull, Facet, Hull, HullBuilder, Witness, surface};
pub use paint::{StoredSample, paint};
pub use stored::Storing;

/// What the tests of this crate see beside its interface. They stand outside, in `tests/weights`, so that the crate is
/// not compiled a second time for them. Nothing of it is part of the interface.
#[doc(hidden)]
pub mod inside {
    use crate::kernel::Kernel;

    /// Returns the weights of a kernel from one side to the other.
    pub fn weights(kernel: &Kernel) -> &[f32] {
        &kernel.weights
    }

    /// Returns the kernel for an image that is `length` pixels long.
    pub fn folded(kernel: &Kernel, length: usize) -> Kernel {
        kernel.folded(length)
    }

    /// Returns a kernel of any weights, even of such as no kernel may have.
    pub fn kernel_of(weights: Vec<f32>) -> Kernel {
        Kernel { weights: weights.into_iter().collect() }
    }
}
