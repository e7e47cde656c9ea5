//! Tests of claws.

use trochoid_image::Window;
use trochoid_scene::claws::{Claw, Places, Ribbon, RibbonPoint, Shape, covered};

use crate::random::Draw;

#[test]
fn the_fast_way_finds_what_every_place_finds_itself() {
    let shape = Shape { curl: 1.9, late: 2.0, taper: 0.6, bulge: 0.2 };
    let thumb = Shape { curl: 1.5, late: 2.2, taper: 0.6, bulge: 0.0 };
    let parts = vec![
        (Ribbon::new(&thumb, [20.0, 9.0], 1.2, 14.0, 3.0), 0.25),
        (Ribbon::new(&shape, [8.3, 8.1], 0.1, 30.0, 6.0), 0.75),
    ];
    let claw = Claw { parts, depth: 1.0, side: 1.0, row: 2.0, tag: 5.0, line: [1.2, 0.8], shade: 0.9 };
    let (window, offset) = (Window::new(-3, -2, 45, 40), [0.25, 0.75]);
    let mut places = Places::default();
    let within = covered(claw.bounds(), window);
    let found = places.find(&claw, within, offset, None);
    let mut parts_seen = [0, 0];
    for (index, y) in (within.y0..within.y1).enumerate() {
        for (column, x) in (within.x0..within.x1).enumerate() {
            let at = claw.at([x as f64 + offset[0], y as f64 + offset[1]]);
            assert_eq!(found[index * within.width() + column], at, "{x}, {y}");
            if let Some((within, random)) = at {
                parts_seen[usize::from(random > 0.5)] += 1;
                let drawn = claw.drawn(within, random);
                let masks = [drawn.mask, drawn.ink, drawn.shade];
                assert!(masks.iter().all(|mask| (0.0..=1.0).contains(mask)), "{drawn:?}");
                assert_eq!((drawn.row, drawn.tag), (2.0, 5.0));
            }
        }
    }
    assert!(parts_seen.iter().all(|count| *count > 20), "{parts_seen:?}");
    // Nothing is found outside.
    for place in (0..2000).map(|i| [f64::from(i % 50) - 4.0, f64::from(i / 50) - 3.0]) {
        let [[x0, x1], [y0, y1]] = claw.bounds();
        let inside = (x0..=x1).contains(&place[0]) && (y0..=y1).contains(&place[1]);
        assert!(inside || claw.at(place).is_none());
    }
}

#[test]
fn samples_side_by_side_have_the_bits_of_single_ones() {
    let mut draw = Draw(5);
    let mut between = |low: f64, high: f64| low + (high - low) * draw.next();
    let bits = |found: Option<(RibbonPoint, f64)>| {
        found.map(|(RibbonPoint { along, across, half_width }, random)| {
            [along, across, half_width, random].map(f64::to_bits)
        })
    };
    // Some ribbons are points, hair-thin, much wider than long, or too small for squares.
    let sizes = [0.0, 1e-300, 1e-160, 1e-3, 1.0, 7.0, 30.0];
    let (mut places, mut inside) = (Places::default(), 0);
    for round in 0..300 {
        let parts = (0..3).map(|part| {
            let shape = Shape {
                curl: between(-7.0, 7.0),
                late: between(0.1, 4.0),
                taper: between(0.05, 3.0),
                bulge: between(0.0, 2.0),
            };
            let mut size = || sizes[between(0.0, 7.0) as usize] * between(0.5, 1.0);
            let [length, half_width] = if round % 3 == 0 { [size(), size()] } else { [between(0.0, 40.0), 5.0] };
            let root =
                [between(-9.0, 30.0), between(-9.0, 20.0)].map(|at| if round % 2 == 0 { at.floor() } else { at });
            (Ribbon::new(&shape, root, between(-4.0, 4.0), length, half_width), f64::from(part))
        });
        let claw =
            Claw { parts: parts.collect(), depth: 1.0, side: 1.0, row: 1.0, tag: 0.0, line: [0.0; 2], shade: 0.0 };
        // Samples on points of the spine have a distance of 0.
        let offset = if round % 2 == 0 { [0.0, 0.0] } else { [between(0.0, 1.0), between(0.0, 1.0)] };
        let window = Window::new(-4, -3, 4 + round % 23, 17);
        let found = places.find(&claw, window, offset, None);
        let pixels = (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| [x, y]));
        for (found, pixel) in found.iter().zip(pixels) {
            let alone = claw.at([0, 1].map(|axis| pixel[axis] as f64 + offset[axis]));
            assert_eq!(bits(*found), bits(alone), "round {round}, {pixel:?}: {found:?}, {alone:?}");
            inside += usize::from(alone.is_some());
        }
    }
    assert!(inside > 5000, "only {inside} samples are inside");
}

#[test]
fn ink_lies_on_rims_and_shade_on_the_inner_side() {
    let shape = Shape { curl: 0.0, late: 1.0, taper: 0.05, bulge: 0.0 };
    let parts = vec![(Ribbon::new(&shape, [0.0, 0.0], 0.0, 100.0, 10.0), 0.0)];
    let claw = Claw { parts, depth: 1.0, side: 1.0, row: 1.0, tag: 0.0, line: [2.0, 1.0], shade: 1.0 };
    let drawn = |x: f64, y: f64| {
        let (within, random) = claw.at([x, y]).unwrap();
        claw.drawn(within, random)
    };
    // The inner side is the right of the ribbon, which is at the bottom of the picture.
    assert_eq!(drawn(50.0, -9.3).ink, 1.0, "outer rim");
    assert_eq!(drawn(50.0, 0.0).ink, 0.0, "middle");
    assert_eq!(drawn(3.0, -5.0).ink, 0.0, "no ink at the root");
    assert_eq!(drawn(42.0, 6.0).shade, 1.0, "shade");
    assert_eq!(drawn(42.0, -6.0).shade, 0.0);
    assert_eq!(drawn(95.0, 6.0).shade, 0.0, "the crescent has ended");
}
