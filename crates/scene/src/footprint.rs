use glam::DVec3;

use crate::Projector;

/// Height over planar depth below which a pixel's patch on the sea is not stretched any further.
///
/// At grazing angles the rest plane is no measure of what a pixel sees: it sees the faces of waves, which
/// stand steeper than this.
pub const GRAZING: f64 = 0.02;

/// Least planar depth over the distance ahead and down: what lies further aside or behind is hardly seen.
const LEAST_DEPTH: f64 = 0.25;

/// Footprint in meters of a pixel that sees a rest point: the side of the square with the area of the pixel's patch
/// on the rest plane, d·s / √max(h/d, [`GRAZING`]) for planar depth d, height h of the camera over the plane, and the
/// size s of a pixel at depth 1.
///
/// That is exact: a patch of solid angle s²·cos³ψ at distance d/cos ψ, seen under a sine of h·cos ψ/d, has the area
/// s²·d³/h. It is the same all along a line across the view.
pub fn footprint(projector: &Projector, rest: DVec3) -> f64 {
    let (width, slant) = patch(projector, rest);
    width / libm::sqrt(slant)
}

/// The patch itself: vectors x, z in meters to what the next pixel across the view sees, and the next one upward.
///
/// [`footprint`] is the square root of its area.
pub fn footprint_axes(projector: &Projector, rest: DVec3) -> [[f64; 2]; 2] {
    let (width, slant) = patch(projector, rest);
    let [x, z] = projector.heading();
    [[-z * width, x * width], [x * width / slant, z * width / slant]]
}

/// Width of the patch in meters, and the sine under which it is seen.
fn patch(projector: &Projector, rest: DVec3) -> (f64, f64) {
    let offset = rest - projector.position;
    let (height, forward) = (offset.y.abs(), projector.forward);
    if projector.orthographic {
        return (projector.pixel_size(1.0), forward.y.abs().max(GRAZING));
    }
    let [x, z] = projector.heading();
    let along = offset.x * x + offset.z * z;
    let depth = along * (forward.x * x + forward.z * z) + offset.y * forward.y;
    let depth = depth.max(LEAST_DEPTH * libm::sqrt(along * along + height * height));
    if depth == 0.0 {
        return (0.0, 1.0);
    }
    (projector.pixel_size(depth), (height / depth).max(GRAZING))
}
