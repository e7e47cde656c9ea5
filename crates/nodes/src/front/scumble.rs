//! Scumble: paint that a dry brush breaks.

use crate::front_support::{Span, bound_by, known};
use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Scumble;

struct Scumble;

static DECLARATION: Declaration = Declaration {
    name: "Scumble",
    end: End::Front,
    summary: "Breaks a soft density into paint dragged over a grain: closed where it is dense, in flecks where it is \
              thin.",
    formula: "s = body·density + dry·(noise − level); t = (s − from)/(to − from) limited to [0, 1]; t²(3 − 2t) · \
              min(density/thin, 1).",
    edge_cases: "0 where the density is 0, whatever the noise. `dry` 0 leaves a curve of the density. `from` = `to` \
                 makes hard flecks.",
    source: "Scumbling: opaque paint, nearly dry, dragged over what lies below.",
    items: &[
        Port::one("density", Accepts::Mask, "How much paint: the alpha of a Spray, foam, mist."),
        Port::one("noise", Accepts::Scalar, "The grain: a ridged Noise, or a Grain."),
        Knob::number("body", 1.15, 0.0, 1e3, "How fast the paint closes as it gets denser.").item(),
        Knob::number("dry", 1.35, 0.0, 1e3, "How much the grain breaks it.").item(),
        Knob::number("level", 0.58, -1e3, 1e3, "The grain's middle: at which it neither takes nor gives.").item(),
        Knob::number("from", 0.16, -1e3, 1e3, "Where paint begins to stick.").item(),
        Knob::number("to", 1.0, -1e3, 1e3, "Where it covers.").item(),
        Knob::number("thin", 0.4, 1e-6, 1.0, "Density below which flecks get fainter.").item(),
    ],
    outputs: &[Output::new("mask", Kind::MASK, "The paint.")],
    revision: 1,
};

impl NodeType for Scumble {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        if node.number("to") < node.number("from") {
            let found = format!("{} below from, {}", node.number("to"), node.number("from"));
            check.error("to", found, "at least as much", "swap them");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Scumble {
    fn interval(&self, _node: &Settled, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn formatted(&self) -> bool {
        false
    }

    fn rate(&self, _node: &Settled) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, node: &Settled, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let figures = ["body", "dry", "level", "from", "to", "thin"].map(|knob| node.number(knob));
        Ok(Box::new(Dragging { node: node.clone(), figures }))
    }
}

struct Dragging {
    node: Settled,
    /// body, dry, level, from, to, thin.
    figures: [f64; 6],
}

impl Dragging {
    fn mask(&self, density: f64, noise: f64) -> f64 {
        let [body, dry, level, from, to, thin] = self.figures;
        let s = body * density + dry * (noise - level);
        let t = if s >= to {
            1.0
        } else if s >= from {
            (s - from) / (to - from)
        } else {
            0.0
        };
        t * t * (3.0 - 2.0 * t) * (density / thin).min(1.0)
    }

    /// What paint may be: more density never takes from it, and neither does more noise.
    fn span(&self, density: Span, noise: Span) -> Span {
        let [_, dry, level, from, to, thin] = self.figures;
        if density.high <= 0.0 {
            return Span::exactly(0.0);
        }
        // Of noise without end none is left that counts nothing.
        let endless = dry == 0.0 && noise.low < noise.high && (noise.low.is_infinite() || noise.high.is_infinite());
        let noise = if endless { Span { low: level, high: level, ..noise } } else { noise };
        let ends = [self.mask(density.low, noise.low), self.mask(density.high, noise.high)];
        let paint = Span::of(&ends).wider(LOST * thin.recip()).within(0.0, 1.0).with(density.clear && noise.clear);
        if endless { paint.or(Span::exactly(0.0)).with(false) } else { paint.with(to > from || ends[0] == ends[1]) }
    }
}

/// What rounding may take off the rising of paint.
const LOST: f64 = 1e-15;

impl Prepared for Dragging {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.take(0, 0) else { return Ok(()) };
        let plane = |port: &str| inputs.planes(port, 0)[0].unwrap_or_default();
        for ((out, density), noise) in mask.iter_mut().zip(plane("density")).zip(plane("noise")) {
            *out = self.mask(f64::from(*density), f64::from(*noise)) as f32;
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bound_by(bounding, outputs, (0, 0), |sample| {
            let of = |port: &str| known(bounding, port, 0, sample).unwrap_or(Span::exactly(0.0));
            self.span(of("density").within(0.0, 1.0), of("noise"))
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let number = |port: &str| inputs.scalar(self.node.source(port));
        Ok(vec![Reference::Mask(self.mask(number("density"), number("noise")))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{frame, refused};

    #[test]
    fn paint_needs_density_and_closes_with_it() {
        let frame = frame("field", r#""out": { "type": "ScreenX" }"#);
        let node = frame.graph.settle(frame.graph.find("out").unwrap(), 1);
        let paint = Dragging { node, figures: [1.15, 1.35, 0.58, 0.16, 1.0, 0.4] };
        for noise in [-1e30, -1.0, 0.0, 0.3, 0.58, 1.0, 1e30, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(paint.mask(0.0, noise), 0.0);
            let mut last = 0.0;
            for density in 0..=100 {
                let mask = paint.mask(f64::from(density) / 100.0, noise);
                assert!((0.0..=1.0).contains(&mask) && mask >= last, "{mask} after {last} at {density} of {noise}");
                last = mask;
            }
        }
        assert_eq!(paint.mask(1.0, 0.58), 1.0, "dense paint is closed at the grain's middle");
        assert!(paint.mask(0.3, 0.9) > 0.2 && paint.mask(0.3, 0.4) == 0.0, "thin paint is in flecks");
    }

    #[test]
    fn edges_run_upward() {
        let nodes = r#""out": { "type": "Scumble", "density": 0.5, "noise": 0.5, "from": 1, "to": 0 }"#;
        assert!(refused("weights", nodes).contains("0 below from"));
    }
}
