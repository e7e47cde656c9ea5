//! Tests of Thickness.

use crate::testing::refused;
use trochoid_nodes::inside::refracted;
use trochoid_scene::DVec3;

#[test]
fn refracts_as_snell_says() {
    for angle in [0.0f64, 0.3, 1.0, 1.57] {
        let bent = refracted(DVec3::new(angle.sin(), -angle.cos(), 0.0), DVec3::Y, 1.333);
        assert!((bent.x - angle.sin() / 1.333).abs() < 1e-12 && bent.y < 0.0, "{bent}");
        assert!((bent.length() - 1.0).abs() < 1e-12);
    }
    let straight = DVec3::new(0.6, -0.8, 0.0);
    assert!((refracted(straight, DVec3::Y, 1.0) - straight).length() < 1e-12);
}

#[test]
fn needs_a_light_to_go_toward() {
    let faults = refused(
        "field",
        r#""camera": { "type": "Camera" }, "sea": { "type": "GerstnerSea", "count": 0 },
           "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
           "out": { "type": "Thickness", "view": "view" }"#,
    );
    assert!(faults.contains("connect \\\"light\\\""), "{faults}");
}
