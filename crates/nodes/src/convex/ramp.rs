//! Ramp: a color gradient along a mask.

use trochoid_graph::*;

/// Maps a mask through a gradient of colors.
///
/// # Formula
/// Σ hᵢ(t)·Cᵢ with hat functions hᵢ over the stops: from Cᵢ to Cᵢ₊₁ by the fraction u = (t − atᵢ)/(atᵢ₊₁ − atᵢ).
/// `smooth` eases it, u²(3 − 2u); `step` keeps Cᵢ until the next stop.
///
/// # Edge cases
/// At a stop, exactly the color of that stop. Before the first stop and after the last, their colors. Two stops at the
/// same position give a hard edge; the position itself has the later color.
///
/// # Source
/// Piecewise linear interpolation as a partition of unity; `smooth`: thesis 3.2.4.2.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The color."))]
#[also_called("ColorRamp", "Gradient", "GradientMap", "Curves", "ColorCurve", "Lookup", "LUT", "Colorize")]
pub(crate) struct Ramp {
    /// Position along the gradient.
    weight: One<port::Mask>,
    /// Colors and their positions, in ascending order.
    #[list(1..=256)]
    stops: Vec<Stop>,
    /// Transition from one stop to the next: linear, smooth (eased in and out), or step (no transition).
    interpolation: Interpolation,
}

/// Color at a position of the gradient.
#[derive(Clone, Items)]
pub(crate) struct Stop {
    /// Position of the color along the gradient, from 0 to 1.
    #[knob(range = 0.0..=1.0, required)]
    at: f64,
    /// Color at this position.
    color: One<port::Color>,
}

/// Transition between two stops.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Interpolation {
    Linear,
    Smooth,
    Step,
}

impl Ramp {
    /// Returns the positions of the stops, made ascending. Keyframed positions that ascend at every keyframe may still
    /// cross in between; then the later stop stays at the position of the earlier one.
    fn places(&self) -> Vec<f64> {
        let reached = |last: &mut f64, stop: &Stop| {
            *last = last.max(stop.at);
            Some(*last)
        };
        self.stops.iter().scan(0.0, reached).collect()
    }
}

impl Node for Ramp {
    fn check(&self, check: &mut Check<'_>) {
        let at: Vec<f64> = self.stops.iter().map(|stop| stop.at).collect();
        if let Some(pair) = at.windows(2).find(|pair| pair[1] < pair[0]) {
            let found = format!("a stop at {} after one at {}", pair[1], pair[0]);
            check.error(Self::STOPS, found, "stops in ascending order", "sort the stops by \"at\"");
        }
        if let Some(three) = at.windows(3).find(|three| three[0] == three[1] && three[1] == three[2]) {
            let found = format!("three stops at {}", three[0]);
            let remedy = "the middle color never shows: remove or move it";
            check.warning(Self::STOPS, found, "at most two stops at the same position, for a hard edge", remedy);
        }
    }
}

impl Pointwise for Ramp {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let (stops, places) = (&self.stops, self.places());
        let x = lowering.scalar(&self.weight);
        let mut color = lowering.color(&stops[0].color);
        // Where t = 1, a mix shows only its own color, so chaining the mixes gives the sum of hat functions.
        for (stop, at) in stops[1..].iter().zip(places.windows(2)) {
            let next = lowering.color(&stop.color);
            let (min, max) = (at[0], at[1]);
            let build = &mut lowering.build;
            let t = match self.interpolation {
                Interpolation::Linear | Interpolation::Smooth if min >= max => build.step(x, max),
                Interpolation::Linear => build.clamp(x, min, max),
                Interpolation::Smooth => {
                    let t = build.clamp(x, min, max);
                    build.smooth(t)
                }
                Interpolation::Step => build.step(x, max),
            };
            color = build.mix(color, next, t);
        }
        Value::Color(color)
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let (stops, places) = (&self.stops, self.places());
        let t = inputs.scalar(&self.weight);
        let reached = places.partition_point(|at| *at <= t);
        let color = |stop: usize| inputs.color(&stops[stop].color);
        if reached == 0 {
            return Reference::Color(color(0));
        }
        if reached == stops.len() || self.interpolation == Interpolation::Step {
            return Reference::Color(color(reached - 1));
        }
        let (from, to) = (color(reached - 1), color(reached));
        let mut u = (t - places[reached - 1]) / (places[reached] - places[reached - 1]);
        if self.interpolation == Interpolation::Smooth {
            u = u * u * (3.0 - 2.0 * u);
        }
        Reference::Color([0, 1, 2].map(|c| (1.0 - u) * from[c] + u * to[c]))
    }
}
