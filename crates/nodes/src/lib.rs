//! Every node of Trochoid, one file each.
//!
//! A node file has the same sections in the same order: declaration, checks, body (lowering, or prepare and
//! fill), reference, tests. The build script finds the files; nothing else names them.
//!
//! Features: `io` (Read, ViewFromPasses), `scene` (cameras, lights, Render, passes), `sea` (wave simulators);
//! all on by default.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

#[cfg(all(test, feature = "io", feature = "sea"))]
mod bound_tests;
mod filter_support;
mod front_support;
#[cfg(feature = "io")]
mod io_support;
mod paint_support;
#[cfg(feature = "scene")]
#[cfg_attr(not(feature = "sea"), allow(dead_code, unused_imports, reason = "only wave simulators use some of it"))]
mod scene_support;
#[cfg(test)]
mod testing;

include!(concat!(env!("OUT_DIR"), "/nodes.rs"));

/// All node types.
///
/// ```
/// let names: Vec<_> = trochoid_nodes::all().iter().map(|ty| ty.declaration().name).collect();
/// assert!(names.contains(&"Mix"));
/// ```
pub fn all() -> &'static [&'static dyn trochoid_graph::NodeType] {
    NODES
}
