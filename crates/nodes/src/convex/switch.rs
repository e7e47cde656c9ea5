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
