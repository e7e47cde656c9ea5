//! Benchmarks the rays of shadows and of light through water, and the trees that they walk.

mod scenes;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use scenes::Scene;
use trochoid_scene::{Obstacles, Surface};

/// Rays that are asked for together, as for a block of a picture.
const TOGETHER: usize = 64;

const NAMES: [&str; 2] = ["teapot", "storm"];

fn scene(name: &str) -> Scene {
    if name == "teapot" { scenes::teapot() } else { scenes::storm() }
}

/// Rays of one kind, on one thread.
#[divan::bench(args = [("teapot", "landed"), ("teapot", "to the light"), ("storm", "landed"), ("storm", "inward"),
    ("storm", "through")], sample_count = 5)]
fn rays(bencher: Bencher<'_, '_>, (name, kind): (&str, &str)) {
    let scene = scene(name);
    let question = scene.questions.iter().find(|question| question.name == kind).expect("its question");
    bencher.counter(ItemsCount::new(question.segments.len())).bench_local(|| {
        for segments in question.segments.chunks(TOGETHER) {
            if question.any {
                black_box(scene.obstacles.blocks(black_box(segments)));
            } else {
                black_box(scene.obstacles.first(black_box(segments)));
            }
        }
    });
}

/// Triangles and their tree, on all threads.
#[divan::bench(args = NAMES, sample_count = 5)]
fn obstacles(bencher: Bencher<'_, '_>, name: &str) {
    let scene = scene(name);
    let surfaces: Vec<&dyn Surface> = scene.surfaces.iter().map(AsRef::as_ref).collect();
    bencher.bench_local(|| Obstacles::new(black_box(&scene.projector), &surfaces));
}

fn main() {
    divan::main();
}
