//! WGSL: a function, with functions of its own before it.

use crate::Job;
use crate::code::{Code, Syntax, code, comment};
use crate::glsl::is_color;
use std::fmt::Write as _;

/// How WGSL is written.
const SYNTAX: Syntax = Syntax { number: "f32", color: "vec3f", is_wgsl: true };

/// Writes the function. Several results are an array, for a function of WGSL returns one value.
pub(crate) fn write(job: &Job<'_>) -> String {
    let Code { functions, statements, results } = code(job, SYNTAX);
    let mut text = String::new();
    comment(&mut text, &[job.by.to_owned()]);
    comment(&mut text, job.heading);
    for parameter in job.inputs.parameters() {
        comment(&mut text, &[format!("{}: {}", parameter.identifier, parameter.help)]);
    }
    let ty = |is_color: bool| if is_color { SYNTAX.color } else { SYNTAX.number };
    let taken = job.inputs.parameters().map(|parameter| (ty(parameter.is_color), parameter.identifier.as_str()));
    let taken: Vec<(&str, &str)> = taken.collect();
    let (returned, value) = match &results[..] {
        [result] => (ty(is_color(job, job.made.roots[0])).to_owned(), result.clone()),
        several => {
            let returned = format!("array<f32, {}>", several.len());
            let value = format!("{returned}({})", several.join(", "));
            (returned, value)
        }
    };
    let _ = write!(text, "\n{functions}{}\n{{\n", SYNTAX.head(&returned, job.name, &taken));
    for statement in &statements {
        let _ = writeln!(text, "    {statement}");
    }
    let _ = write!(text, "    return {value};\n}}\n");
    text
}
