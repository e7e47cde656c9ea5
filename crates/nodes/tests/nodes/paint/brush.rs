//! Strokes painted row by row, against their formula.

use trochoid_field::random::{draw, key};
use trochoid_nodes::inside::{PaintedStroke, StrokeNumbers};

/// Strokes of all directions, small and large, bent, next to edges and free, some along the axes.
fn stroke(index: i64) -> PaintedStroke {
    let random = |which: u64| draw(key(7, index), which);
    let (sin, cos) = match index % 8 {
        0 => (0.0, 1.0),
        1 => (-1.0, 0.0),
        2 => (1.0, -1e-12),
        _ => libm::sincos(std::f64::consts::TAU * random(0)),
    };
    PaintedStroke::new(&StrokeNumbers {
        at: [40.0 * random(1), 12.0 * random(2)],
        along: [cos, sin],
        half: [0.5 + 30.0 * random(3) * random(4), 0.5 + 6.0 * random(5)],
        bend: if index % 3 == 0 { 0.0 } else { 3.0 * random(6) - 1.5 },
        looks: [7, 8, 9, 10].map(random),
        edge: (index % 2 == 0).then(|| ((3.0 * random(11)).floor() - 1.0, 5.0)),
        step: 1.125,
    })
}

/// Surfaces and depths of a row: some of the stroke's own, some others, some where nothing is seen.
fn row(y: i64, width: usize) -> (Vec<f32>, Vec<f32>) {
    let random = |x: usize, which| draw(key(key(1, y), x as i64), which);
    let parts = (0..width).map(|x| (4.0 * random(x, 0)).floor() as f32 - 1.0);
    let depths = [5.0, 5.5, 4.5, 9.0, f32::INFINITY, 0.0, f32::MIN_POSITIVE];
    (parts.collect(), (0..width).map(|x| depths[(7.0 * random(x, 1)) as usize]).collect())
}

/// Columns from the first of a window to the first that is tested, within a group of pixels and beyond.
const BEFORE: [i64; 4] = [0, 3, 8, 21];

#[test]
fn rows_are_what_the_formula_tells_in_whatever_window() {
    let mut covered = 0;
    for index in 0..400 {
        let stroke = stroke(index);
        let shift = [0.25 * (index % 3) as f64, -0.375];
        let bounds = stroke.bounds(shift);
        let (first, width) = (bounds.x0 - 3, bounds.width() + 6);
        for y in bounds.y0 - 2..bounds.y1 + 2 {
            let is_below = (bounds.y0..bounds.y1).contains(&y);
            let (parts, depths) = row(y, width);
            let columns = stroke.columns(shift, y, first, width);
            let whole = stroke.row(shift, y, 0, first, &parts, &depths);
            let beyond = &whole[width..];
            assert!(beyond.iter().all(|covers| covers.to_bits() == 0), "stroke {index}: {beyond:?}");
            for (column, covers) in whole[..width].iter().enumerate() {
                let (x, own) = (first + column as i64, [f64::from(parts[column]), f64::from(depths[column])]);
                if is_below && columns.contains(&column) {
                    let exact = stroke.covers(shift, [x, y], own[0], own[1]);
                    assert!((f64::from(*covers) - exact).abs() < 2e-4, "stroke {index} at {x}, {y}: {covers}, {exact}");
                    covered += usize::from(*covers > 0.0);
                    continue;
                }
                let covers = (-1..3).map(|part| stroke.covers(shift, [x, y], f64::from(part), 5.0)).fold(0.0, f64::max);
                assert!(covers < 1e-6, "stroke {index} covers {covers} at {x}, {y}, outside of {columns:?}");
                assert!(columns.contains(&column) || whole[column].to_bits() == 0, "stroke {index} at {x}, {y}");
            }
            let bits = |row: &[f32]| row.iter().map(|covers| covers.to_bits()).collect::<Vec<_>>();
            for (number, before) in BEFORE.into_iter().enumerate() {
                // Windows that begin before the row, and such that begin within it.
                let skipped = (number * width / 5).min(width - 1);
                let pad = |row: &[f32], by: f32| [&vec![by; before as usize], &row[skipped..]].concat();
                let start = first + skipped as i64 - before;
                let shown = stroke.row(shift, y, 2 * number, start, &pad(&parts, -1.0), &pad(&depths, 1.0));
                let shown = &shown[before as usize..][..width - skipped];
                assert_eq!(bits(shown), bits(&whole[skipped..width]), "stroke {index}, row {y}");
            }
        }
    }
    assert!(covered > 5_000, "{covered} pixels covered");
}
