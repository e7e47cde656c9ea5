//! Valid and invalid formulas.

use super::{MAX_LENGTH, Program, parse};
use trochoid_graph::Span;

const INPUTS: [Vec<f64>; 4] = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];

/// Returns the value by recursion and by the program.
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
    assert!(parse(&"1+".repeat(MAX_LENGTH), [None; 4]).is_err());
    assert_eq!(number(&format!("0{}", "+1".repeat(499))), 499.0);
}

#[test]
fn no_text_brings_the_parser_down() {
    let pieces = ["a", "b", ".x", "(", ")", "[", "]", ",", "+", "-", "*", "^", "<", "min", "dot", "1", "e", ".", " "];
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
    assert!(fault.expected.to_string().contains("letters xyzw"), "{}", fault.expected);
}

#[test]
fn spans_of_runs_hold_the_values_of_every_sample() {
    const SAMPLES: usize = 150;
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24)
    };
    let texts = [
        "a.x + b*a.y - 3",
        "mix(a.x, b, a.y)",
        "mix(4.7, 9.8, smoothstep(0.2, 0.7, a.y))",
        "a.x/mix(b, 2 + b, 1)",
        "if(a.x < 0.4, 1.4*a.y + 0.03*b, sqrt(2)*0.6)",
        "max(a.x, b) + max(0.2 - abs(a.x - b), 0)*max(0.2 - abs(a.x - b), 0)/0.8",
        "[sin(9*a.x), a.x^2 - a.y^2, floor(5*b)]",
    ];
    for text in texts {
        let expression =
            parse(text, [Some(2), Some(1), None, None]).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        // Some samples are certain.
        let mut around = |middle: f64| match random() {
            size if size < 0.2 => [middle; 2],
            size => [middle - 1e-3 * size, middle + 0.1 * size * random()],
        };
        let inputs: Vec<[[f64; 2]; 3]> = (0..SAMPLES).map(|_| [around(0.5), around(0.3), around(0.8)]).collect();
        let mut spans = vec![Vec::new(); expression.width];
        let load = |first: usize, input: usize, component: usize, run: &mut [Span]| {
            for (span, inputs) in run.iter_mut().zip(&inputs[first..]) {
                let [low, high] = inputs[2 * input + component];
                *span = Span { low, high, clear: true };
            }
        };
        Program::new(&expression).spans(SAMPLES, load, |first, component, run| {
            assert_eq!(spans[component].len(), first);
            spans[component].extend_from_slice(run);
        });
        for (sample, inputs) in inputs.iter().enumerate() {
            for part in [[0.0; 3], [1.0; 3], [random(), random(), random()], [0.0, 1.0, 0.5], [1.0, 0.0, random()]] {
                let [x, y, b]: [f64; 3] =
                    std::array::from_fn(|axis| inputs[axis][0] + (inputs[axis][1] - inputs[axis][0]) * part[axis]);
                let values = expression.value(&[vec![x, y], vec![b], Vec::new(), Vec::new()]);
                for (value, spans) in values.iter().zip(&spans) {
                    let span = spans[sample];
                    assert!(
                        span.holds(*value),
                        "{text} of {x}, {y}, {b} is {value}, beyond {span:?} of sample {sample}"
                    );
                    assert!(span.high - span.low < 2.5, "{text}: {span:?}");
                }
            }
        }
    }
}

/// Returns a formula of a.x, a.y and b.
fn random_formula(random: &mut impl FnMut(usize) -> usize, depth: usize) -> String {
    const LEAVES: [&str; 6] = ["a.x", "a.y", "b", "0", "1", "0.5"];
    const FORMS: [&str; 9] = [
        "if(%, %, %)",
        "if(% < %, %, %)",
        "(% < %)*%",
        "(% > 0)*(% != %)",
        "min(%, %)",
        "max(% > %, %)",
        "(% - %)",
        "%/%",
        "[%, %].y",
    ];
    if depth == 0 {
        return LEAVES[random(LEAVES.len())].into();
    }
    let mut formula = String::new();
    for part in FORMS[random(FORMS.len())].split_inclusive('%') {
        formula += part.trim_end_matches('%');
        if part.ends_with('%') {
            // Some parts are the same, so that they are used under several conditions.
            let depth = random(depth);
            formula +=
                &if random(3) == 0 { format!("(a.x + b < {})", random(3)) } else { random_formula(random, depth) };
        }
    }
    format!("({formula})")
}

#[test]
fn steps_are_skipped_only_where_they_do_not_matter() {
    let mut state = 1u64;
    let mut random = |count: usize| {
        state = crate::random::key(state, 3);
        (state >> 33) as usize % count
    };
    for _ in 0..2000 {
        let text = random_formula(&mut random, 5);
        let expression =
            parse(&text, [Some(2), Some(1), None, None]).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        // Runs of equal samples, and mixed ones.
        let mut samples = Vec::new();
        while samples.len() < 300 {
            let values = [0.0, 1.0, -0.0, 0.5, -2.0, f64::NAN, f64::INFINITY, 3.0];
            let mut sample = || [0; 3].map(|_| values[random(values.len())]);
            let same = sample();
            let mixed: [_; 40] = std::array::from_fn(|_| sample());
            if random(2) == 0 { samples.extend([same; 100]) } else { samples.extend(mixed) }
        }
        let mut found = Vec::new();
        let load = |first: usize, input: usize, component: usize, out: &mut [f64]| {
            out.iter_mut().zip(&samples[first..]).for_each(|(out, sample)| *out = sample[2 * input + component]);
        };
        Program::new(&expression).run(samples.len(), load, |_, _, values| found.extend_from_slice(values));
        for ([x, y, b], found) in samples.iter().zip(&found) {
            let value = expression.value(&[vec![*x, *y], vec![*b], Vec::new(), Vec::new()])[0];
            let same = found.to_bits() == value.to_bits() || (found.is_nan() && value.is_nan());
            assert!(same, "{text} of {x}, {y}, {b} is {value}, not {found}");
        }
    }
}

#[test]
fn the_innermost_wrong_part_is_found() {
    let part = |text: &str, inputs: [Vec<f64>; 4], is_wrong: fn(f64) -> bool| {
        let widths = inputs.each_ref().map(|input| (!input.is_empty()).then_some(input.len()));
        let expression = parse(text, widths).unwrap();
        expression.origin(&inputs, is_wrong).map(|part| text[part.text.clone()].to_string())
    };
    let a = |a: f64, b: f64| [vec![a], vec![b], Vec::new(), Vec::new()];
    for (text, expected) in [
        ("a/b", Some("a/b")),
        (" 1 + a / b * 2", Some("a / b")),
        ("1 + (a - 0)/(b + 0)", Some("(a - 0)/(b + 0)")),
        ("max(1, sqrt(a - 1)) + b", Some("sqrt(a - 1)")),
        ("-(log(-1))", Some("(log(-1))")),
        ("[1, a/b, 3].y", Some("a/b")),
        ("[1, a/b, 3].x", None),
        ("if(1, 5, a/b)", None),
        ("length([a, 0/b])", Some("0/b")),
        ("dot([a, a], [1/b, 1])", Some("dot([a, a], [1/b, 1])")),
        ("a + b", None),
    ] {
        assert_eq!(part(text, a(0.0, 0.0), f64::is_nan).as_deref(), expected, "{text}");
    }
    assert_eq!(part("1/b - 1/b", a(0.0, 0.0), |value| !value.is_finite()).as_deref(), Some("1/b"));
    assert_eq!(part("1/(1/b)", a(0.0, 0.0), |value| !value.is_finite()), None);
}
