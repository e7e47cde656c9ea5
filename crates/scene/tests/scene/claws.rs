//! Tests of claws.

use trochoid_image::Window;
use trochoid_scene::claws::{Claw, Places, Ribbon, Shape, covered};

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
    let found = places.find(&claw, within, offset);
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
