//! LightPool: pools of sunlight that falls through gaps in the clouds.

#![allow(clippy::needless_range_loop, reason = "loops over lanes of several arrays")]

use crate::view::{POSITION, is_covered, nothing, ramp, view_planes, view_vector};
use fearless_simd::{Level, dispatch, prelude::*};
use trochoid_field::exponentials;
use trochoid_graph::*;
use trochoid_scene::{DVec3, Light};

/// A mask of pools of light in world space, like sunlight that falls through gaps in the clouds.
///
/// # Formula
/// t²(3 − 2t) with t = (s − from)/(to − from) limited to [0, 1]; s = Σ strengthᵢ·exp(−(a/length)² − (b/width)²) +
/// ragged·noise, where a and b are the horizontal distances from the pool's center along and across its direction. With
/// a `light`, each point is first projected along the light's rays to height 0.
///
/// # Edge cases
/// 0 where no surface is seen. Without pools, the noise alone makes light and gaps. A light at or below the horizon,
/// and a point or spot light, projects nothing. `from` = `to` gives a hard edge.
///
/// # Source
/// Gaussian spots with edges broken by noise: how marine painters lead the eye.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, output(mask: Kind::MASK = "The light."))]
pub(crate) struct LightPool {
    /// View of the surfaces that the light falls on.
    view: One<port::View>,
    /// Field that breaks up the edges of the pools, for example a Noise in world space.
    noise: Optional<port::Scalar>,
    /// Directional light that makes the pools: crests outside a pool, on the side toward the light, then catch light
    /// too.
    light: Optional<port::Light>,
    /// Pools of light.
    #[list(0..=64)]
    pools: Vec<Pool>,
    /// Factor of the noise that is added to the light of the pools.
    #[knob(default = 0.2, range = -1e3..=1e3)]
    ragged: f64,
    /// Light at which the mask begins to rise from 0.
    #[knob(default = 0.05, range = -1e3..=1e3)]
    from: f64,
    /// Light at which the mask reaches 1.
    #[knob(default = 0.7, range = -1e3..=1e3)]
    to: f64,
}

/// A pool of light.
#[derive(Clone, Copy, Items)]
struct Pool {
    /// X coordinate of the pool's center.
    #[knob(default = 0.0, range = -1e7..=1e7, unit = "m", places = X)]
    x: f64,
    /// Z coordinate of the pool's center.
    #[knob(default = 0.0, range = -1e7..=1e7, unit = "m", places = Z)]
    z: f64,
    /// Half the length of the pool: distance from its center at which 1/e of its light is left.
    #[knob(default = 10.0, range = 1e-3..=1e7, unit = "m")]
    length: f64,
    /// Half the width of the pool: distance across it at which 1/e of its light is left.
    #[knob(default = 10.0, range = 1e-3..=1e7, unit = "m")]
    width: f64,
    /// Direction of the pool's length: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -360.0..=360.0, unit = "degrees", places = Heading)]
    direction: f64,
    /// Amount of light in the center of the pool.
    #[knob(default = 1.0, range = 0.0..=1e3)]
    strength: f64,
}

impl Node for LightPool {
    fn check(&self, check: &mut Check<'_>) {
        if self.to < self.from {
            let found = format!("{} below from {}", self.to, self.from);
            check.error(Self::TO, found, "to ≥ from", "swap them, and Invert the mask");
        }
        if self.pools.is_empty() && self.noise.is_none() {
            let found = "no pools and no noise: the light is the same everywhere";
            check.warning(Self::POOLS, found, "pools, or a noise that has gaps", "add \"pools\", or connect \"noise\"");
        }
    }
}

impl Stage for LightPool {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        ChannelSet::of(&POSITION).union(Channel::Coverage.into())
    }

    fn interval(&self, _output: usize, _channel: usize) -> Option<(f64, f64)> {
        Some((0.0, 1.0))
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn rate(&self) -> Rate {
        Rate::Surface
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let lights: Vec<Light> = prepare.handles(&self.light)?;
        let pools = Pools {
            pools: self.pools.iter().map(PreparedPool::of).collect(),
            slant: lights.first().map_or([0.0; 2], slant),
            ragged: self.ragged,
            from: self.from,
            to: self.to,
        };
        Ok(Box::new(PreparedLightPool { view: self.view.clone(), noise: self.noise.clone(), pools }))
    }
}

/// Sine of the elevation at or below which a light counts as coming from the horizon.
const LOWEST: f64 = 1e-3;

/// Returns how far a ray toward the light moves along x and z for each meter up.
fn slant(light: &Light) -> [f64; 2] {
    let toward = light.illuminate(DVec3::ZERO).direction;
    match light {
        Light::Directional { .. } if toward.y > LOWEST => [toward.x / toward.y, toward.z / toward.y],
        _ => [0.0; 2],
    }
}

/// A pool, prepared for evaluation.
struct PreparedPool {
    center: [f64; 2],
    /// Unit vector along its length.
    along: [f64; 2],
    size: [f64; 2],
    strength: f64,
}

impl PreparedPool {
    fn of(pool: &Pool) -> Self {
        let &Pool { x, z, length, width, direction, strength } = pool;
        let (sin, cos) = libm::sincos(direction.to_radians());
        Self { center: [x, z], along: [cos, sin], size: [length, width], strength }
    }
}

/// All pools, and how their light is mapped to the mask.
struct Pools {
    pools: Vec<PreparedPool>,
    slant: [f64; 2],
    ragged: f64,
    from: f64,
    to: f64,
}

/// Bound of the rounding error of a sum, relative to its terms.
const LOST: f64 = 1e-14;

/// Returns the largest magnitude of three numbers.
fn size(numbers: [f64; 3]) -> f64 {
    numbers.into_iter().fold(0.0, |most, number| most.max(number.abs()))
}

/// Points that are computed side by side.
const LANES: usize = 16;

/// Negated exponent from which on a Gaussian counts as 0.
const NOTHING: f64 = 40.0;

impl Pools {
    fn mask(&self, point: DVec3, noise: f64) -> f64 {
        let light = |pool: &PreparedPool| {
            let [a, b] = self.across(pool, point);
            let power = a * a + b * b;
            if power < NOTHING { pool.strength * libm::exp(-power) } else { 0.0 }
        };
        let sum = self.pools.iter().map(light).sum::<f64>() + self.ragged * noise;
        self.brightness(sum)
    }

    /// Returns the masks of several points, by axis and lane: the bits of [`Self::mask`].
    #[inline(always)]
    fn masks(&self, points: &[[f64; LANES]; 3], noise: &[f64; LANES]) -> [f64; LANES] {
        let mut sums = [-0.0; LANES];
        for pool in &self.pools {
            // Loops of few operations on numbers alone, which become vectors.
            let mut powers = [0.0; LANES];
            for lane in 0..LANES {
                let [a, b] = self.across(pool, DVec3::new(points[0][lane], points[1][lane], points[2][lane]));
                powers[lane] = a * a + b * b;
            }
            let mut exponents = [0.0; LANES];
            for lane in 0..LANES {
                exponents[lane] = if powers[lane] < NOTHING { -powers[lane] } else { 0.0 };
            }
            let shares = exponentials(exponents);
            for lane in 0..LANES {
                sums[lane] += if powers[lane] < NOTHING { pool.strength * shares[lane] } else { 0.0 };
            }
        }
        for lane in 0..LANES {
            sums[lane] = self.brightness(sums[lane] + self.ragged * noise[lane]);
        }
        sums
    }

    /// Returns the mask for a sum of light.
    #[inline(always)]
    fn brightness(&self, sum: f64) -> f64 {
        let t = ramp(sum, self.from, self.to - self.from);
        t * t * (3.0 - 2.0 * t)
    }

    /// Returns the span of the mask over spans of the point and the noise.
    fn span(&self, point: [Span; 3], noise: Span) -> Span {
        let (middle, half) = (point.map(Span::middle), point.map(Span::half));
        let reach = |axis: usize, along: usize| {
            let lost = LOST * (1.0 + self.slant[axis].abs()) * size(middle);
            half[along] + self.slant[axis].abs() * half[1] + if size(half) > 0.0 { lost } else { 0.0 }
        };
        let (dx, dz) = (reach(0, 0), reach(1, 2));
        let (mut low, mut high) = (self.ragged * noise.low, self.ragged * noise.high);
        (low, high) = (low.min(high), low.max(high));
        if low.is_nan() || high.is_nan() || !(dx + dz).is_finite() {
            return Span::unclear(0.0, 1.0);
        }
        for pool in &self.pools {
            let [cos, sin] = pool.along.map(f64::abs);
            let [a, b] = self.across(pool, DVec3::from(middle));
            let away = [(a, (dx * cos + dz * sin) / pool.size[0]), (b, (dz * cos + dx * sin) / pool.size[1])];
            let square = |v: f64| v * v;
            let power =
                |end: fn(f64, f64) -> f64| away.map(|(at, by)| square(end(at.abs(), by).max(0.0))).iter().sum::<f64>();
            let light = |power: f64| if power < NOTHING { pool.strength * libm::exp(-power) } else { 0.0 };
            low += light(power(|at, by| at + by));
            high += light(power(|at, by| at - by));
        }
        // Account for Gaussians counted as 0, and for the rounding of sums.
        let strength = self.pools.iter().map(|pool| pool.strength).sum::<f64>();
        let sum = Span { low, high, clear: true }.wider(LOST * (strength + (self.ragged * noise.high).abs()));
        let ends = [sum.low, sum.high].map(|sum| self.brightness(sum));
        let clear = noise.clear && point.iter().all(|along| along.clear);
        let mask = Span::of(&ends).wider(LOST).within(0.0, 1.0);
        mask.with(clear && (self.to > self.from || ends[0] == ends[1]))
    }

    /// Returns the distances of a point from a pool's center along and across it, as fractions of half its size.
    #[inline(always)]
    fn across(&self, pool: &PreparedPool, point: DVec3) -> [f64; 2] {
        let place = [point.x - self.slant[0] * point.y, point.z - self.slant[1] * point.y];
        let [dx, dz] = [place[0] - pool.center[0], place[1] - pool.center[1]];
        let [cos, sin] = pool.along;
        [(dx * cos + dz * sin) / pool.size[0], (dz * cos - dx * sin) / pool.size[1]]
    }
}

struct PreparedLightPool {
    view: One<port::View>,
    noise: Optional<port::Scalar>,
    pools: Pools,
}

impl Prepared for PreparedLightPool {
    fn fill(&self, _block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let Some(mask) = outputs.only(0) else { return Ok(()) };
        let planes = view_planes(inputs, &self.view, POSITION);
        let coverage = inputs.view(&self.view, Channel::Coverage);
        let noise = inputs.all(&self.noise).first().and_then(|connection| connection.planes[0]);
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for (first, out) in (0..mask.len()).step_by(LANES).zip(mask.chunks_mut(LANES)) {
                let run = first..first + out.len();
                let coverage = &coverage[run.clone()];
                if coverage.iter().all(|coverage| *coverage == 0.0) {
                    out.fill(0.0);
                    continue;
                }
                // What lies beyond the samples does no harm.
                let load = |plane: &[f32]| {
                    let mut lanes = [0.0; LANES];
                    lanes.iter_mut().zip(&plane[run.clone()]).for_each(|(lane, value)| *lane = f64::from(*value));
                    lanes
                };
                let masks = self.pools.masks(&planes.map(load), &noise.map_or([0.0; LANES], load));
                for ((out, coverage), mask) in out.iter_mut().zip(coverage).zip(masks) {
                    *out = if *coverage != 0.0 { mask as f32 } else { 0.0 };
                }
            }
        }));
        Ok(())
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        bounding.bound_by(outputs, SoleOutput, 0, |sample| {
            bounding.where_covered(&self.view, sample, || {
                let point = POSITION.map(|channel| bounding.certain(&self.view, channel, sample));
                self.pools.span(point, bounding.known(&self.noise, 0, sample).unwrap_or(Span::exactly(0.0)))
            })
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        if !is_covered(inputs, &self.view) {
            return Ok(nothing());
        }
        let noise = self.noise.as_ref().map_or(0.0, |source| inputs.scalar(source));
        Ok(vec![Reference::Mask(self.pools.mask(view_vector(inputs, &self.view, POSITION), noise))])
    }
}
