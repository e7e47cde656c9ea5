//! What GLSL, OSL and WGSL have in common: statements and functions, which differ in how few things are written.

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

/// What the languages write differently.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Syntax {
    /// Type of numbers.
    pub(crate) number: &'static str,
    /// Type of colors.
    pub(crate) color: &'static str,
    /// Whether types stand after names, and a choice is a call: WGSL.
    pub(crate) is_wgsl: bool,
}

impl Syntax {
    /// Writes the definition of a value.
    fn define(self, ty: &str, name: &str, value: &str) -> String {
        if self.is_wgsl { format!("let {name} = {value};") } else { format!("{ty} {name} = {value};") }
    }

    /// Writes the choice between two values.
    fn choose(self, condition: &str, then: &str, otherwise: &str) -> String {
        match self.is_wgsl {
            true => format!("select({otherwise}, {then}, {condition})"),
            false => format!("{condition} ? {then} : {otherwise}"),
        }
    }

    /// Writes the head of a function; `parameters` are types and names.
    pub(crate) fn head(self, returned: &str, name: &str, parameters: &[(&str, &str)]) -> String {
        let one = |(ty, name): &(&str, &str)| match self.is_wgsl {
            true => format!("{name}: {ty}"),
            false => format!("{ty} {name}"),
        };
        let parameters = parameters.iter().map(one).collect::<Vec<_>>().join(", ");
        match self.is_wgsl {
            true => format!("fn {name}({parameters}) -> {returned}"),
            false => format!("{returned} {name}({parameters})"),
        }
    }
}

/// Translates a program.
pub(crate) fn code(job: &Job<'_>, syntax: Syntax) -> Code {
    let mut writer = Writer { name: job.name, syntax, called: BTreeSet::new(), statements: Vec::new() };
    let results = translate(job, &mut writer);
    let functions = writer.called.iter().map(|function| function.text(job.name, syntax)).collect();
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
    fn text(self, name: &str, syntax: Syntax) -> String {
        let name = format!("{name}_{}", self.ending());
        let Syntax { number, color, .. } = syntax;
        let of = |names: &[&'static str]| names.iter().map(|name| (number, *name)).collect::<Vec<_>>();
        let (returned, parameters, body) = match self {
            Self::Mask => (number, of(&["t"]), vec![syntax.choose("t > 0.0", "min(t, 1.0)", "0.0")]),
            Self::Ramp => {
                let rising = syntax.choose("x >= low", "min((x - low) / (high - low), 1.0)", "0.0");
                let ramp = syntax.choose("x >= high", "1.0", &format!("({rising})"));
                (number, of(&["x", "low", "high"]), vec![ramp])
            }
            Self::Smooth => (number, of(&["t"]), vec!["min(t * t * (3.0 - 2.0 * t), 1.0)".into()]),
            Self::Share => {
                let share = format!("min(v, {}) * scale", literal(f32::MAX));
                (number, of(&["v", "scale"]), vec![syntax.choose("v > 0.0", &share, "0.0")])
            }
            // From the nearer end, which is exact at both ends and where both colors are the same.
            Self::Mix => {
                let mix = syntax.choose("t < 0.5", "a + t * (b - a)", "b + (t - 1.0) * (b - a)");
                (color, vec![(color, "a"), (color, "b"), (number, "t")], vec![mix])
            }
            // IEC 61966-2-1. The power of 2.4 is a square and the fifth root of one; a step of Newton's makes exact what `pow`
            // leaves inexact.
            Self::Decode => {
                let power = "s * (r - (r * d - s) / (5.0 * d))";
                let body = vec![
                    syntax.define(number, "q", "(min(max(x, 0.04), 1e16) + 0.055) / 1.055"),
                    syntax.define(number, "s", "q * q"),
                    syntax.define(number, "r", "pow(s, 0.2)"),
                    syntax.define(number, "d", "r * r * r * r"),
                    syntax.choose("x <= 0.04045", "x / 12.92", power),
                ];
                (number, of(&["x"]), body)
            }
        };
        let mut text = format!("{}\n{{\n", syntax.head(returned, &name, &parameters));
        let (last, before) = body.split_last().map_or(("", &[][..]), |(last, before)| (last.as_str(), before));
        before.iter().for_each(|line| _ = writeln!(text, "    {line}"));
        let _ = write!(text, "    return {last};\n}}\n\n");
        text
    }
}

struct Writer<'w> {
    name: &'w str,
    syntax: Syntax,
    called: BTreeSet<Function>,
    statements: Vec<String>,
}

impl Writer<'_> {
    fn let_float(&mut self, name: String, value: &str) -> String {
        self.statements.push(self.syntax.define(self.syntax.number, &name, value));
        name
    }

    fn let_color(&mut self, at: usize, value: &str) -> String {
        let name = format!("c{at}");
        self.statements.push(self.syntax.define(self.syntax.color, &name, value));
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
        format!("{}({})", self.syntax.color, color.map(literal).join(", "))
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
        let step = self.syntax.choose(&format!("{x} >= {}", literal(threshold)), "1.0", "0.0");
        self.let_float(format!("t{at}"), &step)
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
            let power = format!("pow({t}, {})", literal(left));
            factors.push(format!("({})", self.syntax.choose(&format!("{t} > 0.0"), &power, "0.0")));
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
            let part = self.syntax.choose(&format!("{sum} > 0.0"), &format!("{weight} / {sum}"), &equal);
            self.let_float(format!("w{at}_{i}"), &part)
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
        self.statements.push(self.syntax.define(self.syntax.color, "encoded", color));
        let channels = [0, 1, 2].map(|channel| self.call(Function::Decode, &[&format!("encoded[{channel}]")]));
        format!("{}({})", self.syntax.color, channels.join(", "))
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
            let text = function.text("look", crate::glsl::SYNTAX);
            assert!(text.contains(&format!(" look_{}(", function.ending())) && text.ends_with("}\n\n"), "{text}");
        }
    }
}
