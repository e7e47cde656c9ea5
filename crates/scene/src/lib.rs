//! Cameras, lights, surfaces, what a camera sees of them, and the quantities that shading needs.
//!
//! # Conventions
//! The world is right-handed with Y up, in meters. A camera looks along its own −Z. Pixels are those of
//! `trochoid-image`: y points down, the center of pixel (x, y) lies at (x + ½, y + ½). Depth is planar: along the
//! view axis. Angles are in radians.
//!
//! # Visibility
//! [`Visible::prepare`] tessellates every surface for one camera, once per frame and only for the requested channels;
//! [`Visible::fill`] computes the samples of any window of pixels. Its results depend neither on how the picture is
//! divided into windows nor on the number of threads. [`reference::trace`] computes the same in f64 from the
//! continuous surfaces, without any tessellation.
//!
//! # Features
//! With `files`, the module `files` reads meshes and models of patches from the bytes of files.

pub mod bezier;
mod boxes;
mod camera;
mod certain;
mod channel;
pub mod claws;
mod edges;
mod extent;
#[cfg(feature = "files")]
pub mod files;
mod first_hit;
mod first_point;
mod float;
mod followed;
mod footprint;
mod four;
mod grid_ranges;
mod grid_ray;
mod grid_surface;
mod grid_values;
#[doc(hidden)]
pub mod inside;
mod light;
mod meet_near;
mod obstacles;
mod on_heights;
mod patches;
mod points;
mod project;
mod raster;
pub mod reference;
mod resolve;
mod resting;
mod rigid;
mod same_sheet;
mod sea_point;
mod sea_surface;
pub mod shading;
mod sheets;
mod spacing;
pub mod spray;
mod surface;
mod tessellate;
mod triangles;
mod visible;

pub use camera::{Camera, Projection, Projector, Ray};
pub use certain::Certain;
pub use channel::{Samples, Targets, channel_of};
pub use float::{Floating, Plane};
pub use footprint::{Footprints, GRAZING, footprint, footprints_seen};
pub use glam::DVec3;
pub use grid_surface::GridSurface;
pub use grid_values::{GridDoubt, Number};
pub use light::{Illumination, Light};
pub use obstacles::{Obstacles, Segment, first_reference, surroundings};
pub use on_heights::HeightField;
pub use patches::Patches;
pub use points::{MeshHit, Sums};
pub use resting::Resting;
pub use rigid::{Pose, RigidBodies};
pub use sea_surface::{Resolved, SeaSurface};
pub use surface::{Anchor, Asked, Between, Exact, GivenUp, Hit, Mesh, Met, OneSheet, Sight, Surface, Topology};
pub use triangles::{MAX_TRIANGLES, TriangleModel, Triangles, TrianglesError};
pub use trochoid_image::{Channel, ChannelSet};
pub use visible::{Stats, SurfaceView, Visible, around};
