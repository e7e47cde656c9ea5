//! Passes of quantities that rays find, which go on from the points of a view.

use super::{Facets, Rays, Seen, Surroundings, asked};
use crate::geometry::memory;
use crate::sea::check_surfaces;
use std::sync::Arc;
use trochoid_graph::*;
use trochoid_image::Format;

/// A node whose one output is what rays find around each seen point, and 0 where nothing is seen.
pub(crate) trait Traces: Declare {
    /// Which samples of a pixel may share it.
    const RATE: Rate;

    /// What is seen, and stands in the way.
    fn view(&self) -> &One<port::View>;

    /// How closely it does.
    fn facets(&self) -> &Facets;

    /// The most that it may be.
    fn most(&self) -> f64 {
        1.0
    }

    /// Certain bounds beyond those of its kind.
    fn interval(&self) -> Option<(f64, f64)> {
        None
    }

    /// Reports what ranges of single knobs cannot express.
    fn check(&self, check: &mut Check<'_>) {
        let _ = check;
    }

    /// How long a frame of a format may take.
    fn work(&self, format: Format) -> Option<Work> {
        let _ = format;
        None
    }

    /// The quantity, at one frame.
    ///
    /// # Errors
    /// The view has no camera.
    fn quantity(&self, prepare: &Prepare<'_>) -> Result<Quantity, NodeError>;

    /// The output of a quantity.
    fn output(quantity: f64) -> Reference {
        Reference::Mask(quantity)
    }
}

/// What rays find around a seen point, in f64.
pub(crate) type Quantity = Box<dyn Fn(&Seen, Rays<'_>) -> f64 + Send + Sync>;

/// Such a node.
#[derive(Clone)]
pub(crate) struct RayPass<T>(T);

impl<T: Traces> Items for RayPass<T> {
    const ITEMS: &'static [Item] = T::ITEMS;

    fn read(reader: &mut Reader<'_>) -> Self {
        Self(T::read(reader))
    }
}

impl<T: Traces> Declare for RayPass<T> {
    const DECLARATION: &'static Declaration = T::DECLARATION;
}

impl<T: Traces> Node for RayPass<T> {
    fn check(&self, check: &mut Check<'_>) {
        check_surfaces(self.0.view(), check);
        self.0.check(check);
    }

    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        self.0.work(format)
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl<T: Traces> Stage for RayPass<T> {
    fn asks(&self, _wanted: &[bool]) -> ChannelSet {
        asked()
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        self.0.interval()
    }

    fn rate(&self) -> Rate {
        T::RATE
    }

    fn memory(&self, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory::of_surroundings(self.0.view(), self.0.facets(), reckoning)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedRays {
            surroundings: Surroundings::of(self.0.view(), self.0.facets(), prepare)?,
            quantity: self.0.quantity(prepare)?,
            node: self.0.clone(),
        }))
    }
}

struct PreparedRays<T> {
    node: T,
    surroundings: Arc<Surroundings>,
    quantity: Quantity,
}

impl<T: Traces> Prepared for PreparedRays<T> {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(out) = outputs.only(0) else { return Ok(()) };
        self.surroundings.fill(block, inputs, self.node.view(), out, &self.quantity)
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // The reference's rays meet the surfaces themselves: facets may let them pass, or stop them.
        bounding.bound_by(outputs, (Only, 0), |sample| {
            bounding.where_covered(self.node.view(), sample, || Span::unclear(0.0, self.node.most()))
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![T::output(self.surroundings.quantity_reference(inputs, self.node.view(), &self.quantity))])
    }

    fn bytes(&self) -> usize {
        self.surroundings.bytes()
    }
}
