//! Tests of first points of seas by cells.

mod bernstein;
mod footprints;
mod region;
mod remainder;
mod squares;

use std::f64::consts::TAU;
use trochoid_image::Format;
use trochoid_scene::inside::first_hit::{Cells, First, FirstPoint, Thoroughness};
use trochoid_scene::inside::{carried, first_point, roughness, summit};
use trochoid_scene::{Camera, DVec3, Projection, Projector, Ray, SeaSurface};
use trochoid_sea::{ExplicitWave, GerstnerSpectrum, Sea, Wave};

fn part(case: u32, by: f64) -> f64 {
    (f64::from(case) * by + 0.137).fract()
}

/// Seas of many kinds: calm, steep, folded, far from the origin, late, of one wave and of many.
fn seas() -> Vec<SeaSurface> {
    let spectrum = |count: usize, height: f64, sharpness: f64, time: f64| {
        let options = GerstnerSpectrum {
            count,
            height,
            sharpness,
            wavelength: 5.0,
            spread: 0.8,
            direction_spread: 0.6,
            ..GerstnerSpectrum::default()
        };
        SeaSurface::new(&Sea::new(options.waves().expect("waves")), time, 0.4)
    };
    let fold =
        ExplicitWave { wavelength: 8.0, amplitude: 1.0, direction: 0.3, sharpness: 1.7, phase: 0.5, speed: None };
    let fold = SeaSurface::new(&Sea::new(vec![Wave::try_from(fold).expect("valid")]), 2.0, 0.4);
    vec![
        spectrum(12, 0.5, 0.7, 1.0),
        spectrum(40, 2.5, 1.0, 40.0),
        spectrum(9, 3.0, 1.6, 1e5),
        fold,
        SeaSurface::new(&Sea::new(Vec::new()), 0.0, 0.4),
    ]
}

fn projector(case: u32, middle: [f64; 2]) -> Projector {
    let height = [5.0, 1.5, 40.0, 0.8][case as usize % 4];
    let position = DVec3::new(middle[0] + 7.0 * part(case, 0.618), 0.4 + height, middle[1]);
    let (sin, cos) = libm::sincos(TAU * part(case, 0.31));
    let down = [0.15, 0.02, 1.2, 0.0][(case as usize / 2) % 4];
    let projection = match case % 7 {
        5 => Projection::Orthographic { height: 12.0 },
        _ => Projection::Perspective { fov: 0.2 + 1.2 * part(case, 0.41) },
    };
    let target = position + DVec3::new(cos, -down, sin);
    let camera = Camera { position, target, roll: 0.4 * part(case, 0.77), projection };
    camera.projector(Format::new(48, 27, 1).expect("valid"))
}

/// Returns the stretch of a ray within the slab of heights that a sea reaches, if it is not too long to search.
fn stretch(sea: &SeaSurface, ray: &Ray) -> Option<[f64; 2]> {
    let (height, slope) = (ray.origin.y - sea.level(), ray.direction.y);
    let (a, b) = ((-summit(sea) - height) / slope, (summit(sea) - height) / slope);
    let (start, end) = (a.min(b).max(0.0), a.max(b));
    (start <= end && end < 300.0).then_some([start, end])
}

#[test]
fn cells_are_as_close_to_the_sea_as_they_say() {
    let (mut worst, mut looked_at, mut close) = (0.0_f64, 0, 0);
    for (index, sea) in seas().iter().enumerate() {
        for case in 0..6 {
            let projector = projector(case + 3 * index as u32, [[0.0, 0.0], [1e6, -3e5]][case as usize % 2]);
            let Some(cells) = Cells::new(sea, &projector) else { continue };
            for pick in 0..200 {
                let cell = (part(pick, 0.618) * cells.count() as f64) as usize;
                let at = [part(pick, 0.414), part(pick, 0.732)];
                let (patch, (most_off, turn)) = (cells.patch(cell, at), cells.remainder(cell));
                let rest = cells.rest(cell, at);
                let truth = cells.point(carried(sea, &projector, rest).0);
                for axis in 0..3 {
                    let (value, slopes) = patch[axis];
                    let off = (value - truth[axis]).abs();
                    let bound = most_off[axis];
                    // Rest points far from the origin are rounded.
                    let rounding = 4.0 * f64::EPSILON * (rest[0].abs() + rest[1].abs());
                    assert!(
                        off <= bound + rounding,
                        "sea {index}, camera {case}, axis {axis}: {off:e} above {bound:e}"
                    );
                    worst = worst.max(off / (bound + rounding));
                    let step = 1e-5;
                    let there = |by: [f64; 2]| {
                        let rest = cells.rest(cell, [at[0] + by[0], at[1] + by[1]]);
                        cells.point(carried(sea, &projector, rest).0)[axis]
                    };
                    for (side, own) in slopes.iter().enumerate() {
                        let by = [0, 1].map(|other| if side == other { step } else { 0.0 });
                        let slope = (there(by) - there(by.map(|by| -by))) / (2.0 * step);
                        // By −1…1, half as much as by 0…1. The difference quotient loses digits, above all those by which
                        // rest points far from the origin are rounded.
                        let placed = 0.5 * f64::EPSILON * rest[0].abs().max(rest[1].abs()) / step;
                        let loss = 1e-9 * (1.0 + truth.abs().max_element())
                            + 1e-4 * cells.half(cell) * cells.half(cell)
                            + placed;
                        let off = 0.5 * (own - slope).abs();
                        let turn_here = cells.turn_at(cell, 2.0 * at[side] - 1.0);
                        assert!(turn_here <= turn, "{turn_here:e} {turn:e}");
                        assert!(off <= turn_here + loss, "sea {index}, camera {case}: {off:e}");
                    }
                    looked_at += 1;
                    close += usize::from(off > 1e-3 * bound);
                }
            }
        }
    }
    assert!(looked_at > 5000 && close > 500, "{looked_at} looked at, {close} of them near their bounds");
    assert!(worst < 1.0);
}

/// Returns how far the normal, the Jacobian or the roughness of a point are from another one's.
fn differs(one: &FirstPoint, other: &FirstPoint) -> f64 {
    let [a, b] = [one, other].map(|point| point.shape.expect("asked"));
    let turned = (a.normal.normalize() - b.normal.normalize()).length();
    turned.max((a.normal.y - b.normal.y).abs()).max((a.slope_variance - b.slope_variance).abs())
}

#[test]
fn roughness_is_known_from_the_table_as_well_as_said() {
    let (mut compared, mut closest) = (0, 0.0_f64);
    for sea in &seas()[..4] {
        for case in 0..2000 {
            let footprint = libm::exp(25.0 * part(case, 0.618) - 7.5);
            let truth = sea.frame().evaluate([3.0, -4.0], footprint).slope_variance;
            let Some((found, off)) = roughness(sea, footprint) else {
                assert!(!(1e-3..=6e7).contains(&footprint), "{footprint}");
                continue;
            };
            assert!((found - truth).abs() <= off + 1e-13, "{found} {truth} {off:e} at {footprint}");
            closest = closest.max((found - truth).abs() / off);
            compared += 1;
        }
    }
    assert!(compared > 7000 && closest > 0.3, "{compared}, {closest}");
}

#[test]
fn rays_meet_the_same_points_as_by_the_search_of_each_ray() {
    let (mut met, mut missed, mut unknown, mut overhung, mut alone) = (0, 0, 0, 0, 0);
    let (mut quickly, mut roughly, mut turned_most) = (0, 0, 0.0_f64);
    let (mut nearly, mut by_cells, mut closest) = (0, 0, 0.0_f64);
    for (index, sea) in seas().iter().enumerate() {
        for case in 0..6 {
            let projector = projector(case + 5 * index as u32, [[0.0, 0.0], [2e3, -1e3]][case as usize % 2]);
            let Some(cells) = Cells::new(sea, &projector) else { continue };
            for pick in 0..40 {
                let ray = projector.ray(48.0 * part(pick, 0.618), 27.0 * part(pick, 0.414));
                let Some([start, end]) = stretch(sea, &ray) else { continue };
                let Ok(expected) = first_point(sea, &projector, &ray, [start, end]) else { continue };
                let found = cells.first(sea, &projector, &ray, [start, end], Thoroughness::Thorough);
                match (found, expected) {
                    (First::At(FirstPoint { distance, rest, sheet, .. }), Some((truth, _))) => {
                        let apart = (distance - truth).abs();
                        assert!(
                            apart <= 1e-9 * (1.0 + truth),
                            "sea {index}, camera {case}, ray {pick}: {distance} {truth}"
                        );
                        assert!(sheet.is_none_or(|sheet| sheet.holds(rest)), "{sheet:?} without {rest:?}");
                        alone += usize::from(sheet.is_some());
                        overhung += usize::from(carried(sea, &projector, rest).1.jacobian() < 0.0);
                        met += 1;
                    }
                    (First::Nothing, None) => missed += 1,
                    (First::Unknown, _) => unknown += 1,
                    other => panic!("sea {index}, camera {case}, ray {pick}: {other:?}"),
                }
                let find = |effort| cells.first(sea, &projector, &ray, [start, end], effort);
                let First::At(truth) = found else {
                    for effort in [Thoroughness::Rough, Thoroughness::Near, Thoroughness::Quick] {
                        assert!(!matches!(find(effort), First::At(_)), "sea {index}, camera {case}, ray {pick}");
                    }
                    continue;
                };
                if let First::At(quick) = find(Thoroughness::Quick) {
                    let apart = (quick.distance - truth.distance).abs();
                    assert!(
                        apart <= 1e-9 * (1.0 + truth.distance),
                        "sea {index}, camera {case}, ray {pick}: {apart:e}"
                    );
                    let apart = differs(&quick, &truth);
                    assert!(apart <= quick.off + 1e-9, "{apart:e} above {:e}", quick.off);
                    quickly += 1;
                    turned_most = turned_most.max(quick.off);
                }
                if let First::At(near) = find(Thoroughness::Near) {
                    let say = || format!("sea {index}, camera {case}, ray {pick}: {near:?} {truth:?}");
                    let apart = (near.distance - truth.distance).abs();
                    let moved = libm::hypot(near.rest[0] - truth.rest[0], near.rest[1] - truth.rest[1]);
                    let slack = 1e-9 * (1.0 + truth.distance);
                    assert!(apart <= near.deep + slack && moved <= near.moved + slack, "{}", say());
                    assert!(near.off <= 1e-3 && near.deep + near.moved <= near.off, "{}", say());
                    assert!(differs(&near, &truth) <= near.off + 1e-9, "{:e}: {}", differs(&near, &truth), say());
                    assert!(near.sheet.is_none_or(|sheet| sheet.holds(truth.rest)), "{}", say());
                    nearly += 1;
                    by_cells += usize::from(near.deep > 0.0);
                    closest = closest.max(differs(&near, &truth) / near.off);
                }
                if let First::At(rough) = find(Thoroughness::Rough) {
                    let apart = (rough.distance - truth.distance).abs();
                    assert!(apart <= rough.deep + 1e-9 * (1.0 + truth.distance), "{apart:e} above {:e}", rough.deep);
                    assert!(rough.sheet.is_none_or(|sheet| sheet.holds(truth.rest)), "{rough:?} is on another sheet");
                    roughly += usize::from(rough.shape.is_none());
                }
            }
        }
    }
    assert!(met > 300 && missed > 10 && overhung > 0, "{met} meet it, {missed} miss it, {overhung} meet an overhang");
    assert!(50 * unknown < met, "{unknown} unknown");
    assert!(20 * (met - alone) < met, "{alone} of {met} on a known sheet");
    assert!(10 * quickly > 9 * met && 10 * roughly > 8 * met, "{quickly} of {met} quickly, {roughly} roughly");
    assert!(0.0 < turned_most && turned_most < 2e-4, "{turned_most:e}");
    assert!(10 * nearly > 9 * met && 2 * by_cells > met, "{nearly} of {met} nearly, {by_cells} by cells alone");
    assert!(closest > 0.01, "the nearest is at {closest} of its bound");
}

#[test]
fn cells_far_from_the_origin_are_as_large_as_rounding_lets_them_be() {
    let sea = &seas()[0];
    let count = |middle: [f64; 2]| Cells::new(sea, &projector(0, middle)).map(|cells| cells.count());
    let (near, far) = (count([0.0, 0.0]).expect("something is seen"), count([1e8, 0.0]).expect("something is seen"));
    assert!(2 * far < 3 * near, "{near} cells near the origin, {far} far from it");
}

#[test]
fn squares_without_their_middles_in_sight_are_kept_where_waves_carry_them_into_it() {
    let mut held = 0;
    for (index, sea) in seas().iter().enumerate().take(4) {
        for case in 0..6 {
            let projector = projector(case + 5 * index as u32, [0.0, 0.0]);
            let Some(cells) = Cells::new(sea, &projector) else { continue };
            for pick in 0..2000 {
                // A point of the sea that the region holds lies in a cell.
                let far = 60.0 * part(pick, 0.31);
                let [x, z] = [far * (part(pick, 0.618) - 0.5), far * (part(pick, 0.414) - 0.5)];
                let rest = [projector.position.x + x, projector.position.z + z];
                let point = cells.point(carried(sea, &projector, rest).0);
                if cells.misses(point) {
                    continue;
                }
                let own = cells.point(DVec3::new(rest[0], sea.level(), rest[1]));
                let is_in = |cell: usize| {
                    let [s, t] = cells.place(cell, own);
                    s.clamp(-1e-9, 1.0 + 1e-9) == s && t.clamp(-1e-9, 1.0 + 1e-9) == t
                };
                assert!((0..cells.count()).any(is_in), "sea {index}, camera {case}: {rest:?} is seen at {point}");
                held += 1;
            }
        }
    }
    assert!(held > 3000, "{held}");
}
