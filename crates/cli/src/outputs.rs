//! Selection of outputs by name.

use crate::failure::Failure;
use trochoid::{CheckedGraph, nearest};

/// Returns the indices of the named outputs, each once; of all outputs if no names are given.
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
    // If no name matches, the first output stands in, so that file name patterns are still checked.
    if chosen.is_empty() { vec![0] } else { chosen }
}
