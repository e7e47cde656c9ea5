//! Patch: a Bézier patch of colors over two masks.

use trochoid_graph::*;

/// Blends a grid of 4 colors (bilinear) or 16 colors (bicubic Bézier) by two masks.
///
/// # Formula
/// Σ Bᵢ(u)·Bⱼ(v)·Cⱼᵢ with Bernstein polynomials of degree 1 or 3. Colors are listed row by row; u runs along a row.
///
/// # Edge cases
/// The corner colors appear exactly at the corners. The other 12 of 16 colors pull the result toward themselves but are
/// never reached exactly.
///
/// # Source
/// Bézier patch, evaluated by de Casteljau's algorithm, first in u, then in v; thesis 3.2.4.3.
#[derive(Clone, Node)]
#[node(pointwise, end = Back, revision = 1, role = Patch, output(color: Kind::Color = "The color."))]
pub(crate) struct Patch {
    /// Position along a row of colors.
    u: One<port::Mask>,
    /// Position from the first row to the last.
    v: One<port::Mask>,
    /// 4 or 16 colors, listed row by row.
    #[port(4..=16)]
    colors: Many<port::Color>,
}

/// Evaluates a Bézier curve at `t`: mixes neighbors until one color is left.
fn casteljau(build: &mut Builder<'_>, mut points: Vec<Color>, t: Mask) -> Color {
    while points.len() > 1 {
        points = points.windows(2).map(|pair| build.mix(pair[0], pair[1], t)).collect();
    }
    points[0]
}

/// Returns the Bernstein polynomials at `t`, of degree 1 or 3.
fn bernstein(side: usize, t: f64) -> Vec<f64> {
    let s = 1.0 - t;
    if side == 2 { vec![s, t] } else { vec![s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t] }
}

impl Patch {
    /// Returns the number of colors in a row: 2 of 4 colors, 4 of 16.
    fn side(&self) -> usize {
        if self.colors.len() < 16 { 2 } else { 4 }
    }
}

impl Node for Patch {
    fn check(&self, check: &mut Check<'_>) {
        let count = self.colors.len();
        if count != 4 && count != 16 {
            let remedy =
                "list 2 rows of 2 or 4 rows of 4 colors; use a Ramp for a single row, a Blend for other weights";
            check.error(Self::COLORS, format!("{count} colors"), "4 or 16 colors", remedy);
        }
    }
}

impl Pointwise for Patch {
    fn lower(&self, lowering: &mut Lowering<'_>) -> Value {
        let (u, v) = (lowering.mask(&self.u), lowering.mask(&self.v));
        let colors: Vec<_> = self.colors.iter().map(|source| lowering.color(source)).collect();
        let build = &mut lowering.build;
        let rows = colors.chunks(self.side()).map(|row| casteljau(build, row.to_vec(), u)).collect();
        Value::Color(casteljau(build, rows, v))
    }

    fn reference(&self, inputs: &References<'_>) -> Reference {
        let side = self.side();
        let along = bernstein(side, inputs.scalar(&self.u));
        let down = bernstein(side, inputs.scalar(&self.v));
        let mut sum = [0.0; 3];
        for (index, source) in self.colors.iter().enumerate() {
            let weight = along[index % side] * down[index / side];
            let color = inputs.color(source);
            sum = [0, 1, 2].map(|c| sum[c] + weight * color[c]);
        }
        Reference::Color(sum)
    }
}
