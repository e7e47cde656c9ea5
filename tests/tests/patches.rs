//! Views meet the surfaces between the vertices of their meshes: pictures are as with points on the surfaces themselves.

use crate::support::{evaluate_again, root, sample, settings};
use trochoid::{Buffers, Cache, Certifier, CheckedGraph, Format, Silent, load};

const SIZE: [u32; 2] = [240, 135];

/// Returns a scene at a size for tests, with these points.
fn scene(name: &str, points: &str) -> CheckedGraph {
    let path = root().join(format!("graphs/{name}.json"));
    let graph = load(&path, &[format!("view.points={points}")]).unwrap().graph;
    graph.with_format(Format::new(SIZE[0], SIZE[1], 1).unwrap())
}

/// Colors of these scenes are encoded as displayed. Limits of the error that one clear pixel in a thousand exceeds, of
/// the largest one, and of the error that one in a thousand exceeds by certificate.
#[test]
fn scenes_look_as_with_points_on_their_surfaces() {
    for (name, limits) in [("stormy_sea_bare", [0.008, 0.03, 0.015]), ("toon_sea", [1e-4, 0.03, 0.005])] {
        // All of them look at one sea.
        let mut cache = Cache::new();
        let two = settings(|s| s.threads = 2);
        let [meshed, followed] = ["mesh", "surface"].map(|points| {
            let graph = scene(name, points);
            let frame = graph.frames().0;
            evaluate_again(&graph, frame, &Buffers::new(), &two, &mut cache).pictures.swap_remove(0)
        });
        let graph = scene(name, "mesh");
        let certifier = Certifier::new(&graph, &[], graph.frames().0, &[], &two).unwrap();
        let certified = certifier.certify(&Buffers::new(), &mut cache, &Silent).unwrap().swap_remove(0);
        let (mut errors, mut bounds) = (Vec::new(), Vec::new());
        for index in 0..(SIZE[0] * SIZE[1]) as usize {
            if certified.doubt[index] > 0.0 {
                continue;
            }
            let (x, y) = ((index % SIZE[0] as usize) as i64, (index / SIZE[0] as usize) as i64);
            let off = |channel: usize| (sample(&meshed, channel, x, y) - sample(&followed, channel, x, y)).abs();
            errors.push((0..3).map(off).fold(0.0, f32::max));
            bounds.push((0..3).map(|channel| certified.errors[channel][index]).fold(0.0, f32::max));
        }
        assert!(errors.len() > 25_000, "{name}: {} clear pixels", errors.len());
        let [errors, bounds] = [errors, bounds].map(|mut values| {
            values.sort_by(f32::total_cmp);
            [values[values.len() - values.len() / 1000], values[values.len() - 1]]
        });
        let found = [errors[0], errors[1], bounds[0]];
        assert!(found.iter().zip(&limits).all(|(found, limit)| found <= limit), "{name}: {found:?}, not {limits:?}");
    }
}
