//! Tests of the hull against brute force, on random, degenerate and lattice points.

use proptest::prelude::*;
use trochoid_weights::arithmetic::{blend, normalize};
use trochoid_weights::{BoxHull, Hull, HullBuilder};

type Lattice = [i64; 3];

fn color(p: Lattice) -> [f32; 3] {
    p.map(|v| v as f32 / 256.0)
}

fn sub(a: Lattice, b: Lattice) -> Lattice {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Lattice, b: Lattice) -> Lattice {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Lattice, b: Lattice) -> i64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Whether p is a convex combination of some of the points, in integers. By Carathéodory's theorem, four points are
/// enough.
fn contains(points: &[Lattice], p: Lattice) -> bool {
    let on_segment = |a: Lattice, b: Lattice| cross(sub(b, a), sub(p, a)) == [0; 3] && dot(sub(p, a), sub(p, b)) <= 0;
    let in_triangle = |a: Lattice, b: Lattice, c: Lattice| {
        let normal = cross(sub(b, a), sub(c, a));
        let turn = |a: Lattice, b: Lattice| dot(normal, cross(sub(b, a), sub(p, a)));
        normal != [0; 3] && dot(normal, sub(p, a)) == 0 && turn(a, b) >= 0 && turn(b, c) >= 0 && turn(c, a) >= 0
    };
    let volume = |a: Lattice, b: Lattice, c: Lattice, d: Lattice| dot(cross(sub(b, a), sub(c, a)), sub(d, a)).signum();
    let in_simplex = |a: Lattice, b: Lattice, c: Lattice, d: Lattice| {
        let whole = volume(a, b, c, d);
        whole != 0
            && [volume(p, b, c, d), volume(a, p, c, d), volume(a, b, p, d), volume(a, b, c, p)]
                .iter()
                .all(|&part| part * whole >= 0)
    };
    points.iter().enumerate().any(|(i, &a)| {
        points[..=i].iter().enumerate().any(|(j, &b)| {
            on_segment(a, b)
                || points[..j]
                    .iter()
                    .enumerate()
                    .any(|(k, &c)| in_triangle(a, b, c) || points[..k].iter().any(|&d| in_simplex(a, b, c, d)))
        })
    })
}

/// Points of a coarse lattice, so that duplicates, collinear points and coplanar faces are frequent; often without
/// volume.
fn cloud() -> impl Strategy<Value = Vec<Lattice>> {
    let solid = |side: i64, count: usize| prop::collection::vec([0..side, 0..side, 0..side], 0..count);
    let plane = prop::collection::vec([0_i64..6, 0_i64..6], 1..14).prop_flat_map(|coordinates| {
        ([-2_i64..3, -2_i64..3, -2_i64..3], [-2_i64..3, -2_i64..3, -2_i64..3]).prop_map(move |(u, v)| {
            coordinates.iter().map(|c| std::array::from_fn(|i| 60 + c[0] * u[i] + c[1] * v[i])).collect()
        })
    });
    prop_oneof![solid(3, 14), solid(5, 16), solid(256, 14), solid(1, 4), plane]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn hull_agrees_with_brute_force(points in cloud(), probes in prop::collection::vec([0_i64..8, 0_i64..8, 0_i64..8], 12)) {
        let hull = Hull::new(&points.iter().map(|&p| color(p)).collect::<Vec<_>>());
        let mut distinct = points.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let mut extreme: Vec<[f32; 3]> = (0..distinct.len()).filter(|&i| {
            let others: Vec<Lattice> = distinct.iter().copied().filter(|&p| p != distinct[i]).collect();
            !contains(&others, distinct[i])
        }).map(|i| color(distinct[i])).collect();
        let mut vertices = hull.vertices().to_vec();
        let order = |a: &[f32; 3], b: &[f32; 3]| a.partial_cmp(b).unwrap();
        vertices.sort_by(order);
        extreme.sort_by(order);
        prop_assert_eq!(vertices, extreme);
        let offset = if distinct.iter().flatten().any(|&v| v > 40) { 56 } else { 0 };
        for probe in probes.iter().map(|p| p.map(|v| v + offset)).chain(distinct.iter().copied()) {
            let exit = hull.exit(&color(probe), hull.margin(0));
            prop_assert_eq!(exit.is_none(), contains(&distinct, probe), "{:?} of {:?}: {:?}", probe, distinct, exit);
            let distance = hull.signed_distance(color(probe).map(f64::from));
            prop_assert_eq!(distance <= hull.margin(0), exit.is_none());
            if let Some(witness) = exit.and_then(|_| hull.witness(color(probe).map(f64::from))) {
                prop_assert!((witness.distance - distance).abs() < 1e-12);
                // Near an edge the normal comes from a rounded difference.
                let rounding = 1e-12_f64.max(1e-15 / distance);
                for v in hull.vertices() {
                    let reach: f64 = (0..3).map(|i| witness.normal[i] * f64::from(v[i])).sum();
                    prop_assert!(reach <= witness.offset + rounding);
                }
            }
        }
    }

    #[test]
    fn blends_of_the_points_are_no_exits(
        points in prop::collection::vec([0.0_f32..1.0, 0.0_f32..1.0, 0.0_f32..1.0], 1..30),
        weights in prop::collection::vec(0.0_f32..1.0, 30),
        flat in any::<bool>(),
    ) {
        let points: Vec<[f32; 3]> = points.iter().map(|&[r, g, b]| if flat { [r, g, 0.25] } else { [r, g, b] }).collect();
        let hull = Hull::new(&points);
        let mut parts = vec![0.0; points.len()];
        normalize(&weights[..points.len() - 1], 1e-3, &mut parts);
        let blend = [0, 1, 2].map(|i| blend(&points.iter().map(|point| point[i]).collect::<Vec<_>>(), &parts));
        prop_assert_eq!(hull.exit(&blend, hull.margin(1)), None);
        prop_assert_eq!(BoxHull::new(&points).exit(&blend, 0.0), None);
        for point in &points {
            prop_assert_eq!(hull.exit(point, hull.margin(0)), None);
        }
    }

    #[test]
    fn rows_agree_with_pixels(
        points in prop::collection::vec([0.2_f32..0.8, 0.2_f32..0.8, 0.2_f32..0.8], 1..200),
        pixels in prop::collection::vec(prop::array::uniform3(
            prop_oneof![40 => 0.0_f32..1.0, 1 => Just(f32::NAN), 1 => Just(f32::INFINITY), 1 => Just(f32::NEG_INFINITY)]), 200),
        margin in prop_oneof![Just(0.0), 0.0_f64..0.2],
    ) {
        let hull = Hull::new(&points);
        let channel = |i: usize| pixels.iter().map(|p| p[i]).collect::<Vec<_>>();
        let (r, g, b) = (channel(0), channel(1), channel(2));
        let single: Vec<f64> = pixels.iter().filter_map(|p| hull.exit(p, margin)).collect();
        prop_assert_eq!(hull.exits(&r, &g, &b, margin), (single.len() as u64, single.iter().copied().fold(0.0, f64::max)));
        for pixel in pixels.iter().filter(|p| p.iter().all(|v| v.is_finite())) {
            let distance = hull.signed_distance(pixel.map(f64::from));
            prop_assert_eq!(hull.exit(pixel, margin), (distance > margin).then_some(distance));
        }
        let around = BoxHull::new(&points);
        let single: Vec<f64> = pixels.iter().filter_map(|p| around.exit(p, margin)).collect();
        prop_assert_eq!(around.exits(&r, &g, &b, margin), (single.len() as u64, single.iter().copied().fold(0.0, f64::max)));
    }

    /// Tests pixels near faces, edges and corners, at fractions and multiples of the margin, and difficult ones.
    #[test]
    fn rows_agree_with_pixels_at_the_boundary(
        points in prop::collection::vec([0.0_f32..1.0, 0.0_f32..1.0, 0.0_f32..1.0], 1..150),
        stretch in prop::array::uniform3(prop_oneof![4 => Just(1.0_f32), 1 => Just(0.0), 1 => Just(1e-2), 1 => Just(1e-4), 1 => Just(1e-6)]),
        turned in any::<bool>(),
        scale in prop_oneof![8 => Just(1.0_f32), 1 => Just(1e-42), 1 => Just(1e-33), 1 => Just(1e-20), 1 => Just(1e20), 1 => Just(1e37)],
        levels in prop_oneof![Just(0), Just(1), 2_usize..40],
        large in prop_oneof![9 => Just(0.0), 1 => Just(0.1), 1 => Just(f64::INFINITY)],
        mixes in prop::collection::vec((any::<[prop::sample::Index; 3]>(),
            prop::array::uniform2(prop_oneof![Just(0.0_f32), Just(1.0), 0.0_f32..1.0]),
            prop::array::uniform3(prop_oneof![3 => Just(0.0_f64), 2 => -1.0..1.0]),
            prop_oneof![Just(0.0_f64), Just(0.5), Just(0.99), Just(1.01), Just(2.0), Just(1e3), Just(1e6)]), 300),
        hostile in prop::collection::vec((0_usize..300, 0_usize..3, prop_oneof![
            Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY), Just(f32::MAX), Just(-f32::MAX),
            Just(f32::from_bits(1)), Just(-0.0), Just(-1.0)]), 0..6),
    ) {
        let place = |p: &[f32; 3]| {
            let [x, y, z]: [f32; 3] = std::array::from_fn(|i| p[i] * stretch[i]);
            let [x, y, z] = if turned { [0.2 + 0.5 * x + 0.25 * y - 0.125 * z, 0.4 - 0.25 * x + 0.5 * y, 0.1 + z + 0.25 * x] } else { [x, y, z] };
            [x * scale, y * scale, z * scale]
        };
        let points: Vec<[f32; 3]> = points.iter().map(place).collect();
        let hull = Hull::new(&points);
        let margin = hull.margin(levels) + large;
        let corners = hull.vertices();
        let mut pixels: Vec<[f32; 3]> = mixes.iter().map(|(colors, [t, u], away, times)| {
            let [a, b, c] = colors.each_ref().map(|index| corners[index.index(corners.len())]);
            std::array::from_fn(|i| {
                let mixed = trochoid_weights::arithmetic::mix(trochoid_weights::arithmetic::mix(a[i], b[i], *t), c[i], *u);
                (f64::from(mixed) + away[i] * times * hull.margin(levels)) as f32
            })
        }).collect();
        for &(at, channel, value) in &hostile {
            pixels[at][channel] = value;
        }
        let channel = |i: usize| pixels.iter().map(|p| p[i]).collect::<Vec<_>>();
        let (r, g, b) = (channel(0), channel(1), channel(2));
        let single: Vec<f64> = pixels.iter().filter_map(|p| hull.exit(p, margin)).collect();
        prop_assert_eq!(hull.exits(&r, &g, &b, margin), (single.len() as u64, single.iter().copied().fold(0.0, f64::max)));
    }

    #[test]
    fn pieces_and_order_do_not_matter(points in prop::collection::vec(any::<[u8; 3]>(), 1..4000), cut in any::<prop::sample::Index>()) {
        let points: Vec<[f32; 3]> = points.iter().map(|p| p.map(|v| f32::from(v) / 255.0)).collect();
        let whole = Hull::new(&points);
        let cut = cut.index(points.len());
        let mut builder = HullBuilder::new();
        builder.add(&points[cut..]);
        let head = &points[..cut];
        let channel = |i: usize| head.iter().map(|p| p[i]).collect::<Vec<_>>();
        builder.add_row(&channel(0), &channel(1), &channel(2));
        prop_assert_eq!(builder.finish(), whole);
    }
}

#[test]
fn degenerate_hulls() {
    let empty = Hull::new(&[]);
    assert_eq!((empty.dimension(), empty.vertices().len()), (None, 0));
    assert_eq!(empty.signed_distance([0.0; 3]), f64::INFINITY);
    assert_eq!(empty.exits(&[0.5], &[0.5], &[0.5], 0.0), (1, f64::INFINITY));
    assert!(empty.witness([0.0; 3]).is_none());

    let point = Hull::new(&[[0.5; 3]; 100]);
    assert_eq!((point.dimension(), point.facets().len()), (Some(0), 6));
    assert_eq!(point.signed_distance([0.5; 3]), 0.0);
    assert_eq!(point.signed_distance([0.5, 0.5 + 0.375, 0.5 + 0.5]), 0.625);

    let gray: Vec<[f32; 3]> = (0..=255).map(|v| [v as f32 / 255.0; 3]).collect();
    let segment = Hull::new(&gray);
    assert_eq!((segment.dimension(), segment.vertices().len()), (Some(1), 2));
    assert!(segment.signed_distance([0.3; 3]).abs() < 1e-15);
    assert!((segment.signed_distance([2.0, 1.0, 1.0]) - 1.0).abs() < 1e-15);
    assert!((segment.signed_distance([1.0, 0.0, 0.0]) - (2.0_f64 / 3.0).sqrt()).abs() < 1e-15);

    let square = Hull::new(&[
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.5, 0.5, 1.0],
        [0.5, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ]);
    assert_eq!((square.dimension(), square.vertices().len(), square.facets().len()), (Some(2), 4, 6));
    assert_eq!(square.signed_distance([0.25, 0.25, 1.5]), 0.5);
    assert_eq!(square.signed_distance([1.375, 1.5, 1.0]), 0.625);

    let cube: Vec<[f32; 3]> = (0..27).map(|i| [i / 9, i / 3 % 3, i % 3].map(|v| v as f32 / 2.0)).collect();
    let cube = Hull::new(&cube);
    assert_eq!((cube.dimension(), cube.vertices().len(), cube.facets().len()), (Some(3), 8, 6));
    assert_eq!(cube.signed_distance([0.5, 0.5, 0.75]), -0.25);
    assert_eq!(cube.signed_distance([2.0, 2.0, 2.0]), 3.0_f64.sqrt());
}

#[test]
fn points_that_are_not_finite_are_left_out_and_judged_as_exits() {
    let hull = Hull::new(&[[0.0; 3], [f32::NAN; 3], [1.0; 3], [f32::INFINITY, 0.0, 0.0]]);
    assert_eq!(hull.vertices(), [[0.0; 3], [1.0; 3]]);
    assert_eq!(hull.exit(&[f32::NAN, 0.0, 0.0], 1e9), Some(f64::INFINITY));
    assert_eq!(hull.exits(&[f32::NAN, 0.0], &[0.0; 2], &[0.0; 2], 1e-9), (1, f64::INFINITY));
}

#[test]
fn extreme_magnitudes() {
    let tiny = f32::from_bits(1);
    for scale in [tiny, f32::MIN_POSITIVE, 1.0, f32::MAX] {
        let points = [[0.0; 3], [scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, scale], [scale, scale, 0.0]];
        let hull = Hull::new(&points);
        assert_eq!((hull.dimension(), hull.vertices().len()), (Some(3), 5), "scale {scale:e}");
        assert!(points.iter().all(|p| hull.exit(p, hull.margin(0)).is_none()));
        assert!(hull.exit(&[scale, scale, scale], hull.margin(0)).is_some());
    }
    // Nearly a plane: one point is off it by the least that an f32 can be.
    let sliver = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.5, 0.5, tiny]];
    assert_eq!((Hull::new(&sliver).dimension(), Hull::new(&sliver).vertices().len()), (Some(3), 5));
}

#[test]
fn margin_counts_levels_in_ulps_of_the_largest_coordinate() {
    let hull = Hull::new(&[[0.0; 3], [1.0, 0.5, 0.25]]);
    let one = hull.margin(1) - hull.margin(0);
    assert!((one / f64::from(f32::EPSILON) - 1.5 * 3.0_f64.sqrt()).abs() < 1e-6);
    assert!(hull.margin(0) < 1e-14 && hull.margin(0) > 0.0);
    assert!((hull.margin(10) - hull.margin(0) - 10.0 * one).abs() < 1e-18);
    assert!(Hull::new(&[[f32::MAX; 3]]).margin(3).is_finite());
    assert_eq!(Hull::new(&[[0.0; 3]]).margin(5), 0.0);
}

#[test]
fn pixels_beyond_the_rim_of_a_thin_hull_are_exits() {
    for thickness in [1e-38_f32, 1e-20, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5] {
        // Flat along an axis, and turned so that every coordinate takes part.
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, thickness]];
        let turn =
            |p: [f32; 3]| [0.1 + 0.3 * p[0] + p[2], 0.2 + 0.3 * p[1] + p[2], 0.6 - 0.3 * p[0] - 0.2 * p[1] + p[2]];
        let needle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, thickness, 0.0], [0.5, 0.0, thickness]];
        for (points, outside, inside, least) in [
            (flat, [2.0, 2.0, 0.0], [0.5, 0.5, 0.0], 1.4),
            (flat, [1.001, 0.5, 0.0], [0.5, 0.25, 0.0], 0.00099),
            (flat.map(turn), turn([1.001, 0.5, 0.0]), turn([0.5, 0.5, 0.0]), 0.0002),
            (flat.map(turn), turn([2.0, 2.0, 0.0]), turn([0.5, 0.25, 0.0]), 0.3),
            (needle, [1.001, 0.0, 0.0], [0.75, 0.0, 0.0], 0.00099),
            (needle.map(turn), turn([1.001, 0.0, 0.0]), turn([0.75, 0.0, 0.0]), 0.0003),
        ] {
            let hull = Hull::new(&points);
            let distance = hull.signed_distance(outside.map(f64::from));
            assert!(distance > least, "{thickness:e} {points:?} {outside:?}: {distance:e}");
            assert!(hull.exit(&outside, hull.margin(2)).is_some());
            assert_eq!(hull.exit(&inside, hull.margin(2)), None);
        }
    }
}

#[test]
fn a_witness_holds_however_near_the_point_is() {
    let points = [[69, 31, 38], [23, 220, 71], [7, 153, 139]].map(color);
    let hull = Hull::new(&points);
    // 1.7e-6 above the triangle.
    let witness = hull.witness(color([56, 57, 59]).map(f64::from)).unwrap();
    assert!(witness.distance > 0.0 && witness.distance < 2e-6, "{witness:?}");
    for v in points {
        let reach: f64 = (0..3).map(|i| witness.normal[i] * f64::from(v[i])).sum();
        assert!(reach <= witness.offset + 1e-15, "{v:?} {witness:?}");
    }
}

#[test]
fn edges_are_listed_once() {
    let corner = |index: u32| [0, 1, 2].map(|axis| (index >> axis & 1) as f32);
    let points: Vec<[f32; 3]> = (0..8).map(corner).collect();
    // A point, a segment, a square, a cube.
    for (count, edges) in [(0, 0), (1, 1), (2, 1), (4, 4), (8, 12)] {
        let hull = Hull::new(&points[..count]);
        assert_eq!(hull.edges().len(), edges, "{count}");
        let is_corner = |end: &[f64; 3]| hull.vertices().iter().any(|v| v.map(f64::from) == *end);
        assert!(hull.edges().iter().flatten().all(is_corner));
        let turned = |[a, b]: [[f64; 3]; 2]| [b, a];
        assert!(count == 1 || hull.edges().iter().all(|edge| !hull.edges().contains(&turned(*edge))));
    }
}
