//! Switch: passes on one of several inputs.

use trochoid_graph::*;

/// Passes on one of its inputs; the others are not evaluated.
///
/// # Formula
/// inputs[which]
///
/// # Edge cases
/// Only the chosen input is planned, evaluated and read from disk. Each keyframe of `which` holds until the next. A
/// bypassed input without a value drops out of the list, and those after it move up.
///
/// # Source
/// Choosing one of several colors adds none to the palette.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(output: Kind::ANY = "The chosen input."))]
#[also_called("Choose", "Select", "Selector")]
pub(crate) struct Switch {
    /// Inputs to choose from, all of the same kind.
    #[port(1..=MOST)]
    inputs: Many<port::Image>,
    /// Index of the chosen input, counted from 0.
    #[knob(default = 0, range = 0..=MOST as i64 - 1, hold_keys)]
    which: i64,
}

/// Largest number of inputs.
const MOST: usize = 256;

impl Switch {
    /// Returns the chosen input; none if `which` is out of range.
    fn chosen(&self) -> Option<&Source<Vec<f64>>> {
        self.inputs.get(usize::try_from(self.which).ok()?)
    }

    /// Returns the chosen input of a checked node.
    fn input(&self) -> &Source<Vec<f64>> {
        match self.chosen() {
            Some(input) => input,
            None => unreachable!("checked at every key, and keys hold"),
        }
    }
}

impl Node for Switch {
    fn identity(&self) -> Option<&Source<Vec<f64>>> {
        self.chosen()
    }

    fn check(&self, check: &mut Check<'_>) {
        let inputs = &self.inputs;
        if self.chosen().is_none() {
            let found = format!("{}, with {} inputs", self.which, inputs.len());
            let expected = format!("a whole number from 0 to {}", inputs.len() - 1);
            check.error(Self::WHICH, found, expected, "inputs are counted from 0: choose one of them, or add inputs");
        }
        let Some(first) = check.kind(&inputs[0]) else { return };
        for (index, input) in inputs.iter().enumerate() {
            if let Some(kind) = check.kind(input).filter(|kind| *kind != first) {
                let found = format!("a {first} as inputs[0] and a {kind} as inputs[{index}]");
                let remedy = "the kind of the output must not depend on the choice: connect inputs of one kind";
                check.error(Self::INPUTS, found, "inputs of one kind", remedy);
                return;
            }
        }
    }
}

impl Pointwise for Switch {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        lowering.value(self.input())
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        inputs.value(self.input())
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{agrees, frame, graph, refused};

    #[test]
    fn any_image_is_handed_on() {
        let nodes = r##""x": { "type": "ScreenX" }, "y": { "type": "ScreenY" },
            "weights": { "type": "Stack", "weights": ["x", "y"] },
            "color": { "type": "Mix", "a": "#123", "b": "#def", "weight": "x" }"##;
        for which in [0, 1] {
            for (key, inputs) in [
                ("weights", r#""x", "y""#),
                ("weights", r#"0.25, "y""#),
                ("weights", r#""weights", "weights""#),
                ("color", r##""color", "#456""##),
                ("color", r##"[1, 2, 3], "color""##),
            ] {
                agrees(
                    key,
                    &format!(r#"{nodes}, "out": {{ "type": "Switch", "inputs": [{inputs}], "which": {which} }}"#),
                );
            }
        }
    }

    #[test]
    fn switches_of_switches_know_their_kind() {
        let nodes = r#""out": { "type": "Switch", "inputs": ["b"] }, "b": { "type": "Switch", "inputs": ["c", "x"] },
            "c": { "type": "Switch", "inputs": ["x"] }, "x": { "type": "ScreenX" }"#;
        assert_eq!(frame("weights", nodes).lowered([0.5, 0.5]), [1.0, 0.0]);
        let looped = r#""out": { "type": "Switch", "inputs": ["b"] }, "b": { "type": "Switch", "inputs": ["out"] }"#;
        assert!(refused("weights", looped).contains("loop"));
    }

    #[test]
    fn keys_hold_until_the_next() {
        let keyed = |keys: &str| {
            format!(r#""out": {{ "type": "Switch", "inputs": [0.25, 0.5, 0.75], "which": {{ "keys": [{keys}] }} }}"#)
        };
        let graph = graph("weights", &keyed("[1, 0], [10, 2]"), std::path::Path::new(".")).unwrap();
        let id = graph.find("out").unwrap();
        let which = [0, 1, 9, 10, 11].map(|frame| graph.settle(id, frame).node().identity().unwrap().number());
        assert_eq!(which, [0.25, 0.25, 0.25, 0.75, 0.75].map(Some));
        let text = refused("weights", &keyed("[1, 0], [10, 3]"));
        assert!(text.contains("3, with 3 inputs") && text.contains("a whole number from 0 to 2"), "{text}");
        assert!(refused("weights", &keyed("[1, 0], [10, 1.5]")).contains("a whole number"));
        let linear = r#""out": { "type": "Switch", "inputs": [0, 1],
            "which": { "keys": [[1, 0], [10, 1]], "interpolation": "linear" } }"#;
        assert!(refused("weights", linear).contains("holds until the next"));
    }

    #[test]
    fn inputs_are_of_one_kind() {
        let text = refused("color", r##""out": { "type": "Switch", "inputs": ["#fff", 0.5] }"##);
        assert!(text.contains("a Color as inputs[0] and a mask as inputs[1]"), "{text}");
        let text = refused("color", r#""out": { "type": "Switch", "inputs": [] }"#);
        assert!(text.contains("a list of 1 to 256"), "{text}");
        assert!(refused("color", r#""out": { "type": "Switch", "inputs": [1.5] }"#).contains("1.5"));
    }
}
