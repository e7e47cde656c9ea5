//! FieldMath: computes a field by a formula that the user writes.

use crate::filter::numbers;
use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};
use trochoid_field::{Expression, Program, parse};
use trochoid_graph::*;
use trochoid_image::Window;
use trochoid_memory::Scratch;

/// Computes a field from other fields by a formula.
///
/// # Formula
/// `expression`, a formula of the inputs a, b, c and d. Operators: + − * / ^ and < <= > >= == != (1 if true, 0 if
/// false). Functions: min max clamp abs sign floor ceil fract mod sqrt exp log sin cos atan2 (angles in radians)
/// smoothstep(from, to, x) mix(a, b, t) if(condition, a, b) dot length. Constants: pi; frame, the number of the frame;
/// time, the seconds since the first frame. Components are x, y, z and w: a.x or a.zyx picks some, [a, b.x] joins them.
///
/// # Edge cases
/// Computes in f64. An operand of one component is combined with each component of the other operand. A result that is
/// NaN, like 0/0 or the root of a negative number, is replaced by `nan` and counted as repaired; ±∞ is kept. ^ is
/// right-associative and binds more tightly than a leading sign: −2^2 is −4. As conditions, 0 and NaN are false.
///
/// # Source
/// Fields are not colors, so any arithmetic is allowed on them; a Clamp turns the result into a mask.
#[derive(Clone, Node)]
#[node(
    stage, end = Front, revision = 1,
    example = r#""expression": "2 * a", "a": 0.5"#,
    output(field: Kind::ANY = "The result.")
)]
#[also_called(
    "Math", "Expression", "Formula", "Checkerboard", "Checker", "Stripes", "Grid", "MergeExpression", "VectorMath" => "a formula"
)]
pub(crate) struct FieldMath {
    /// Formula to compute, for example "a*sin(6*b.x) + 1".
    #[knob(required)]
    expression: String,
    /// Number of components of the result.
    #[knob(default = 1, range = 1..=4, hold_keys)]
    components: i64,
    /// Field a of the formula.
    a: Optional<port::Field>,
    /// Field b of the formula.
    b: Optional<port::Field>,
    /// Field c of the formula.
    c: Optional<port::Field>,
    /// Field d of the formula.
    d: Optional<port::Field>,
    /// Value that replaces NaN, where the formula has no result.
    #[knob(default = 0.0, range = LOWEST..=HIGHEST)]
    nan: f64,
}

const LOWEST: f64 = -HIGHEST;
const HIGHEST: f64 = f32::MAX as f64;

impl FieldMath {
    /// Returns the inputs in order.
    fn inputs(&self) -> [&Optional<port::Field>; 4] {
        [&self.a, &self.b, &self.c, &self.d]
    }

    /// Parses the formula for inputs with these numbers of components. An error is made of what was found, what was
    /// expected, and the remedy.
    fn parsed(&self, widths: [Option<usize>; 4]) -> Result<Expression, BadData> {
        let expression = parse(&self.expression, widths).map_err(|fault| {
            let place = format!("column {} of the expression", fault.column);
            let remedy = fault.remedy.map_or("write it as `trochoid nodes FieldMath` says".into(), |r| r.to_string());
            BadData::new(format_args!("{} at {place}", fault.found), fault.expected.to_string(), remedy)
        })?;
        let components = self.components as usize;
        if expression.width == components {
            return Ok(expression);
        }
        let remedy = format!("set \"components\" to {}, or pick some, as in (…).x", expression.width);
        Err(BadData::new(format_args!("a result of {} components", expression.width), components.to_string(), remedy))
    }
}

impl Node for FieldMath {
    fn kinds(&self) -> Option<Vec<Kind>> {
        Some(vec![Kind::Field(self.components.clamp(1, 4) as usize)])
    }

    fn check(&self, check: &mut Check<'_>) {
        let mut widths = [None; 4];
        for (width, port) in widths.iter_mut().zip(self.inputs()) {
            if let Some(source) = port.as_ref() {
                // The kind of a faulty source is unknown; its own error suffices.
                let Some(kind) = check.kind(source) else { return };
                *width = Some(kind.channels());
            }
        }
        if let Err(BadData { found, expected, remedy, .. }) = self.parsed(widths) {
            check.error(Self::EXPRESSION, found, expected, remedy);
        }
    }
}

impl Stage for FieldMath {
    fn depends_on_format(&self) -> bool {
        false
    }

    fn depends_on_time(&self) -> bool {
        let words = self.expression.split(|c: char| !c.is_alphanumeric());
        words.into_iter().any(|word| matches!(word, "frame" | "time"))
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedFieldMath {
            node: self.clone(),
            own: [prepare.frame.frame as f64, prepare.frame.time],
            picture: prepare.frame.format.window(),
            program: OnceLock::new(),
            repaired: Mutex::default(),
            first: Mutex::default(),
        }))
    }
}

/// Values that were NaN: one bit per pixel, by component and sample position within the pixel.
type Repaired = HashMap<(usize, [u64; 2]), Vec<u64>>;

struct PreparedFieldMath {
    node: FieldMath,
    /// Frame and time, which follow the inputs.
    own: [f64; 2],
    picture: Window,
    /// The compiled formula, once the inputs are known.
    program: OnceLock<Result<Program, NodeError>>,
    repaired: Mutex<Repaired>,
    first: Mutex<Option<FirstNan>>,
}

/// The first NaN in the order of rows, and of samples within a pixel.
struct FirstNan {
    /// Row, column, offset of the sample, component.
    place: ([i64; 2], [u64; 2], usize),
    /// Values of the inputs there, and of what follows them.
    inputs: Vec<Vec<f64>>,
}

impl PreparedFieldMath {
    /// Parses the formula for inputs with these numbers of components.
    fn expression(&self, widths: [Option<usize>; 4]) -> Result<Expression, NodeError> {
        Ok(self.node.parsed(widths)?)
    }

    /// Replaces NaN and records where. A pixel is recorded rather than counted, because overlapping tiles may compute
    /// it more than once.
    fn repair(&self, block: &Block<'_>, component: usize, plane: &mut [f32], values: impl Fn(usize) -> Vec<Vec<f64>>) {
        // Without branches, since there is hardly ever one.
        if !plane.iter().fold(false, |any, value| any | value.is_nan()) {
            return;
        }
        let mut repaired = self.repaired.lock().unwrap_or_else(PoisonError::into_inner);
        let words = self.picture.area().div_ceil(64);
        let bits = repaired.entry((component, block.offset.map(f64::to_bits))).or_insert_with(|| vec![0; words]);
        for (index, value) in plane.iter_mut().enumerate().filter(|(_, value)| value.is_nan()) {
            *value = literal(self.node.nan);
            let Some([x, y]) = block.pixel(index) else { continue };
            if self.picture.contains(x, y) {
                let place = (y - self.picture.y0) as usize * self.picture.width() + (x - self.picture.x0) as usize;
                bits[place / 64] |= 1 << (place % 64);
                let place = ([y, x], block.offset.map(f64::to_bits), component);
                let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
                if first.as_ref().is_none_or(|first| place < first.place) {
                    *first = Some(FirstNan { place, inputs: values(index) });
                }
            }
        }
    }
}

impl Prepared for PreparedFieldMath {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let ports = self.node.inputs();
        let planes = ports.map(|port| inputs.all(port).first().map(|connection| &connection.planes[..]));
        let program = self
            .program
            .get_or_init(|| Ok(Program::new(&self.expression(planes.map(|planes| planes.map(<[_]>::len)))?)));
        let program = program.as_ref().map_err(Clone::clone)?;
        let mut wanted: Scratch<_> = (0..program.width()).map(|component| outputs.only(component)).collect();
        let load = |first: usize, input: usize, component: usize, run: &mut [f64]| {
            if let Some(own) = input.checked_sub(planes.len()) {
                run.fill(self.own[own]);
            } else if let Some(Some(plane)) = planes[input].and_then(|planes| planes.get(component)) {
                run.iter_mut().zip(&plane[first..]).for_each(|(out, value)| *out = f64::from(*value));
            }
        };
        program.run(block.window.area(), load, |first, component, run| {
            if let Some(plane) = &mut wanted[component] {
                plane[first..].iter_mut().zip(run).for_each(|(out, value)| *out = *value as f32);
            }
        });
        let values = |index: usize| -> Vec<Vec<f64>> {
            let at = |plane: &Option<&[f32]>| plane.map_or(f64::NAN, |plane| f64::from(plane[index]));
            let inputs =
                planes.iter().map(|planes| planes.map_or(Vec::new(), |planes| planes.iter().map(at).collect()));
            inputs.chain(self.own.map(|own| vec![own])).collect()
        };
        for (component, plane) in wanted.iter_mut().enumerate() {
            if let Some(plane) = plane {
                self.repair(block, component, plane, values);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let Some(Ok(program)) = self.program.get() else { return Ok(()) };
        let ports = self.node.inputs();
        let [values, bounds] = [bounding.inputs, bounding.bounds]
            .map(|inputs| ports.map(|port| inputs.all(port).first().map_or(&[][..], |connection| &connection.planes)));
        let mut wanted: Vec<_> = (0..program.width()).map(|component| outputs.only(component)).collect();
        let load = |first: usize, port: usize, component: usize, run: &mut [Span]| {
            if let Some(own) = port.checked_sub(values.len()) {
                return run.fill(Span::around(self.own[own], Bound::EXACT));
            }
            let [values, bounds] = [values[port], bounds[port]].map(|planes| planes.get(component).copied().flatten());
            let [values, bounds] = [values, bounds].map(|plane| plane.map(|plane| &plane[first..]));
            for (index, span) in run.iter_mut().enumerate() {
                let bound = bounds.map_or(Bound::EXACT, |bounds| Bound::decode(bounds[index]));
                *span = Span::around(values.map_or(0.0, |values| f64::from(values[index])), bound);
            }
        };
        program.spans(bounding.block.window.area(), load, |first, component, run| {
            let (Some(wanted), Some(filled)) = (&mut wanted[component], bounding.filled[0][component]) else { return };
            for ((wanted, filled), span) in wanted[first..].iter_mut().zip(&filled[first..]).zip(run) {
                let bound = if span.low.is_nan() && !span.is_any() {
                    Bound::of(literal_error(literal(self.node.nan)))
                } else {
                    span.bound(f64::from(*filled))
                };
                *wanted = bound.encode();
            }
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let of = |port: &Optional<_>| port.as_ref().map_or(Vec::new(), |source| numbers(inputs, source));
        let values = self.node.inputs().map(of);
        let widths = values.each_ref().map(|value| (!value.is_empty()).then_some(value.len()));
        let values = [&values[..], &self.own.map(|value| vec![value])].concat();
        let mut result = self.expression(widths)?.value(&values);
        result.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = self.node.nan);
        Ok(vec![Reference::Field(result)])
    }

    fn repaired(&self) -> u64 {
        let repaired = self.repaired.lock().unwrap_or_else(PoisonError::into_inner);
        repaired.values().flatten().map(|word| u64::from(word.count_ones())).sum()
    }

    fn first_repaired(&self) -> Option<Repair> {
        let first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
        let FirstNan { place: ([y, x], ..), inputs } = first.as_ref()?;
        let width = |input: &Vec<f64>| (!input.is_empty()).then_some(input.len());
        let widths = std::array::from_fn(|input| inputs.get(input).and_then(width));
        let expression = self.expression(widths).ok()?;
        let origin = expression.origin(inputs, f64::is_nan)?;
        let part: String = self.node.expression.chars().skip(origin.text.start).take(origin.text.len()).collect();
        let list = |numbers: &[f64]| match numbers {
            [number] => number.to_string(),
            numbers => format!("[{}]", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")),
        };
        let names = ["a", "b", "c", "d", "frame", "time"].into_iter().enumerate();
        let used = names.filter(|(input, _)| origin.uses(*input));
        let used: Vec<String> = used.map(|(input, name)| format!("{name} = {}", list(&inputs[input]))).collect();
        let with = if used.is_empty() { String::new() } else { format!(" with {}", used.join(", ")) };
        Some(Repair { pixel: [*x, *y], cause: format!("{part}{with}") })
    }
}
