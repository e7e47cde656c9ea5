//! Grain: the texture of the canvas or paper that a picture is painted on.

use crate::field::Screen;
use std::f64::consts::PI;
use trochoid_field::{Noise, NoiseKind, NoiseParameters};
use trochoid_graph::*;

/// A mask of the weave of canvas or the tooth of paper, fixed on the picture, with a mean of ½.
///
/// # Formula
/// ½ + relief·(h − mean)/2, limited to [0, 1]. canvas: threads cross alternately over and under; h = sin(πs)·(0.55 +
/// 0.45·sin(πr))·(1 + slub·n) of the thread on top, with s across it, r along it from crossing to crossing, and noise n
/// stretched along the thread. paper: h = 0.7·fbm + 0.3·(2·ridged − 1), with the ridged noise stretched into fibers.
///
/// # Edge cases
/// As threads get narrower than 2 pixels, the grain fades to ½; at 1 pixel and below, it is ½ everywhere. Threads are
/// counted per picture height, so the grain does not change with the picture's size.
///
/// # Source
/// Plain weave; paper as a height field: Curtis et al., Computer-Generated Watercolor, 1997.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "Height of the grain: 1 is highest."))]
pub(crate) struct Grain {
    /// Type of ground: canvas or paper.
    kind: Ground,
    /// Number of threads per picture height; for paper, number of bumps.
    #[knob(default = 220.0, range = 1.0..=1e4)]
    threads: f64,
    /// Unevenness of the threads; 0 makes them uniform. Canvas only.
    #[knob(default = 0.5, range = 0.0..=1.0)]
    slub: f64,
    /// Rotation of the grain, clockwise.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees")]
    turn: f64,
    /// Depth of the grain; 0 gives ½ everywhere.
    #[knob(default = 1.0, range = 0.0..=8.0)]
    relief: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

/// Ground that a picture is painted on.
#[derive(Clone, Copy, Debug, PartialEq, Choice)]
pub(crate) enum Ground {
    Canvas,
    Paper,
}

impl Node for Grain {}

/// Stretch of the noise along threads and fibers.
const DRAWN_OUT: f64 = 9.0;
/// Position across a thread at which its noise is looked up.
const BETWEEN: f64 = 0.37;
/// Height of a thread where it goes under, and the height it gains where it lies on top.
const LOW: f64 = 0.55;
const BOW: f64 = 0.45;
/// Mean of sin(πs)·(0.55 + 0.45·sin(πr)).
const MEAN: f64 = (2.0 / PI) * (LOW + BOW * 2.0 / PI);
/// Weights of bumps and fibers in the height of paper.
const BUMPS: f64 = 0.7;
const FIBERS: f64 = 0.3;

impl Stage for Grain {
    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn rate(&self) -> Rate {
        Rate::Pixel
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let seed = self.seed as u32;
        let noise = |kind: NoiseKind, octaves: usize, salt: u32| {
            let parameters =
                NoiseParameters { scale: 1.0, octaves, lacunarity: 2.1, gain: 0.6, seed: seed.wrapping_mul(5) ^ salt };
            Noise::new(kind, parameters, None)
        };
        let noises = match self.kind {
            Ground::Canvas => [noise(NoiseKind::Fbm, 2, 0x53), noise(NoiseKind::Fbm, 2, 0x54)],
            Ground::Paper => [noise(NoiseKind::Fbm, 4, 0x51), noise(NoiseKind::Ridged, 2, 0x52)],
        };
        // Threads per pixel.
        let density = self.threads / f64::from(prepare.frame.format.height());
        let t = (2.0 - 2.0 * density).clamp(0.0, 1.0);
        Ok(Box::new(PreparedGrain {
            node: self.clone(),
            turn: libm::sincos(-self.turn.to_radians()),
            kept: t * t * (3.0 - 2.0 * t),
            screen: Screen::of(prepare.frame.format),
            noises,
        }))
    }
}

struct PreparedGrain {
    node: Grain,
    /// Sine and cosine of the rotation from the picture back to the grain.
    turn: (f64, f64),
    /// Fraction of the relief that remains at this size of threads in pixels.
    kept: f64,
    screen: Screen,
    /// Noises of canvas: threads that run across, threads that run down. Noises of paper: bumps, fibers.
    noises: [Noise; 2],
}

impl PreparedGrain {
    /// Converts a position in pixels to one in threads.
    fn place(&self, pixels: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.screen.at(pixels);
        let (sin, cos) = self.turn;
        [(x * cos - y * sin) * self.node.threads, (x * sin + y * cos) * self.node.threads]
    }

    /// Returns the positions at which the two noises are looked up.
    fn lookups(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        match self.node.kind {
            // Each thread has noise of its own, stretched along it.
            Ground::Canvas => [[x / DRAWN_OUT, libm::floor(y) + BETWEEN], [libm::floor(x) + BETWEEN, y / DRAWN_OUT]],
            Ground::Paper => [[x / 2.0, y / 2.0], [x / 2.0 / DRAWN_OUT, y / 2.0]],
        }
    }

    /// Returns the mask at a position in threads, from the values of the two noises.
    fn mask(&self, [x, y]: [f64; 2], noises: [f64; 2]) -> f64 {
        let height = match self.node.kind {
            Ground::Canvas => {
                let (i, j) = (libm::floor(x), libm::floor(y));
                let [u, v] = [libm::sin(PI * (x - i)), libm::sin(PI * (y - j))];
                // Checkerboard: the thread that runs across is on top in every second square.
                let across = (i + j) - 2.0 * libm::floor((i + j) / 2.0) == 0.0;
                let (bulge, bow, noise) = if across { (v, u, noises[0]) } else { (u, v, noises[1]) };
                // h = sin(πs)·(0.55 + 0.45·sin(πr))·(1 + slub·n), minus its mean.
                bulge * (LOW + BOW * bow) * (1.0 + self.node.slub * noise) - MEAN
            }
            // h = 0.7·fbm + 0.3·(2·ridged − 1).
            Ground::Paper => BUMPS * noises[0] + FIBERS * (2.0 * noises[1] - 1.0),
        };
        (0.5 + 0.5 * self.node.relief * self.kept * height).clamp(0.0, 1.0)
    }

    /// Returns the mask at a position in pixels, in f64.
    fn truth(&self, pixels: [f64; 2]) -> f64 {
        let place = self.place(pixels);
        let lookups = self.lookups(place);
        self.mask(place, [0, 1].map(|axis: usize| self.noises[axis].reference(&lookups[axis], 0.0)))
    }
}

impl Prepared for PreparedGrain {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        if self.kept == 0.0 || self.node.relief == 0.0 {
            mask.fill(0.5);
            return Ok(());
        }
        let places: Vec<[f64; 2]> = block.places().map(|place| self.place(place)).collect();
        let mut noises = [vec![0.0f32; places.len()], vec![0.0f32; places.len()]];
        for (axis, (noise, out)) in self.noises.iter().zip(&mut noises).enumerate() {
            noise.fill::<2>(places.iter().map(|place| self.lookups(*place)[axis]), &[], out);
        }
        for (((out, place), a), b) in mask.iter_mut().zip(&places).zip(&noises[0]).zip(&noises[1]) {
            *out = self.mask(*place, [f64::from(*a), f64::from(*b)]) as f32;
        }
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_at(outputs, SoleOutput, 0, |at| self.truth(at));
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Mask(self.truth(inputs.at))])
    }
}
