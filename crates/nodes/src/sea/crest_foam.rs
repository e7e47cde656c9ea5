//! CrestFoam: foam on crests that are high and flat.

use crate::view::{Masks, Ramp};
use trochoid_graph::*;

/// A mask of foam on the crests of waves: where they stand high and their tops lie flat.
///
/// # Formula
/// R((h − height)/rise) · R((n.y − flatness)/softness), R limits to [0, 1]; h is the height above the rest level, n the
/// unit normal.
///
/// # Edge cases
/// 0 where nothing is seen. Rise or softness 0 is a step that includes its threshold; flatness −1 with softness 0
/// leaves the height alone to decide.
///
/// # Source
/// A toon water after Hokusai: where the normal is steepest above a height, the crest turns and foams.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The foam."))]
pub(crate) struct CrestFoam {
    /// The water.
    #[port(wants(Folds))]
    view: One<port::View>,
    /// Height from which on there is foam.
    #[knob(default = 0.5, range = -1e5..=1e5, unit = "m")]
    height: f64,
    /// How much higher it is full.
    #[knob(default = 0.5, range = 0.0..=1e5, unit = "m")]
    rise: f64,
    /// The normal's y from which on there is foam; 1 is level.
    #[knob(default = 0.9, range = -1.0..=1.0)]
    flatness: f64,
    /// How much more it is full.
    #[knob(default = 0.05, range = 0.0..=2.0)]
    softness: f64,
}

impl Masks for CrestFoam {
    fn view(&self) -> &One<port::View> {
        &self.view
    }

    fn ramps(&self) -> Vec<(Channel, Ramp)> {
        vec![
            (Channel::Height, Ramp::Rising { from: self.height, width: self.rise }),
            (Channel::NormalY, Ramp::Rising { from: self.flatness, width: self.softness }),
        ]
    }
}
