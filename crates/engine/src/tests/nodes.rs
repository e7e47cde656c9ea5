//! The fewest node types that make a graph, so that the engine is tested without knowing the real ones.

use trochoid_graph::*;

/// A field that runs from −1 to 2 over the columns.
pub(super) struct Slope;
/// Clamp to [0, 1].
pub(super) struct Gate;
/// Mix.
pub(super) struct Mix;
/// Blends three colors with weights t, t and the remainder, normalized.
pub(super) struct Thirds;

static SLOPE: Declaration = declare("Slope", End::Front, &[], &[Output::new("field", Kind::Field(1), "")]);
static GATE: Declaration =
    declare("Gate", End::Back, &[Port::one("field", Accepts::Scalar, "")], &[Output::new("mask", Kind::MASK, "")]);
static MIX: Declaration = declare(
    "Mix",
    End::Back,
    &[Port::one("a", Accepts::Color, ""), Port::one("b", Accepts::Color, ""), Port::one("weight", Accepts::Mask, "")],
    &[Output::new("color", Kind::Color, "")],
);
static THIRDS: Declaration = declare(
    "Thirds",
    End::Back,
    &[Port::many("colors", Accepts::Color, 3, 3, ""), Port::one("weight", Accepts::Mask, "")],
    &[Output::new("color", Kind::Color, "")],
);

pub(super) const fn declare(
    name: &'static str,
    end: End,
    items: &'static [Item],
    outputs: &'static [Output],
) -> Declaration {
    Declaration { name, end, summary: "", formula: "", edge_cases: "", source: "", items, outputs, revision: 1 }
}

/// A registry of all of them.
pub(super) fn registry() -> Registry {
    let types: [&'static dyn NodeType; 4] = [&Slope, &Gate, &Mix, &Thirds];
    Registry::new(types)
}

impl NodeType for Slope {
    fn declaration(&self) -> &'static Declaration {
        &SLOPE
    }
    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for Slope {
    fn variance(&self, _node: &Settled, _output: usize) -> Variance {
        Variance::Column
    }
    fn prepare(&self, _node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(Sloping(f64::from(prepare.frame.format.width()))))
    }
}

struct Sloping(f64);

impl Prepared for Sloping {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let width = block.window.width();
        for (i, value) in outputs.take(0, 0).unwrap().iter_mut().enumerate() {
            let x = block.window.x0 as f64 + (i % width) as f64 + block.offset[0];
            *value = (x / self.0 * 3.0 - 1.0) as f32;
        }
        Ok(())
    }
    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Field(vec![inputs.at[0] / self.0 * 3.0 - 1.0])])
    }
}

macro_rules! pointwise {
    ($ty:ident, $declaration:ident) => {
        impl NodeType for $ty {
            fn declaration(&self) -> &'static Declaration {
                &$declaration
            }
            fn body(&self) -> Body<'_> {
                Body::Pointwise(self)
            }
        }
    };
}

pointwise!(Gate, GATE);
pointwise!(Mix, MIX);
pointwise!(Thirds, THIRDS);

impl Pointwise for Gate {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(node.source("field"));
        Value::Weights(Weights::mask(lowering.build.clamp(x, 0.0, 1.0)))
    }
    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        Reference::Mask(inputs.scalar(node.source("field")).clamp(0.0, 1.0))
    }
}

impl Pointwise for Mix {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let (a, b) = (lowering.color(node.source("a")), lowering.color(node.source("b")));
        let t = lowering.mask(node.source("weight"));
        Value::Color(lowering.build.mix(a, b, t))
    }
    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let (a, b) = (inputs.color(node.source("a")), inputs.color(node.source("b")));
        let t = inputs.scalar(node.source("weight"));
        Reference::Color([0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c]))
    }
}

impl Pointwise for Thirds {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let colors: Vec<Color> = node.all("colors").iter().map(|source| lowering.color(source)).collect();
        let t = lowering.scalar(node.source("weight"));
        let weights = lowering.build.normalize(vec![t, t], 1.0);
        Value::Color(lowering.build.blend(&colors, &weights))
    }
    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let colors: Vec<[f64; 3]> = node.all("colors").iter().map(|source| inputs.color(source)).collect();
        let t = inputs.scalar(node.source("weight"));
        let sum = (2.0 * t).max(1.0);
        let weights = [t / sum, t / sum, 1.0 - 2.0 * t / sum];
        Reference::Color([0, 1, 2].map(|c| (0..3).map(|i| weights[i] * colors[i][c]).sum()))
    }
}
