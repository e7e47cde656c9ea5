//! Quantities found by rays that start at seen points: the channels they need, and filling a block with them.

use super::surroundings::{First, Surroundings};
use super::{NORMAL, POSITION, is_covered, too_rough, view_planes, view_vector};
use std::cell::Cell;
use trochoid_graph::{Block, Channel, ChannelSet, Inputs, NodeError, One, References, port};
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, Ray};

/// A seen point.
pub(crate) struct SeenPoint {
    /// Position in the picture, in pixels.
    pub(crate) at: [f64; 2],
    pub(crate) point: DVec3,
    /// Unit normal.
    pub(crate) normal: DVec3,
    /// Size of the facets at the point, in meters.
    pub(crate) facet: f64,
}

/// Surroundings that rays may hit.
#[derive(Clone, Copy)]
pub(crate) struct Rays<'a> {
    pub(crate) first: First<'a>,
    pub(crate) blocks: &'a dyn Fn(&Ray, f64) -> bool,
}

/// Number of points between checks for cancellation.
const CANCEL_INTERVAL: usize = 64;

/// Returns the channels that the view must supply.
pub(crate) fn required_channels() -> ChannelSet {
    ChannelSet::of(&NORMAL).union(ChannelSet::of(&POSITION)).union(Channel::Coverage.into())
}

impl Surroundings {
    fn seen(&self, at: [f64; 2], point: DVec3, normal: DVec3) -> SeenPoint {
        SeenPoint { at, point, normal: unit_or_up(normal), facet: self.facet(point) }
    }

    /// Fills a block with a quantity of the seen points, using tessellated surfaces; 0 where nothing is seen.
    ///
    /// # Errors
    /// The user cancelled.
    pub(crate) fn fill(
        &self,
        block: &Block<'_>,
        inputs: &Inputs<'_>,
        view: &One<port::View>,
        out: &mut [f32],
        quantity: impl Fn(&SeenPoint, Rays<'_>) -> f64,
    ) -> Result<(), NodeError> {
        let (points, normals) = (view_planes(inputs, view, POSITION), view_planes(inputs, view, NORMAL));
        let coverage = inputs.view(view, Channel::Coverage);
        let vector = |planes: [&[f32]; 3], index: usize| DVec3::from(planes.map(|plane| f64::from(plane[index])));
        let first = |ray: &_, limit| self.first(ray, limit);
        let blocks = |ray: &_, limit| self.blocks(ray, limit);
        let rays = Rays { first: &first, blocks: &blocks };
        for (index, (out, at)) in out.iter_mut().zip(block.places()).enumerate() {
            // Rays may be slow: a row of soft shadows can take longer than anyone wants to wait.
            if index % CANCEL_INTERVAL == 0 {
                inputs.check_cancelled()?;
            }
            *out = if coverage[index] > 0.0 {
                quantity(&self.seen(at, vector(points, index), vector(normals, index)), rays) as f32
            } else {
                0.0
            };
        }
        Ok(())
    }

    /// Returns the quantity at one sample in f64, using continuous surfaces.
    ///
    /// # Errors
    /// A surface is too rough to find where a ray hits it.
    pub(crate) fn quantity_reference(
        &self,
        inputs: &References<'_>,
        view: &One<port::View>,
        quantity: impl Fn(&SeenPoint, Rays<'_>) -> f64,
    ) -> Result<f64, NodeError> {
        if !is_covered(inputs, view) {
            return Ok(0.0);
        }
        let (point, normal) = (view_vector(inputs, view, POSITION), view_vector(inputs, view, NORMAL));
        // Quantities cannot fail, so an error is kept and returned instead of the result.
        let failed = Cell::new(None);
        let first = |ray: &_, limit| {
            self.first_reference(ray, limit).unwrap_or_else(|error| {
                failed.set(Some(error));
                None
            })
        };
        let rays = Rays { first: &first, blocks: &|ray, limit| first(ray, limit).is_some() };
        let found = quantity(&self.seen(inputs.at, point, normal), rays);
        failed.get().map_or(Ok(found), |error| Err(too_rough(error)))
    }
}
