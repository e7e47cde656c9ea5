//! Tests of Render.

use crate::testing::{Frame, graph};
use rayon::prelude::*;
use std::path::Path;
use trochoid_image::Window;

/// Filters and strokes may ask for pixels beyond the part for which a view was prepared, from many threads at once.
#[test]
fn pixels_beyond_a_part_have_the_bits_of_the_whole() {
    let nodes = r#""camera": { "type": "Camera", "position": [0, 3, 10] }, "sea": { "type": "GerstnerSea", "count": 40 },
        "view": { "type": "Render", "camera": "camera", "surfaces": ["sea"] }, "out": { "type": "Height", "view": "view" }"#;
    let frame = |part: Option<Window>| Frame::near(graph("field", nodes, Path::new(".")).unwrap(), part).unwrap();
    let (whole, part) = (frame(None), frame(Some(Window::new(1, 1, 2, 2))));
    let Window { x0, y0, x1, y1 } = whole.context.format.window();
    let pixels: Vec<[i64; 2]> = (y0..y1).flat_map(|y| (x0..x1).map(move |x| [x, y])).collect();
    let (view, height) = (whole.graph.find("view").unwrap(), trochoid_image::Channel::Height as usize);
    let differ = |[x, y]: &[i64; 2]| {
        let at = [*x as f64 + 0.5, *y as f64 + 0.5];
        let [a, b] = [&whole, &part].map(|frame| frame.filled(view, 0, height, at).to_bits());
        a != b
    };
    assert_eq!(pixels.par_iter().filter(|pixel| differ(pixel)).count(), 0);
}
