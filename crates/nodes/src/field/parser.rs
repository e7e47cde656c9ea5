//! Parser of FieldMath's formulas: the grammar, and checks of the numbers of components.
//!
//! ```text
//! comparison = sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
//! sum        = product { ("+" | "-") product }
//! product    = power { ("*" | "/") power }
//! power      = "-" power | part [ "^" power ]
//! part       = atom { "." letters }
//! atom       = number | name | name "(" list ")" | "[" list "]" | "(" comparison ")"
//! ```
//! No existing crate fits: they compute with the machine's math functions, whose bits differ between machines, or have
//! no vectors.

use super::expression::{Expression, Node};
use super::program::Function;
use trochoid_graph::nearest;

/// A syntax or type error and its column, in characters, counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) column: usize,
    pub(crate) found: String,
    pub(crate) expected: String,
    /// Remedy, if one is known.
    pub(crate) remedy: Option<String>,
}

impl Fault {
    fn with_remedy(self, remedy: String) -> Self {
        Self { remedy: Some(remedy), ..self }
    }
}

/// Largest nesting depth: more than anyone writes, and safe for the stack.
const DEPTH: usize = 64;
/// Largest number of characters: more than anyone writes; it also bounds the depth of chains of operators.
const LENGTH: usize = 1000;
/// Largest number of components of a value.
pub(crate) const WIDEST: usize = 4;

/// Parses an expression. `inputs` has the number of components of each connected input.
pub(crate) fn parse(text: &str, inputs: [Option<usize>; 4]) -> Result<Expression, Fault> {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() > LENGTH {
        let expected = format!("at most {LENGTH} characters");
        return Err(Fault {
            column: LENGTH + 1,
            found: format!("{} characters", characters.len()),
            expected,
            remedy: None,
        });
    }
    let mut parser = Parser { text: characters, at: 0, depth: 0, inputs };
    let expression = parser.comparison()?;
    parser.space();
    match parser.text.get(parser.at) {
        None => Ok(expression),
        Some(_) => Err(parser.fault("an operator or the end")),
    }
}

struct Parser {
    text: Vec<char>,
    at: usize,
    depth: usize,
    inputs: [Option<usize>; 4],
}

type Parsed = Result<Expression, Fault>;

impl Parser {
    fn space(&mut self) {
        while self.text.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
    }

    /// Returns the error that something else was expected here.
    fn fault(&mut self, expected: &str) -> Fault {
        self.space();
        let found = match self.text.get(self.at) {
            Some(c) => format!("'{c}'"),
            None => "the end".into(),
        };
        self.fault_at(self.at, found, expected)
    }

    fn fault_at(&self, at: usize, found: impl Into<String>, expected: impl Into<String>) -> Fault {
        Fault { column: at + 1, found: found.into(), expected: expected.into(), remedy: None }
    }

    /// Skips a sign and returns true, if it stands here.
    fn take(&mut self, sign: &str) -> bool {
        self.space();
        let here = sign.chars().enumerate().all(|(i, c)| self.text.get(self.at + i) == Some(&c));
        self.at += if here { sign.len() } else { 0 };
        here
    }

    fn expect(&mut self, sign: &str) -> Result<(), Fault> {
        if self.take(sign) { Ok(()) } else { Err(self.fault(&format!("'{sign}'"))) }
    }

    /// Applies a rule one level deeper; fails if that is too deep.
    fn nested(&mut self, rule: impl FnOnce(&mut Self) -> Parsed) -> Parsed {
        if self.depth == DEPTH {
            return Err(self.fault_at(self.at, format!("more than {DEPTH} levels"), "fewer levels of brackets"));
        }
        self.depth += 1;
        let result = rule(self);
        self.depth -= 1;
        result
    }

    fn comparison(&mut self) -> Parsed {
        let left = self.sum()?;
        self.space();
        let at = self.at;
        let signs = [
            ("<=", Function::LessOrEqual),
            (">=", Function::GreaterOrEqual),
            ("==", Function::Equal),
            ("!=", Function::Unequal),
            ("<", Function::Less),
            (">", Function::Greater),
        ];
        match signs.into_iter().find(|(sign, _)| self.take(sign)) {
            Some((_, function)) => {
                let right = self.sum()?;
                self.each(at, function, vec![left, right])
            }
            None => Ok(left),
        }
    }

    /// Parses operators of equal precedence, which are left-associative.
    fn row(&mut self, signs: [(&str, Function); 2], operand: fn(&mut Self) -> Parsed) -> Parsed {
        let mut left = operand(self)?;
        loop {
            self.space();
            let at = self.at;
            let Some((_, function)) = signs.into_iter().find(|(sign, _)| self.take(sign)) else { return Ok(left) };
            let right = operand(self)?;
            left = self.each(at, function, vec![left, right])?;
        }
    }

    fn sum(&mut self) -> Parsed {
        self.row([("+", Function::Add), ("-", Function::Subtract)], Self::product)
    }

    fn product(&mut self) -> Parsed {
        self.row([("*", Function::Multiply), ("/", Function::Divide)], Self::power)
    }

    fn power(&mut self) -> Parsed {
        self.space();
        let at = self.at;
        if self.take("-") {
            let operand = self.nested(Self::power)?;
            return self.each(at, Function::Negate, vec![operand]);
        }
        let base = self.part()?;
        self.space();
        let at = self.at;
        if !self.take("^") {
            return Ok(base);
        }
        let exponent = self.nested(Self::power)?;
        self.each(at, Function::Power, vec![base, exponent])
    }

    fn part(&mut self) -> Parsed {
        let mut value = self.nested(Self::atom)?;
        while self.take(".") {
            let at = self.at;
            let letters = self.word();
            let picked: Option<Vec<usize>> = letters.chars().map(|c| "xyzw".find(c)).collect();
            value = match picked {
                Some(picked)
                    if (1..=WIDEST).contains(&picked.len()) && picked.iter().all(|index| *index < value.width) =>
                {
                    Expression { width: picked.len(), node: Node::Pick(Box::new(value), picked) }
                }
                _ => {
                    let expected = format!("1 to 4 of the letters {}", &"xyzw"[..value.width.min(WIDEST)]);
                    return Err(self.fault_at(at, format!("\".{letters}\" of {}", components(value.width)), expected));
                }
            };
        }
        Ok(value)
    }

    fn word(&mut self) -> String {
        let start = self.at;
        while self.text.get(self.at).is_some_and(|c| c.is_ascii_alphanumeric() || *c == '_') {
            self.at += 1;
        }
        self.text[start..self.at].iter().collect()
    }

    fn atom(&mut self) -> Parsed {
        self.space();
        let at = self.at;
        if self.take("(") {
            let value = self.comparison()?;
            self.expect(")")?;
            return Ok(value);
        }
        if self.take("[") {
            let values = self.list("]")?;
            return self.join(at, values);
        }
        match self.text.get(at) {
            Some(c) if c.is_ascii_digit() || *c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => {
                let name = self.word();
                if self.take("(") { self.call(at, &name) } else { self.name(at, &name) }
            }
            _ => Err(self.fault("a number, an input, a function or '('")),
        }
    }

    fn number(&mut self) -> Parsed {
        let start = self.at;
        let digits = |parser: &mut Self| {
            while parser.text.get(parser.at).is_some_and(char::is_ascii_digit) {
                parser.at += 1;
            }
        };
        digits(self);
        if self.text.get(self.at) == Some(&'.') && self.text.get(self.at + 1).is_some_and(char::is_ascii_digit) {
            self.at += 1;
            digits(self);
        }
        if matches!(self.text.get(self.at), Some('e' | 'E')) {
            let sign = usize::from(matches!(self.text.get(self.at + 1), Some('+' | '-')));
            if self.text.get(self.at + 1 + sign).is_some_and(char::is_ascii_digit) {
                self.at += 1 + sign;
                digits(self);
            }
        }
        let text: String = self.text[start..self.at].iter().collect();
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Expression { node: Node::Number(number), width: 1 }),
            _ => Err(self.fault_at(start, format!("'{text}'"), "a finite number, such as 0.5 or 2e3")),
        }
    }

    fn name(&mut self, at: usize, name: &str) -> Parsed {
        if name == "pi" {
            return Ok(Expression { node: Node::Number(std::f64::consts::PI), width: 1 });
        }
        match ["a", "b", "c", "d"].iter().position(|input| *input == name) {
            Some(index) => match self.inputs[index] {
                Some(width) => Ok(Expression { node: Node::Input(index), width }),
                None => {
                    let fault = self.fault_at(at, format!("the unconnected input {name}"), "a connected input");
                    Err(fault.with_remedy(format!("connect \"{name}\", or leave it out of the expression")))
                }
            },
            None if Function::named(name).is_some() || matches!(name, "dot" | "length") => {
                self.at = at + name.len();
                Err(self.fault(&format!("'(' after {name}")))
            }
            None => {
                let fault = self.fault_at(at, format!("\"{name}\""), "an input a, b, c or d, pi, or a function");
                Err(fault
                    .with_remedy("connect the Field to \"a\", \"b\", \"c\" or \"d\", and write that letter".into()))
            }
        }
    }

    /// Parses a list of values up to a closing bracket.
    fn list(&mut self, close: &str) -> Result<Vec<Expression>, Fault> {
        let mut values = vec![self.comparison()?];
        while self.take(",") {
            values.push(self.comparison()?);
        }
        if self.take(close) { Ok(values) } else { Err(self.fault(&format!("',' or '{close}'"))) }
    }

    fn join(&self, at: usize, values: Vec<Expression>) -> Parsed {
        let width = values.iter().map(|value| value.width).sum();
        if width > WIDEST {
            return Err(self.fault_at(at, components(width), "at most 4 components"));
        }
        Ok(Expression { node: Node::Join(values), width })
    }

    fn call(&mut self, at: usize, name: &str) -> Parsed {
        let arguments = self.list(")")?;
        let function = Function::named(name);
        let (least, most) = match (name, function) {
            ("dot", _) => (2, 2),
            ("length", _) => (1, 1),
            (_, Some(function)) => function.arguments(),
            _ => {
                let expected = format!("a function: {}, dot or length", Function::names().join(", "));
                let fault = self.fault_at(at, format!("\"{name}\""), expected);
                let names = Function::names().into_iter().chain(["dot", "length"]);
                return Err(match nearest(name, names) {
                    Some(near) => fault.with_remedy(format!("did you mean \"{near}\"?")),
                    None => fault,
                });
            }
        };
        if !(least..=most).contains(&arguments.len()) {
            let expected = if least == most { format!("{least}") } else { format!("{least} or more") };
            let found = format!("{} arguments of {name}", arguments.len());
            return Err(self.fault_at(at, found, expected));
        }
        match function {
            Some(function) => self.each(at, function, arguments),
            None if name == "dot" => {
                let mut arguments = arguments.into_iter();
                match (arguments.next(), arguments.next()) {
                    (Some(a), Some(b)) if a.width == b.width => {
                        Ok(Expression { node: Node::Dot(Box::new(a), Box::new(b)), width: 1 })
                    }
                    (Some(a), Some(b)) => Err(self.unlike(at, a.width, b.width)),
                    _ => unreachable!("two arguments were counted"),
                }
            }
            None => {
                let argument = arguments.into_iter().next();
                Ok(Expression { node: argument.map_or(Node::Number(0.0), |a| Node::Length(Box::new(a))), width: 1 })
            }
        }
    }

    fn unlike(&self, at: usize, a: usize, b: usize) -> Fault {
        let found = format!("{} combined with {}", components(a), components(b));
        self.fault_at(at, found, "the same number of components, or a single number")
    }

    /// Applies a function component by component.
    fn each(&self, at: usize, function: Function, arguments: Vec<Expression>) -> Parsed {
        let width = arguments.iter().map(|argument| argument.width).max().unwrap_or(1);
        match arguments.iter().find(|argument| argument.width != 1 && argument.width != width) {
            Some(other) => Err(self.unlike(at, width, other.width)),
            None => Ok(Expression { node: Node::Each(function, arguments), width }),
        }
    }
}

/// Describes a number of components.
fn components(count: usize) -> String {
    if count == 1 { "a single number".into() } else { format!("{count} components") }
}

#[cfg(test)]
mod tests {
    use super::super::Program;
    use super::*;

    const INPUTS: [Vec<f64>; 4] = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];

    /// Checks that recursion and the program give the same value.
    fn values(text: &str, inputs: [Vec<f64>; 4]) -> Vec<f64> {
        let widths = inputs.each_ref().map(|input| (!input.is_empty()).then_some(input.len()));
        let expression = parse(text, widths).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        let value = expression.value(&inputs);
        assert_eq!(value.len(), expression.width, "{text}");
        let mut found = vec![Vec::new(); value.len()];
        let load = |_: usize, input: usize, component: usize, out: &mut [f64]| out.fill(inputs[input][component]);
        Program::new(&expression).run(70, load, |first, component, values| {
            assert_eq!(found[component].len(), first);
            found[component].extend_from_slice(values);
        });
        for (found, value) in found.iter().zip(&value) {
            assert_eq!(found.len(), 70);
            for found in found {
                assert!(found == value || (found.is_nan() && value.is_nan()), "{text}: {found}, expected {value}");
            }
        }
        value
    }

    fn number(text: &str) -> f64 {
        values(text, INPUTS)[0]
    }

    #[test]
    fn operators_bind_as_in_mathematics() {
        for (text, value) in [
            ("1 + 2*3", 7.0),
            ("(1 + 2)*3", 9.0),
            ("8/4/2", 1.0),
            ("1 - 2 - 3", -4.0),
            ("2^3^2", 512.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("--3", 3.0),
            ("2*-3", -6.0),
            ("1.5e1", 15.0),
            (".5", 0.5),
            ("1 < 2", 1.0),
            ("1 + 1 >= 3", 0.0),
            ("2 == 2", 1.0),
            ("2 != 2", 0.0),
            ("min(3, 2) + max(3, 2)", 5.0),
            ("clamp(7, 0, 1)", 1.0),
            ("abs(-3) + floor(-1.5) + ceil(1.2) + sign(-9)", 2.0),
            ("fract(-0.25)", 0.75),
            ("mod(-1, 3)", 2.0),
            ("sqrt(16) + exp(0) + log(1)", 5.0),
            ("sin(0) + cos(0) + atan2(0, 1)", 1.0),
            ("smoothstep(0, 2, 1)", 0.5),
            ("mix(10, 20, 0.25)", 12.5),
            ("if(2 > 1, 5, 6)", 5.0),
            ("dot([1, 2, 3], [4, 5, 6])", 32.0),
            ("length([3, 4])", 5.0),
            ("[1, 2, 3].zx.y", 1.0),
        ] {
            assert_eq!(number(text), value, "{text}");
        }
        assert!(number("0/0").is_nan() && number("sqrt(-1)").is_nan() && number("min(0/0, 1)").is_nan());
        assert_eq!(number("1/0"), f64::INFINITY);
    }

    #[test]
    fn numbers_go_with_each_component() {
        let inputs = [vec![1.0, 2.0, 3.0], vec![10.0], vec![0.5, 0.25], vec![7.0]];
        assert_eq!(values("a*b + 1", inputs.clone()), [11.0, 21.0, 31.0]);
        assert_eq!(values("[c, a.z, dot(a, a)]", inputs.clone()), [0.5, 0.25, 3.0, 14.0]);
        assert_eq!(values("mix(a.xy, c, 0.5)", inputs.clone()), [0.75, 1.125]);
        assert_eq!(values("a > 1.5", inputs), [0.0, 1.0, 1.0]);
    }

    #[test]
    fn faults_tell_their_place() {
        let widths = [Some(3), Some(2), Some(1), None];
        for (text, column, words) in [
            ("", 1, "found the end"),
            ("1 +", 4, "found the end"),
            ("1 + * 2", 5, "found '*'"),
            ("(1 + 2", 7, "')'"),
            ("1 2", 3, "an operator or the end"),
            ("c < 1 < 2", 7, "an operator or the end"),
            ("foo(1)", 1, "\"foo\""),
            ("sine", 1, "\"sine\""),
            ("sin + 1", 5, "'(' after sin"),
            ("min(1)", 1, "1 arguments of min"),
            ("clamp(1, 2)", 1, "2 arguments of clamp"),
            ("a + b", 3, "3 components combined with 2 components"),
            ("dot(a, b)", 1, "3 components combined with 2 components"),
            ("c + d", 5, "the unconnected input d"),
            ("b.z", 3, "letters xy"),
            ("b.", 3, "\".\""),
            ("[a, b]", 1, "5 components"),
            ("1e999", 1, "a finite number"),
            ("2 + é", 5, "found 'é'"),
            ("1.2.3", 5, "letters x"),
        ] {
            let fault = match parse(text, widths) {
                Err(fault) => fault,
                Ok(expression) => panic!("{text} was read as {expression:?}"),
            };
            let told = format!("found {}; expected {}", fault.found, fault.expected);
            assert!(told.contains(words), "{text}: {told}");
            assert_eq!(fault.column, column, "{text}: {told}");
        }
    }

    #[test]
    fn depth_and_length_are_bounded() {
        let deep = format!("{}1{}", "(".repeat(200), ")".repeat(200));
        assert!(parse(&deep, [None; 4]).is_err());
        assert!(parse(&"-".repeat(900), [None; 4]).is_err());
        assert!(parse(&"1+".repeat(LENGTH), [None; 4]).is_err());
        assert_eq!(number(&format!("0{}", "+1".repeat(499))), 499.0);
    }

    #[test]
    fn no_text_brings_the_parser_down() {
        let pieces =
            ["a", "b", ".x", "(", ")", "[", "]", ",", "+", "-", "*", "^", "<", "min", "dot", "1", "e", ".", " "];
        let mut state = 1u32;
        let mut read = 0;
        for _ in 0..20_000 {
            let mut text = String::new();
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            for _ in 0..1 + (state >> 16) % 7 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                text.push_str(pieces[(state >> 16) as usize % pieces.len()]);
            }
            let _ = parse(&text, [Some(1), Some(24), None, None]);
            if parse(&text, [Some(3), Some(1), None, None]).is_ok() {
                values(&text, [vec![0.5, -2.0, f64::INFINITY], vec![3.0], Vec::new(), Vec::new()]);
                read += 1;
            }
        }
        assert!(read > 200, "{read} texts were expressions");
    }

    #[test]
    fn weights_of_many_classes_have_four_letters() {
        let widths = [Some(24), None, None, None];
        assert_eq!(parse("a.wx", widths).map(|read| read.width), Ok(2));
        let fault = parse("a.b", widths).expect_err("no such letter");
        assert!(fault.expected.contains("letters xyzw"), "{}", fault.expected);
    }
}
