//! Tests of footprints.

use trochoid_image::Format;
use trochoid_scene::inside::{heading, least_footprint};
use trochoid_scene::{Camera, DVec3, Projection, footprint};

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
