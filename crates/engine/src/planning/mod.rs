//! Turns a checked graph into a [`Plan`](crate::Plan): what is needed, in which order, and why the rest is left out.
//!
//! Nodes are lowered to one program (`lower`), which is optimized (`optimize`) and turned into passes over the
//! samples (`schedule`); `left_out` and `explain` say what happened to the other nodes. Nothing here reads a file or
//! fills a plane, and nothing here depends on `running`, which executes plans.

pub(crate) mod bounds;
mod controls;
pub(crate) mod explain;
pub(crate) mod gates;
pub(crate) mod left_out;
mod lower;
mod optimize;
pub(crate) mod plan;
mod planner;
pub(crate) mod pointwise;
pub(crate) mod schedule;
pub(crate) mod shading;
