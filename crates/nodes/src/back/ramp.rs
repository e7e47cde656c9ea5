//! Ramp: colors along a mask.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Ramp;

struct Ramp;

static DECLARATION: Declaration = Declaration {
    name: "Ramp",
    end: End::Back,
    summary: "Leads through colors along a mask.",
    formula: "Σ hᵢ(t)·Cᵢ, the hat functions hᵢ over the stops: u = (t − atᵢ)/(atᵢ₊₁ − atᵢ) of the way from Cᵢ to Cᵢ₊₁; \
              `smooth` eases u²(3 − 2u); `step` keeps Cᵢ until the next stop.",
    edge_cases: "At a stop exactly its color, before the first and after the last theirs. Two stops at one place are a \
                 hard edge, with the later color at the place itself.",
    source: "Piecewise linear interpolation as a partition of unity; smooth: thesis 3.2.4.2.",
    items: &[
        Port::one("weight", Accepts::Mask, "Where along the ramp."),
        List::of(
            "stops",
            &[
                Knob::number("at", 0.0, 0.0, 1.0, "Place of the color, 0 to 1.").required().item(),
                Port::one("color", Accepts::Color, "The color there."),
            ],
            1,
            256,
            "Colors and their places, ascending.",
        ),
        Knob::choice("interpolation", &["linear", "smooth", "step"], "How to get from stop to stop.").item(),
    ],
    outputs: &[Output::new("color", Kind::Color, "The color.")],
    revision: 1,
};

/// The places of the stops. Keyed places that ascend at their keys might cross in between: the later one then waits.
fn places(node: &Settled) -> Vec<f64> {
    let mut last = 0.0_f64;
    let stops = node.list("stops").iter();
    stops
        .map(|stop| {
            last = last.max(stop.number("at"));
            last
        })
        .collect()
}

impl NodeType for Ramp {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let at: Vec<f64> = node.list("stops").iter().map(|stop| stop.number("at")).collect();
        if let Some(pair) = at.windows(2).find(|pair| pair[1] < pair[0]) {
            let found = format!("a stop at {} after one at {}", pair[1], pair[0]);
            check.error("stops", found, "stops that ascend", "sort the stops by \"at\"");
        }
        if let Some(three) = at.windows(3).find(|three| three[0] == three[1] && three[1] == three[2]) {
            let found = format!("three stops at {}", three[0]);
            let remedy = "the middle color never shows: remove or move it";
            check.warning("stops", found, "at most two stops at one place: a hard edge", remedy);
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Ramp {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let (stops, places) = (node.list("stops"), places(node));
        let interpolation = node.text("interpolation");
        let x = lowering.scalar(node.source("weight"));
        let mut color = lowering.color(stops[0].source("color"));
        // A mask that has reached 1 shows its color alone, so each Mix needs only the one before.
        for (stop, at) in stops[1..].iter().zip(places.windows(2)) {
            let next = lowering.color(stop.source("color"));
            let (min, max) = (at[0] as f32, at[1] as f32);
            let t = if interpolation == "step" || min >= max {
                lowering.build.step(x, max)
            } else {
                let t = lowering.build.clamp(x, min, max);
                if interpolation == "smooth" { lowering.build.smooth(t) } else { t }
            };
            color = lowering.build.mix(color, next, t);
        }
        Value::Color(color)
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let (stops, places) = (node.list("stops"), places(node));
        let t = inputs.scalar(node.source("weight"));
        let reached = places.partition_point(|at| *at <= t);
        let color = |stop: usize| inputs.color(stops[stop].source("color"));
        if reached == 0 {
            return Reference::Color(color(0));
        }
        if reached == stops.len() || node.text("interpolation") == "step" {
            return Reference::Color(color(reached - 1));
        }
        let (from, to) = (color(reached - 1), color(reached));
        let mut u = (t - places[reached - 1]) / (places[reached] - places[reached - 1]);
        if node.text("interpolation") == "smooth" {
            u = u * u * (3.0 - 2.0 * u);
        }
        Reference::Color([0, 1, 2].map(|c| (1.0 - u) * from[c] + u * to[c]))
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{agrees, frame, refused};

    fn ramp(interpolation: &str, stops: &str) -> String {
        format!(
            r#""x": {{ "type": "ScreenX" }},
            "out": {{ "type": "Ramp", "weight": "x", "interpolation": "{interpolation}", "stops": [{stops}] }}"#
        )
    }

    const STOPS: &str = r#"{ "at": 0.1, "color": [1, 0, 0] }, { "at": 0.4, "color": [0, 1, 0] },
        { "at": 0.4, "color": [0.5, 0.5, 0] }, { "at": 0.9, "color": [0, 0, 1] }"#;

    #[test]
    fn the_chain_of_mixes_is_the_sum_of_hats() {
        for interpolation in ["linear", "smooth", "step"] {
            agrees("color", &ramp(interpolation, STOPS));
        }
        agrees("color", &ramp("linear", r#"{ "at": 0.5, "color": [1, 2, 3] }"#));
    }

    #[test]
    fn a_stop_shows_its_color() {
        for interpolation in ["linear", "smooth", "step"] {
            let stops = r#"{ "at": 0, "color": [0.1, 0.7, 0.3] }, { "at": 0.5, "color": [0.3, 0.9, 0.1] },
                { "at": 0.5, "color": [0.2, 0.6, 0.4] }, { "at": 1, "color": [0.7, 0.2, 0.9] }"#;
            let frame = frame("color", &ramp(interpolation, stops));
            assert_eq!(frame.lowered([0.5, 0.5]), [0.1, 0.7, 0.3]);
            assert_eq!(frame.lowered([2.0, 0.5]), [0.2, 0.6, 0.4], "the later of two at one place");
            assert_eq!(frame.lowered([3.5, 0.5]), [0.7, 0.2, 0.9]);
        }
    }

    #[test]
    fn stops_ascend() {
        let stops = r#"{ "at": 0.5, "color": [1, 0, 0] }, { "at": 0.4, "color": [0, 1, 0] }"#;
        assert!(refused("color", &ramp("linear", stops)).contains("a stop at 0.4 after one at 0.5"));
    }
}
