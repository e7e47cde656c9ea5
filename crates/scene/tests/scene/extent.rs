//! Tests of the parts of seas that cameras may see.

use trochoid_image::Format;
use trochoid_scene::inside::{HORIZON_M, sector};
use trochoid_scene::{Camera, DVec3, Projection, Projector};

fn projector(position: DVec3, target: DVec3) -> Projector {
    let projection = Projection::Perspective { fov: 0.7 };
    Camera { position, target, roll: 0.0, projection }.projector(Format::new(160, 90, 1).expect("valid"))
}

#[test]
fn the_sky_holds_no_sea() {
    let up = projector(DVec3::new(0.0, 6.0, 0.0), DVec3::new(0.0, 26.0, -20.0));
    assert_eq!(sector(&up, 0.0, 2.0, 2.0), None);
    // From within the waves, the same view may contain a crest that towers nearby.
    let inside = projector(DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, 21.0, -20.0));
    assert!(sector(&inside, 0.0, 2.0, 2.0).is_some());
}

#[test]
fn looking_down_takes_the_full_circle_but_not_the_horizon() {
    let down = projector(DVec3::new(0.0, 50.0, 0.0), DVec3::ZERO);
    let sector = sector(&down, 0.0, 1.0, 1.0).expect("sea");
    assert!(sector.closed && sector.radii[0] == 0.0 && sector.radii[1] < 50.0);
}

#[test]
fn the_wedge_holds_the_frustum() {
    let ahead = projector(DVec3::new(3.0, 6.0, 30.0), DVec3::new(0.0, 2.0, 0.0));
    let sector = sector(&ahead, 0.0, 2.0, 3.0).expect("sea");
    assert!(!sector.closed && sector.width > 0.7 && sector.width < 0.85);
    assert_eq!(sector.radii[1], HORIZON_M);
}
