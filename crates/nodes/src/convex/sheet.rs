//! Sheet: a grid of colors over two masks.

use trochoid_graph::*;

/// Blends a grid of colors by two masks; every color of the grid is reached exactly.
///
/// # Formula
/// Σ hᵢ(u)·hⱼ(v)·Cⱼᵢ with hat functions h over the positions of the columns and rows: from one to the next by the
/// fraction t = (u − atᵢ)/(atᵢ₊₁ − atᵢ). `smooth` eases it, t²(3 − 2t). Colors are listed row by row; u runs along a
/// row.
///
/// # Edge cases
/// Where a column and a row cross, exactly the color listed for them. Before the first column or row and after the
/// last, their colors. Two columns or rows at the same position give a hard edge; the position itself has the later
/// one.
///
/// # Source
/// Piecewise bilinear interpolation as a partition of unity: products of hat functions. A Patch, in contrast, does not
/// reach its inner colors.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, output(color: Kind::Color = "The color."))]
pub(crate) struct Sheet {
    /// Position along a row of colors.
    u: One<port::Mask>,
    /// Position from the first row to the last.
    v: One<port::Mask>,
    /// Colors of the grid, listed row by row.
    #[port(1..=1024)]
    colors: Many<port::Color>,
    /// Number of columns: colors in each row.
    #[knob(range = 1..=1024, required)]
    columns: i64,
    /// Positions of the columns, from 0 to 1, in ascending order; evenly spaced by default.
    #[knob(len = 1..=1024)]
    columns_at: Option<Vec<f64>>,
    /// Positions of the rows, from 0 to 1, in ascending order; evenly spaced by default.
    #[knob(len = 1..=1024)]
    rows_at: Option<Vec<f64>>,
    /// Transition from one color to the next: linear, or smooth (eased in and out).
    interpolation: Interpolation,
}

/// Transition between two colors.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Interpolation {
    Linear,
    Smooth,
}

impl Interpolation {
    /// Applies the easing to a fraction of the way.
    fn eased(self, build: &mut Builder<'_>, t: Mask) -> Mask {
        match self {
            Self::Linear => t,
            Self::Smooth => build.smooth(t),
        }
    }

    /// Applies the easing in f64.
    fn eased_reference(self, t: f64) -> f64 {
        match self {
            Self::Linear => t,
            Self::Smooth => t * t * (3.0 - 2.0 * t),
        }
    }
}

impl Sheet {
    /// Returns the number of colors in a row. A keyframed number of columns larger than the number of colors means a
    /// single row.
    fn columns_used(&self) -> usize {
        (self.columns.max(1) as usize).min(self.colors.len())
    }

    /// Returns the positions of the columns and of the rows.
    fn places(&self) -> [Vec<f64>; 2] {
        let columns = self.columns_used();
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
                let found = format!("{} positions", at.len());
                check.error(knob, found, format!("{expected}, one each"), "list as many positions, or none");
            }
            if let Some(pair) = at.windows(2).find(|pair| pair[1] < pair[0]) {
                let remedy = "sort the positions, and their colors with them";
                check.error(knob, format!("{} after {}", pair[1], pair[0]), "positions in ascending order", remedy);
            }
            if let Some(at) = at.iter().find(|at| !(0.0..=1.0).contains(*at)) {
                check.error(knob, format!("a position of {at}"), "positions from 0 to 1", "divide them by the largest");
            }
        }
    }
}

/// Returns a mask for each color after the first: how far it covers the colors before it.
fn cover_masks(build: &mut Builder<'_>, x: Scalar, places: &[f64], between: Interpolation) -> Vec<Mask> {
    let cover = |at: &[f64]| {
        let (min, max) = (at[0], at[1]);
        if min >= max {
            return build.step(x, max);
        }
        let t = build.clamp(x, min, max);
        between.eased(build, t)
    };
    places.windows(2).map(cover).collect()
}

/// Mixes each color over those before it.
fn mix_over(build: &mut Builder<'_>, colors: &[Color], cover_masks: &[Mask]) -> Color {
    colors[1..].iter().zip(cover_masks).fold(colors[0], |below, (color, cover)| build.mix(below, *color, *cover))
}

/// Returns the hat functions of the positions at `t`.
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
        let across = cover_masks(build, u, &columns, self.interpolation);
        let rows_of_colors = colors.chunks_exact(self.columns_used()).map(|row| mix_over(build, row, &across));
        let rows_of_colors: Vec<_> = rows_of_colors.collect();
        let down = cover_masks(build, v, &rows, self.interpolation);
        Value::Color(mix_over(build, &rows_of_colors, &down))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let [columns, rows] = self.places();
        let across = hats(&columns, inputs.scalar(&self.u), self.interpolation);
        let down = hats(&rows, inputs.scalar(&self.v), self.interpolation);
        let columns = self.columns_used();
        let mut sum = [0.0; 3];
        for (index, source) in self.colors.iter().enumerate() {
            let weight = across[index % columns] * down[index / columns];
            let color = inputs.color(source);
            sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
        }
        Reference::Color(sum)
    }
}
