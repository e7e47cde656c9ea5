//! Warnings about a document, as far as they concern what is asked for.

use crate::failure::Failure;
use crate::{remedies, shell};
use trochoid::{CheckedGraph, Diagnostic, NodeId};

/// Returns the warnings that concern some outputs: those on nodes that feed them, on the outputs themselves, and on the
/// document as a whole.
pub(crate) fn of(graph: &CheckedGraph, outputs: &[usize], warnings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let all = graph.outputs();
    if (0..all.len()).all(|index| outputs.contains(&index)) {
        return warnings;
    }
    let feeds = graph.upstream(outputs.iter().map(|index| all[*index].node));
    let concerns = |warning: &Diagnostic| match (&warning.node, warning.port.as_deref()) {
        (Some(node), _) => graph.find(node).is_none_or(|NodeId(index)| feeds[index]),
        (None, Some("palette")) => false,
        (None, Some(port)) => {
            let output = all.iter().position(|output| output.name == port);
            output.is_none_or(|output| outputs.contains(&output))
        }
        (None, None) => true,
    };
    warnings.into_iter().filter(concerns).collect()
}

/// Prints warnings; if there are failures, returns them with the warnings after them.
///
/// # Errors
/// There are failures.
pub(crate) fn after(failures: impl IntoIterator<Item = Failure>, warnings: &[Diagnostic]) -> Result<(), Failure> {
    match Failure::all(failures) {
        Ok(()) => {
            shell::tell(&remedies::texts(warnings));
            Ok(())
        }
        Err(failure) => Err(failure.warning(warnings)),
    }
}
