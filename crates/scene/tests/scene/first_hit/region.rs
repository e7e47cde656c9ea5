//! Tests of the part of the world that cells have to hold.

use trochoid_image::Format;
use trochoid_scene::inside::first_hit::SeenRegion;
use trochoid_scene::inside::summit;
use trochoid_scene::{Camera, DVec3, Projection, SeaSurface};
use trochoid_sea::{GerstnerSpectrum, Sea};

#[test]
fn every_point_of_the_slab_in_the_picture_is_in_the_region() {
    let waves = GerstnerSpectrum { count: 20, height: 2.0, ..GerstnerSpectrum::default() }.waves().expect("waves");
    let sea = SeaSurface::new(&Sea::new(waves), 0.0, 0.5);
    let mut held = 0;
    for case in 0..200 {
        let part = |by: f64| (f64::from(case) * by + 0.07).fract();
        let position = DVec3::new(3.0, 0.5 + 20.0 * (part(0.37) - 0.3), 8.0);
        let ahead = DVec3::new(part(0.11) - 0.5, 2.0 * (part(0.52) - 0.7), part(0.91) - 0.5);
        let projection = match case % 4 {
            0 => Projection::Orthographic { height: 30.0 },
            _ => Projection::Perspective { fov: 0.1 + 2.4 * part(0.23) },
        };
        let camera = Camera { position, target: position + ahead, roll: 3.0 * part(0.71), projection };
        let projector = camera.projector(Format::new(40, 30, 1).expect("valid"));
        let region = SeenRegion::new(&sea, &projector);
        let along = region.along();
        for pixel in 0..300 {
            let at = |by: f64, size: f64| (f64::from(pixel) * by).fract() * size;
            let ray = projector.ray(at(0.618, 40.0), at(0.414, 30.0));
            let (a, b) = (
                (0.5 - summit(&sea) - ray.origin.y) / ray.direction.y,
                (0.5 + summit(&sea) - ray.origin.y) / ray.direction.y,
            );
            let (near, far) = (a.min(b).max(0.0), a.max(b));
            if !(near < far && far < 1e5) {
                continue;
            }
            let point = region.point(ray.at(near + (far - near) * (f64::from(pixel) * 0.732).fract()));
            let [low, high] = along.expect("something is seen");
            assert!(low <= point.x && point.x <= high, "case {case}: {point} in {low}…{high}");
            let [left, right] = region.across([point.x - 0.1, point.x + 0.1]).expect("something is seen");
            assert!(left <= point.z && point.z <= right, "case {case}: {point} in {left}…{right}");
            assert!(!region.misses([point - 0.1, point + 0.1]));
            assert!(region.holds(&ray, [near, far]), "case {case}");
            held += 1;
        }
    }
    assert!(held > 5000, "{held}");
}
