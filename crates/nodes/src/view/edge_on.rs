//! Seas that a camera sees exactly from the side.

use super::{Camera, Projection, Render};
use trochoid_graph::{Check, Harmonic};

/// Sine of the angle up to which a direction counts as level, or as at right angles.
const EXACT: f64 = 1e-9;

/// Warns about seas that cover nothing: parallel, level rays run along their crests, and never meet the water from above.
pub(super) fn check_edge_on(render: &Render, check: &mut Check<'_>) {
    let Some(camera) = check.upstream(&render.camera) else { return };
    let Some(forward) = camera.node.get::<Camera>().and_then(level_forward) else { return };
    let is_along = |wave: &Harmonic| {
        let (sin, cos) = libm::sincos(wave.direction.to_radians());
        wave.amplitude == 0.0 || (cos * forward[0] + sin * forward[1]).abs() <= EXACT
    };
    let mut unseen = Vec::new();
    for source in render.surfaces.iter() {
        let Some(sea) = check.upstream(source) else { continue };
        let spectrum = sea.node.node().dynamics().and_then(|sea| sea.spectrum());
        if spectrum.is_some_and(|spectrum| spectrum.waves.iter().all(is_along)) {
            unseen.push(format!("\"{}\"", sea.name));
        }
    }
    if unseen.is_empty() {
        return;
    }
    let found = format!(
        "{}, along whose crests the parallel rays of the level camera \"{}\" run, so that nothing of it is seen",
        unseen.join(", "),
        camera.name
    );
    let remedy =
        "turn or tilt the camera; for a section of the sea, look straight down, and draw what lies below its height";
    check.warning(Render::SURFACES, found, "surfaces that the camera sees from above or below", remedy);
}

/// Returns the direction, x and z, of a camera whose rays are all level; `None` for other cameras.
fn level_forward(camera: &Camera) -> Option<[f64; 2]> {
    if camera.projection != Projection::Orthographic {
        return None;
    }
    let [x, y, z] = [0, 1, 2].map(|axis| camera.target[axis] - camera.position[axis]);
    let long = libm::hypot(libm::hypot(x, y), z);
    // A camera at its target looks along −Z.
    let [x, y, z] = if long > 0.0 { [x / long, y / long, z / long] } else { [0.0, 0.0, -1.0] };
    (y.abs() <= EXACT).then_some([x, z])
}
