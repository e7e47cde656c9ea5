use glam::DVec3;

use crate::Projector;

/// Sine of the grazing angle below which a pixel's patch on the sea is not stretched any further.
///
/// At grazing angles the rest plane is no measure of what a pixel sees: it sees the faces of waves, which
/// stand steeper than this.
pub const GRAZING: f64 = 0.02;

/// Footprint in meters of a pixel that sees a rest point: the side of the square with the area of the pixel's patch
/// on the rest plane, d·α / √max(sin γ, [`GRAZING`]) for distance d, angle α of a pixel and grazing angle γ.
pub fn footprint(projector: &Projector, rest: DVec3) -> f64 {
    let offset = rest - projector.position;
    let distance = offset.length();
    let sine = if projector.orthographic {
        projector.forward.y.abs()
    } else if distance > 0.0 {
        offset.y.abs() / distance
    } else {
        1.0
    };
    projector.pixel_size(distance) / libm::sqrt(sine.max(GRAZING))
}
