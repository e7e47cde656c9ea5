//! All nodes of Trochoid, one file each.
//!
//! Node files have the same sections in the same order: declaration, checks, body (lowering, or prepare and fill),
//! reference, tests. Only the `mod.rs` of its folder names a node. Code shared by the nodes of a folder is in the same
//! folder.
//!
//! Features: `io` (Read, ViewFromPasses), `scene` (cameras, lights, Render, passes) and `sea` (wave simulators). All
//! are on by default.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

#[cfg(all(test, feature = "io", feature = "sea"))]
mod bound_tests;
mod convex;
mod field;
#[cfg(feature = "io")]
mod files;
mod filter;
#[cfg(feature = "scene")]
mod geometry;
#[cfg(feature = "scene")]
mod lit;
mod paint;
#[cfg(feature = "scene")]
mod sea;
#[cfg(test)]
mod testing;
#[cfg(feature = "scene")]
mod view;

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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use trochoid_graph::{OUTPUT_WORDS, Registry, Term, refusal};

    #[test]
    fn each_word_of_other_programs_means_one_thing_and_none_is_refused() {
        let registry = Registry::new(crate::all());
        let aliases = registry.iter().flat_map(|ty| ty.declaration().aliases).map(|alias| alias.word);
        let mut known: BTreeSet<String> = registry.names().map(str::to_lowercase).collect();
        for word in aliases.chain(OUTPUT_WORDS) {
            assert!(refusal(word).is_none(), "{word} is refused");
            assert!(
                known.insert(word.to_lowercase()),
                "\"{word}\" names two nodes, or one twice: remove it from the also_called of one"
            );
        }
        assert_eq!(Term::of("image_read", &registry).and_then(|term| term.node()), Some("Read"));
        assert!(Term::of("Read", &registry).is_none() && Term::of("", &registry).is_none());
        assert_eq!(Term::of("file output", &registry), Some(Term::Output));
    }
}
