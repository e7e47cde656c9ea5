//! Sheet: a grid of colors over two masks.

use trochoid_graph::*;

pub(crate) static NODE: &dyn NodeType = &Sheet;

struct Sheet;

static DECLARATION: Declaration = Declaration {
    name: "Sheet",
    end: End::Back,
    summary: "Spans a grid of colors over two masks, and meets every one of them.",
    formula: "Σ hᵢ(u)·hⱼ(v)·Cⱼᵢ, the hat functions h over the places of the columns and rows: between two places t = \
              (u − atᵢ)/(atᵢ₊₁ − atᵢ) of the way to the next; `smooth` eases t²(3 − 2t). Colors row by row, u \
              fastest.",
    edge_cases: "At a crossing exactly its color; before the first and after the last column or row theirs. Two \
                 columns or rows at one place are a hard edge, with the later one at the place itself.",
    source: "Piecewise bilinear interpolation as a partition of unity: products of hat functions. Unlike a Patch, \
             whose inner colors pull without being met.",
    items: &[
        Port::one("u", Accepts::Mask, "Along a row of colors."),
        Port::one("v", Accepts::Mask, "From row to row."),
        Port::many("colors", Accepts::Color, 1, 1024, "The colors, row by row, u fastest."),
        Knob::integer("columns", 1, 1, 1024, "Colors in a row.").required().item(),
        Knob::numbers(
            "columns_at",
            1,
            1024,
            "Places of the columns, 0 to 1, ascending; by default evenly from 0 to 1.",
        )
        .optional()
        .item(),
        Knob::numbers("rows_at", 1, 1024, "Places of the rows, 0 to 1, ascending; by default evenly from 0 to 1.")
            .optional()
            .item(),
        Knob::choice("interpolation", &["linear", "smooth"], "How to get from color to color.").item(),
    ],
    outputs: &[Output::new("color", Kind::Color, "The color.")],
    revision: 1,
};

/// Columns and rows; a keyed count that the colors do not fill is that of one row.
fn size(node: &Settled) -> [usize; 2] {
    let count = node.all("colors").len();
    let columns = (node.integer("columns").max(1) as usize).min(count);
    [columns, count / columns]
}

/// Places along an axis.
fn places(node: &Settled, knob: &str, count: usize) -> Vec<f64> {
    if node.is_set(knob) {
        return node.numbers(knob).to_vec();
    }
    let last = (count - 1).max(1) as f64;
    (0..count).map(|index| index as f64 / last).collect()
}

impl NodeType for Sheet {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let (count, columns) = (node.all("colors").len(), node.integer("columns").max(1) as usize);
        if count == 0 {
            return;
        }
        if count % columns != 0 {
            let found = format!("{count} colors in rows of {columns}");
            let remedy = format!("list {} colors, or set another number of columns", count.div_ceil(columns) * columns);
            check.error("colors", found, "whole rows", remedy);
            return;
        }
        for (knob, expected) in [("columns_at", columns), ("rows_at", count / columns)] {
            if !node.is_set(knob) {
                continue;
            }
            let at = node.numbers(knob);
            if at.len() != expected {
                let found = format!("{} places", at.len());
                check.error(knob, found, format!("{expected}, one each"), "list as many places, or none");
            }
            if let Some(pair) = at.windows(2).find(|pair| pair[1] < pair[0]) {
                let remedy = "sort the places, and their colors with them";
                check.error(knob, format!("{} after {}", pair[1], pair[0]), "places that ascend", remedy);
            }
            if let Some(at) = at.iter().find(|at| !(0.0..=1.0).contains(*at)) {
                check.error(knob, format!("a place at {at}"), "places from 0 to 1", "divide them by the largest");
            }
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Pointwise(self)
    }
}

/// How far each color after the first is laid over those before it. Where a mask has reached 1, it covers them.
fn covers(build: &mut Builder<'_>, x: Scalar, places: &[f64], smooth: bool) -> Vec<Mask> {
    let pairs = places.windows(2).map(|at| (at[0] as f32, at[1] as f32));
    pairs
        .map(|(min, max)| {
            if min >= max {
                return build.step(x, max);
            }
            let t = build.clamp(x, min, max);
            if smooth { build.smooth(t) } else { t }
        })
        .collect()
}

/// The colors laid over each other.
fn laid(build: &mut Builder<'_>, colors: &[Color], covers: &[Mask]) -> Color {
    colors[1..].iter().zip(covers).fold(colors[0], |below, (color, cover)| build.mix(below, *color, *cover))
}

/// The hat functions of places.
fn hats(places: &[f64], t: f64, smooth: bool) -> Vec<f64> {
    let mut hats = vec![0.0; places.len()];
    let reached = places.partition_point(|at| *at <= t);
    if reached == 0 {
        hats[0] = 1.0;
    } else if reached == places.len() {
        hats[reached - 1] = 1.0;
    } else {
        let u = (t - places[reached - 1]) / (places[reached] - places[reached - 1]);
        let u = if smooth { u * u * (3.0 - 2.0 * u) } else { u };
        (hats[reached - 1], hats[reached]) = (1.0 - u, u);
    }
    hats
}

impl Pointwise for Sheet {
    fn lower(&self, node: &Settled, lowering: &mut Lowering<'_>) -> Value {
        let smooth = node.text("interpolation") == "smooth";
        let [columns, rows] = size(node);
        let (u, v) = (lowering.scalar(node.source("u")), lowering.scalar(node.source("v")));
        let colors: Vec<_> = node.all("colors").iter().map(|source| lowering.color(source)).collect();
        let build = &mut lowering.build;
        let across = covers(build, u, &places(node, "columns_at", columns), smooth);
        let rows_of_colors: Vec<_> = colors.chunks_exact(columns).map(|row| laid(build, row, &across)).collect();
        let down = covers(build, v, &places(node, "rows_at", rows), smooth);
        Value::Color(laid(build, &rows_of_colors, &down))
    }

    fn reference(&self, node: &Settled, inputs: &References<'_>) -> Reference {
        let smooth = node.text("interpolation") == "smooth";
        let [columns, rows] = size(node);
        let across = hats(&places(node, "columns_at", columns), inputs.scalar(node.source("u")), smooth);
        let down = hats(&places(node, "rows_at", rows), inputs.scalar(node.source("v")), smooth);
        let mut sum = [0.0; 3];
        for (index, source) in node.all("colors").iter().enumerate() {
            let weight = across[index % columns] * down[index / columns];
            let color = inputs.color(source);
            sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
        }
        Reference::Color(sum)
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{agrees, frame, refused};

    fn sheet(columns: usize, rows: usize, more: &str) -> String {
        let color = |i: usize| format!("[{}, {}, {}]", i as f64 / 32.0, ((i * 7) % 5) as f64 / 5.0, (i * i) % 3);
        let colors: Vec<String> = (0..columns * rows).map(color).collect();
        format!(
            r#""x": {{ "type": "ScreenX" }}, "y": {{ "type": "ScreenY" }},
            "out": {{ "type": "Sheet", "u": "x", "v": "y", "columns": {columns}, {more} "colors": [{}] }}"#,
            colors.join(", ")
        )
    }

    #[test]
    fn laying_over_is_the_sum_of_hats() {
        for more in ["", r#""interpolation": "smooth", "#] {
            for (columns, rows) in [(1, 1), (1, 4), (6, 1), (2, 2), (6, 5), (3, 7)] {
                agrees("color", &sheet(columns, rows, more));
            }
        }
        let places = r#""columns_at": [0.1, 0.4, 0.4, 1], "rows_at": [0, 0.3, 0.7], "interpolation": "smooth", "#;
        agrees("color", &sheet(4, 3, places));
    }

    #[test]
    fn crossings_show_their_color() {
        let at = |x: u32, y: u32| [f64::from(x) + 0.5, f64::from(y) + 0.5];
        for more in ["", r#""interpolation": "smooth", "#] {
            let frame = frame("color", &sheet(4, 3, more));
            for (x, y) in (0..3).flat_map(|y| (0..4).map(move |x| (x, y))) {
                assert_eq!(frame.lowered(at(x, y))[0], (y * 4 + x) as f32 / 32.0, "{x}, {y}");
            }
        }
        // Of two columns at one place the later.
        let frame = frame("color", &sheet(4, 1, r#""columns_at": [0, 0.5, 0.5, 1], "#));
        assert_eq!(frame.lowered([2.0, 1.5])[0], 2.0 / 32.0);
    }

    #[test]
    fn grids_without_whole_rows_or_places_are_refused() {
        assert!(refused("color", &sheet(3, 2, "").replace("\"columns\": 3", "\"columns\": 4")).contains("6 colors"));
        assert!(refused("color", &sheet(3, 2, r#""rows_at": [0, 0.5, 1], "#)).contains("3 places"));
        assert!(refused("color", &sheet(3, 2, r#""rows_at": [0.5, 0.25], "#)).contains("0.25 after 0.5"));
        assert!(refused("color", &sheet(3, 2, r#""rows_at": [0.5, 1.25], "#)).contains("1.25"));
    }
}
