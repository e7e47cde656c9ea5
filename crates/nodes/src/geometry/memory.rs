//! Memory estimates for surfaces and views of them, from measurements of the scenes under `graphs/`.

use crate::view::Facets;
use std::path::Path;
use trochoid_graph::{Connected, MemoryContext, MemoryUse, One, Source, port};
#[cfg(feature = "sea")]
use trochoid_scene::SeaSurface;
use trochoid_scene::Visible;

/// Bytes per vertex of a view's mesh: position, three derivatives or a normal, rest point, slope, screen position, and
/// its share of the bins.
const VERTEX: u64 = 80;
/// Bytes per vertex of the surfaces that rays hit: position, triangles and nodes of a tree.
const OBSTACLE: u64 = 120;
/// Maximum number of vertices of a surface in a view.
const MOST: u64 = 8_000_000;

const VIEW: &str = "lower the format's \"width\" and \"height\", or the \"fineness\" of the Render";

/// Vertices per pixel of a sea in a small picture, where they are not limited by pixel, and how many are not.
#[cfg(feature = "sea")]
const SMALL: (f64, f64) = (1.5, 3e5);

/// Vertices per pixel of patches whose triangles are a pixel off.
const CURVED: f64 = 0.01;

/// Returns the memory of a sea of waves: the vertices of a view are limited by pixel, times `detail` along each axis;
/// small pictures have more.
#[cfg(feature = "sea")]
pub(crate) fn of_sea(detail: f64, context: &MemoryContext<'_>) -> MemoryUse {
    let pixels = context.pixels() as f64 * (detail * detail);
    let (per_pixel, free) = SMALL;
    let vertices = (SeaSurface::VERTICES_PER_PIXEL * pixels).max((per_pixel * pixels).min(free));
    MemoryUse::default().per_view((vertices as u64).min(MOST) * VERTEX)
}

/// Returns the memory of a sea on a grid with `held` bytes per cell. A view has several vertices per cell, but hardly
/// more than one per pixel.
#[cfg(feature = "sea")]
pub(crate) fn of_grid(cells: u64, held: u64, context: &MemoryContext<'_>) -> MemoryUse {
    let remedy = "lower \"columns\" or \"rows\"";
    MemoryUse::held(cells * held, remedy).per_view((4 * cells).max(cells + context.pixels()).min(MOST + cells) * VERTEX)
}

/// Returns the memory of a model from a file with a number of bytes per vertex; a view contains all of it.
pub(crate) fn of_model(path: &Path, bytes_of_vertex: u64) -> MemoryUse {
    let vertices = std::fs::metadata(path).map_or(0, |file| file.len() / bytes_of_vertex);
    // Positions, normals and coordinates in f64, and triangles.
    MemoryUse::held(vertices * 96, "use a smaller model").working(vertices * 96).per_view(vertices * VERTEX)
}

/// Returns the memory of patches with a number of vertices along each side.
pub(crate) fn of_patches(patches: u64, side: u64) -> MemoryUse {
    MemoryUse::default().per_view((patches * side * side).min(MOST) * VERTEX)
}

/// Returns the memory of patches that are cut as a view requires, with a tolerance in pixels: the number of vertices is
/// inverse to it.
pub(crate) fn of_curved(tolerance: f64, context: &MemoryContext<'_>) -> MemoryUse {
    let vertices = context.pixels() as f64 * CURVED / tolerance;
    MemoryUse::default().per_view((vertices as u64).min(MOST) * VERTEX)
}

/// Returns the memory of a view of a port's surfaces, with `fineness` times the vertex density that pixels require
/// along each axis.
pub(crate) fn of_view(surfaces: &impl Connected, fineness: f64, context: &MemoryContext<'_>) -> MemoryUse {
    let seen = context.all(surfaces).fold(0, |sum: u64, taken| sum.saturating_add(taken.per_view));
    let held = seen as f64 * (fineness * fineness);
    let pixel = context.frame.format.samples() as u64 * Visible::BYTES_OF_SAMPLE;
    let most = Visible::MOST_SAMPLES * Visible::BYTES_OF_SAMPLE;
    MemoryUse::held((held as u64).min(seen.max(MOST * VERTEX)), VIEW).per_view(seen).thread(pixel, most)
}

/// Returns the memory of the surroundings of a view that block rays.
pub(crate) fn of_surroundings(view: &One<port::View>, facets: &Facets, context: &MemoryContext<'_>) -> MemoryUse {
    let seen = context.all(view).fold(0, |sum: u64, taken| sum.saturating_add(taken.per_view));
    let Facets { detail, beyond } = *facets;
    let wider = (1.0 + 2.0 * beyond) / detail;
    let vertices = seen as f64 / VERTEX as f64 * (wider * wider);
    let held = (vertices as u64).min(seen / VERTEX + MOST) * OBSTACLE;
    let view = match **view {
        Source::Output { node, .. } => node.0 as u64,
        _ => 0,
    };
    MemoryUse::held(held, "raise \"detail\", or lower \"beyond\"").working(held).shared([
        view,
        beyond.to_bits(),
        detail.to_bits(),
    ])
}
