//! Quantities found by rays that start at seen points: the channels they need, and filling a block with them.

use super::surroundings::{Rays, Surroundings};
use super::{NORMAL, POSITION, is_covered, too_rough, view_planes, view_vector};
use std::cell::Cell;
use trochoid_graph::{Block, Channel, ChannelSet, Inputs, NodeError, One, References, port};
use trochoid_memory::Scratch;
use trochoid_scene::shading::unit_or_up;
use trochoid_scene::{DVec3, GivenUp, Segment};

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

/// Number of points whose rays are asked for together, between checks for cancellation.
const TOGETHER: usize = 64;

/// Rays that meet continuous surfaces, in f64. Quantities cannot fail, so an error is kept.
struct ExactRays<'a> {
    surroundings: &'a Surroundings,
    failed: Cell<Option<GivenUp>>,
}

impl Rays for ExactRays<'_> {
    fn first(&self, segments: &[Segment]) -> Scratch<Option<f64>> {
        let first = |&Segment { ray, limit }: &Segment| {
            self.surroundings.first_reference(&ray, limit).unwrap_or_else(|error| {
                self.failed.set(Some(error));
                None
            })
        };
        segments.iter().map(first).collect()
    }

    fn blocks(&self, segments: &[Segment]) -> Scratch<bool> {
        self.first(segments).iter().map(|distance| distance.is_some()).collect()
    }
}

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
        quantity: impl Fn(&[SeenPoint], &dyn Rays) -> Scratch<f64>,
    ) -> Result<(), NodeError> {
        let (points, normals) = (view_planes(inputs, view, POSITION), view_planes(inputs, view, NORMAL));
        let coverage = inputs.view(view, Channel::Coverage);
        let vector = |planes: [&[f32]; 3], index: usize| DVec3::from(planes.map(|plane| f64::from(plane[index])));
        out.fill(0.0);
        let (mut seen, mut indices) = (Scratch::new(), Scratch::new());
        let mut places = block.places().enumerate().filter(|(index, _)| coverage[*index] > 0.0).peekable();
        while places.peek().is_some() {
            // Rays may be slow: a row of soft shadows can take longer than anyone wants to wait.
            inputs.check_cancelled()?;
            seen.clear();
            indices.clear();
            for (index, at) in places.by_ref().take(TOGETHER) {
                seen.push(self.seen(at, vector(points, index), vector(normals, index)));
                indices.push(index);
            }
            for (index, quantity) in indices.iter().zip(&quantity(&seen, self)) {
                out[*index] = *quantity as f32;
            }
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
        quantity: impl Fn(&[SeenPoint], &dyn Rays) -> Scratch<f64>,
    ) -> Result<f64, NodeError> {
        if !is_covered(inputs, view) {
            return Ok(0.0);
        }
        let (point, normal) = (view_vector(inputs, view, POSITION), view_vector(inputs, view, NORMAL));
        let rays = ExactRays { surroundings: self, failed: Cell::new(None) };
        let found = quantity(&[self.seen(inputs.at, point, normal)], &rays);
        rays.failed.get().map_or(Ok(found[0]), |error| Err(too_rough(error)))
    }
}
