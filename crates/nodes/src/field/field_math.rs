//! FieldMath: any arithmetic on fields.

use crate::filter::numbers;
use std::collections::HashMap;
use std::sync::{Mutex, OnceLock, PoisonError};
use trochoid_field::{Expression, Program, parse};
use trochoid_graph::*;
use trochoid_image::Window;

/// Computes a field from fields by a formula.
///
/// # Formula
/// `expression`, of a, b, c and d: + − * / ^; < <= > >= == != (1 where it holds, else 0); min max clamp abs sign floor
/// ceil fract mod sqrt exp log sin cos atan2 (radians) smoothstep(from, to, x) mix(a, b, t) if(condition, a, b) dot
/// length; pi; a.x, a.zyx (x y z w are the components); [a, b.x] joins components.
///
/// # Edge cases
/// All is computed in f64. A single number goes with each component of the other operand. Where a result is NaN, as 0/0
/// or the root of a negative number is, it becomes `nan` and counts as repaired; ±∞ is kept. ^ binds tighter than a
/// sign before it and from the right: −2^2 is −4. 0 and NaN are false.
///
/// # Source
/// The front end computes freely; a Clamp makes a mask of the result.
#[derive(Clone, Node)]
#[node(end = Front, revision = 1, output(field: Kind::ANY = "The result."))]
#[also_called(
    "Math", "Expression", "Formula", "Checkerboard", "Checker", "Stripes", "Grid", "MergeExpression", "VectorMath" => "a formula"
)]
pub(crate) struct FieldMath {
    /// The formula, such as "a*sin(6*b.x) + 1".
    #[knob(required)]
    expression: String,
    /// How many components the result has.
    #[knob(default = 1, range = 1..=4, held)]
    components: i64,
    /// Input a.
    a: Optional<port::Field>,
    /// Input b.
    b: Optional<port::Field>,
    /// Input c.
    c: Optional<port::Field>,
    /// Input d.
    d: Optional<port::Field>,
    /// What stands where the formula has no value.
    #[knob(default = 0.0, range = LOWEST..=HIGHEST)]
    nan: f64,
}

const LOWEST: f64 = -HIGHEST;
const HIGHEST: f64 = f32::MAX as f64;

impl FieldMath {
    /// The inputs, in order.
    fn inputs(&self) -> [&Optional<port::Field>; 4] {
        [&self.a, &self.b, &self.c, &self.d]
    }

    /// The formula, for inputs of these numbers of components.
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
                // Of a source that is itself faulty nothing can be said.
                let Some(kind) = check.kind(source) else { return };
                *width = Some(kind.channels());
            }
        }
        if let Err(BadData { found, expected, remedy, .. }) = self.parsed(widths) {
            check.error(Self::EXPRESSION, found, expected, remedy);
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for FieldMath {
    fn formatted(&self) -> bool {
        false
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(PreparedFieldMath {
            node: self.clone(),
            picture: prepare.frame.format.window(),
            program: OnceLock::new(),
            repaired: Mutex::default(),
        }))
    }
}

/// Which values were NaN: by component and place in the pixel, a bit for each pixel.
type Repaired = HashMap<(usize, [u64; 2]), Vec<u64>>;

struct PreparedFieldMath {
    node: FieldMath,
    picture: Window,
    /// The formula, once the inputs are known.
    program: OnceLock<Result<Program, NodeError>>,
    repaired: Mutex<Repaired>,
}

impl PreparedFieldMath {
    /// The formula, where the inputs have these components.
    fn expression(&self, widths: [Option<usize>; 4]) -> Result<Expression, NodeError> {
        Ok(self.node.parsed(widths)?)
    }

    /// Sets NaN to its substitute, and keeps where that was: tiles may compute a pixel more than once.
    fn repair(&self, block: &Block<'_>, component: usize, plane: &mut [f32]) {
        if !plane.iter().any(|value| value.is_nan()) {
            return;
        }
        let mut repaired = self.repaired.lock().unwrap_or_else(PoisonError::into_inner);
        let words = self.picture.area().div_ceil(64);
        let bits = repaired.entry((component, block.offset.map(f64::to_bits))).or_insert_with(|| vec![0; words]);
        for (index, value) in plane.iter_mut().enumerate().filter(|(_, value)| value.is_nan()) {
            *value = self.node.nan as f32;
            let Some([x, y]) = block.pixel(index) else { continue };
            if self.picture.contains(x, y) {
                let place = (y - self.picture.y0) as usize * self.picture.width() + (x - self.picture.x0) as usize;
                bits[place / 64] |= 1 << (place % 64);
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
        let mut wanted: Vec<_> = (0..program.width()).map(|component| outputs.only(component)).collect();
        let load = |first: usize, input: usize, component: usize, run: &mut [f64]| {
            if let Some(Some(plane)) = planes[input].and_then(|planes| planes.get(component)) {
                run.iter_mut().zip(&plane[first..]).for_each(|(out, value)| *out = f64::from(*value));
            }
        };
        program.run(block.window.area(), load, |first, component, run| {
            if let Some(plane) = &mut wanted[component] {
                plane[first..].iter_mut().zip(run).for_each(|(out, value)| *out = *value as f32);
            }
        });
        for (component, plane) in wanted.into_iter().enumerate() {
            if let Some(plane) = plane {
                self.repair(block, component, plane);
            }
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        let Some(Ok(program)) = self.program.get() else { return Ok(()) };
        let ports = self.node.inputs();
        let of = |inputs: &Inputs<'_>, port: usize, component: usize, sample: usize| {
            let connection = inputs.all(ports[port]).first()?;
            Some(connection.planes.get(component).copied()??[sample])
        };
        let mut wanted: Vec<_> = (0..program.width()).map(|component| outputs.only(component)).collect();
        for sample in 0..bounding.block.window.area() {
            let spans = program.spans(|port, component| {
                let value = of(bounding.inputs, port, component, sample).map_or(0.0, f64::from);
                let bound = of(bounding.bounds, port, component, sample).map_or(Bound::EXACT, Bound::decode);
                Span::around(value, bound)
            });
            for (component, (span, wanted)) in spans.iter().zip(&mut wanted).enumerate() {
                let (Some(wanted), Some(filled)) = (wanted, bounding.filled[0][component]) else { continue };
                let bound = if span.low.is_nan() && !span.is_any() {
                    Bound::of(self.node.nan.abs() * LITERAL)
                } else {
                    span.bound(f64::from(filled[sample]))
                };
                wanted[sample] = bound.encode();
            }
        }
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let of = |port: &Optional<_>| port.as_ref().map_or(Vec::new(), |source| numbers(inputs, source));
        let values = self.node.inputs().map(of);
        let widths = values.each_ref().map(|value| (!value.is_empty()).then_some(value.len()));
        let mut result = self.expression(widths)?.value(&values);
        result.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = self.node.nan);
        Ok(vec![Reference::Field(result)])
    }

    fn repaired(&self) -> u64 {
        let repaired = self.repaired.lock().unwrap_or_else(PoisonError::into_inner);
        repaired.values().flatten().map(|word| u64::from(word.count_ones())).sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{frame, refused};

    #[test]
    fn nan_is_repaired_and_counted_once() {
        let frame = frame("field", r#""out": { "type": "FieldMath", "expression": "sqrt(-1)", "nan": 7 }"#);
        let id = frame.graph.find("out").unwrap();
        for at in [[0.5, 0.5], [0.5, 0.5], [3.5, 2.5], [0.25, 0.5], [-0.5, 0.5]] {
            assert_eq!(frame.filled(id, 0, 0, at), 7.0);
        }
        assert_eq!(frame.truth([0.5, 0.5]), [7.0]);
        assert_eq!(frame.node("out").repaired(), 3);
    }

    #[test]
    fn faults_of_formulas_are_told_with_their_place() {
        let of = |nodes: &str| refused("field", nodes);
        let faults = of(r#""out": { "type": "FieldMath", "expression": "1 + $" }"#);
        assert!(faults.contains("'$' at column 5"), "{faults}");
        let faults = of(r#""out": { "type": "FieldMath", "expression": "[1, 2, 3]" }"#);
        assert!(faults.contains("set \\\"components\\\" to 3"), "{faults}");
        let faults = of(r#""out": { "type": "FieldMath", "expression": "a + b", "a": 1 }"#);
        assert!(faults.contains("input b, to which nothing is connected"), "{faults}");
        of(r#""out": { "type": "FieldMath" }"#);
    }
}
