//! Outputs chosen by name.

use crate::failure::Failure;
use trochoid::{CheckedGraph, nearest};

/// Indices of the outputs of these names, each once; all outputs for no names.
pub(crate) fn choose(graph: &CheckedGraph, names: &[String], faults: &mut Vec<Failure>) -> Vec<usize> {
    let known: Vec<&str> = graph.outputs().iter().map(|output| output.name.as_str()).collect();
    if names.is_empty() {
        return (0..known.len()).collect();
    }
    let mut chosen = Vec::new();
    for name in names {
        match known.iter().position(|known| known == name) {
            Some(index) if chosen.contains(&index) => {}
            Some(index) => chosen.push(index),
            None => {
                let remedy = match nearest(name, known.iter().copied()) {
                    Some(near) => format!("did you mean {near}?"),
                    None => "choose one of them".into(),
                };
                let message = format!("--output: found \"{name}\"; expected one of {}", known.join(", "));
                faults.push(Failure::usage(message, remedy));
            }
        }
    }
    // A stand-in where no name fits, so that the pattern is looked at all the same.
    if chosen.is_empty() { vec![0] } else { chosen }
}
