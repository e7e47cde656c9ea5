//! Benchmarks sums of waves on grids and on lines, by every method, and steps of a toon sea.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trochoid_sea::toon::{Basin, Behavior, Boundary, Burst, Motion, ToonSea};
use trochoid_sea::{
    FieldSet, Fields, GerstnerSpectrum, Grid, GridPlan, Line, LineScratch, Lines, Method, Sea, SeaFrame,
};

const SIDE: usize = 256;
const POINTS: usize = 2048;
const WANTED: FieldSet = FieldSet { displacement: true, derivatives: true, slope_variance: false, velocity: false };

fn sea(count: usize) -> SeaFrame {
    let spectrum = GerstnerSpectrum { count, ..GerstnerSpectrum::default() };
    Sea::new(spectrum.waves().expect("waves within range")).at(12.5)
}

/// Displacement and derivatives at the points of a grid.
#[divan::bench(args = [(Method::Direct, 10), (Method::Direct, 100), (Method::Separable, 10), (Method::Separable, 100),
    (Method::Single, 10), (Method::Single, 100), (Method::Single, 10_000), (Method::Double, 10), (Method::Double, 100),
    (Method::Double, 10_000)])]
fn grid(bencher: Bencher<'_, '_>, (method, waves): (Method, usize)) {
    let frame = sea(waves);
    let grid = Grid { origin: [-40.0, 7.0], step: [0.25; 2], columns: SIDE, rows: SIDE, footprint: 0.25 };
    let mut plan = GridPlan::by(method, grid, WANTED).expect("a grid within range");
    let mut fields = Fields::default();
    bencher.counter(ItemsCount::new(SIDE * SIDE)).bench_local(|| {
        plan.evaluate(black_box(&frame), &mut fields);
        black_box(&fields);
    });
}

/// Displacement and derivatives at the points of a straight row.
#[divan::bench(args = [10, 100, 1000, 10_000])]
fn line(bencher: Bencher<'_, '_>, waves: usize) {
    let frame = sea(waves);
    let lines = Lines::new(&frame, POINTS);
    let line = Line { origin: [3.0, -50.0], step: [0.11, 0.03], footprint: 0.2 };
    let (mut scratch, mut fields) = (LineScratch::default(), Fields::default());
    bencher.counter(ItemsCount::new(POINTS)).bench_local(|| {
        lines.evaluate(black_box(&line), WANTED, &mut scratch, &mut fields);
        black_box(&fields);
    });
}

/// One step of a toon sea with bursts that travel over it.
#[divan::bench(args = [0, 100, 10_000])]
fn toon_step(bencher: Bencher<'_, '_>, bursts: usize) {
    let basin = Basin { columns: 512, rows: 512, spacing: 0.15, boundary: Boundary::Replicate };
    let path = |lane: f64| [[0.0, lane], [25.0, lane + 3.0], [50.0, lane - 3.0], [76.0, lane]];
    let burst = |index: usize| {
        let share = (index as f64 * 0.618_033_988_749) % 1.0;
        Burst { duration: 8.0 + 8.0 * share, offset: 16.0 * share, ..Burst::along(path(76.0 * share)) }
    };
    let sea = ToonSea::new(basin, Motion::default(), Behavior::default(), (0..bursts).map(burst).collect());
    let mut simulation = sea.expect("a stable sea").simulate(Default::default());
    let mut time = 0.0;
    bencher.counter(ItemsCount::new(basin.cells())).bench_local(|| {
        time += 1.0 / 60.0;
        black_box(simulation.at(time).height[0]);
    });
}

fn main() {
    divan::main();
}
