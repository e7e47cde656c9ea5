//! Formulas of `FieldMath`, as far as the tests draw them: + − * /, signs, components, lists, and some functions.

/// Returns the value of a formula of the inputs a, b, c and d.
pub(super) fn value(text: &str, inputs: &[Vec<f64>; 4]) -> Vec<f64> {
    let mut reader = Reader { rest: text.as_bytes(), inputs };
    let value = reader.sum();
    assert!(reader.rest.iter().all(u8::is_ascii_whitespace), "{text}");
    value
}

struct Reader<'a> {
    rest: &'a [u8],
    inputs: &'a [Vec<f64>; 4],
}

/// Combines component by component; an operand of one component goes with each of the other.
fn each(a: &[f64], b: &[f64], of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let pick = |all: &[f64], index: usize| if all.len() == 1 { all[0] } else { all[index] };
    (0..a.len().max(b.len())).map(|index| of(pick(a, index), pick(b, index))).collect()
}

impl Reader<'_> {
    fn peek(&mut self) -> u8 {
        self.rest = self.rest.trim_ascii_start();
        self.rest.first().copied().unwrap_or(0)
    }

    fn takes(&mut self, sign: u8) -> bool {
        let found = self.peek() == sign;
        self.rest = &self.rest[usize::from(found)..];
        found
    }

    fn word(&mut self, belongs: impl Fn(u8) -> bool) -> String {
        self.peek();
        let end = self.rest.iter().position(|byte| !belongs(*byte)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        String::from_utf8(word.to_vec()).unwrap()
    }

    fn sum(&mut self) -> Vec<f64> {
        let mut left = self.product();
        loop {
            if self.takes(b'+') {
                left = each(&left, &self.product(), |a, b| a + b);
            } else if self.takes(b'-') {
                left = each(&left, &self.product(), |a, b| a - b);
            } else {
                return left;
            }
        }
    }

    fn product(&mut self) -> Vec<f64> {
        let mut left = self.factor();
        loop {
            if self.takes(b'*') {
                left = each(&left, &self.factor(), |a, b| a * b);
            } else if self.takes(b'/') {
                left = each(&left, &self.factor(), |a, b| a / b);
            } else {
                return left;
            }
        }
    }

    fn factor(&mut self) -> Vec<f64> {
        let first = self.peek();
        if self.takes(b'-') {
            return self.factor().iter().map(|x| -x).collect();
        }
        if self.takes(b'(') {
            let value = self.sum();
            assert!(self.takes(b')'));
            return value;
        }
        if self.takes(b'[') {
            return self.list(b']').concat();
        }
        if first.is_ascii_digit() {
            return vec![self.word(|byte| byte.is_ascii_digit() || byte == b'.').parse().unwrap()];
        }
        let word = self.word(|byte| byte.is_ascii_alphabetic());
        if let Some(input) = ["a", "b", "c", "d"].iter().position(|name| *name == word) {
            if !self.takes(b'.') {
                return self.inputs[input].clone();
            }
            let components = self.word(|byte| byte.is_ascii_alphabetic());
            return components.bytes().map(|name| self.inputs[input][usize::from(name - b'x')]).collect();
        }
        if word == "pi" {
            return vec![std::f64::consts::PI];
        }
        assert!(self.takes(b'('), "{word}");
        let arguments = self.list(b')');
        let of = |f: fn(f64) -> f64| arguments[0].iter().map(|x| f(*x)).collect();
        match word.as_str() {
            "sin" => of(f64::sin),
            "cos" => of(f64::cos),
            "abs" => of(f64::abs),
            "sqrt" => of(f64::sqrt),
            "min" => each(&arguments[0], &arguments[1], f64::min),
            "max" => each(&arguments[0], &arguments[1], f64::max),
            other => panic!("the evaluator does not know {other}"),
        }
    }

    fn list(&mut self, end: u8) -> Vec<Vec<f64>> {
        let mut items = vec![self.sum()];
        while self.takes(b',') {
            items.push(self.sum());
        }
        assert!(self.takes(end));
        items
    }
}
