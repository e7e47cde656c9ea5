//! What a look asks of its document: an output, inputs, and values that are set.

use crate::{BindingFault, CheckedGraph, Diagnostic, LookError, PlanError, Severity, nearest};

/// What a look asks of its document.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked<'a> {
    /// Name of the output, if there is one.
    pub(crate) output: Option<&'a str>,
    /// Names of the inputs.
    pub(crate) inputs: &'a [String],
    /// Assignments.
    pub(crate) set: &'a [String],
}

impl Asked<'_> {
    /// Returns the name of the output, and makes nodes of the inputs that are none; or adds every fault.
    pub(crate) fn of(self, graph: &mut CheckedGraph, faults: &mut Vec<Diagnostic>) -> Option<String> {
        let output = self.chosen(graph, faults);
        let mut opened: Vec<&String> = Vec::with_capacity(self.inputs.len());
        for (index, name) in self.inputs.iter().enumerate() {
            let port = format!("inputs[{index}]");
            if let Some(first) = self.inputs[..index].iter().position(|other| other == name) {
                let found = format!("\"{name}\", which is inputs[{first}] already");
                faults.push(fault(graph.name(), &port, found, "each input once", "leave one of them out"));
                continue;
            }
            match graph.open(name) {
                Ok(_) => opened.push(name),
                Err(mut found) => {
                    // Who names no place in the document may have mistaken the place of the name.
                    if found.node.is_none() && found.port.is_none() {
                        found.port = Some(port);
                    }
                    faults.push(*found);
                }
            }
        }
        for assignment in self.set {
            let Some((path, _)) = assignment.split_once('=') else { continue };
            if let Some(name) = opened.iter().find(|name| takes_the_place_of(graph, name, path)) {
                let index = self.inputs.iter().position(|input| input == *name).unwrap_or_default();
                let found = format!("a value for \"{path}\", whose place inputs[{index}], \"{name}\", takes");
                let expected = "either a value or an input";
                faults.push(Diagnostic {
                    file: assignment.clone(),
                    is_assigned: true,
                    port: None,
                    ..fault(graph.name(), "", found, expected, "leave one of them out")
                });
            }
        }
        output
    }

    /// Returns the fault of an input of which another output is needed, which only the plan shows; or the error.
    pub(crate) fn of_plan(self, document: &str, error: PlanError) -> LookError {
        let (name, output) = match error {
            PlanError::Binding { name, reason: BindingFault::Output(output) } => (name, output),
            error => return error.into(),
        };
        let index = self.inputs.iter().position(|input| *input == name).unwrap_or_default();
        let found = format!("\"{name}\", of which the output needs \"{name}.{output}\", too");
        let expected = "a node whose first output alone is needed";
        let remedy = format!("bind the nodes that take \"{name}.{output}\" and \"{name}\" instead");
        LookError::Asked(vec![fault(document, &format!("inputs[{index}]"), found, expected, &remedy)])
    }

    /// Returns the name of the output.
    fn chosen(self, graph: &CheckedGraph, faults: &mut Vec<Diagnostic>) -> Option<String> {
        let known: Vec<&str> = graph.outputs().iter().map(|spec| spec.name.as_str()).collect();
        let name = match (self.output, &known[..]) {
            (Some(name), _) => name,
            (None, [only]) => only,
            (None, all) => {
                let (found, expected) = (format!("none of {} outputs", all.len()), "the name of one of them");
                faults.push(fault(graph.name(), "output", found, expected, &format!("name {}", all.join(" or "))));
                return None;
            }
        };
        let Some(spec) = graph.outputs().iter().find(|spec| spec.name == name) else {
            let remedy = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => "name one of them".into(),
            };
            let expected = format!("one of the outputs {}", known.join(", "));
            faults.push(fault(graph.name(), "output", format!("\"{name}\""), &expected, &remedy));
            return None;
        };
        if spec.is_recipe {
            let node = graph.node(spec.node);
            let color = match spec.output {
                0 => node.name.clone(),
                output => format!("{}.{}", node.name, node.ty.declaration().outputs[output].name),
            };
            let [line, column] = spec.place;
            let found = format!("the recipe of \"{color}\", which has its weights over all colors, for a file");
            let remedy = format!("ask for an output with \"color\": \"{color}\"; add one if there is none");
            let asked = fault(graph.name(), name, found, "an output with a color, weights or a field", &remedy);
            faults.push(Diagnostic { line, column, ..asked });
            return None;
        }
        Some(name.into())
    }
}

/// Whether samples of an input take the place of a value at a path, so that it would have no effect.
fn takes_the_place_of(graph: &CheckedGraph, input: &str, path: &str) -> bool {
    let Some(rest) = path.strip_prefix(input) else { return false };
    if !(rest.is_empty() || rest.starts_with(['.', '['])) {
        return false;
    }
    if input.contains('.') {
        return true;
    }
    // Values of a node may decide how many channels it has.
    let node = graph.find(input).map(|id| graph.node(id));
    node.is_some_and(|node| {
        node.ty.declaration().outputs.first().map(|output| output.kind) == node.kinds.first().copied()
    })
}

/// Returns a fault of what is asked, at a place that callers know.
fn fault(document: &str, port: &str, found: String, expected: &str, remedy: &str) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        file: document.into(),
        is_assigned: false,
        line: 0,
        column: 0,
        node: None,
        port: Some(port.into()),
        found,
        expected: expected.into(),
        remedy: remedy.into(),
        means: None,
        used: None,
    }
}
