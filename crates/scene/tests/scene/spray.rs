//! Tests of drop stamps: bins against the plain loop, independence of windows, and the same paint at every size.

use trochoid_image::{Format, Window};
use trochoid_scene::spray::{Brush, Dabs, Droplet, Planes, Stamp};
use trochoid_scene::{Camera, DVec3, Projection};

/// Pseudorandom numbers that are the same in every run (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn camera(orthographic: bool) -> Camera {
    let projection =
        if orthographic { Projection::Orthographic { height: 14.0 } } else { Projection::Perspective { fov: 0.9 } };
    Camera { position: DVec3::new(0.0, 2.0, 20.0), target: DVec3::ZERO, roll: 0.2, projection }
}

/// Returns drops in front of, beside and behind the camera; every tenth one has a hostile number.
fn drops(count: usize, seed: u64) -> Vec<Droplet> {
    let mut random = Random(seed);
    let mut drop = |index: usize| {
        let mut drop = Droplet {
            position: [random.between(-15.0, 15.0), random.between(-8.0, 8.0), random.between(-20.0, 24.0)],
            velocity: [0, 1, 2].map(|_| random.between(-9.0, 9.0)),
            radius: random.between(0.01, 0.7),
            share: random.between(0.0, 1.0),
            age: random.between(0.0, 1.0),
            strength: random.between(0.0, 1.0),
            shape: random.bits(),
        };
        match index % 50 {
            7 => drop.radius = 1e6,
            17 => drop.velocity = [1e9, -1e9, 1e5],
            27 => drop.position = [1e12, 0.0, -1e3],
            37 => drop.radius = 0.0,
            47 => drop.position = [0.0, 2.0, 20.0],
            _ => {}
        }
        drop
    };
    (0..count).map(&mut drop).collect()
}

fn depth(index: usize) -> f32 {
    [f32::INFINITY, 15.0, 30.0, f32::INFINITY, 5.0][index % 5]
}

#[test]
fn any_windows_and_single_pixels_give_the_bits_of_the_plain_loop() {
    let format = Format::new(100, 60, 1).expect("valid");
    let all = format.window();
    let mut covered = 0;
    for (round, stamp) in [Stamp::Mixed, Stamp::Disc, Stamp::Streak, Stamp::Ragged].into_iter().enumerate() {
        for orthographic in [false, true] {
            let brush = Brush { stamp, soft: [0.0, 2.0][round % 2], least: 0.5 + round as f64, ..Brush::default() };
            let projector = camera(orthographic).projector(format);
            let dabs = Dabs::new(&projector, &drops(300, 5 + round as u64), &brush).expect("few");
            for offset in [[0.5, 0.5], [0.0, 0.0], [1.0, 1.0], [0.124, 0.93]] {
                for (width, height) in [(100, 60), (1, 60), (37, 5), (64, 64)] {
                    let tiles = all.tiles(width, height);
                    for window in tiles {
                        let surface: Vec<f32> = pixels(window).map(|(x, y)| depth((x * 7 + y) as usize)).collect();
                        let mut planes = [0, 1, 2].map(|_| vec![f32::NAN; window.area()]);
                        let [alpha, far, age] = &mut planes;
                        let wanted = Planes {
                            alpha: Some(&mut alpha[..]),
                            depth: Some(&mut far[..]),
                            age: Some(&mut age[..]),
                            ..Planes::default()
                        };
                        if width == 37 {
                            let single: Vec<[i64; 2]> = pixels(window).map(|(x, y)| [x, y]).collect();
                            dabs.fill_pixels_unless(&single, offset, &surface, wanted, &|| false);
                        } else {
                            dabs.fill(window, offset, &surface, wanted);
                        }
                        for (index, (x, y)) in pixels(window).enumerate() {
                            let place = [x as f64 + offset[0], y as f64 + offset[1]];
                            let truth = dabs.at(place, f64::from(surface[index]));
                            let found = [alpha[index], far[index], age[index]].map(f32::to_bits);
                            let expected = [truth.alpha, truth.depth, truth.age].map(|value| (value as f32).to_bits());
                            assert_eq!(found, expected, "{stamp:?} at {place:?} in {window:?}");
                            assert!((0.0..=1.0).contains(&truth.alpha) && (0.0..=1.0).contains(&truth.age));
                            covered += usize::from(truth.alpha > 0.0);
                        }
                    }
                }
            }
        }
    }
    assert!(covered > 50_000, "{covered} samples covered");
}

fn pixels(window: Window) -> impl Iterator<Item = (i64, i64)> {
    (window.y0..window.y1).flat_map(move |y| (window.x0..window.x1).map(move |x| (x, y)))
}

#[test]
fn pictures_of_any_size_have_the_same_paint() {
    // Drops from several pixels down to a hundredth of one, in front of an empty background.
    let drops: Vec<Droplet> = drops(400, 9)
        .into_iter()
        .filter(|drop| drop.radius > 0.0 && drop.radius < 1.0 && drop.position[2] < 5.0 && drop.velocity[0] < 1e3)
        .collect();
    let tiny = drops.iter().map(|drop| Droplet { radius: drop.radius * 0.02, ..*drop }).collect::<Vec<_>>();
    for (drops, tolerance) in [(drops, 0.03), (tiny, 0.06)] {
        let mean = |width: u32| {
            let format = Format::new(width, width * 9 / 16, 1).expect("valid");
            let dabs = Dabs::new(&camera(false).projector(format), &drops, &Brush::default()).expect("few");
            let all = format.window();
            let mut alpha = vec![0.0; all.area()];
            let surface = vec![f32::INFINITY; all.area()];
            dabs.fill(all, [0.5; 2], &surface, Planes { alpha: Some(&mut alpha), ..Planes::default() });
            alpha.iter().map(|alpha| f64::from(*alpha)).sum::<f64>() / alpha.len() as f64
        };
        let (small, large) = (mean(480), mean(960));
        assert!(large > 1e-5, "{large}");
        assert!((small / large - 1.0).abs() < tolerance, "{small} at 480, {large} at 960");
    }
}

#[test]
fn stamps_that_cover_too_much_are_refused() {
    let format = Format::new(4096, 4096, 1).expect("valid");
    let drop = Droplet { radius: 1e3, ..drops(1, 3)[0] };
    let huge = vec![Droplet { position: [0.0; 3], strength: 1.0, age: 0.0, ..drop }; 2000];
    let refused = Dabs::new(&camera(true).projector(format), &huge, &Brush::default()).expect_err("too much");
    assert!(refused.to_string().contains("bins of 32"), "{refused}");
}
