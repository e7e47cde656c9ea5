//! Requirements on the pixels of outputs, and checks of whether they are met.

use std::fmt;
use trochoid_engine::{Frame, Picture};
use trochoid_graph::{CheckedGraph, Guarantee, Kind, OutputSpec};

/// Returns the guarantee on an output's colors; `None` for outputs that are not colors.
///
/// It is always the hull, because all color operations of the program have scalar weights.
pub fn guarantee(spec: &OutputSpec) -> Option<Guarantee> {
    (spec.kind == Kind::Color).then_some(Guarantee::Hull)
}

/// Returns the requirement on an output: the stricter of its own and of `required`, which applies to colors only.
pub fn requirement(spec: &OutputSpec, required: Option<Guarantee>) -> Option<Guarantee> {
    spec.require.max(required.filter(|_| spec.kind == Kind::Color))
}

/// Returns the guarantee that holds on a picture's pixels: that of its class, if no pixel is outside and none is NaN.
pub fn held(picture: &Picture) -> Option<Guarantee> {
    picture.guarantee.filter(|_| picture.audit.hull_exits == 0 && picture.audit.nan_count == 0)
}

/// Output that misses its requirement at a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Miss {
    /// Index of the output in the graph.
    pub output: usize,
    /// Name of the output.
    pub name: String,
    /// Number of the frame.
    pub frame: i64,
    /// Required guarantee.
    pub required: Guarantee,
    /// Guarantee of the picture's class.
    pub guarantee: Option<Guarantee>,
    /// Number of pixels outside.
    pub exits: u64,
    /// Largest distance of a pixel outside.
    pub worst: f64,
    /// Number of pixels that are NaN.
    pub nan: u64,
    /// Number of pixels.
    pub pixels: u64,
}

impl fmt::Display for Miss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, frame, exits, worst, nan, pixels, .. } = self;
        let class = self.guarantee.map_or("none", Guarantee::name);
        write!(f, "frame {frame}: output \"{name}\": found the guarantee {class}")?;
        write!(f, ", {exits} of {pixels} pixels outside, the worst by {worst:.3e}, {nan} NaN")?;
        write!(f, "; expected {}, no pixel outside, no NaN", self.required.name())
    }
}

/// Returns the pictures of a frame that miss the requirement of their outputs, or `required`, which applies to all
/// colors.
pub fn misses(graph: &CheckedGraph, frame: &Frame, required: Option<Guarantee>) -> Vec<Miss> {
    let judged = frame.pictures.iter().filter_map(|picture| {
        let spec = &graph.outputs()[picture.output];
        let required = requirement(spec, required)?;
        if held(picture) >= Some(required) {
            return None;
        }
        Some(Miss {
            output: picture.output,
            name: spec.name.clone(),
            frame: frame.number,
            required,
            guarantee: picture.guarantee,
            exits: picture.audit.hull_exits,
            worst: picture.audit.worst_exit,
            nan: picture.audit.nan_count,
            pixels: picture.audit.pixels,
        })
    });
    judged.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid_engine::{Buffers, Cache, Plan, Settings, Silent};

    fn frame(require: &str) -> (CheckedGraph, Frame) {
        let text = format!(
            r##"{{"trochoid": 1, "format": {{"width": 4, "height": 1}},
                "nodes": {{"across": {{"type": "ScreenX"}},
                           "mix": {{"type": "Mix", "a": "#000", "b": "#fff", "weight": "across"}}}},
                "outputs": {{"beauty": {{"color": "mix"{require}}}, "mask": {{"weights": "across"}}}}}}"##
        );
        let loaded = crate::parse("judge", &text, std::path::Path::new("."), &[]).expect("valid");
        let plan = Plan::new(&loaded.graph, &[], 1, &[], &Settings::default()).expect("small");
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).expect("no files");
        (loaded.graph, frame)
    }

    #[test]
    fn what_stays_inside_misses_nothing() {
        let (graph, frame) = frame(r#", "require": {"guarantee": "hull"}"#);
        assert_eq!(misses(&graph, &frame, Some(Guarantee::Hull)), []);
    }

    #[test]
    fn exits_nan_and_a_weaker_class_are_misses() {
        let (graph, inside) = frame("");
        let damage: [fn(&mut Picture); 3] =
            [|p| p.audit.hull_exits = 3, |p| p.audit.nan_count = 1, |p| p.guarantee = Some(Guarantee::Box)];
        for damage in damage {
            let mut frame = inside.clone();
            damage(&mut frame.pictures[0]);
            assert_eq!(misses(&graph, &frame, None), [], "nothing is required");
            let found = misses(&graph, &frame, Some(Guarantee::Hull));
            assert_eq!(found.len(), 1, "the mask is no color");
            assert!(found[0].to_string().contains("output \"beauty\""), "{}", found[0]);
        }
    }

    #[test]
    fn the_stricter_requirement_counts() {
        let (graph, mut frame) = frame(r#", "require": {"guarantee": "hull"}"#);
        frame.pictures[0].guarantee = Some(Guarantee::Box);
        assert_eq!(misses(&graph, &frame, Some(Guarantee::Box))[0].required, Guarantee::Hull);
        let (graph, mut frame) = self::frame(r#", "require": {"guarantee": "box"}"#);
        frame.pictures[0].guarantee = Some(Guarantee::Box);
        assert_eq!(misses(&graph, &frame, None), []);
        assert_eq!(misses(&graph, &frame, Some(Guarantee::Hull))[0].required, Guarantee::Hull);
    }
}
