//! Tests across crates: architecture, scenes, random graphs, and the guarantees of the design on real pixels. Cases in
//! files are tested by the other binary, `cases`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod access;
mod adaptive;
mod architecture;
mod bad_documents;
mod book;
mod branches;
mod cancellation;
mod cartoon;
mod certificates;
mod curves;
mod declared;
mod demand;
mod diagram;
mod drift;
mod engine_folders;
mod explain;
mod faults;
mod filters;
mod formulas;
mod frames;
mod groups;
mod held;
mod hoisting;
mod include;
mod keeping;
mod library;
mod light_paths;
mod lines;
mod looks;
mod manual;
mod memory;
mod merging;
mod painter;
mod palette;
mod passes_told;
mod patches;
mod pipes;
mod portable;
mod random;
mod recipes;
mod references;
mod scale;
mod scenes;
mod shading;
mod shown;
mod spray;
mod stores;
mod streaming;
mod sums;
mod support;
mod texture;
mod thesis;

/// Counts the memory that the tests take.
#[global_allocator]
static HEAP: trochoid::Heap = trochoid::Heap;
