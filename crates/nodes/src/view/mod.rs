//! Cameras, views of surfaces, and the passes taken from views.

mod camera;
pub(crate) mod cloud_layers;
mod clouds;
mod copy;
mod curvature;
mod depth;
mod edge_on;
pub(crate) mod flow_field;
mod flow_lanes;
mod height;
mod in_front;
mod mask;
mod neighborhood;
mod normal;
mod object_mask;
mod outline;
mod path_knobs;
mod position;
mod ray_pass;
mod render;
mod rest;
mod rest_distance;
mod seen;
mod seen_rows;
mod silhouette;
mod sky;
mod surroundings;
pub(crate) mod thickness;
mod uv;

pub(crate) use camera::{Camera, Projection};
pub(crate) use copy::{ChannelCopy, ViewCopy};
pub(crate) use mask::{ChannelMask, Ramp, ViewMask, ramp};
pub(crate) use neighborhood::{Neighborhood, change, grown, may_see, surface_of};
pub(crate) use path_knobs::PathKnobs;
pub(crate) use ray_pass::{Quantity, RayPass, RayQuantity};
pub(crate) use render::Render;
pub(crate) use seen::{SeenPoint, required_channels};
pub(crate) use surroundings::{Facets, Rays, Surroundings, landed};

use crate::lit::Vectors3;
use std::path::PathBuf;
use std::sync::Arc;
use trochoid_graph::{
    BadData, Channel, ChannelSet, FrameContext, Handle, Inputs, NoBound, NodeError, NodeType, One, Prepare, Prepared,
    Reference, References, escape_remedy, port,
};
use trochoid_scene::{DVec3, Exact, GivenUp, Surface};

/// Handle output by nodes with a surface.
pub(crate) type SurfaceHandle = Arc<dyn Surface>;

/// Handle output by a Render, besides its planes.
pub(crate) struct RenderHandle {
    pub(crate) camera: trochoid_scene::Camera,
    /// The surfaces in view, in the order of [`Channel::Surface`].
    pub(crate) surfaces: Vec<SurfaceHandle>,
    /// The same for references; the same surfaces unless the Render was prepared for references.
    pub(crate) exact: Vec<SurfaceHandle>,
}

/// Largest doubt about a surface itself, in meters and radians, up to which its points bound those that rays meet.
pub(crate) const MOST_DOUBT: f64 = 1e-6;

/// Why there is no bound beyond it.
pub(crate) const NO_RUN: NoBound =
    NoBound("rounding may carry even the f64 run of a toon sea further than 1e-6 m from its definition");

/// Returns the surfaces that references see, with at least the wanted channels.
///
/// # Errors
/// The user cancelled.
pub(crate) fn exact(
    surfaces: &[SurfaceHandle],
    wanted: ChannelSet,
    prepare: &Prepare<'_>,
) -> Result<Vec<SurfaceHandle>, NodeError> {
    let of = |surface: &SurfaceHandle| match surface.exact(wanted, prepare.cancellation()) {
        Exact::Itself => Ok(surface.clone()),
        Exact::Other(exact) => Ok(exact),
        Exact::Stopped => Err(NodeError::Cancelled),
    };
    surfaces.iter().map(of).collect()
}

/// Returns the error of a reference whose ray was given up.
pub(crate) fn too_rough(error: GivenUp) -> NodeError {
    let remedy = "lower the \"sharpness\" or the height of the waves, or look from farther away";
    NodeError::GivenUp(Box::new(BadData::new(error, "surfaces whose first point along a ray can be found", remedy)))
}

/// Stage that outputs a camera or a light.
pub(crate) struct PreparedHandle<T>(pub(crate) T);

impl<T: Copy + Send + Sync + 'static> Prepared for PreparedHandle<T> {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.0))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(Arc::new(self.0))])
    }
}

pub(crate) const POSITION: [Channel; 3] = [Channel::PositionX, Channel::PositionY, Channel::PositionZ];
pub(crate) const NORMAL: [Channel; 3] = [Channel::NormalX, Channel::NormalY, Channel::NormalZ];

/// Returns three channels of the view at one sample, in f64.
pub(crate) fn view_vector(inputs: &References<'_>, view: &One<port::View>, channels: [Channel; 3]) -> DVec3 {
    DVec3::from(channels.map(|channel| inputs.view(view, channel)))
}

/// Returns three channels of the view over a block.
pub(crate) fn view_planes<'a>(inputs: &Inputs<'a>, view: &One<port::View>, channels: [Channel; 3]) -> Vectors3<'a> {
    channels.map(|channel| inputs.view(view, channel))
}

/// Whether a sample of the view is covered, in f64.
pub(crate) fn is_covered(inputs: &References<'_>, view: &One<port::View>) -> bool {
    inputs.view(view, Channel::Coverage) > 0.0
}

/// Whether no sample of a block is covered; masks are 0 there, whatever their inputs.
pub(crate) fn is_bare(inputs: &Inputs<'_>, view: &One<port::View>) -> bool {
    inputs.view(view, Channel::Coverage).iter().all(|coverage| *coverage == 0.0)
}

/// Sets a mask to its background, 0, where the view is not covered.
pub(crate) fn uncover(inputs: &Inputs<'_>, view: &One<port::View>, mask: &mut [f32]) {
    for (mask, coverage) in mask.iter_mut().zip(inputs.view(view, Channel::Coverage)) {
        if *coverage == 0.0 {
            *mask = 0.0;
        }
    }
}

/// Returns a mask's reference at an uncovered sample.
pub(crate) fn nothing() -> Vec<Reference> {
    vec![Reference::Mask(0.0)]
}

/// Returns the path of the file that a node names, at the frame.
///
/// # Errors
/// The file does not exist, and a file exists whose path contains a literal `#` or `%`.
pub(crate) fn named(frame: &FrameContext, written: &str) -> Result<PathBuf, NodeError> {
    let path = frame.path(written);
    if !path.exists()
        && let Some(remedy) = escape_remedy(frame, written)
    {
        return Err(BadData::new("no file of this name", "an existing file", remedy).in_file(path).into());
    }
    Ok(path)
}

pub(crate) static NODES: &[NodeType] = &[
    NodeType::of::<camera::Camera>(),
    NodeType::of::<clouds::Clouds>(),
    NodeType::of::<curvature::Curvature>(),
    NodeType::of::<ViewCopy<depth::Depth>>(),
    NodeType::of::<flow_field::FlowField>(),
    NodeType::of::<ViewCopy<height::Height>>(),
    NodeType::of::<in_front::InFront>(),
    NodeType::of::<ViewCopy<normal::Normal>>(),
    NodeType::of::<object_mask::ObjectMask>(),
    NodeType::of::<outline::Outline>(),
    NodeType::of::<ViewCopy<position::Position>>(),
    NodeType::of::<render::Render>(),
    NodeType::of::<ViewCopy<rest::Rest>>(),
    NodeType::of::<ViewCopy<rest_distance::RestDistance>>(),
    NodeType::of::<silhouette::Silhouette>(),
    NodeType::of::<sky::Sky>(),
    NodeType::of::<RayPass<thickness::Thickness>>(),
    NodeType::of::<ViewCopy<uv::UV>>(),
];
