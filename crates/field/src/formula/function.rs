//! Functions of formulas, on single numbers and on runs of them.

/// Number of samples that a loop computes at a time.
pub(super) const WIDE: usize = 8;

macro_rules! functions {
    ($($name:ident $text:literal ($count:literal) $of:expr;)*) => {
        /// Function or operator of numbers.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum Function { $($name,)* }

        impl Function {
            /// All functions.
            pub(super) const ALL: &[Self] = &[$(Self::$name,)*];

            fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// Returns the number of arguments.
            pub(super) fn arguments(self) -> usize {
                match self { $(Self::$name => $count,)* }
            }

            /// Computes the function over a run of samples, whose number is a multiple of [`WIDE`].
            #[inline(always)]
            pub(super) fn fill(self, [a, b, c]: [&[f64]; 3], out: &mut [f64]) {
                match self {
                    $(Self::$name => {
                        let of: fn(f64, f64, f64) -> f64 = $of;
                        let wide = out.as_chunks_mut().0.iter_mut();
                        let wide = wide.zip(a.as_chunks().0).zip(b.as_chunks().0).zip(c.as_chunks().0);
                        for (((out, a), b), c) in wide {
                            let (out, a, b, c): (&mut [f64; WIDE], &[f64; WIDE], &[f64; WIDE], &[f64; WIDE]) =
                                (out, a, b, c);
                            for lane in 0..WIDE {
                                out[lane] = of(a[lane], b[lane], c[lane]);
                            }
                        }
                    })*
                }
            }

            /// Computes the function of single numbers.
            pub(super) fn of(self, arguments: &[f64]) -> f64 {
                let argument = |index: usize| arguments.get(index).copied().unwrap_or(0.0);
                let of: fn(f64, f64, f64) -> f64 = match self { $(Self::$name => $of,)* };
                of(argument(0), argument(1), argument(2))
            }
        }
    };
}

fn truth(holds: bool) -> f64 {
    if holds { 1.0 } else { 0.0 }
}

/// Returns the second of two numbers if `second` says so, else the first; NaN if either is NaN.
fn either(a: f64, b: f64, second: bool) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::NAN
    } else if second {
        b
    } else {
        a
    }
}

fn least(a: f64, b: f64) -> f64 {
    either(a, b, b < a)
}

fn most(a: f64, b: f64) -> f64 {
    either(a, b, b > a)
}

/// Returns t²(3 − 2t), with t the position of x between a and b, clamped to [0, 1].
fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = least(most((x - a) / (b - a), 0.0), 1.0);
    t * t * (3.0 - 2.0 * t)
}

// Names without letters are operators; those of functions are what documents write.
functions! {
    Add "+" (2) |a, b, _| a + b;
    Subtract "-" (2) |a, b, _| a - b;
    Multiply "*" (2) |a, b, _| a * b;
    Divide "/" (2) |a, b, _| a / b;
    Power "^" (2) |a, b, _| libm::pow(a, b);
    Negate "-" (1) |a, _, _| -a;
    Less "<" (2) |a, b, _| truth(a < b);
    LessOrEqual "<=" (2) |a, b, _| truth(a <= b);
    Greater ">" (2) |a, b, _| truth(a > b);
    GreaterOrEqual ">=" (2) |a, b, _| truth(a >= b);
    Equal "==" (2) |a, b, _| truth(a == b);
    Unequal "!=" (2) |a, b, _| truth(a != b);
    Least "min" (2) |a, b, _| least(a, b);
    Most "max" (2) |a, b, _| most(a, b);
    Clamp "clamp" (3) |x, low, high| least(most(x, low), high);
    Abs "abs" (1) |a, _, _| a.abs();
    Sign "sign" (1) |a, _, _| if a.is_nan() { a } else { truth(a > 0.0) - truth(a < 0.0) };
    Floor "floor" (1) |a, _, _| a.floor();
    Ceil "ceil" (1) |a, _, _| a.ceil();
    Fract "fract" (1) |a, _, _| a - a.floor();
    Mod "mod" (2) |a, b, _| a - b * (a / b).floor();
    Sqrt "sqrt" (1) |a, _, _| a.sqrt();
    Exp "exp" (1) |a, _, _| libm::exp(a);
    Log "log" (1) |a, _, _| libm::log(a);
    Sin "sin" (1) |a, _, _| libm::sin(a);
    Cos "cos" (1) |a, _, _| libm::cos(a);
    Atan2 "atan2" (2) |y, x, _| libm::atan2(y, x);
    Smoothstep "smoothstep" (3) |a, b, x| smoothstep(a, b, x);
    Mix "mix" (3) |a, b, t| (1.0 - t) * a + t * b;
    If "if" (3) |condition, a, b| if condition != 0.0 { a } else { b };
}

impl Function {
    /// Looks up the function of a name.
    pub(super) fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|function| function.text() == name)
    }

    /// Returns all names that can be called.
    pub(super) fn names() -> Vec<&'static str> {
        let texts = Self::ALL.iter().map(|function| function.text());
        texts.filter(|text| text.starts_with(|c: char| c.is_ascii_alphabetic())).collect()
    }
}
