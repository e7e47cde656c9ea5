//! The same picture with fewer pixels.

use crate::{CheckedGraph, Declaration, Item, Record, Setting, Takes};
use trochoid_image::Format;

impl CheckedGraph {
    /// The same picture at another format, for proxies and previews: what is measured in pixels, such as the width of a
    /// line, keeps its share of the picture's width.
    pub fn drawn_at(mut self, format: Format) -> Self {
        let scale = f64::from(format.width()) / f64::from(self.format.width());
        for node in &mut self.nodes {
            shrink(node.ty.declaration(), &mut node.record, scale);
        }
        self.with_format(format)
    }
}

fn shrink(declaration: &Declaration, record: &mut Record, scale: f64) {
    for item in declaration.items {
        let Item::Knob(knob) = item else { continue };
        if !knob.drawn {
            continue;
        }
        let range = |value: f64| match knob.takes {
            Takes::Number { min, max } => value.clamp(min, max),
            Takes::Integer { min, max } => value.round().clamp(min as f64, max as f64),
            _ => value,
        };
        let settings = record.knobs.iter_mut().filter(|(name, _)| *name == knob.name);
        for (_, setting) in settings {
            if let Setting::Numeric(animated) = setting {
                *animated = animated.map(|values| values.iter().map(|value| range(value * scale)).collect());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Animated, Declaration, End, Item, Knob, Record, Setting};

    static ITEMS: &[Item] = &[
        Knob::number("width", 4.0, 0.5, 64.0, "A line's width.").drawn().item(),
        Knob::integer("reach", 4, 1, 64, "A reach.").drawn().item(),
        Knob::number("height", 4.0, 0.0, 64.0, "A wave's height.").unit("m").item(),
    ];

    #[test]
    fn pixels_shrink_within_their_range_and_meters_do_not() {
        let declaration = Declaration {
            name: "Test",
            end: End::Front,
            summary: "",
            formula: "",
            edge_cases: "",
            source: "",
            items: ITEMS,
            outputs: &[],
            revision: 1,
        };
        let setting = |name: &'static str| (name, Setting::Numeric(Animated::constant(vec![4.0])));
        let mut record =
            Record { knobs: vec![setting("width"), setting("reach"), setting("height")], ..Record::default() };
        super::shrink(&declaration, &mut record, 1.0 / 16.0);
        let settled = record.settle(1.0);
        assert_eq!((settled.number("width"), settled.integer("reach"), settled.number("height")), (0.5, 1, 4.0));
    }
}
