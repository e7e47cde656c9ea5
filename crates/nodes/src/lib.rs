//! All nodes of Trochoid, one file each.
//!
//! Node files have the same sections in the same order: declaration, checks, body (lowering, or prepare and fill),
//! reference. Only the `mod.rs` of its folder names a node. Code shared by the nodes of a folder is in the same
//! folder.
//!
//! Features: `io` (Read, ViewFromPasses), `scene` (cameras, lights, Render, passes) and `sea` (wave simulators). All
//! are on by default.

mod convex;
mod field;
#[cfg(feature = "io")]
mod files;
mod filter;
mod formulas;
#[cfg(feature = "scene")]
mod geometry;
#[doc(hidden)]
pub mod inside;
#[cfg(feature = "scene")]
mod lit;
mod paint;
#[cfg(feature = "scene")]
mod sea;
#[cfg(feature = "scene")]
mod view;

pub use formulas::LinkFormulas;
use trochoid_graph::NodeType;

/// Returns all node types.
///
/// ```
/// let names: Vec<_> = trochoid_nodes::all().map(|ty| ty.declaration().name).collect();
/// assert!(names.contains(&"Mix"));
/// ```
pub fn all() -> impl Iterator<Item = &'static NodeType> {
    let folders = [
        convex::NODES,
        field::NODES,
        filter::NODES,
        paint::NODES,
        #[cfg(feature = "scene")]
        geometry::NODES,
        #[cfg(feature = "scene")]
        lit::NODES,
        #[cfg(feature = "scene")]
        sea::NODES,
        #[cfg(feature = "scene")]
        view::NODES,
        #[cfg(feature = "io")]
        files::NODES,
    ];
    folders.into_iter().flatten()
}
