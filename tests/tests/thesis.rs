//! The claim of the thesis: the picture keeps its style for any image as weight.

use crate::support::{evaluate, root, settings};
use trochoid::{Buffers, CheckedGraph, Format, Rgb, load};

const WIDTH: usize = 96;
const HEIGHT: usize = 54;

fn storm() -> CheckedGraph {
    let loaded = load(&root().join("graphs/open_sea.json"), &[]).unwrap();
    loaded.graph.with_format(Format::new(WIDTH as u32, HEIGHT as u32, 4).unwrap())
}

/// Returns images that were not made to be weights.
fn images() -> Vec<(&'static str, Vec<f32>)> {
    let make = |f: &dyn Fn(f32, f32) -> f32| -> Vec<f32> {
        let pixel = |i: usize| f((i % WIDTH) as f32 / (WIDTH - 1) as f32, (i / WIDTH) as f32 / (HEIGHT - 1) as f32);
        (0..WIDTH * HEIGHT).map(|i| pixel(i).clamp(0.0, 1.0)).collect()
    };
    let mut state = 1u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    let noise: Vec<f32> = (0..WIDTH * HEIGHT).map(|_| noise()).collect();
    // Like a photograph: soft shapes, a horizon, a disc of light, grain and vignetting.
    let photograph = make(&|x, y| {
        let grain = 0.03 * (127.0 * x + 311.0 * y).sin();
        let hills = if y > 0.6 + 0.1 * (5.0 * x).sin() { 0.25 } else { 0.7 - 0.4 * y };
        let disc = 0.6 * (-60.0 * ((x - 0.7).powi(2) + (y - 0.25).powi(2))).exp();
        (hills + disc + grain) * (1.2 - 0.8 * ((x - 0.5).powi(2) + (y - 0.5).powi(2)))
    });
    vec![
        ("noise", noise),
        ("a checkerboard", make(&|x, y| ((x * 31.0) as i32 + (y * 17.0) as i32).rem_euclid(2) as f32)),
        ("a gradient", make(&|x, y| 0.5 * (x + y))),
        ("a photograph", photograph),
        ("nothing", make(&|_, _| 0.0)),
        ("everything", make(&|_, _| 1.0)),
    ]
}

#[test]
fn any_image_as_weight_keeps_the_palette() {
    let graph = storm();
    let mask = graph.nodes().iter().find(|node| node.ty.declaration().name == "NonSpecular").unwrap();
    let name = mask.name.clone();
    let plain = evaluate(&graph, 1, &Buffers::new(), &settings(|s| s.threads = 2));
    let palette: Vec<Rgb> = plain.pictures[0].control_colors.clone();
    assert!(palette.len() >= 3, "{palette:?}");
    let mut seen = vec![plain.pictures[0].planes.clone()];
    for (what, image) in images() {
        let buffers = Buffers::new().with(&name, &[&image]);
        let frame = evaluate(&graph, 1, &buffers, &settings(|s| s.threads = 2));
        let picture = &frame.pictures[0];
        let audit = picture.audit;
        assert_eq!((audit.hull_exits, audit.nan_count), (0, 0), "{what}");
        assert_eq!(audit.pixels, (WIDTH * HEIGHT) as u64);
        assert!(audit.weight_min >= 0.0 && audit.weight_sum_max_deviation == 0.0, "{what}: {audit:?}");
        assert_eq!(picture.control_colors, palette, "{what}: the palette is the same");
        in_hull(&palette, picture, what);
        assert!(seen.iter().all(|planes| *planes != picture.planes), "{what} changes the picture");
        seen.push(picture.planes.clone());
    }
}

/// Checks that no pixel lies beyond the palette in any of many directions. This is independent of the engine, which
/// judges by the facets of the hull.
fn in_hull(palette: &[Rgb], picture: &trochoid::Picture, what: &str) {
    let [r, g, b] = [0, 1, 2].map(|c| picture.planes[c].samples());
    for i in 0..1000u32 {
        // A Fibonacci sphere.
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 1000.0;
        let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let ring = (1.0 - z * z).sqrt();
        let along =
            |color: Rgb| ring * cos * f64::from(color[0]) + ring * sin * f64::from(color[1]) + z * f64::from(color[2]);
        let reach = palette.iter().map(|color| along(*color)).fold(f64::NEG_INFINITY, f64::max);
        for at in 0..r.len() {
            let excess = along([r[at], g[at], b[at]]) - reach;
            assert!(excess <= picture.margin, "{what}: pixel {at} is {excess:e} outside");
        }
    }
}
