//! FoldFoam: foam where waves squeeze the surface.

use crate::view::{ChannelMask, Ramp};
use trochoid_graph::*;

/// A mask of foam where waves squeeze the surface; it starts before crests fold over.
///
/// # Formula
/// (threshold − det J)/width, limited to [0, 1]. det J is the ratio of the displaced area to the area at rest: 1 on
/// calm water, 0 where the surface begins to fold, negative in folds.
///
/// # Edge cases
/// 0 where nothing is seen. Width 0 is a step: 1 below the threshold.
///
/// # Source
/// Tessendorf, Simulating Ocean Water, 2001 (the Jacobian of the choppy sea). The threshold above 0 follows many seas
/// that look broken long before they fold.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The foam."))]
pub(crate) struct FoldFoam {
    /// View of the water.
    #[port(wants(Folds))]
    view: One<port::View>,
    /// Jacobian below which foam starts.
    #[knob(default = 0.4, range = -100.0..=100.0)]
    threshold: f64,
    /// Further decrease of the Jacobian over which foam reaches full strength.
    #[knob(default = 0.3, range = 0.0..=100.0)]
    width: f64,
}

impl ChannelMask for FoldFoam {
    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn ramps(&self) -> Vec<(Channel, Ramp)> {
        vec![(Channel::Jacobian, Ramp::Falling { from: self.threshold, width: self.width })]
    }
}
