//! Grain: the texture of the canvas or paper that a picture is painted on.

use crate::field::Screen;
use std::f64::consts::PI;
use trochoid_field::{Noise, NoiseKind, NoiseParameters};
use trochoid_graph::*;
use trochoid_memory::Scratch;

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

    fn memory(&self, _context: &MemoryContext<'_>) -> MemoryUse {
        // Where a pixel lies in the pulp, and the values of noise there.
        MemoryUse::default().thread(64, u64::MAX)
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

    /// Returns the mask at a height over the mean.
    fn mask(&self, height: f64) -> f64 {
        (0.5 + 0.5 * self.node.relief * self.kept * height).clamp(0.0, 1.0)
    }

    /// Returns the mask at a position in pixels, in f64.
    fn truth(&self, pixels: [f64; 2]) -> f64 {
        let place = self.place(pixels);
        let noise = |which: usize, lookup: [f64; 2]| self.noises[which].reference(&lookup, 0.0);
        self.mask(match self.node.kind {
            Ground::Canvas => {
                let [x, y] = place.map(Crossing::at);
                let top = top(&x, &y);
                self.canvas(&x, &y, noise(top, on_thread(top, &x, &y)))
            }
            Ground::Paper => {
                let [bumps, fibers] = in_pulp(place);
                paper([noise(0, bumps), noise(1, fibers)])
            }
        })
    }

    /// Returns the height of canvas from the noise of the thread on top: h = sin(πs)·(0.55 + 0.45·sin(πr))·(1 +
    /// slub·n), minus its mean.
    fn canvas(&self, x: &Crossing, y: &Crossing, noise: f64) -> f64 {
        let (bulge, bow) = if top(x, y) == ACROSS { (y.sine, x.sine) } else { (x.sine, y.sine) };
        bulge * (LOW + BOW * bow) * (1.0 + self.node.slub * noise) - MEAN
    }

    /// Fills the mask of canvas row by row.
    fn fill_canvas(&self, block: &Block<'_>, mask: &mut [f32]) {
        let width = block.window.width().max(1);
        // If the grain is not turned, positions along x repeat from row to row, and those along y within a row.
        let (mut columns, mut y) = (Scratch::of(Crossing::at(0.0), width), Crossing::at(0.0));
        let mut threads = [Looked::default(), Looked::default()];
        let mut places = block.places().map(|pixels| self.place(pixels));
        let mut found = Scratch::of((y, 0, 0), width);
        for row in mask.chunks_mut(width) {
            threads.iter_mut().for_each(Looked::begin);
            for ((x, found), place) in columns.iter_mut().zip(&mut found).zip(&mut places) {
                x.move_to(place[0]);
                y.move_to(place[1]);
                let top = top(x, &y);
                *found = (y, top, threads[top].index(on_thread(top, x, &y)));
            }
            for (thread, noise) in threads.iter_mut().zip(&self.noises) {
                thread.fill(noise, self.node.slub);
            }
            for ((out, x), (y, top, index)) in row.iter_mut().zip(&columns).zip(&found) {
                *out = self.mask(self.canvas(x, y, f64::from(threads[*top].values[*index]))) as f32;
            }
        }
    }

    /// Fills the mask of paper.
    fn fill_paper(&self, block: &Block<'_>, mask: &mut [f32]) {
        let lookups: Scratch<[[f64; 2]; 2]> = block.places().map(|pixels| in_pulp(self.place(pixels))).collect();
        let mut noises = [0, 1].map(|_| Scratch::of(0.0f32, lookups.len()));
        for (which, (noise, out)) in self.noises.iter().zip(&mut noises).enumerate() {
            noise.fill::<2>(lookups.iter().map(|lookups| lookups[which]), &[], out);
        }
        for ((out, bumps), fibers) in mask.iter_mut().zip(&noises[0]).zip(&noises[1]) {
            *out = self.mask(paper([*bumps, *fibers].map(f64::from))) as f32;
        }
    }
}

/// Returns the height of paper: h = 0.7·fbm + 0.3·(2·ridged − 1).
fn paper([bumps, fibers]: [f64; 2]) -> f64 {
    BUMPS * bumps + FIBERS * (2.0 * fibers - 1.0)
}

/// Returns where the noises of bumps and fibers are looked up.
fn in_pulp([x, y]: [f64; 2]) -> [[f64; 2]; 2] {
    [[x / 2.0, y / 2.0], [x / 2.0 / DRAWN_OUT, y / 2.0]]
}

/// The threads that run across, among the noises of canvas; the others run down.
const ACROSS: usize = 0;

/// Position along an axis among the threads that it crosses.
#[derive(Clone, Copy)]
struct Crossing {
    at: f64,
    /// Number of the thread.
    thread: f64,
    /// Sine of π times the position within the thread.
    sine: f64,
    is_odd: bool,
}

impl Crossing {
    fn at(at: f64) -> Self {
        let thread = libm::floor(at);
        Self { at, thread, sine: libm::sin(PI * (at - thread)), is_odd: thread != 2.0 * libm::floor(thread / 2.0) }
    }

    fn move_to(&mut self, at: f64) {
        if self.at != at {
            *self = Self::at(at);
        }
    }
}

/// Returns which thread is on top. As on a checkerboard, that which runs across is in every second square.
fn top(x: &Crossing, y: &Crossing) -> usize {
    if x.is_odd == y.is_odd { ACROSS } else { 1 - ACROSS }
}

/// Returns where the noise of the thread on top is looked up. Each thread has noise of its own, stretched along it.
fn on_thread(top: usize, x: &Crossing, y: &Crossing) -> [f64; 2] {
    if top == ACROSS { [x.at / DRAWN_OUT, y.thread + BETWEEN] } else { [x.thread + BETWEEN, y.at / DRAWN_OUT] }
}

/// The noise of threads in a row.
#[derive(Default)]
struct Looked {
    /// Different places at which it is looked up, and those of the row before.
    places: Scratch<[f64; 2]>,
    before: Scratch<[f64; 2]>,
    values: Scratch<f32>,
}

impl Looked {
    /// Begins a row.
    fn begin(&mut self) {
        std::mem::swap(&mut self.places, &mut self.before);
        self.places.clear();
    }

    /// Returns the index of the value at a place.
    fn index(&mut self, place: [f64; 2]) -> usize {
        if self.places.last() != Some(&place) {
            self.places.push(place);
        }
        self.places.len() - 1
    }

    /// Looks up the noise, unless it has no effect.
    fn fill(&mut self, noise: &Noise, slub: f64) {
        if self.places != self.before {
            self.values.resize(self.places.len(), 0.0);
            if slub != 0.0 {
                noise.fill(self.places.iter().copied(), &[], &mut self.values);
            }
        }
    }
}

impl Prepared for PreparedGrain {
    fn fill(&self, block: &Block<'_>, _inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        if self.kept == 0.0 || self.node.relief == 0.0 {
            mask.fill(0.5);
            return Ok(());
        }
        match self.node.kind {
            Ground::Canvas => self.fill_canvas(block, mask),
            Ground::Paper => self.fill_paper(block, mask),
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
