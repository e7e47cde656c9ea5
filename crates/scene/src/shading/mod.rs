//! Quantities that lights and view directions give at a shading point; colors are the back end's business.
//!
//! Each has a `reference` in f64, one point, straight from the formula, and a `fill` in f32 over slices. Vectors of
//! `fill` are three slices, one for each axis, and all slices of a call are of one length.

pub mod blinn;
pub mod fresnel;
pub mod lambert;

use glam::DVec3;

/// Three slices of one length: the x, y and z of many vectors.
pub type Vectors<'a> = [&'a [f32]; 3];

/// The unit vector along `vector`; (0, 1, 0) where it is zero or not finite.
pub fn unit_or_up(vector: DVec3) -> DVec3 {
    vector.try_normalize().unwrap_or(DVec3::Y)
}

/// One of many vectors in f32, as it is.
#[inline]
pub(crate) fn pick(vectors: Vectors<'_>, index: usize) -> glam::Vec3 {
    glam::Vec3::new(vectors[0][index], vectors[1][index], vectors[2][index])
}

/// f32 form of [`unit_or_up`].
#[inline]
pub(crate) fn unit_or_up_f32(vector: glam::Vec3) -> glam::Vec3 {
    vector.try_normalize().unwrap_or(glam::Vec3::Y)
}

/// Unit vectors from points to the camera at `eye`, or against `forward` where rays are parallel, written to `out`.
pub fn view_directions(positions: Vectors<'_>, projector: &crate::Projector, out: [&mut [f32]; 3]) {
    let [x, y, z] = out;
    for index in 0..x.len() {
        let view = if projector.orthographic {
            -projector.forward
        } else {
            unit_or_up(projector.position - pick(positions, index).as_dvec3())
        };
        (x[index], y[index], z[index]) = (view.x as f32, view.y as f32, view.z as f32);
    }
}

#[cfg(test)]
mod tests;
