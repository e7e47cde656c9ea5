//! Scumble: broken paint, as dragged by a dry brush over a grain.

use trochoid_graph::*;

/// Turns a soft density into paint dragged over a grain: solid where it is dense, broken into flecks where it is thin.
///
/// # Formula
/// t²(3 − 2t) · min(density/thin, 1) with t = (s − from)/(to − from) limited to [0, 1] and s = body·density +
/// dry·(noise − level).
///
/// # Edge cases
/// 0 where the density is 0, whatever the noise. With `dry` 0, the grain has no effect. `from` = `to` gives flecks with
/// hard edges.
///
/// # Source
/// Scumbling: nearly dry, opaque paint dragged over the layer below.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "The paint."))]
pub(crate) struct Scumble {
    /// Amount of paint, for example foam, mist or the alpha of a Spray.
    density: One<port::Mask>,
    /// Grain that breaks the paint, for example a ridged Noise or a Grain.
    noise: One<port::Scalar>,
    /// Factor of the density: how quickly the paint becomes solid as it gets denser.
    #[knob(default = 1.15, range = 0.0..=1e3)]
    body: f64,
    /// Factor of the grain: how strongly it breaks the paint.
    #[knob(default = 1.35, range = 0.0..=1e3)]
    dry: f64,
    /// Value of the grain that neither adds nor removes paint.
    #[knob(default = 0.58, range = -1e3..=1e3)]
    level: f64,
    /// Value of s (see the formula) at which paint begins to show.
    #[knob(default = 0.16, range = -1e3..=1e3)]
    from: f64,
    /// Value of s at which paint covers fully.
    #[knob(default = 1.0, range = -1e3..=1e3)]
    to: f64,
    /// Density below which the flecks get fainter.
    #[knob(default = 0.4, range = 1e-6..=1.0)]
    thin: f64,
}

impl Node for Scumble {
    fn check(&self, check: &mut Check<'_>) {
        if self.to < self.from {
            let found = format!("{} below from {}", self.to, self.from);
            check.error(Self::TO, found, "to ≥ from", "swap them");
        }
    }
}

impl Stage for Scumble {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn depends_on_format(&self) -> bool {
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
    /// Computes the formula.
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

    /// Returns the span of the mask, which grows with both density and noise.
    fn span(&self, density: Span, noise: Span) -> Span {
        if density.high <= 0.0 {
            return Span::exactly(0.0);
        }
        // With `dry` 0 the noise has no effect, unless it is infinite: 0·∞ is NaN, which makes the mask 0.
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

/// Rounding error of the mask, relative to 1/thin.
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
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
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
