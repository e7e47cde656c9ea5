//! Tests of the edge functions of triangles.

use trochoid_scene::inside::edge_values;

#[test]
fn half_the_width_holds_every_small_triangle() {
    let mut state = 7_u64;
    let mut random = |most: i64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as i64) % most
    };
    let (pixel, mut areas) = (1 << 12, 0);
    for case in 0..20_000 {
        // As far apart as allowed from one another, and from the starting position: a pixel to the right or less.
        let side = if case % 2 == 0 { 1 << 13 } else { 9 };
        let origin = [random(1 << 27), random(1 << 27)];
        let corners = [(); 3].map(|()| {
            let at = origin.map(|at| (at + random(side)) as i32);
            (at, random(1000) as f32 / 7.0)
        });
        let from = origin.map(|at| at + random(side + pixel) - pixel);
        for _ in 0..8 {
            let by = [random(side + 2 * pixel), random(side + 2 * pixel)];
            let [narrow, wide] = edge_values(corners, from, by);
            assert_eq!(narrow, wide, "case {case}");
            let Some(wide) = wide else { continue };
            assert_eq!(wide.inside, wide.functions.iter().all(|value| *value >= 0), "case {case}");
            areas += 1;
        }
    }
    assert!(areas > 100_000, "{areas}");
}
