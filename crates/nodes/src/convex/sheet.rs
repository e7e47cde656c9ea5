//! Sheet: a grid of colors over two masks.

use trochoid_graph::*;

/// Spans a grid of colors over two masks, and meets every one of them.
///
/// # Formula
/// Σ hᵢ(u)·hⱼ(v)·Cⱼᵢ, the hat functions h over the places of the columns and rows: between two places t = (u −
/// atᵢ)/(atᵢ₊₁ − atᵢ) of the way to the next; `smooth` eases t²(3 − 2t). Colors row by row, u fastest.
///
/// # Edge cases
/// At a crossing exactly its color; before the first and after the last column or row theirs. Two columns or rows at
/// one place are a hard edge, with the later one at the place itself.
///
/// # Source
/// Piecewise bilinear interpolation as a partition of unity: products of hat functions. Unlike a Patch, whose inner
/// colors pull without being met.
#[derive(Clone, Node)]
#[node(end = Back, revision = 1, output(color: Kind::Color = "The color."))]
pub(crate) struct Sheet {
    /// Along a row of colors.
    u: One<port::Mask>,
    /// From row to row.
    v: One<port::Mask>,
    /// The colors, row by row, u fastest.
    #[port(1..=1024)]
    colors: Many<port::Color>,
    /// Colors in a row.
    #[knob(range = 1..=1024, required)]
    columns: i64,
    /// Places of the columns, 0 to 1, ascending; by default evenly from 0 to 1.
    #[knob(len = 1..=1024)]
    columns_at: Option<Vec<f64>>,
    /// Places of the rows, 0 to 1, ascending; by default evenly from 0 to 1.
    #[knob(len = 1..=1024)]
    rows_at: Option<Vec<f64>>,
    /// How to get from color to color.
    interpolation: Interpolation,
}

/// What lies between two colors.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Interpolation {
    Linear,
    Smooth,
}

impl Interpolation {
    /// A part of the way as it is gone.
    fn eased(self, build: &mut Builder<'_>, t: Mask) -> Mask {
        match self {
            Self::Linear => t,
            Self::Smooth => build.smooth(t),
        }
    }

    /// The same in f64.
    fn eased_reference(self, t: f64) -> f64 {
        match self {
            Self::Linear => t,
            Self::Smooth => t * t * (3.0 - 2.0 * t),
        }
    }
}

impl Sheet {
    /// Colors in a row; a keyed number of columns that the colors do not fill is that of one row.
    fn in_a_row(&self) -> usize {
        (self.columns.max(1) as usize).min(self.colors.len())
    }

    /// Places of the columns, and of the rows.
    fn places(&self) -> [Vec<f64>; 2] {
        let columns = self.in_a_row();
        let evenly = |count: usize| {
            let last = (count - 1).max(1) as f64;
            (0..count).map(|index| index as f64 / last).collect()
        };
        let places = |given: &Option<Vec<f64>>, count: usize| given.clone().unwrap_or_else(|| evenly(count));
        [places(&self.columns_at, columns), places(&self.rows_at, self.colors.len() / columns)]
    }
}

impl Node for Sheet {
    fn check(&self, check: &mut Check<'_>) {
        let (count, columns) = (self.colors.len(), self.columns.max(1) as usize);
        if count == 0 {
            return;
        }
        if count % columns != 0 {
            let found = format!("{count} colors in rows of {columns}");
            let remedy = format!("list {} colors, or set another number of columns", count.div_ceil(columns) * columns);
            check.error(Self::COLORS, found, "whole rows", remedy);
            return;
        }
        let axes = [(Self::COLUMNS_AT, &self.columns_at, columns), (Self::ROWS_AT, &self.rows_at, count / columns)];
        for (knob, at, expected) in axes {
            let Some(at) = at else { continue };
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
fn covers(build: &mut Builder<'_>, x: Scalar, places: &[f64], between: Interpolation) -> Vec<Mask> {
    let pairs = places.windows(2).map(|at| (at[0] as f32, at[1] as f32));
    let cover = |(min, max): (f32, f32)| {
        if min >= max {
            return build.step(x, max);
        }
        let t = build.clamp(x, min, max);
        between.eased(build, t)
    };
    pairs.map(cover).collect()
}

/// The colors laid over each other.
fn laid(build: &mut Builder<'_>, colors: &[Color], covers: &[Mask]) -> Color {
    colors[1..].iter().zip(covers).fold(colors[0], |below, (color, cover)| build.mix(below, *color, *cover))
}

/// The hat functions of places.
fn hats(places: &[f64], t: f64, between: Interpolation) -> Vec<f64> {
    let mut hats = vec![0.0; places.len()];
    let reached = places.partition_point(|at| *at <= t);
    if reached == 0 {
        hats[0] = 1.0;
    } else if reached == places.len() {
        hats[reached - 1] = 1.0;
    } else {
        let u = (t - places[reached - 1]) / (places[reached] - places[reached - 1]);
        let u = between.eased_reference(u);
        (hats[reached - 1], hats[reached]) = (1.0 - u, u);
    }
    hats
}

impl Pointwise for Sheet {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let [columns, rows] = self.places();
        let (u, v) = (lowering.scalar(&self.u), lowering.scalar(&self.v));
        let colors: Vec<_> = self.colors.iter().map(|source| lowering.color(source)).collect();
        let build = &mut lowering.build;
        let across = covers(build, u, &columns, self.interpolation);
        let rows_of_colors = colors.chunks_exact(self.in_a_row()).map(|row| laid(build, row, &across));
        let rows_of_colors: Vec<_> = rows_of_colors.collect();
        let down = covers(build, v, &rows, self.interpolation);
        Value::Color(laid(build, &rows_of_colors, &down))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let [columns, rows] = self.places();
        let across = hats(&columns, inputs.scalar(&self.u), self.interpolation);
        let down = hats(&rows, inputs.scalar(&self.v), self.interpolation);
        let columns = self.in_a_row();
        let mut sum = [0.0; 3];
        for (index, source) in self.colors.iter().enumerate() {
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
