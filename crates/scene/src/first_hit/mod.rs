//! First points of seas on a camera's rays, from cells that all rays share.
//!
//! Within a small square of rest points, a sea is nearly a polynomial, and from its waves follows how nearly. So the part
//! of a sea that a camera may see is divided into cells, each a patch in Bézier form with a bound of its distance from
//! the sea (`remainder`). A tree of boxes finds the cells that a ray may meet, the nearest first. A patch is halved
//! until the ray certainly misses it, or until it is one-to-one across the ray; in the latter case Newton's method on
//! the sum of the waves itself finds the only point, or its absence is proven (`search`). Where values may be off by a
//! thousandth, the patch mostly tells them, too (`near`).
//!
//! Compared with [`first_point`](crate::first_point), which starts from bounds that hold for all phases and shares
//! nothing between rays, a ray takes about a thousandth of the time.

mod bernstein;
mod cells;
mod derivatives;
mod first;
mod footprints;
pub mod inside;
mod kept;
mod near;
mod part;
mod region;
mod remainder;
mod search;
mod sizes;
mod squares;

pub(crate) use cells::NoCells;
pub(crate) use first::{First, FirstPoint, Shape, Thoroughness};
pub(crate) use kept::KeptCells;
