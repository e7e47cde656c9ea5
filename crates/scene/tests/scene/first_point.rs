//! Tests of the search for the first point of a sea on a ray.

use std::f64::consts::TAU;
use trochoid_image::Format;
use trochoid_scene::inside::{carried, first_point};
use trochoid_scene::{Camera, DVec3, GivenUp, Projection, Ray, SeaSurface};
use trochoid_sea::{ExplicitWave, Sea, Wave};

/// Returns where the ray first crosses the line through points of a curve, in the plane of the ray.
fn first_of_line(points: impl Iterator<Item = [f64; 2]>, origin: [f64; 2], direction: [f64; 2]) -> Option<f64> {
    let side = |[x, y]: [f64; 2]| (x - origin[0]) * direction[1] - (y - origin[1]) * direction[0];
    let along = |[x, y]: [f64; 2]| (x - origin[0]) * direction[0] + (y - origin[1]) * direction[1];
    let mut last: Option<[f64; 2]> = None;
    let mut first = None::<f64>;
    for point in points {
        if let Some(last) = last.filter(|last| (side(*last) > 0.0) != (side(point) > 0.0)) {
            let part = side(last) / (side(last) - side(point));
            let distance = along(last) + part * (along(point) - along(last));
            if distance >= 0.0 && first.is_none_or(|first| distance < first) {
                first = Some(distance);
            }
        }
        last = Some(point);
    }
    first
}

#[test]
fn seas_too_rough_to_search_are_given_up() {
    let wave = |direction: f64| {
        let wave =
            ExplicitWave { wavelength: 5.0, amplitude: 1e3, direction, sharpness: 1e3, phase: direction, speed: None };
        Wave::try_from(wave).expect("valid")
    };
    let surface = SeaSurface::new(&Sea::new([0.0, 0.7, 2.0].map(wave).to_vec()), 0.0, 0.0);
    let camera = Camera {
        position: DVec3::new(0.0, 3.0, 0.0),
        target: DVec3::new(1.0, 3.0, 0.0),
        roll: 0.0,
        projection: Projection::Perspective { fov: 0.5 },
    };
    let projector = camera.projector(Format::new(64, 64, 1).expect("valid"));
    let ray = Ray { origin: camera.position, direction: DVec3::new(0.8, 0.0, 0.6) };
    assert_eq!(first_point(&surface, &projector, &ray, [0.0, 1e5]), Err(GivenUp));
}

#[test]
fn rays_meet_the_first_sheet_of_folds() {
    let (length, amplitude, horizontal) = (8.0, 1.0, 2.2);
    let wave = ExplicitWave {
        wavelength: length,
        amplitude,
        direction: 0.0,
        sharpness: horizontal * TAU / length,
        phase: 0.0,
        speed: None,
    };
    let wave = Wave::try_from(wave).expect("valid");
    assert!((wave.horizontal - horizontal).abs() < 1e-12 && horizontal * TAU / length > 1.5, "it folds");
    let surface = SeaSurface::new(&Sea::new(vec![wave]), 0.0, 0.0);
    let camera = Camera {
        position: DVec3::new(0.0, 0.0, 1.0),
        target: DVec3::ZERO,
        roll: 0.0,
        // So fine that the footprint filters nothing.
        projection: Projection::Orthographic { height: 1e-3 },
    };
    let projector = camera.projector(Format::new(64, 64, 1).expect("valid"));
    let (mut met, mut overhung) = (0, 0);
    for case in 0..400 {
        let part = |of: f64| (f64::from(case) * of).fract();
        let (x, y, turn) = (16.0 * part(0.618) - 8.0, 3.0 * part(0.414) - 1.5, TAU * part(0.732));
        let (sin, cos) = libm::sincos(turn);
        let ray = Ray { origin: DVec3::new(x, y, 3.0), direction: DVec3::new(cos, sin, 0.0) };
        let points = (-30_000..=30_000).map(|step| {
            let rest = f64::from(step) * 1e-3;
            let sample = surface.frame().evaluate([rest, 0.0], 0.0);
            [rest + sample.displacement[0], sample.displacement[1]]
        });
        let expected = first_of_line(points, [x, y], [cos, sin]).filter(|distance| *distance < 20.0);
        let found = first_point(&surface, &projector, &ray, [0.0, 20.0]).expect("it is smooth");
        let (Some((distance, rest)), Some(expected)) = (found, expected) else {
            assert_eq!(found.map(|found| found.0), expected, "ray {case}");
            continue;
        };
        assert!((distance - expected).abs() < 1e-4, "ray {case}: {distance} should be {expected}");
        let (point, sample) = carried(&surface, &projector, rest);
        assert!((point.truncate() - ray.at(distance).truncate()).length() < 1e-10, "ray {case}");
        met += 1;
        overhung += usize::from(sample.jacobian() < 0.0);
    }
    assert!(met > 200 && overhung > 20, "{met} rays meet it, {overhung} an overhang");
}
