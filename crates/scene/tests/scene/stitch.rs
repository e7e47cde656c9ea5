//! Tests of the triangles of patches that are cut to match their neighbors.

use std::collections::HashMap;
use trochoid_scene::inside::cut;

/// Every inner edge is shared by two triangles in opposite directions, every border piece belongs to one, and
/// areas over (u, v) are positive and sum to 1.
#[test]
fn any_cut_covers_the_square_once() {
    for edges in [[1, 1, 1, 1], [1, 7, 2, 3], [9, 1, 1, 9], [5, 5, 5, 5], [64, 1, 3, 17]] {
        for inner in [[2, 2], [2, 5], [6, 3], [9, 9]] {
            let (vertices, inner_points, triangles) = cut(edges, inner);
            let cut = (edges, inner);
            let mut points = Vec::new();
            for (edge, count) in edges.into_iter().enumerate() {
                for t in (0..count).map(|index| index as f64 / count as f64) {
                    points.push([[t, 0.0], [1.0, t], [1.0 - t, 1.0], [0.0, 1.0 - t]][edge]);
                }
            }
            points.extend(inner_points);
            assert_eq!(points.len(), vertices);
            let (mut area, mut sides) = (0.0, HashMap::new());
            for triangle in triangles {
                let [p, q, r] = triangle.map(|vertex| points[vertex as usize]);
                let twice = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
                assert!(twice > 0.0, "{cut:?}");
                area += twice / 2.0;
                for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                    *sides.entry((triangle[from], triangle[to])).or_insert(0) += 1;
                }
            }
            assert!((area - 1.0).abs() < 1e-12, "{cut:?}: {area}");
            assert!(sides.values().all(|count| *count == 1), "{cut:?}");
            let border = sides.keys().filter(|(from, to)| !sides.contains_key(&(*to, *from))).count();
            assert_eq!(border, edges.iter().sum::<usize>(), "{cut:?}");
        }
    }
}
