//! InFront: which of two views is nearer.

use crate::sea::check_same_camera;
use trochoid_graph::*;

/// A mask of the places where one view's surface is nearer than another view's.
///
/// # Formula
/// 1 where d < d'; with `soft`, (d' − d)/soft + ½ limited to [0, 1]. d, d' are the planar depths of `view` and
/// `other`.
///
/// # Edge cases
/// 0 where `view` sees nothing; 1 where only `other` sees nothing. Equal depths: 0, or ½ with `soft`.
///
/// # Source
/// Z compositing: Duff, Compositing 3-D Rendered Images, 1985.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "1 where `view` is in front."))]
pub(crate) struct InFront {
    /// View that may be in front.
    view: One<port::View>,
    /// View that may be behind.
    other: One<port::View>,
    /// Depth range over which one view blends into the other; 0 is a hard edge.
    #[knob(default = 0.0, range = 0.0..=1e6, unit = "m")]
    soft: f64,
}

impl Node for InFront {
    fn check(&self, check: &mut Check<'_>) {
        check_same_camera([&self.view, &self.other], check);
        if *self.view == *self.other {
            let found = "the same view as \"view\", so the mask is meaningless";
            check.warning(Self::OTHER, found, "another view", "connect a Render of the surfaces behind");
        }
    }
}

impl Stage for InFront {
    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        Channel::Depth.into()
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(self.clone()))
    }
}

/// Returns the mask in f64, in which depths are exact.
fn mask(depth: f64, other: f64, soft: f64) -> f64 {
    if depth == f64::INFINITY {
        0.0
    } else if soft == 0.0 || other == f64::INFINITY {
        f64::from(u8::from(depth < other))
    } else {
        ((other - depth) / soft + 0.5).clamp(0.0, 1.0)
    }
}

/// Relative rounding error of a difference of depths.
const LOST: f64 = 1e-15;

impl Prepared for InFront {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(out) = outputs.only(0) else { return Ok(()) };
        let [depth, other] = [&self.view, &self.other].map(|view| inputs.view(view, Channel::Depth));
        for ((out, depth), other) in out.iter_mut().zip(depth).zip(other) {
            *out = mask(f64::from(*depth), f64::from(*other), self.soft) as f32;
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            let [depth, other] = [&self.view, &self.other].map(|view| bounding.certain(view, Channel::Depth, sample));
            // The mask falls with the view's depth and rises with the other's.
            let ends = [mask(depth.high, other.low, self.soft), mask(depth.low, other.high, self.soft)];
            if ends.iter().any(|end| end.is_nan()) {
                return Span::unclear(0.0, 1.0);
            }
            if ends[0] == ends[1] && (ends[0] == 0.0 || ends[0] == 1.0) {
                return Span::exactly(ends[0]);
            }
            let smooth = self.soft > 0.0 && depth.high.is_finite() && other.high.is_finite();
            let slack = LOST * (depth.high.abs() + other.high.abs()) / self.soft;
            let span = Span { low: ends[0], high: ends[1], clear: smooth && depth.clear && other.clear };
            if smooth { span.wider(slack).within(0.0, 1.0) } else { span }
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let [depth, other] = [&self.view, &self.other].map(|view| inputs.view(view, Channel::Depth));
        Ok(vec![Reference::Mask(mask(depth, other, self.soft))])
    }
}
