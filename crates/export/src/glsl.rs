//! GLSL: a function, with functions of its own before it.

use crate::Job;
use crate::code::{Code, Syntax, code, comment};
use std::fmt::Write as _;

/// How GLSL is written.
pub(crate) const SYNTAX: Syntax = Syntax { number: "float", color: "vec3", is_wgsl: false };

/// Writes the function.
pub(crate) fn write(job: &Job<'_>) -> String {
    let Code { functions, statements, results } = code(job, SYNTAX);
    let is_color = job.made.roots.iter().any(|root| is_color(job, *root));
    let mut text = String::new();
    comment(&mut text, &[job.by.to_owned()]);
    comment(&mut text, job.heading);
    comment(&mut text, &["GLSL 1.30 and newer, or ES 3.00 with floats of high precision.".into()]);
    for parameter in job.inputs.parameters() {
        comment(&mut text, &[format!("{}: {}", parameter.identifier, parameter.help)]);
    }
    let _ = write!(text, "\n{functions}");
    let ty = |is_color: bool| if is_color { SYNTAX.color } else { SYNTAX.number };
    let taken = job.inputs.parameters().map(|parameter| format!("{} {}", ty(parameter.is_color), parameter.identifier));
    let mut taken: Vec<String> = taken.collect();
    let several = results.len() != 1;
    if several {
        taken.extend(job.results.iter().map(|result| format!("out float {result}")));
    }
    let returned = if several { "void" } else { ty(is_color) };
    let _ = writeln!(text, "{returned} {}({})\n{{", job.name, taken.join(", "));
    for statement in &statements {
        let _ = writeln!(text, "    {statement}");
    }
    if several {
        for (name, result) in job.results.iter().zip(&results) {
            let _ = writeln!(text, "    {name} = {result};");
        }
    } else {
        let _ = writeln!(text, "    return {};", results[0]);
    }
    text.push_str("}\n");
    text
}

/// Whether a position of the program has a color.
pub(crate) fn is_color(job: &Job<'_>, position: u32) -> bool {
    job.made.program.ops()[position as usize].0.ty() == trochoid_graph::Type::Color
}
