//! Times the judgment of a picture against the hull of its palette, for pixels that are mixes of few or many colors,
//! with similar or different neighbors.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trochoid_weights::arithmetic::mix;
use trochoid_weights::{BoxHull, Hull};

/// Number of pixels: few enough to stay in the cache, like a band that has just been computed.
const PIXELS: usize = 1 << 15;

/// Number of nested mixes in each pixel.
const LEVELS: usize = 6;

const PALETTE: [[f32; 3]; 12] = [
    [0.30, 0.46, 0.50],
    [0.42, 0.52, 0.48],
    [0.60, 0.66, 0.70],
    [0.78, 0.70, 0.62],
    [0.02, 0.06, 0.09],
    [0.04, 0.08, 0.08],
    [0.20, 0.26, 0.32],
    [0.28, 0.27, 0.29],
    [0.10, 0.14, 0.18],
    [0.97, 0.95, 0.90],
    [0.45, 0.50, 0.55],
    [0.98, 0.99, 1.00],
];

/// Colors of which pixels are mixes.
#[derive(Clone, Copy, Debug)]
enum Colors {
    Palette,
    Ball(usize),
    Flat,
    Thin,
    Gray,
    Point,
}

const COLORS: [Colors; 8] = [
    Colors::Palette,
    Colors::Ball(50),
    Colors::Ball(100),
    Colors::Ball(4000),
    Colors::Flat,
    Colors::Thin,
    Colors::Gray,
    Colors::Point,
];

fn main() {
    divan::main();
}

struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn unit(&mut self) -> f32 {
        (self.bits() >> 7) as f32 / 16_777_216.0
    }

    /// Returns a random weight that is 0 or 1 half of the time.
    fn weight(&mut self) -> f32 {
        match self.bits() >> 16 & 3 {
            0 => 0.0,
            1 => 1.0,
            _ => self.unit(),
        }
    }
}

impl Colors {
    fn make(self) -> Vec<[f32; 3]> {
        let mut random = Random(7);
        match self {
            Self::Palette => PALETTE.to_vec(),
            Self::Ball(count) => {
                let mut on_ball = || {
                    let v = [(); 3].map(|()| random.unit() - 0.5);
                    let length = v.iter().map(|v| v * v).sum::<f32>().sqrt().max(1e-3);
                    v.map(|v| 0.5 + 0.5 * v / length)
                };
                (0..count).map(|_| on_ball()).collect()
            }
            Self::Flat => PALETTE.map(|[r, g, _]| [r, g, 0.25]).to_vec(),
            Self::Thin => PALETTE.map(|[r, g, b]| [r, g, 0.25 + 1e-5 * b]).to_vec(),
            Self::Gray => PALETTE.map(|[r, ..]| [r; 3]).to_vec(),
            Self::Point => vec![PALETTE[0]],
        }
    }

    /// Makes pixels of nested mixes of random colors; runs of neighbors share colors, with slowly changing weights.
    fn picture(self, run: usize) -> (Hull, [Vec<f32>; 3]) {
        let colors = self.make();
        let mut random = Random(1);
        let mut picture = [(); 3].map(|()| Vec::with_capacity(PIXELS));
        let (mut chosen, mut weights) = ([[0.0; 3]; LEVELS + 1], [[0.0; 2]; LEVELS]);
        for x in 0..PIXELS {
            if x % run == 0 {
                chosen = chosen.map(|_| colors[random.bits() as usize % colors.len()]);
                weights = weights.map(|_| {
                    let from = random.weight();
                    [from, if random.bits() & 1 == 0 { from } else { random.unit() }]
                });
            }
            let along = (x % run) as f32 / run as f32;
            for (c, channel) in picture.iter_mut().enumerate() {
                let mut value = chosen[LEVELS][c];
                for (color, &[from, to]) in chosen.iter().zip(&weights) {
                    value = mix(color[c], value, mix(from, to, along));
                }
                channel.push(value);
            }
        }
        (Hull::new(&colors), picture)
    }
}

fn judge(bencher: Bencher<'_, '_>, colors: Colors, run: usize) {
    let (hull, [r, g, b]) = colors.picture(run);
    let margin = hull.margin(LEVELS);
    assert_eq!(hull.exits(&r, &g, &b, margin).0, 0);
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| hull.exits(black_box(&r), &g, &b, margin));
}

/// Pixels without relation to their neighbors.
#[divan::bench(args = COLORS, sample_count = 40)]
fn noise(bencher: Bencher<'_, '_>, colors: Colors) {
    judge(bencher, colors, 1);
}

/// Pixels similar to their neighbors, like in most pictures.
#[divan::bench(args = COLORS, sample_count = 40)]
fn smooth(bencher: Bencher<'_, '_>, colors: Colors) {
    judge(bencher, colors, 200);
}

#[divan::bench(sample_count = 40)]
fn all_nan(bencher: Bencher<'_, '_>) {
    let hull = Hull::new(&PALETTE);
    let channel = vec![f32::NAN; PIXELS];
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| hull.exits(black_box(&channel), &channel, &channel, 1e-6));
}

#[divan::bench(sample_count = 40)]
fn around(bencher: Bencher<'_, '_>) {
    let (hull, [r, g, b]) = Colors::Palette.picture(1);
    let hull = BoxHull::new(hull.vertices());
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| hull.exits(black_box(&r), &g, &b, 0.0));
}

#[divan::bench(args = [12, 100, 4000], sample_count = 40)]
fn make(bencher: Bencher<'_, '_>, count: usize) {
    let colors = Colors::Ball(count).make();
    bencher.bench_local(|| Hull::new(black_box(&colors)));
}
