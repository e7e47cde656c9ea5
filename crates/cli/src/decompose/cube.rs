//! A recoloring as a table of colors that other programs apply: .cube, a 3-D LUT.
//!
//! Weights of a picture that is taken apart depend on its colors alone, so to paint it in other colors is a map of colors.
//! The form is Adobe's Cube LUT Specification 1.0: colors between 0 and 1 as they are displayed, red first.

use rayon::prelude::*;
use std::fmt::Write as _;
use trochoid::{GENERATOR, VERSION};
use trochoid_palette::Decomposer;

/// Returns the table with `side` colors along each axis, from the colors of the decomposer to `into`.
pub(super) fn text(title: &str, decomposer: &Decomposer, into: &[[f64; 3]], side: usize) -> String {
    let last = (side - 1).max(1) as f64;
    let line = |index: usize| {
        let at = [index % side, index / side % side, index / side / side].map(|step| step as f64 / last);
        let weights = decomposer.weights(at);
        let mixed = |c: usize| weights.iter().zip(into).map(|(weight, color)| weight * color[c]).sum::<f64>();
        format!("{:.6} {:.6} {:.6}\n", mixed(0), mixed(1), mixed(2))
    };
    let lines: Vec<String> = (0..side * side * side).into_par_iter().map(line).collect();
    let title = title.replace(['"', '\n', '\r'], "'");
    let mut text = format!("# {GENERATOR}{VERSION}\n");
    let _ = write!(text, "TITLE \"{title}\"\nLUT_3D_SIZE {side}\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n\n");
    text.extend(lines);
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn the_table_maps_colors_red_first() {
        let corners: Vec<[f64; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from)).collect();
        let decomposer = Decomposer::new(&corners, 0.0).unwrap();
        // Red and blue change places.
        let into: Vec<[f64; 3]> = corners.iter().map(|[r, g, b]| [*b, *g, *r]).collect();
        let text = text("a \"swap\"", &decomposer, &into, 3);
        let mut lines = text.lines();
        assert!(lines.next().unwrap().starts_with("# Trochoid "));
        assert_eq!(lines.next(), Some("TITLE \"a 'swap'\""));
        let rows: Vec<&str> = lines.skip(4).collect();
        assert_eq!(rows.len(), 27);
        assert_eq!(rows[1], "0.000000 0.000000 0.500000");
        assert_eq!(rows[3], "0.000000 0.500000 0.000000");
        assert_eq!(rows[9], "0.500000 0.000000 0.000000");
    }
}
