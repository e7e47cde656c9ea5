//! What camera, lights, Render and passes share.

mod around;
pub(crate) mod clouds;
mod copy;
mod geometry;
mod lit;
mod mask;
pub(crate) mod memory;
mod mesh;
mod model;
mod parted;
mod seen;
#[cfg(feature = "sea")]
pub(crate) mod stability;
mod surroundings;
mod thickness;
mod toward;
mod waters;

pub(crate) use around::{Around, change, grown, may_see, surface_of};
pub(crate) use copy::ViewCopy;
pub(crate) use geometry::{
    FLIP, ROTATE, SCALE, Standing, TRANSLATE, UP, check_ending, check_scale, placement, to_y_up, y_up_to,
};
pub(crate) use lit::{COMBINE, Lights, Vectors3, eye, toward_eye, view_directions};
pub(crate) use mask::{Ramp, ViewMask, ramp};
pub(crate) use mesh::read_mesh;
pub(crate) use model::{patch, read_model};
pub(crate) use parted::{Parted, parted};
pub(crate) use seen::{Rays, Seen, asked};
pub(crate) use surroundings::{BEYOND, DETAIL, Surroundings, landed};
pub(crate) use thickness::{DISTANCE, INSET, Way};
pub(crate) use toward::{Near, Toward};
pub(crate) use waters::{
    REST, TRAILS, WAVES, can_break, check_indices, check_roots, check_same_camera, check_sea, check_surfaces,
    check_trails,
};

use std::path::PathBuf;
use std::sync::Arc;
use trochoid_graph::{Channel, FrameContext, Inputs, NodeError, Reference, References, Settled, escape_remedy};
use trochoid_scene::{Camera, DVec3, Surface};

/// What nodes with a Surface as output hand on.
pub(crate) type SurfaceHandle = Arc<dyn Surface>;

/// What a Render hands on beside its planes.
pub(crate) struct Looking {
    pub(crate) camera: Camera,
    /// What is seen, in the order of [`Channel::Surface`].
    pub(crate) surfaces: Vec<SurfaceHandle>,
}

/// A vector knob.
pub(crate) fn vector(node: &Settled, knob: &str) -> DVec3 {
    DVec3::from(node.vector3(knob))
}

pub(crate) const POSITION: [Channel; 3] = [Channel::PositionX, Channel::PositionY, Channel::PositionZ];
pub(crate) const NORMAL: [Channel; 3] = [Channel::NormalX, Channel::NormalY, Channel::NormalZ];

/// Three channels of the view at one sample, in f64.
pub(crate) fn view_vector(node: &Settled, inputs: &References<'_>, channels: [Channel; 3]) -> DVec3 {
    DVec3::from(channels.map(|channel| inputs.view(node.source("view"), channel)))
}

/// Three channels of the view over a block.
pub(crate) fn view_planes<'a>(inputs: &Inputs<'a>, channels: [Channel; 3]) -> Vectors3<'a> {
    channels.map(|channel| inputs.view("view", channel))
}

/// Whether a sample of the view is covered, in f64.
pub(crate) fn is_covered(node: &Settled, inputs: &References<'_>) -> bool {
    inputs.view(node.source("view"), Channel::Coverage) > 0.0
}

/// Whether no sample of a block is covered: there, a mask is 0 whatever it is made of.
pub(crate) fn is_bare(inputs: &Inputs<'_>) -> bool {
    inputs.view("view", Channel::Coverage).iter().all(|coverage| *coverage == 0.0)
}

/// Sets a mask to its background, 0, where the view is not covered.
pub(crate) fn uncover(inputs: &Inputs<'_>, mask: &mut [f32]) {
    for (mask, coverage) in mask.iter_mut().zip(inputs.view("view", Channel::Coverage)) {
        if *coverage == 0.0 {
            *mask = 0.0;
        }
    }
}

/// A mask of the reference at an uncovered sample.
pub(crate) fn nothing() -> Vec<Reference> {
    vec![Reference::Mask(0.0)]
}

/// The file that a node names, at the frame.
///
/// # Errors
/// There is none, but one whose folders or name have a `#` or a `%` of their own.
pub(crate) fn named(frame: &FrameContext, written: &str) -> Result<PathBuf, NodeError> {
    let path = frame.path(written);
    if !path.exists()
        && let Some(remedy) = escape_remedy(frame, written)
    {
        return Err(NodeError::new(format!("{}: found no file of this name, expected one; {remedy}", path.display())));
    }
    Ok(path)
}
