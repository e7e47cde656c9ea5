//! What a page draws of color space, as JSON.

use super::super::{Found, write::hex};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use trochoid::Hull;
use trochoid_palette::Cloud;

/// Most cells into which a cloud of pixels is gathered.
const MOST_CELLS: usize = 4000;
/// Most colors outside that are drawn.
const MOST_OUTSIDE: usize = 400;

/// Pixels of nearly the same color.
pub(super) struct Cell {
    /// Mean of their colors, in steps of 8 bits.
    pub(super) color: [f64; 3],
    pub(super) pixels: u64,
}

/// Gathers the pixels of a cloud in cubes of color space, as small as their number allows.
pub(super) fn cells(cloud: &Cloud) -> Vec<Cell> {
    let gathered = |shift: u32| {
        let mut sums: BTreeMap<[u8; 3], ([u64; 3], u64)> = BTreeMap::new();
        for (color, count) in cloud.colors() {
            let (sum, pixels) = sums.entry(color.map(|v| v >> shift)).or_default();
            sum.iter_mut().zip(color).for_each(|(sum, v)| *sum += u64::from(v) * u64::from(count));
            *pixels += u64::from(count);
        }
        sums
    };
    // With cubes of 32 steps, there are 512 cells at most.
    let sums = (2..=5).map(gathered).find(|sums| sums.len() <= MOST_CELLS).unwrap_or_default();
    sums.into_values().map(|(sum, pixels)| Cell { color: sum.map(|v| v as f64 / pixels as f64), pixels }).collect()
}

/// Returns the colors of the palette, the edges of its hull, the pixels and those outside.
pub(super) fn space(found: &Found, cells: &[Cell]) -> Value {
    let colors = &found.chosen.colors;
    let hull = Hull::new(&colors.iter().map(|color| color.map(|v| (255.0 * v) as f32)).collect::<Vec<_>>());
    let rounded = |point: [f64; 3]| point.map(|v| v.round() as u8);
    let edges = hull.edges().iter().map(|[from, to]| [rounded(*from), rounded(*to)].concat());
    let far = |(color, _): ([u8; 3], u32)| {
        let distance = hull.signed_distance(color.map(f64::from));
        (distance > 1e-9).then_some((distance, color))
    };
    let mut outside: Vec<(f64, [u8; 3])> = found.cloud.colors().filter_map(far).collect();
    outside.sort_by(|a, b| b.0.total_cmp(&a.0));
    outside.truncate(MOST_OUTSIDE);
    let pixels = found.cloud.pixels().max(1) as f64;
    // The size of a dot: the root of its share, in 1000 parts.
    let dot = |cell: &Cell| {
        let size = (1000.0 * (cell.pixels as f64 / pixels).sqrt()).round() as u32;
        let [r, g, b] = rounded(cell.color).map(u32::from);
        [r, g, b, size]
    };
    let named = found.chosen.names.iter().zip(colors);
    json!({
        "colors": named.map(|(name, color)| json!([name, hex(*color), color.map(|v| 255.0 * v)])).collect::<Vec<_>>(),
        "edges": edges.collect::<Vec<_>>(),
        "pixels": cells.iter().map(dot).collect::<Vec<_>>(),
        "outside": outside.into_iter().map(|(_, color)| color).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_all_pixels_and_are_few() {
        let mut cloud = Cloud::new();
        for index in 0..100_000_u32 {
            cloud.add([index as u8, (index / 7) as u8, (index / 256) as u8]);
        }
        let found = cells(&cloud);
        assert!(found.len() <= MOST_CELLS && found.len() > 400, "{}", found.len());
        assert_eq!(found.iter().map(|cell| cell.pixels).sum::<u64>(), 100_000);
        let mut one = Cloud::new();
        (0..5).for_each(|_| one.add([1, 2, 3]));
        let found = cells(&one);
        assert_eq!((found.len(), found[0].color, found[0].pixels), (1, [1.0, 2.0, 3.0], 5));
    }
}
