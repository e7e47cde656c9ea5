//! Constant: one control color.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Constant;

struct Constant;

static DECLARATION: Declaration = Declaration {
    name: "Constant",
    end: End::Back,
    summary: "Gives one control color everywhere.",
    formula: "C",
    edge_cases: "A keyed color is one control color at each frame.",
    source: "A vertex of the hull: Akleman, Liu, House, Barycentric Shaders, 2016.",
    items: &[Knob::color("color", "The control color.").item()],
    outputs: &[Output::new("color", Kind::Color, "The color.")],
    revision: 1,
};

impl NodeType for Constant {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

impl Pointwise for Constant {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let color = node.vector3("color").map(|v| v as f32);
        Value::Color(lowering.build.control(color))
    }

    fn reference(&self, node: &Settled, _inputs: &References<'_>) -> Reference {
        Reference::Color(node.vector3("color"))
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{agrees, frame};

    #[test]
    fn a_color_is_itself() {
        agrees("color", r##""out": { "type": "Constant", "color": "#8b9aa1" }"##);
        let nodes = r#""out": { "type": "Constant", "color": [0.25, 0.5, 4] }"#;
        assert_eq!(frame("color", nodes).lowered([0.5, 0.5]), [0.25, 0.5, 4.0]);
    }
}
