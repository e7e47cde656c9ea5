//! Tests of the edge functions of triangles.

use trochoid_scene::inside::{edge_values, narrow_edge_values};

#[test]
fn half_the_width_and_floats_hold_every_triangle_that_they_are_for() {
    let mut state = 7_u64;
    let mut random = |most: i64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as i64) % most
    };
    let (pixel, mut areas, mut insides) = (1 << 12, [0; 4], 0);
    for case in 0..40_000 {
        // As far apart as allowed from one another, and from the starting position: a pixel to the right or less.
        let side = [1 << 14, 9, 1 << 24, 1 << 18][case % 4];
        let origin = [random(1 << 27), random(1 << 27)];
        let corners = [(); 3].map(|()| {
            let at = origin.map(|at| (at + random(side)) as i32);
            (at, random(1000) as f32 / 7.0)
        });
        let from = origin.map(|at| at + random(side + pixel) - pixel);
        for _ in 0..8 {
            let by = [random(side + 2 * pixel), random(side + 2 * pixel)];
            let [wide, float] = edge_values(corners, from, by);
            assert_eq!(float, wide, "case {case}");
            if side <= 1 << 14 {
                assert_eq!(narrow_edge_values(corners, from, by), wide, "case {case}");
            }
            let Some(wide) = wide else { continue };
            assert_eq!(wide.inside, wide.functions.iter().all(|value| *value >= 0), "case {case}");
            areas[case % 4] += 1;
            insides += usize::from(wide.inside);
        }
    }
    assert!(areas.iter().all(|areas| *areas > 30_000) && insides > 1000, "{areas:?}, {insides}");
}
