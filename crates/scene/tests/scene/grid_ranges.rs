//! Tests of the ranges of height fields over their cells.

use trochoid_scene::GridSurface;
use trochoid_scene::inside::GridRanges;

#[test]
fn no_height_is_beyond_the_range_of_its_cell_and_blocks() {
    let (columns, rows, spacing) = (41, 37, 0.5);
    let part = |index: usize, by: f64| (index as f64 * by).fract();
    let heights = (0..columns * rows).map(|cell| (4.0 * part(cell, 0.618) * part(cell, 0.0137)) as f32).collect();
    let grid = GridSurface::new(heights, columns, spacing, [0.0, 0.0], 0.0);
    let ranges = GridRanges::new(&grid);
    let mut near = 0;
    for place in 0..20_000 {
        let at = [40.0 * part(place, 0.732), 36.0 * part(place, 0.414)];
        let [height, ..] = grid.height(at[0] * spacing, at[1] * spacing).expect("on the grid");
        let cell = at.map(|along| along as usize);
        let [low, high] = ranges.cell(cell);
        assert!(low <= height && height <= high, "{at:?}");
        assert!(ranges.blocks(cell).iter().all(|[least, most]| *least <= low && high <= *most), "{at:?}");
        near += usize::from(high - height < 0.3 * (high - low));
    }
    assert!(near > 100, "{near}");
}
