//! Lights, and nodes that shade surfaces by them.

mod fresnel;
mod light;
mod light_pool;
mod lights;
mod non_specular;
mod pass;
mod shadow;
mod specular;
mod toward;
mod translucency;

pub(crate) use lights::{Combine, Lights, Lit, Vectors3, eye, toward_eye, view_directions, view_positions};
pub(crate) use pass::{Facing, LitPass, LitShader};
pub(crate) use toward::{BoundedDirection, BoundedVector};

use crate::view::RayPass;
use trochoid_graph::NodeType;

pub(crate) static NODES: &[NodeType] = &[
    NodeType::of::<LitPass<fresnel::Fresnel>>(),
    NodeType::of::<light::Light>(),
    NodeType::of::<light_pool::LightPool>(),
    NodeType::of::<LitPass<non_specular::NonSpecular>>(),
    NodeType::of::<RayPass<shadow::Shadow>>(),
    NodeType::of::<LitPass<specular::Specular>>(),
    NodeType::of::<RayPass<translucency::Translucency>>(),
];
