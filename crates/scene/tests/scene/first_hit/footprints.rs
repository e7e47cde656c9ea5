//! Tests of the footprints over a sea, ahead of a camera.

use std::f64::consts::TAU;
use trochoid_image::Format;
use trochoid_scene::inside::first_hit::SeaFootprints;
use trochoid_scene::inside::{footprint_of, heading};
use trochoid_scene::{Camera, DVec3, Projection, SeaSurface};
use trochoid_sea::Sea;

#[test]
fn squares_are_those_of_the_sea_and_change_as_said() {
    let mut compared = 0;
    for case in 0..400 {
        let part = |by: f64| (f64::from(case) * by + 0.1).fract();
        let height = [0.0, 1e-3, 6.0, 400.0][case as usize % 4];
        let position = DVec3::new(5.0, 1.0 + height * (part(0.37) - 0.5).signum(), -3.0);
        let (sin, cos) = libm::sincos(TAU * part(0.618));
        let ahead = DVec3::new(cos, 3.0 * (part(0.414) - 0.5) * part(0.83), sin);
        let projection = match case % 5 {
            0 => Projection::Orthographic { height: 20.0 },
            _ => Projection::Perspective { fov: 0.2 + 2.0 * part(0.29) },
        };
        let camera = Camera { position, target: position + ahead, roll: part(0.53), projection };
        let projector = camera.projector(Format::new(64, 36, 1).expect("valid"));
        let sea = SeaSurface::new(&Sea::new(Vec::new()), 0.0, 1.0).with_detail(0.7);
        let footprints = SeaFootprints::new(&sea, &projector);
        let [x, z] = heading(&projector);
        let kinks = footprints.kinks();
        for place in 0..40 {
            let u = (f64::from(place) - 12.0) * 3.0 * (1.0 + height);
            let rest = DVec3::new(position.x + u * x - 2.0 * z, 1.0, position.z + u * z + 2.0 * x);
            let print = footprint_of(&sea, &projector, rest);
            let square = footprints.square(u);
            assert!((square - print * print).abs() <= 1e-9 * print * print + 1e-12, "{case} at {u}: {square} {print}");
            if kinks.contains(&u) {
                continue;
            }
            let (own, change) = footprints.change(u);
            assert!(
                (own - print).abs() <= 1e-9 * print + 1e-12
                    && 2.0 * change.abs() <= own * footprints.linear(u) * (1.0 + 1e-9),
                "{case} at {u}"
            );
            let free = kinks.iter().map(|kink| (kink - u).abs()).fold(f64::INFINITY, f64::min).min(10.0);
            for share in [-0.9, -0.4, 0.3, 0.9] {
                let there = footprints.square(u + share * free);
                // The constant coefficient of m is 1.
                let most = square * (footprints.growth(u, share.abs() * free) - 1.0);
                assert!((there - square).abs() <= most * (1.0 + 1e-9) + 1e-9 * square, "{case} at {u} by {share}");
                compared += 1;
            }
            let step = 1e-4 * free.max(1e-6);
            let slope = (footprints.square(u + step) - footprints.square(u - step)) / (2.0 * step);
            // f² changes by 2f·f′.
            assert!((slope - 2.0 * own * change).abs() <= 1e-3 * slope.abs() + 1e-6 * square, "{case} at {u}");
            assert!(slope.abs() <= square * footprints.linear(u) * (1.0 + 1e-3) + 1e-6 * square, "{case} at {u}");
        }
    }
    assert!(compared > 10_000);
}
