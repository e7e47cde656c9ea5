//! Passes of quantities found by rays that start at the points of a view.

use super::{Facets, Rays, SeenPoint, Surroundings, required_channels};
use crate::geometry::memory;
use crate::sea::check_surfaces;
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_memory::Scratch;

/// A node whose only output is a quantity that rays find around each seen point, and 0 where nothing is seen.
pub(crate) trait RayQuantity: Declare {
    /// Samples of a pixel that may share the quantity.
    const RATE: Rate;

    /// Returns the view whose surfaces are seen and block rays.
    fn view(&self) -> &One<port::View>;

    /// Returns the facets of the surfaces that block rays.
    fn facets(&self) -> &Facets;

    /// Returns the maximum of the quantity.
    fn most(&self) -> f64 {
        1.0
    }

    /// Returns certain bounds tighter than those of the output's kind.
    fn interval(&self) -> Option<(f64, f64)> {
        None
    }

    /// Reports errors that ranges of single knobs cannot express.
    fn check(&self, check: &mut Check<'_>) {
        let _ = check;
    }

    /// Returns the estimated work for a frame of a format.
    fn work(&self, format: Format) -> Option<Work> {
        let _ = format;
        None
    }

    /// Returns the quantity at one frame.
    ///
    /// # Errors
    /// The view has no camera.
    fn quantity(&self, prepare: &Prepare<'_>) -> Result<Quantity, NodeError>;

    /// Returns the output for a quantity.
    fn output(quantity: f64) -> Reference {
        Reference::Mask(quantity)
    }
}

/// Function that returns the quantities found by rays around seen points, in f64, each from its own point alone.
pub(crate) type Quantity = Box<dyn Fn(&[SeenPoint], &dyn Rays) -> Scratch<f64> + Send + Sync>;

/// Node with such a quantity.
#[derive(Clone)]
pub(crate) struct RayPass<T>(T);

impl<T: RayQuantity> Items for RayPass<T> {
    const ITEMS: &'static [Item] = T::ITEMS;

    fn read(reader: &mut Reader<'_>) -> Self {
        Self(T::read(reader))
    }
}

impl<T: RayQuantity> Declare for RayPass<T> {
    const DECLARATION: &'static Declaration = T::DECLARATION;
}

impl<T: RayQuantity> Node for RayPass<T> {
    fn check(&self, check: &mut Check<'_>) {
        check_surfaces(self.0.view(), check);
        self.0.check(check);
    }

    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        self.0.work(format)
    }
}

impl<T: RayQuantity> Computes for RayPass<T> {
    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl<T: RayQuantity> Stage for RayPass<T> {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        required_channels()
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        self.0.interval()
    }

    fn rate(&self) -> Rate {
        T::RATE
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        memory::of_surroundings(self.0.view(), self.0.facets(), context)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedRayPass {
            surroundings: Surroundings::of(self.0.view(), self.0.facets(), prepare)?,
            quantity: self.0.quantity(prepare)?,
            node: self.0.clone(),
        }))
    }
}

struct PreparedRayPass<T> {
    node: T,
    surroundings: Arc<Surroundings>,
    quantity: Quantity,
}

impl<T: RayQuantity> Prepared for PreparedRayPass<T> {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(out) = outputs.only(0) else { return Ok(()) };
        self.surroundings.fill(block, inputs, self.node.view(), out, &self.quantity)
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // The reference's rays hit the surfaces themselves, so facets may pass or block rays differently.
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            bounding.where_covered(self.node.view(), sample, || Span::unclear(0.0, self.node.most()))
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let quantity = self.surroundings.quantity_reference(inputs, self.node.view(), &self.quantity)?;
        Ok(vec![T::output(quantity)])
    }

    fn bytes(&self) -> usize {
        self.surroundings.bytes()
    }
}
