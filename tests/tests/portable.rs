//! Results do not depend on the machine in a single bit: transcendental functions come from `libm`.

use crate::architecture::sources;
use crate::support::root;

/// The crates whose numbers reach pixels, keys, certificates or plans.
const PROMISED: &[&str] =
    &["engine", "graph", "image", "io", "jit", "memory", "nodes", "scene", "sea", "trochoid", "weights"];

/// Functions of f32 and f64 whose last bit the standard library leaves to the machine and its C library. What IEEE 754
/// rounds correctly (`sqrt`, `mul_add`, `round`, remainders) is the same everywhere.
const FUNCTIONS: &[&str] = &[
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "exp", "exp2", "exp_m1",
    "gamma", "hypot", "ln", "ln_1p", "ln_gamma", "log", "log10", "log2", "powf", "powi", "sin", "sin_cos", "sinh",
    "tan", "tanh",
];

/// Functions of `glam` that call those.
const VECTORS: &[&str] = &["angle_between", "angle_to", "from_angle", "from_axis_angle", "from_rotation", "slerp"];

/// Returns whether code calls the function as a method or by the path of its type.
fn calls(line: &str, function: &str) -> bool {
    let is_whole = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let named = |before: &str| {
        line.match_indices(&format!("{before}{function}")).any(|(at, found)| is_whole(&line[at + found.len()..]))
    };
    line.contains(&format!(".{function}(")) || named("f32::") || named("f64::")
}

#[test]
fn bits_come_from_libm_and_not_from_the_machine() {
    let mut files = Vec::new();
    for name in PROMISED {
        sources(&root().join("crates").join(name).join("src"), &mut files);
    }
    assert!(files.len() > 300, "only {} sources", files.len());
    let mut faults = Vec::new();
    for (place, text) in &files {
        for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")) {
            let machine = FUNCTIONS.iter().find(|function| calls(line, function));
            let found = machine.or_else(|| VECTORS.iter().find(|function| line.contains(**function)));
            faults.extend(found.map(|function| format!("{place}:{}: {function} depends on the machine", index + 1)));
        }
    }
    assert!(faults.is_empty(), "call libm instead, or multiply for a power:\n{}", faults.join("\n"));
}

#[test]
fn calls_are_found_however_they_are_written() {
    for line in ["x.powf(2.0)", "let y = (a + b).sin();", "f64::atan2(y, x)", "values.map(f32::exp)"] {
        assert!(FUNCTIONS.iter().any(|function| calls(line, function)), "{line}");
    }
    for line in ["libm::pow(x, 2.0)", "x.sqrt()", "self.sine()", "f64::exponent(x)", "catalog(3)", "tan(x)"] {
        assert!(!FUNCTIONS.iter().any(|function| calls(line, function)), "{line}");
    }
}
