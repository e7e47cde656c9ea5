//! CrestFoam: foam on high, flat crests.

use crate::view::{ChannelMask, Ramp};
use trochoid_graph::*;

/// A mask of foam on wave crests: where the surface is high and nearly level.
///
/// # Formula
/// R((h − height)/rise) · R((n.y − flatness)/softness). R limits its argument to [0, 1]; h is the height above the
/// rest level, n the unit normal.
///
/// # Edge cases
/// 0 where nothing is seen. Rise or softness 0 is a step that includes its threshold. With flatness −1 and softness 0,
/// only the height counts.
///
/// # Source
/// A toon water after Hokusai: where the normal is steepest above a height, the crest turns and foams.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The foam."))]
#[also_called("Foam", "Whitecaps")]
pub(crate) struct CrestFoam {
    /// View of the water.
    #[port(wants(Folds))]
    view: One<port::View>,
    /// Height above which foam starts.
    #[knob(default = 0.5, range = -1e5..=1e5, unit = "m")]
    height: f64,
    /// Further rise over which foam reaches full strength.
    #[knob(default = 0.5, range = 0.0..=1e5, unit = "m")]
    rise: f64,
    /// Normal's y above which foam starts; 1 is level.
    #[knob(default = 0.9, range = -1.0..=1.0)]
    flatness: f64,
    /// Further increase of the normal's y over which foam reaches full strength.
    #[knob(default = 0.05, range = 0.0..=2.0)]
    softness: f64,
}

impl ChannelMask for CrestFoam {
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
