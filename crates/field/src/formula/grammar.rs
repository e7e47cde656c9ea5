//! Grammar of formulas, and their parser.
//!
//! ```text
//! comparison = sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
//! sum        = product { ("+" | "-") product }
//! product    = power { ("*" | "/") power }
//! power      = "-" power | part [ "^" power ]
//! part       = atom { "." letters }
//! atom       = number | name | name "(" list ")" | "[" list "]" | "(" comparison ")"
//! ```
//! The parser is our own: other crates compute with the machine's functions, whose last bits differ between machines, or
//! lack vectors.

use super::typing::{each, join};
use super::{Expected, Expression, Fault, Found, Function, MAX_DEPTH, MAX_LENGTH, MAX_WIDTH, Tree};

/// Parses a formula. `inputs` gives the numbers of components of the inputs a, b, c and d; `None` if unconnected.
///
/// # Errors
/// The text is not a formula, or combines values whose numbers of components do not fit.
pub fn parse(text: &str, inputs: [Option<usize>; 4]) -> Result<Expression, Fault> {
    parse_names(text, Names::Letters(inputs))
}

/// Parses a formula of named values, such as `hull.x + 2*sin(time)`. `names` are the names, which may have dots, and the
/// numbers of components of their values; their indices are those of the inputs of [`Expression::value`].
///
/// # Errors
/// Same as [`parse`].
pub fn parse_named(text: &str, names: &[(String, usize)]) -> Result<Expression, Fault> {
    parse_names(text, Names::Named(names))
}

fn parse_names(text: &str, names: Names<'_>) -> Result<Expression, Fault> {
    let characters: Vec<char> = text.chars().collect();
    if characters.len() > MAX_LENGTH {
        let (found, expected) = (Found::Length(characters.len()), Expected::Length);
        return Err(Fault { column: MAX_LENGTH + 1, found, expected, remedy: None });
    }
    let mut parser = Parser { text: characters, at: 0, depth: 0, names };
    let expression = parser.comparison()?;
    parser.space();
    match parser.text.get(parser.at) {
        None => Ok(expression),
        Some(_) => Err(parser.fault(Expected::Operator)),
    }
}

/// Names of the values that a formula has.
pub(super) enum Names<'n> {
    /// Inputs a, b, c and d, with their numbers of components; `None` if unconnected.
    Letters([Option<usize>; 4]),
    /// Names with their numbers of components.
    Named(&'n [(String, usize)]),
}

pub(super) struct Parser<'n> {
    text: Vec<char>,
    pub(super) at: usize,
    depth: usize,
    pub(super) names: Names<'n>,
}

pub(super) type Parsed = Result<Expression, Fault>;

impl Parser<'_> {
    fn space(&mut self) {
        while self.text.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
    }

    /// Makes the error that the character here is not what was expected.
    pub(super) fn fault(&mut self, expected: Expected) -> Fault {
        self.space();
        fault_at(self.at, self.text.get(self.at).map_or(Found::End, |c| Found::Character(*c)), expected)
    }

    /// Consumes this character if it is next.
    fn take(&mut self, sign: &str) -> bool {
        self.space();
        let here = sign.chars().enumerate().all(|(i, c)| self.text.get(self.at + i) == Some(&c));
        self.at += if here { sign.len() } else { 0 };
        here
    }

    fn expect(&mut self, sign: &'static str) -> Result<(), Fault> {
        if self.take(sign) { Ok(()) } else { Err(self.fault(Expected::Sign(sign))) }
    }

    /// Enters a level of nesting.
    fn nested(&mut self, rule: impl FnOnce(&mut Self) -> Parsed) -> Parsed {
        if self.depth == MAX_DEPTH {
            return Err(fault_at(self.at, Found::TooDeep, Expected::FewerLevels));
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
                each(at, function, vec![left, right])
            }
            None => Ok(left),
        }
    }

    /// Parses operators of equal precedence, left to right.
    fn row(&mut self, signs: [(&str, Function); 2], operand: fn(&mut Self) -> Parsed) -> Parsed {
        let mut left = operand(self)?;
        loop {
            self.space();
            let at = self.at;
            let Some((_, function)) = signs.into_iter().find(|(sign, _)| self.take(sign)) else { return Ok(left) };
            let right = operand(self)?;
            left = each(at, function, vec![left, right])?;
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
            return each(at, Function::Negate, vec![operand]);
        }
        let base = self.part()?;
        self.space();
        let at = self.at;
        if !self.take("^") {
            return Ok(base);
        }
        let exponent = self.nested(Self::power)?;
        each(at, Function::Power, vec![base, exponent])
    }

    fn part(&mut self) -> Parsed {
        let mut value = self.nested(Self::atom)?;
        while self.take(".") {
            let at = self.at;
            let letters = self.word();
            let picked: Option<Vec<usize>> = letters.chars().map(|c| "xyzw".find(c)).collect();
            value = match picked {
                Some(picked)
                    if (1..=MAX_WIDTH).contains(&picked.len()) && picked.iter().all(|index| *index < value.width) =>
                {
                    let text = value.text.start..self.at;
                    Expression { width: picked.len(), tree: Tree::Pick(Box::new(value), picked), text }
                }
                _ => {
                    let found = Found::Letters(letters, value.width);
                    return Err(fault_at(at, found, Expected::Letters(value.width)));
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

    /// Reads on to the end of the longest known name that begins with a word.
    fn with_parts(&mut self, word: String) -> String {
        let Names::Named(known) = self.names else { return word };
        let rest = |name: &str| -> Option<usize> {
            let rest: Vec<char> = name.strip_prefix(&word)?.chars().collect();
            let follows = self.text[self.at..].starts_with(&rest);
            let ends = |next: Option<&char>| !next.is_some_and(|c| c.is_ascii_alphanumeric() || *c == '_');
            (follows && ends(self.text.get(self.at + rest.len()))).then_some(rest.len())
        };
        let Some((name, length)) =
            known.iter().filter_map(|(name, _)| Some((name, rest(name)?))).max_by_key(|(_, length)| *length)
        else {
            return word;
        };
        self.at += length;
        name.clone()
    }

    fn atom(&mut self) -> Parsed {
        self.space();
        let at = self.at;
        if self.take("(") {
            let value = self.comparison()?;
            self.expect(")")?;
            return Ok(Expression { text: at..self.at, ..value });
        }
        if self.take("[") {
            let values = self.list("]")?;
            return join(at..self.at, values);
        }
        match self.text.get(at) {
            Some(c) if c.is_ascii_digit() || *c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() || *c == '_' => {
                let name = self.word();
                if self.take("(") {
                    return self.call(at, &name);
                }
                let name = self.with_parts(name);
                self.name(at, &name)
            }
            _ => Err(self.fault(Expected::Value)),
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
            Ok(number) if number.is_finite() => {
                Ok(Expression { tree: Tree::Number(number), width: 1, text: start..self.at })
            }
            _ => Err(fault_at(start, Found::Number(text), Expected::FiniteNumber)),
        }
    }

    /// Parses values up to a closing bracket.
    pub(super) fn list(&mut self, close: &'static str) -> Result<Vec<Expression>, Fault> {
        let mut values = vec![self.comparison()?];
        while self.take(",") {
            values.push(self.comparison()?);
        }
        if self.take(close) { Ok(values) } else { Err(self.fault(Expected::CommaOr(close))) }
    }
}

/// Makes an error without a remedy.
pub(super) fn fault_at(at: usize, found: Found, expected: Expected) -> Fault {
    Fault { column: at + 1, found, expected, remedy: None }
}
