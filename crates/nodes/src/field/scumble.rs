//! Scumble: paint that a dry brush breaks.

use trochoid_graph::*;

/// Breaks a soft density into paint dragged over a grain: closed where it is dense, in flecks where it is thin.
///
/// # Formula
/// s = body·density + dry·(noise − level); t = (s − from)/(to − from) limited to [0, 1]; t²(3 − 2t) · min(density/thin, 1).
///
/// # Edge cases
/// 0 where the density is 0, whatever the noise. `dry` 0 leaves a curve of the density. `from` = `to` makes hard
/// flecks.
///
/// # Source
/// Scumbling: opaque paint, nearly dry, dragged over what lies below.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(mask: Kind::MASK = "The paint."))]
pub(crate) struct Scumble {
    /// How much paint: the alpha of a Spray, foam, mist.
    density: One<port::Mask>,
    /// The grain: a ridged Noise, or a Grain.
    noise: One<port::Scalar>,
    /// How fast the paint closes as it gets denser.
    #[knob(default = 1.15, range = 0.0..=1e3)]
    body: f64,
    /// How much the grain breaks it.
    #[knob(default = 1.35, range = 0.0..=1e3)]
    dry: f64,
    /// The grain's middle: at which it neither takes nor gives.
    #[knob(default = 0.58, range = -1e3..=1e3)]
    level: f64,
    /// Where paint begins to stick.
    #[knob(default = 0.16, range = -1e3..=1e3)]
    from: f64,
    /// Where it covers.
    #[knob(default = 1.0, range = -1e3..=1e3)]
    to: f64,
    /// Density below which flecks get fainter.
    #[knob(default = 0.4, range = 1e-6..=1.0)]
    thin: f64,
}

impl Node for Scumble {
    fn check(&self, check: &mut Check<'_>) {
        if self.to < self.from {
            let found = format!("{} below from, {}", self.to, self.from);
            check.error(Self::TO, found, "at least as much", "swap them");
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Scumble {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn formatted(&self) -> bool {
        false
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, _prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(self.clone()))
    }
}

impl Scumble {
    /// The formula.
    fn mask(&self, density: f64, noise: f64) -> f64 {
        let s = self.body * density + self.dry * (noise - self.level);
        let t = if s >= self.to {
            1.0
        } else if s >= self.from {
            (s - self.from) / (self.to - self.from)
        } else {
            0.0
        };
        t * t * (3.0 - 2.0 * t) * (density / self.thin).min(1.0)
    }

    /// What paint may be: more density never takes from it, and neither does more noise.
    fn span(&self, density: Span, noise: Span) -> Span {
        if density.high <= 0.0 {
            return Span::exactly(0.0);
        }
        // Of noise without end none is left that counts nothing.
        let endless =
            self.dry == 0.0 && noise.low < noise.high && (noise.low.is_infinite() || noise.high.is_infinite());
        let noise = if endless { Span { low: self.level, high: self.level, ..noise } } else { noise };
        let ends = [self.mask(density.low, noise.low), self.mask(density.high, noise.high)];
        let paint = Span::of(&ends).wider(LOST * self.thin.recip()).within(0.0, 1.0).with(density.clear && noise.clear);
        if endless {
            paint.or(Span::exactly(0.0)).with(false)
        } else {
            paint.with(self.to > self.from || ends[0] == ends[1])
        }
    }
}

/// What rounding may take off the rising of paint.
const LOST: f64 = 1e-15;

impl Prepared for Scumble {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let [densities, noises] = [inputs.planes(&self.density, 0), inputs.planes(&self.noise, 0)]
            .map(|planes| planes[0].unwrap_or_default());
        for ((out, density), noise) in mask.iter_mut().zip(densities).zip(noises) {
            *out = self.mask(f64::from(*density), f64::from(*noise)) as f32;
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_by(outputs, (Only, 0), |sample| {
            let [density, noise] = [bounding.known(&self.density, 0, sample), bounding.known(&self.noise, 0, sample)]
                .map(|span| span.unwrap_or(Span::exactly(0.0)));
            self.span(density.within(0.0, 1.0), noise)
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Mask(self.mask(inputs.scalar(&self.density), inputs.scalar(&self.noise)))])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{frame, refused};

    #[test]
    fn paint_needs_density_and_closes_with_it() {
        let frame = frame("weights", r#""out": { "type": "Scumble", "density": 0.5, "noise": 0.5 }"#);
        let node = frame.graph.settle(frame.graph.find("out").unwrap(), 1);
        let paint: &Scumble = node.get().unwrap();
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
