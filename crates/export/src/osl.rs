//! OSL: a shader whose parameters are the inputs, with functions before it.

use crate::Job;
use crate::code::{Code, Syntax, code, comment};
use crate::glsl::is_color;
use std::fmt::Write as _;

/// How OSL is written.
const SYNTAX: Syntax = Syntax { number: "float", color: "color", is_wgsl: false };

/// Writes the shader.
pub(crate) fn write(job: &Job<'_>) -> String {
    let Code { functions, statements, results } = code(job, SYNTAX);
    let mut text = String::new();
    comment(&mut text, &[job.by.to_owned()]);
    comment(&mut text, job.heading);
    let _ = write!(text, "\n{functions}");
    let _ = writeln!(text, "shader {}(", job.name);
    for parameter in job.inputs.parameters() {
        let ty = if parameter.is_color { SYNTAX.color } else { SYNTAX.number };
        let range = if parameter.is_weight { ", float min = 0.0, float max = 1.0" } else { "" };
        // The help has no other signs that a string would have to escape.
        let help = parameter.help.replace('\\', "\\\\").replace('"', "\\\"");
        let _ = writeln!(text, "    {ty} {} = 0.0 [[ string help = \"{help}\"{range} ]],", parameter.identifier);
    }
    let made: Vec<String> = job
        .results
        .iter()
        .zip(&job.made.roots)
        .map(|(result, root)| {
            let ty = if is_color(job, *root) { SYNTAX.color } else { SYNTAX.number };
            format!("    output {ty} {result} = 0.0")
        })
        .collect();
    let _ = writeln!(text, "{})\n{{", made.join(",\n"));
    for statement in &statements {
        let _ = writeln!(text, "    {statement}");
    }
    for (name, result) in job.results.iter().zip(&results) {
        let _ = writeln!(text, "    {name} = {result};");
    }
    text.push_str("}\n");
    text
}
