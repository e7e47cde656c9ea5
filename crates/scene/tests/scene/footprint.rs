//! Tests of footprints.

use trochoid_image::Format;
use trochoid_scene::inside::{heading, least_footprint};
use trochoid_scene::{Camera, DVec3, Projection, footprint, footprints_seen};

#[test]
fn no_footprint_is_less_than_the_least() {
    let format = Format::new(320, 180, 1).expect("valid");
    let part = |case: i32, of: f64| (f64::from(case) * of).fract();
    let mut close = 0;
    for case in 1..2000 {
        let camera = Camera {
            position: DVec3::new(3.0, 40.0 * part(case, 0.618) - 10.0, -2.0),
            target: DVec3::new(50.0 * part(case, 0.414) - 25.0, 0.0, 50.0 * part(case, 0.732) - 25.0),
            roll: 6.0 * part(case, 0.236),
            projection: Projection::Perspective { fov: 0.9 },
        };
        let projector = camera.projector(format);
        let from = 60.0 * part(case, 0.303) - 40.0;
        let ends = [from, from + 30.0 * part(case, 0.817) * part(case, 0.551)];
        let [x, z] = heading(&projector);
        let at = |step: u32| {
            let along = ends[0] + (ends[1] - ends[0]) * f64::from(step) / 200.0;
            footprint(&projector, projector.position.with_y(1.0) + along * DVec3::new(x, 0.0, z))
        };
        let found = (0..=200).map(at).fold(f64::INFINITY, f64::min);
        let least = least_footprint(&projector, 1.0, ends);
        assert!(least <= found * (1.0 + 1e-12), "{least} of {camera:?} at {ends:?}, where one is {found}");
        close += usize::from(least >= 0.9 * found);
    }
    assert!(close > 1800, "{close} of them are close");
}

#[test]
fn footprints_seen_have_the_bits_of_those_of_points() {
    let format = Format::new(320, 180, 1).expect("valid");
    let part = |case: usize, of: f64| (case as f64 * of).fract();
    let hostile = [0.0, -0.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e-45, f32::MAX, -3.0];
    for case in 0..300 {
        let perspective = Projection::Perspective { fov: 0.1 + 2.5 * part(case, 0.123) };
        let camera = Camera {
            position: DVec3::new(3.0, 40.0 * part(case, 0.618) - 10.0, -2.0),
            target: match case % 10 {
                0 => DVec3::new(3.0, -100.0, -2.0),
                _ => DVec3::new(50.0 * part(case, 0.414) - 25.0, 0.0, 50.0 * part(case, 0.732) - 25.0),
            },
            roll: 6.0 * part(case, 0.236),
            projection: if case % 7 == 0 { Projection::Orthographic { height: 12.0 } } else { perspective },
        };
        let projector = camera.projector(format);
        let count = 1 + case % 41;
        let places: Vec<[f64; 2]> =
            (0..count).map(|i| [320.0 * part(case + i, 0.303), 180.0 * part(case * i, 0.817)]).collect();
        let usual = |i: usize| (1e3 * part(case + i, 0.551).powi(3)) as f32;
        let depths: Vec<f32> =
            (0..count).map(|i| if i % 5 == 3 { hostile[(i + case) % hostile.len()] } else { usual(i) }).collect();
        let mut found = vec![f32::NAN; count];
        footprints_seen(&projector, &places, &depths, &mut found);
        for (([x, y], depth), found) in places.into_iter().zip(depths).zip(found) {
            let ray = projector.ray(x, y);
            let distance = f64::from(depth) / ray.direction.dot(projector.forward);
            let truth = if depth.is_finite() { footprint(&projector, ray.at(distance)) as f32 } else { 0.0 };
            assert_eq!(found.to_bits(), truth.to_bits(), "{camera:?} at {x}, {y}, {depth}: {found}, expected {truth}");
        }
    }
}
