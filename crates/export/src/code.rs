//! What GLSL and OSL have in common: statements and functions, of which only the names of types differ.

use crate::Job;
use crate::input::Parameter;
use crate::translate::{Power, Target, literal, translate};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// A translated program.
pub(crate) struct Code {
    /// Functions that the statements call, each followed by an empty line.
    pub(crate) functions: String,
    /// Statements, one a line, without indentation.
    pub(crate) statements: Vec<String>,
    /// Expressions of the results.
    pub(crate) results: Vec<String>,
}

/// Translates a program; `color` is the name of the type of colors.
pub(crate) fn code(job: &Job<'_>, color: &'static str) -> Code {
    let mut writer = Writer { name: job.name, color, called: BTreeSet::new(), statements: Vec::new() };
    let results = translate(job, &mut writer);
    let functions = writer.called.iter().map(|function| function.text(job.name, color)).collect();
    Code { functions, statements: writer.statements, results }
}

/// A function of the shader's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Function {
    Mask,
    Ramp,
    Smooth,
    Share,
    Mix,
    Decode,
}

impl Function {
    /// Returns the ending of its name, one of [`names::FUNCTIONS`](crate::names::FUNCTIONS).
    fn ending(self) -> &'static str {
        match self {
            Self::Mask => "mask",
            Self::Ramp => "ramp",
            Self::Smooth => "smooth",
            Self::Share => "share",
            Self::Mix => "mix",
            Self::Decode => "decode",
        }
    }

    /// Returns its definition. Comparisons are written so that NaN gives 0.
    fn text(self, name: &str, color: &str) -> String {
        let name = format!("{name}_{}", self.ending());
        match self {
            Self::Mask => format!("float {name}(float t)\n{{\n    return t > 0.0 ? min(t, 1.0) : 0.0;\n}}\n\n"),
            Self::Ramp => format!(
                "float {name}(float x, float low, float high)\n{{\n    \
                 return x >= high ? 1.0 : (x >= low ? min((x - low) / (high - low), 1.0) : 0.0);\n}}\n\n"
            ),
            Self::Smooth => {
                format!("float {name}(float t)\n{{\n    return min(t * t * (3.0 - 2.0 * t), 1.0);\n}}\n\n")
            }
            Self::Share => {
                let most = literal(f32::MAX);
                format!(
                    "float {name}(float v, float scale)\n{{\n    return v > 0.0 ? min(v, {most}) * scale : 0.0;\n}}\n\n"
                )
            }
            // From the nearer end, which is exact at both ends and where both colors are the same.
            Self::Mix => format!(
                "{color} {name}({color} a, {color} b, float t)\n{{\n    \
                 return t < 0.5 ? a + t * (b - a) : b + (t - 1.0) * (b - a);\n}}\n\n"
            ),
            // IEC 61966-2-1. The power of 2.4 is a square and the fifth root of one; a step of Newton's makes exact what `pow`
            // leaves inexact.
            Self::Decode => format!(
                "float {name}(float x)\n{{\n    \
                 float q = (min(max(x, 0.04), 1e16) + 0.055) / 1.055;\n    \
                 float s = q * q;\n    \
                 float r = pow(s, 0.2);\n    \
                 float d = r * r * r * r;\n    \
                 return x <= 0.04045 ? x / 12.92 : s * (r - (r * d - s) / (5.0 * d));\n}}\n\n"
            ),
        }
    }
}

struct Writer<'w> {
    name: &'w str,
    color: &'static str,
    called: BTreeSet<Function>,
    statements: Vec<String>,
}

impl Writer<'_> {
    fn let_float(&mut self, name: String, value: &str) -> String {
        self.statements.push(format!("float {name} = {value};"));
        name
    }

    fn let_color(&mut self, at: usize, value: &str) -> String {
        let name = format!("c{at}");
        self.statements.push(format!("{} {name} = {value};", self.color));
        name
    }

    fn call(&mut self, function: Function, arguments: &[&str]) -> String {
        self.called.insert(function);
        format!("{}_{}({})", self.name, function.ending(), arguments.join(", "))
    }
}

impl Target for Writer<'_> {
    type Ref = String;

    fn number(&mut self, value: f32) -> String {
        literal(value)
    }

    fn color(&mut self, color: [f32; 3]) -> String {
        format!("{}({})", self.color, color.map(literal).join(", "))
    }

    fn input(&mut self, parameter: &Parameter) -> String {
        parameter.identifier.clone()
    }

    fn mask(&mut self, at: usize, parameter: &Parameter) -> String {
        let call = self.call(Function::Mask, &[&parameter.identifier]);
        self.let_float(format!("t{at}"), &call)
    }

    fn ramp(&mut self, at: usize, x: &String, scale: f32, low: f32, high: f32) -> String {
        let x = if scale == 1.0 { x.clone() } else { format!("{} * {x}", literal(scale)) };
        let call = self.call(Function::Ramp, &[&x, &literal(low), &literal(high)]);
        self.let_float(format!("t{at}"), &call)
    }

    fn step(&mut self, at: usize, x: &String, threshold: f32) -> String {
        self.let_float(format!("t{at}"), &format!("{x} >= {} ? 1.0 : 0.0", literal(threshold)))
    }

    fn smooth(&mut self, at: usize, t: &String) -> String {
        let call = self.call(Function::Smooth, &[t]);
        self.let_float(format!("t{at}"), &call)
    }

    fn power(&mut self, at: usize, t: &String, power: Power) -> String {
        let mut last = t.clone();
        let mut two = 1;
        while two < power.highest() {
            two *= 2;
            last = self.let_float(format!("q{at}_{two}"), &format!("{last} * {last}"));
        }
        let factor = |two: u32| if two == 1 { t.clone() } else { format!("q{at}_{two}") };
        let mut factors: Vec<String> = power.twos().map(factor).collect();
        // Roots are exact in every program, and `pow` is not.
        let (roots, left) = power.roots();
        let mut last = t.clone();
        for depth in 1..=roots.last().copied().unwrap_or_default() {
            last = self.let_float(format!("r{at}_{depth}"), &format!("sqrt({last})"));
        }
        factors.extend(roots.iter().map(|depth| format!("r{at}_{depth}")));
        if left > 0.0 {
            factors.push(format!("({t} > 0.0 ? pow({t}, {}) : 0.0)", literal(left)));
        }
        self.let_float(format!("t{at}"), &format!("min({}, {t})", factors.join(" * ")))
    }

    fn complement(&mut self, at: usize, t: &String) -> String {
        self.let_float(format!("t{at}"), &format!("1.0 - {t}"))
    }

    fn product(&mut self, at: usize, t: &String, u: &String) -> String {
        self.let_float(format!("t{at}"), &format!("{t} * {u}"))
    }

    fn partition(&mut self, at: usize, weights: &[String]) -> Vec<String> {
        let sum = self.let_float(format!("s{at}"), &sum(weights));
        let equal = literal((1.0 / weights.len() as f64) as f32);
        let part = |(i, weight): (usize, &String)| {
            self.let_float(format!("w{at}_{i}"), &format!("{sum} > 0.0 ? {weight} / {sum} : {equal}"))
        };
        weights.iter().enumerate().map(part).collect()
    }

    fn normalize(&mut self, at: usize, values: &[String], scale: f32, floor: f32) -> Vec<String> {
        let shares: Vec<String> =
            values.iter().map(|value| self.call(Function::Share, &[value, &literal(scale)])).collect();
        let named = shares.iter().enumerate().map(|(i, share)| self.let_float(format!("q{at}_{i}"), share));
        let shares: Vec<String> = named.collect();
        let sum = self.let_float(format!("s{at}"), &sum(&shares));
        let divisor = self.let_float(format!("d{at}"), &format!("max({sum}, {})", literal(floor)));
        let parts = shares.iter().map(|share| format!("{share} / {divisor}"));
        let parts: Vec<String> = parts.chain([format!("({divisor} - {sum}) / {divisor}")]).collect();
        parts.iter().enumerate().map(|(i, part)| self.let_float(format!("w{at}_{i}"), part)).collect()
    }

    fn mix(&mut self, at: usize, a: &String, b: &String, t: &String) -> String {
        let call = self.call(Function::Mix, &[a, b, t]);
        self.let_color(at, &call)
    }

    fn blend(&mut self, at: usize, colors: &[String], weights: &[String]) -> String {
        let terms: Vec<String> =
            weights.iter().zip(colors).map(|(weight, color)| format!("{weight} * {color}")).collect();
        self.let_color(at, &sum(&terms))
    }

    fn decode(&mut self, color: &String) -> String {
        self.statements.push(format!("{} encoded = {color};", self.color));
        let channels = [0, 1, 2].map(|channel| self.call(Function::Decode, &[&format!("encoded[{channel}]")]));
        format!("{}({})", self.color, channels.join(", "))
    }
}

/// Adds terms up, a few on a line.
fn sum(terms: &[String]) -> String {
    let lines: Vec<String> = terms.chunks(8).map(|line| line.join(" + ")).collect();
    lines.join("\n        + ")
}

/// Writes lines as comments.
pub(crate) fn comment(text: &mut String, lines: &[String]) {
    for line in lines {
        let _ = writeln!(text, "// {line}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_input_takes_the_name_of_a_function() {
        let all = [Function::Mask, Function::Ramp, Function::Smooth, Function::Share, Function::Mix, Function::Decode];
        assert_eq!(all.map(Function::ending), crate::names::FUNCTIONS);
        for function in all {
            let text = function.text("look", "vec3");
            assert!(text.contains(&format!(" look_{}(", function.ending())) && text.ends_with("}\n\n"), "{text}");
        }
    }
}
