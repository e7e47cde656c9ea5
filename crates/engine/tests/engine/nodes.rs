//! A minimal set of node types that make a graph, so that the engine is tested without the real ones.

use trochoid_graph::*;

/// A field that runs from −1 to 2 over the columns.
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(field: Kind::Field(1) = ""))]
pub(super) struct Slope;

/// Clamps a field to [0, 1].
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(mask: Kind::MASK = ""))]
pub(super) struct Gate {
    /// Field to clamp.
    field: One<port::Scalar>,
}

/// Mixes two colors.
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = ""))]
pub(super) struct Mix {
    /// Color where the weight is 0.
    a: One<port::Color>,
    /// Color where the weight is 1.
    b: One<port::Color>,
    /// Share of `b`.
    weight: One<port::Mask>,
}

/// Blends three colors with weights t, t and the remainder, normalized.
///
/// # Formula
/// # Edge cases
/// # Source
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = ""))]
pub(super) struct Thirds {
    /// Three colors to blend.
    #[port(3..=3)]
    colors: Many<port::Color>,
    /// Weight t of the first and the second color.
    weight: One<port::Mask>,
}

/// Node types, to register them beside others.
pub(super) static TYPES: [NodeType; 4] =
    [NodeType::of::<Slope>(), NodeType::of::<Gate>(), NodeType::of::<Mix>(), NodeType::of::<Thirds>()];

/// Returns a registry of all of them.
pub(super) fn registry() -> Registry {
    Registry::new(&TYPES)
}

impl Node for Slope {}

impl Stage for Slope {
    fn variance(&self, _output: usize) -> Variance {
        Variance::Column
    }
    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        Ok(Box::new(Sloping(f64::from(prepare.frame.format.width()))))
    }
}

struct Sloping(f64);

impl Prepared for Sloping {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let width = block.window.width();
        for (i, value) in outputs.only(0).unwrap().iter_mut().enumerate() {
            let x = block.window.x0 as f64 + (i % width) as f64 + block.offset[0];
            *value = (x / self.0 * 3.0 - 1.0) as f32;
        }
        Ok(())
    }
    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Field(vec![inputs.at[0] / self.0 * 3.0 - 1.0])])
    }
}

impl Node for Gate {}
impl Node for Mix {}
impl Node for Thirds {}

impl Pointwise for Gate {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let x = lowering.scalar(&self.field);
        Value::Weights(Weights::mask(lowering.build.clamp(x, 0.0, 1.0)))
    }
    fn reference(&self, inputs: &References<'_>) -> Reference {
        Reference::Mask(inputs.scalar(&self.field).clamp(0.0, 1.0))
    }
}

impl Pointwise for Mix {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let (a, b) = (lowering.color(&self.a), lowering.color(&self.b));
        let t = lowering.mask(&self.weight);
        Value::Color(lowering.build.mix(a, b, t))
    }
    fn reference(&self, inputs: &References<'_>) -> Reference {
        let (a, b) = (inputs.color(&self.a), inputs.color(&self.b));
        let t = inputs.scalar(&self.weight);
        Reference::Color([0, 1, 2].map(|c| (1.0 - t) * a[c] + t * b[c]))
    }
}

impl Pointwise for Thirds {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let colors: Vec<Color> = self.colors.iter().map(|source| lowering.color(source)).collect();
        let t = lowering.scalar(&self.weight);
        let weights = lowering.build.normalize(vec![t, t], 1.0);
        Value::Color(lowering.build.blend(&colors, &weights))
    }
    fn reference(&self, inputs: &References<'_>) -> Reference {
        let colors: Vec<[f64; 3]> = self.colors.iter().map(|source| inputs.color(source)).collect();
        let t = inputs.scalar(&self.weight);
        let sum = (2.0 * t).max(1.0);
        let weights = [t / sum, t / sum, 1.0 - 2.0 * t / sum];
        Reference::Color([0, 1, 2].map(|c| (0..3).map(|i| weights[i] * colors[i][c]).sum()))
    }
}
