//! Tests of rays on height fields.

use crate::random::Draw;
use trochoid_image::Format;
use trochoid_scene::inside::first_of_grid;
use trochoid_scene::{Asked, Camera, DVec3, GridSurface, Projection, Ray, Sight, Surface};

fn grid() -> GridSurface {
    let heights = (0..7 * 9).map(|cell| 0.8 * (f64::from(cell) * 0.618).fract() as f32 - 0.4).collect();
    GridSurface::new(heights, 7, 0.5, [-1.0, 2.0], 0.3)
}

#[test]
fn rays_cross_where_tiny_steps_first_find_them_below() {
    let grid = grid();
    let (mut met, mut missed) = (0, 0);
    for case in 0..600 {
        let part = |by: f64| (f64::from(case) * by + 0.21).fract();
        let origin = DVec3::new(4.0 * part(0.618) - 1.5, 0.3 + 2.0 * part(0.414), 5.0 * part(0.732) + 1.5);
        let target = DVec3::new(3.0 * part(0.29) - 1.0, 0.6 * part(0.53) - 0.1, 4.0 * part(0.87) + 2.0);
        let direction = match case % 10 {
            0 => DVec3::NEG_Y,
            1 => DVec3::new(target.x - origin.x, target.y - origin.y, 0.0).normalize(),
            _ => (target - origin).normalize(),
        };
        let ray = Ray { origin, direction };
        let gap = |distance: f64| {
            let point = ray.at(distance);
            grid.height(point.x, point.z).map(|[height, ..]| point.y - 0.3 - height)
        };
        let (mut expected, mut last) = (None, None::<f64>);
        for step in 0..40_000 {
            let distance = f64::from(step) * 2e-4;
            let here = gap(distance);
            if let (Some(before), Some(here)) = (last, here)
                && (before > 0.0) != (here > 0.0)
            {
                expected = Some(distance);
                break;
            }
            last = here;
        }
        let found = first_of_grid(&grid, &ray, 7.9998);
        match (found, expected) {
            (Some(found), Some(expected)) => {
                assert!((found - expected).abs() < 3e-4, "ray {case}: {found} should be {expected}");
                let left = gap(found).unwrap_or(0.0).abs();
                assert!(left < 1e-12, "ray {case}: {left:e} off");
                met += 1;
            }
            (None, None) => missed += 1,
            // Steps miss what is thinner than they are long.
            (Some(found), None) => {
                assert!(gap(found).is_none_or(|gap| gap.abs() < 1e-12), "ray {case}: {found}");
            }
            (None, Some(expected)) => panic!("ray {case}: missed at {expected}"),
        }
    }
    assert!(met > 200 && missed > 50, "{met} met, {missed} missed");
}

#[test]
fn rays_cross_the_sheets_of_their_points_only_once() {
    let mut draw = Draw(5);
    let camera =
        Camera { position: DVec3::Y, target: DVec3::X, roll: 0.0, projection: Projection::Perspective { fov: 0.9 } };
    let projector = camera.projector(Format::new(16, 9, 1).expect("valid"));
    let (mut with, mut without) = (0, 0);
    for round in 0..4000 {
        let (columns, rows) = (6, 5);
        // Rough, or smooth and met at grazing angles.
        let rough = [1.0, 0.3, 0.05][round % 3];
        let heights = (0..columns * rows).map(|_| (rough * (draw.next() - 0.5)) as f32).collect();
        let grid = GridSurface::new(heights, columns, 0.5, [0.0, 0.0], 0.0);
        let origin = DVec3::new(3.0 * draw.next() - 0.3, 0.6 * rough * draw.next(), 2.4 * draw.next() - 0.3);
        let target = DVec3::new(2.5 * draw.next(), 0.8 * rough * (draw.next() - 0.5), 2.0 * draw.next());
        let ray = Ray { origin, direction: (target - origin).normalize() };
        let end = if round % 4 == 0 { 2.0 * draw.next() } else { f64::INFINITY };
        let Sight::Point(met) = grid.first(&projector, &ray, end, Asked::Values) else { continue };
        let Some(sheet) = met.sheet else {
            without += 1;
            continue;
        };
        with += 1;
        assert!(sheet.holds([met.hit.position.x, met.hit.position.z]) || !near_middle(&met.hit.position), "{round}");
        let mut sides = Vec::new();
        for step in 0..8000 {
            let point = ray.at(f64::from(step) * 5e-4);
            if let Some([height, ..]) = grid.height(point.x, point.z).filter(|_| sheet.holds([point.x, point.z])) {
                sides.push(point.y > height);
            }
        }
        let crossings = sides.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(crossings <= 1, "round {round}: {crossings} crossings");
    }
    assert!(with > 500 && without > 20, "{with} with a sheet, {without} without");
}

/// Returns whether a point does not lie on an edge of its cell.
fn near_middle(point: &DVec3) -> bool {
    [point.x, point.z].iter().all(|along| ((along / 0.5).fract() - 0.5).abs() < 0.499)
}
