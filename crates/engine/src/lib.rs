//! Plans and evaluates checked graphs: demand, pruning, fusion, tiles on all cores, and the count of what
//! left the hull.
//!
//! The engine knows no node. It sees the pointwise program to which back-end nodes lower, and stages that
//! prepare once a frame and fill tiles. [`Plan::new`] decides what is needed, in which order, and why the
//! rest is left out; [`Plan::evaluate`] gives a [`Frame`]. Output is bit-identical for every tile size, number
//! of threads, and switch of [`Switches`]. [`ReferenceFrame`] is the slow f64 evaluator that all of this is
//! held against.

mod bands;
mod buffers;
mod certify;
mod controls;
mod examine;
mod explain;
mod fill;
mod frame;
mod inspect;
mod judge;
mod keep;
mod kernel;
mod left_out;
mod lower;
mod memory;
mod optimize;
mod plan;
mod planner;
mod points;
mod prepare;
mod reference;
mod rules;
mod run;
mod schedule;
mod settings;
mod shading;
#[cfg(test)]
mod tests;
mod tile;

pub use buffers::Buffers;
pub use certify::{Certified, Certifier, Distribution, Limiting};
pub use explain::{Account, Channels, Evidence, Fate, Proved};
pub use frame::{EvalError, Frame, Monitor, NodeReport, Phases, Picture, Silent, State};
pub use inspect::{Blame, Inspected, Inspection};
pub use left_out::LeftOut;
pub use memory::{MemoryAccount, Pictures, Taker};
pub use plan::{Plan, PlanError};
pub use points::ShadingPlan;
pub use prepare::Cache;
pub use reference::{ReferenceError, ReferenceFrame, ReferencePixel};
pub use rules::interval::Interval;
pub use run::Sink;
pub use settings::{Judging, Settings, Switches};
pub use trochoid_memory::Instructions;
pub use trochoid_weights::{Audit, Hull};
