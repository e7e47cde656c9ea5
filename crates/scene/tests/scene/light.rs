//! Tests of lights.

use trochoid_scene::{DVec3, Illumination, Light};

#[test]
fn spot_is_full_inside_and_dark_outside() {
    let spot = Light::Spot { position: DVec3::Y * 10.0, target: DVec3::ZERO, angle: 0.5, soft: 0.1 };
    assert_eq!(spot.illuminate(DVec3::ZERO), Illumination { direction: DVec3::Y, intensity: 1.0 });
    assert_eq!(spot.illuminate(DVec3::X * 50.0).intensity, 0.0);
    let edge = spot.illuminate(DVec3::X * 10.0 * f64::tan(0.45)).intensity;
    assert!((edge - 0.5).abs() < 1e-9, "{edge}");
    let hard = Light::Spot { position: DVec3::Y, target: DVec3::ZERO, angle: 0.0, soft: 0.0 };
    assert_eq!(hard.illuminate(DVec3::ZERO).intensity, 1.0);
}

#[test]
fn degenerate_directions_point_up() {
    assert_eq!(Light::Directional { direction: DVec3::ZERO }.illuminate(DVec3::ONE).direction, DVec3::Y);
    assert_eq!(Light::Point { position: DVec3::ONE }.illuminate(DVec3::ONE).direction, DVec3::Y);
}
