//! Spray: drops thrown into the air by breaking crests and bursts.

use super::waters::can_break;
use crate::lit::eye;
use crate::view::SurfaceHandle;
use std::sync::{Arc, OnceLock};
use trochoid_graph::*;
use trochoid_scene::Projector;
use trochoid_scene::spray::{Brush, Dabs, Planes, SpraySample, Stamp, TooMuchSpray};
use trochoid_sea::spray::{self as model, Burst, MAX_DROPS, SprayError, SprayParameter, SprayRun};

/// Drops thrown into the air by breaking crests and by bursts set by hand, drawn as brush stamps.
///
/// # Formula
/// Drops are born at the rate `density`·clamp((threshold − det J)/width, 0, 1) per m² and s, fewer between tufts. v' =
/// −g·ŷ + drag·(radius/r)(wind − v). alpha = 1 − Π(1 − αᵢ), αᵢ = opacity·(1 − age)·stamp·seen, seen = clamp((d −
/// dᵢ)/soft + ½, 0, 1), with d, dᵢ the depths of view and drop.
///
/// # Edge cases
/// Cells and steps of births are fixed in world space and time: drops do not depend on the picture's size, nor a frame
/// on earlier frames. The knobs at a frame, and the sea's, apply to all drops in it, whenever they were born. Only a
/// GerstnerSea folds; with other surfaces, or none, only bursts throw drops. Drops vanish at the sea's level. Without
/// drops: alpha 0, depth +∞, age 0.
///
/// # Source
/// Thesis 3.2.4.5: particles, each with one of several modelled strokes. Peachey, Modeling Waves and Surf, 1986.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, outputs = Out)]
pub(crate) struct Spray {
    /// View whose surfaces hide drops and whose camera sees them.
    view: One<port::View>,
    /// The GerstnerSea whose crests break.
    #[port(wants(Folds))]
    sea: Optional<port::Surface>,
    /// Center x, z of the region in which crests throw drops.
    #[knob(default = [0.0; 2], unit = "m", places = Position)]
    center: [f64; 2],
    /// Size of the region along x and z.
    #[knob(default = [60.0; 2], unit = "m")]
    size: [f64; 2],
    /// Side of the cells in which drops are born; shorter crests throw nothing.
    #[knob(default = 0.5, range = 1e-3..=1e5, unit = "m")]
    cell: f64,
    /// Number of birth steps per second.
    #[knob(default = 20.0, range = 1e-2..=1e4, unit = "1/s")]
    rate: f64,
    /// Jacobian det J below which drops are born.
    #[knob(default = 0.4, range = -1e6..=1e6)]
    threshold: f64,
    /// Further decrease of det J over which `density` is reached.
    #[knob(default = 0.2, range = 0.0..=1e6)]
    width: f64,
    /// Drops born per square meter and second where crests break fully.
    #[knob(default = 40.0, range = 0.0..=1e6)]
    density: f64,
    /// Share of the water's velocity that drops inherit.
    #[knob(default = 0.8, range = -1e3..=1e3)]
    follow: f64,
    /// Maximum speed at which crests throw drops, added to the inherited velocity.
    #[knob(default = 3.0, range = 0.0..=1e4, unit = "m/s")]
    speed: f64,
    /// Maximum angle between a throw and straight up.
    #[knob(default = 35.0, range = 0.0..=180.0, unit = "degrees")]
    spread: f64,
    /// Wind velocity x, y, z.
    #[knob(default = [4.0, 0.0, 0.0], unit = "m/s")]
    wind: [f64; 3],
    /// Rate at which the largest drops adopt the wind's velocity.
    #[knob(default = 0.6, range = 0.0..=1e4, unit = "1/s")]
    drag: f64,
    /// Maximum lifetime of a drop.
    #[knob(default = 1.5, range = 0.0..=1e4, unit = "s")]
    lifetime: f64,
    /// Radius of the largest drops at birth.
    #[knob(default = 0.25, range = 0.0..=1e4, unit = "m")]
    radius: f64,
    /// Growth of a drop's radius over its life: 0 keeps the radius, 1 doubles it.
    #[knob(default = 1.0, range = 0.0..=1e3)]
    growth: f64,
    /// Variation of radii, lifetimes and speeds: 0 is none, 1 is full.
    #[knob(default = 1.0, range = 0.0..=1.0)]
    vary: f64,
    /// Size of the tufts in which drops gather along a crest.
    #[knob(default = 3.0, range = 1e-3..=1e5, unit = "m")]
    tuft: f64,
    /// Contrast between tufts: 0 is even, 1 leaves gaps.
    #[knob(default = 0.8, range = 0.0..=1.0)]
    torn: f64,
    /// Shape of the stamps; "mixed" draws large drops ragged, small ones as discs and streaks.
    stamp: Shape,
    /// Alpha at the center of a stamp at birth.
    #[knob(default = 0.9, range = 0.0..=1.0)]
    opacity: f64,
    /// Exposure time over which motion draws out streaks and ragged stamps.
    #[knob(default = 0.04, range = 0.0..=10.0, unit = "s")]
    stretch: f64,
    /// Minimum radius of a stamp; drops that appear smaller fade instead.
    #[knob(default = 0.7, range = 0.1..=100.0, in_pixels)]
    least: f64,
    /// Depth range over which a drop disappears behind a surface; 0 is a hard edge.
    #[knob(default = 0.3, range = 0.0..=1e6, unit = "m")]
    soft: f64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
    /// Throws set by hand, for example where a wave hits a rock.
    #[list(0..=1000)]
    bursts: Vec<Throw>,
}

#[derive(Clone, Items)]
struct Throw {
    /// Center of the throw.
    #[knob(default = [0.0; 3], unit = "m", places = Position)]
    position: [f64; 3],
    /// Radius around the position in which drops are born.
    #[knob(default = 0.3, range = 0.0..=1e6, unit = "m")]
    extent: f64,
    /// Start time.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "s")]
    time: f64,
    /// Duration.
    #[knob(default = 0.2, range = 0.0..=1e6, unit = "s")]
    duration: f64,
    /// Direction of the throw, of any length; 0, 0, 0 is up.
    #[knob(default = [0.0, 1.0, 0.0])]
    direction: [f64; 3],
    /// Maximum angle between a drop's velocity and the direction.
    #[knob(default = 25.0, range = 0.0..=180.0, unit = "degrees")]
    spread: f64,
    /// Maximum speed.
    #[knob(default = 8.0, range = 0.0..=1e4, unit = "m/s")]
    speed: f64,
    /// Number of drops, thrown in about √count jets.
    #[knob(default = 200, range = 0..=MAX_DROPS as i64)]
    count: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Shape {
    Mixed,
    Disc,
    Streak,
    Ragged,
}

#[derive(Clone, Copy, Debug, PartialEq, Outputs)]
enum Out {
    /// Coverage of the drops.
    #[output(Kind::MASK)]
    Alpha,
    /// Planar depth of the nearest drop, in meters; +∞ where there is none.
    #[output(Kind::Field(1))]
    Depth,
    /// Mean age of the drops, as a share of their lifetimes; 0 where there are none.
    #[output(Kind::MASK)]
    Age,
}

impl Throw {
    fn burst(&self) -> Burst {
        let Self { position, extent, time, duration, direction, spread, speed, count } = *self;
        Burst { position, extent, time, duration, direction, spread: spread.to_radians(), speed, count: count as usize }
    }
}

impl Spray {
    /// Returns the spray that the knobs describe.
    fn spray(&self) -> Result<model::Spray, SprayError> {
        let spray = model::Spray {
            center: self.center,
            size: self.size,
            cell: self.cell,
            rate: self.rate,
            threshold: self.threshold,
            width: self.width,
            density: self.density,
            follow: self.follow,
            speed: self.speed,
            cone: self.spread.to_radians(),
            wind: self.wind,
            drag: self.drag,
            lifetime: self.lifetime,
            radius: self.radius,
            growth: self.growth,
            vary: self.vary,
            tuft: self.tuft,
            torn: self.torn,
            seed: self.seed,
            bursts: self.bursts.iter().map(Throw::burst).collect(),
        };
        spray.check().map(|()| spray)
    }

    /// Returns the knob or list that a parameter comes from.
    fn item_of(parameter: SprayParameter) -> ItemName {
        match parameter {
            SprayParameter::Center => Self::CENTER,
            SprayParameter::Size => Self::SIZE,
            SprayParameter::Cell => Self::CELL,
            SprayParameter::Rate => Self::RATE,
            SprayParameter::Threshold => Self::THRESHOLD,
            SprayParameter::Width => Self::WIDTH,
            SprayParameter::Density => Self::DENSITY,
            SprayParameter::Follow => Self::FOLLOW,
            SprayParameter::Speed => Self::SPEED,
            SprayParameter::Cone => Self::SPREAD,
            SprayParameter::Wind => Self::WIND,
            SprayParameter::Drag => Self::DRAG,
            SprayParameter::Lifetime => Self::LIFETIME,
            SprayParameter::Radius => Self::RADIUS,
            SprayParameter::Growth => Self::GROWTH,
            SprayParameter::Vary => Self::VARY,
            SprayParameter::Tuft => Self::TUFT,
            SprayParameter::Torn => Self::TORN,
            SprayParameter::Bursts => Self::BURSTS,
        }
    }

    fn brush(&self) -> Brush {
        let stamp = match self.stamp {
            Shape::Mixed => Stamp::Mixed,
            Shape::Disc => Stamp::Disc,
            Shape::Streak => Stamp::Streak,
            Shape::Ragged => Stamp::Ragged,
        };
        Brush { stamp, opacity: self.opacity, stretch: self.stretch, least: self.least, soft: self.soft }
    }
}

impl Node for Spray {
    fn check(&self, check: &mut Check<'_>) {
        if let Err(error) = self.spray() {
            let (item, expected) = (Self::item_of(error.parameter()), "a spray within its limits");
            return check.error(item, error, expected, "change the named knobs");
        }
        if !self.bursts.is_empty() {
            return;
        }
        let [x, z] = self.size;
        if x == 0.0 || z == 0.0 {
            let found = format!("an empty region of {x} × {z} m and no bursts, so there are no drops");
            let remedy = "increase \"size\", or add \"bursts\"";
            check.warning(Self::SIZE, found, "a region with an area, or bursts", remedy);
        } else if !can_break(&self.sea, check) && (self.sea.is_none() || self.threshold <= 1.0) {
            let found = "no breaking waves and no bursts, so there are no drops";
            let seas = check.offering(Offer::Waves);
            let remedy = format!("connect {seas} to \"sea\", or add \"bursts\"");
            check.warning(Self::SEA, found, format!("the waves of {seas}, or bursts"), remedy);
        }
    }
}

impl Stage for Spray {
    fn is_costly(&self) -> bool {
        true
    }

    fn required_channels(&self, _wanted: &[bool]) -> ChannelSet {
        Channel::Depth.into()
    }

    fn interval(&self, output: usize, _channel: usize) -> Option<(f64, f64)> {
        match Out::ALL[output] {
            Out::Alpha | Out::Age => Some((0.0, 1.0)),
            Out::Depth => None,
        }
    }

    fn rate(&self) -> Rate {
        // Smaller stamps would slip between pixels, and a hard edge has to be resolved at each sample.
        if self.least >= 0.5 && self.soft > 0.0 { Rate::Surface } else { Rate::Sample }
    }

    fn depends_on_time(&self) -> bool {
        true
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        // The born drops, and the bins of stamps.
        const DROP: f64 = 64.0;
        let Ok(spray) = self.spray() else { return MemoryUse::default() };
        let drops = spray.most_drops() * DROP;
        MemoryUse::held(drops as u64 + context.pixels() * 4, "lower \"density\", \"lifetime\" or \"size\"")
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let seas: Vec<SurfaceHandle> = prepare.handles(&self.sea)?;
        let spray = self.spray()?;
        let sea = seas.first().and_then(|surface| surface.as_sea()).map(|sea| (sea.frame().sea(), sea.level()));
        // Frames share the births they have in common.
        let run = prepare.shared(&(&spray, &sea), || {
            let spray = spray.clone();
            Ok(match sea.clone() {
                Some((sea, level)) => SprayRun::new(spray, sea, level),
                None => SprayRun::bursts(spray),
            }?)
        })?;
        let (time, brush) = (prepare.frame.time, self.brush());
        let projector = eye(prepare, &self.view, prepare.frame.format)?;
        let drops = run.at_unless(time, prepare.cancellation())?;
        let dabs = Dabs::new(&projector, &drops, &brush)?;
        let (view, drops, reference) = (self.view.clone(), drops.len(), OnceLock::new());
        Ok(Box::new(PreparedSpray { view, run, time, projector, brush, drops, dabs, reference }))
    }
}

struct PreparedSpray {
    view: One<port::View>,
    /// Kept for the next frame.
    run: Arc<SprayRun>,
    time: f64,
    projector: Projector,
    brush: Brush,
    /// Number of drops in the air; `dabs` holds only those in the picture.
    drops: usize,
    dabs: Dabs,
    /// Stamps of the f64 births, computed when a reference is first requested.
    reference: OnceLock<Result<Dabs, TooMuchSpray>>,
}

impl PreparedSpray {
    /// Returns the stamps of the f64 births, unless there are too many.
    fn truth(&self) -> Result<&Dabs, TooMuchSpray> {
        let made =
            self.reference.get_or_init(|| Dabs::new(&self.projector, &self.run.exact_at(self.time), &self.brush));
        made.as_ref().map_err(|much| *much)
    }
}

/// Paints stamps over a block in front of surfaces at the given depths.
fn paint(dabs: &Dabs, block: &Block<'_>, surface: &[f32], planes: Planes<'_>, stop: &dyn Fn() -> bool) {
    match block.scattered {
        Some(pixels) => dabs.fill_pixels_unless(pixels, block.offset, surface, planes, stop),
        None => dabs.fill_unless(block.window, block.offset, surface, planes, stop),
    }
}

/// Returns the largest f32 not above a number.
fn down(number: f64) -> f32 {
    let near = number as f32;
    if f64::from(near) > number { near.next_down() } else { near }
}

impl Prepared for PreparedSpray {
    fn fill(&self, block: &Block<'_>, inputs: &Inputs<'_>, outputs: &mut Outputs<'_>) -> Result<(), NodeError> {
        let [alpha, depth, age] = Out::ALL.map(|output| outputs.take(output, 0));
        let surface = inputs.view(&self.view, Channel::Depth);
        let planes = Planes { alpha, depth, age, weight: None };
        let stop = inputs.cancellation();
        paint(&self.dabs, block, surface, planes, stop);
        inputs.check_cancelled()
    }

    fn bound(&self, bounding: &Bounding<'_>, outputs: &mut Outputs<'_>) -> Result<(), NoBound> {
        // Whether a drop is born depends on a random draw against the waves, so that no drop's error follows from errors
        // of other values.
        let Ok(dabs) = self.truth() else { return Err(NoBound("the reference's drops cover too many pixels")) };
        let count = bounding.block.window.area();
        let depths: Vec<Span> = (0..count).map(|sample| bounding.certain(&self.view, Channel::Depth, sample)).collect();
        // The deeper the surface, the more is seen of each drop.
        let seen = |surface: Vec<f32>| {
            let mut planes = [(); 4].map(|()| vec![0.0; count]);
            let [alpha, depth, age, weight] = planes.each_mut().map(|plane| Some(&mut plane[..]));
            paint(dabs, bounding.block, &surface, Planes { alpha, depth, age, weight }, &|| false);
            planes
        };
        let near = seen(depths.iter().map(|depth| down(depth.low)).collect());
        let far = seen(depths.iter().map(|depth| -down(-depth.high)).collect());
        let rounded = |low: f32, high: f32| {
            // Allow for the rounding of the reference's values to f32.
            let slack = |end: f32| {
                if end.is_finite() { f64::from(end.abs()) * LITERAL + f64::from(f32::from_bits(1)) } else { 0.0 }
            };
            Span { low: f64::from(low) - slack(low), high: f64::from(high) + slack(high), clear: true }
        };
        bounding.bound_by(outputs, Out::Alpha, 0, |sample| {
            let alpha = rounded(near[0][sample], far[0][sample]).within(0.0, 1.0);
            alpha.with(depths[sample].clear && (self.brush.soft > 0.0 || near[0][sample] == far[0][sample]))
        });
        bounding.bound_by(outputs, Out::Depth, 0, |sample| {
            let [nearest, farthest] = [&far, &near].map(|planes| planes[1][sample]);
            rounded(nearest, farthest).with(nearest == farthest)
        });
        bounding.bound_by(outputs, Out::Age, 0, |sample| {
            let is_bare = far[0][sample] == 0.0 && far[1][sample] == f32::INFINITY;
            if is_bare || depths[sample].low == depths[sample].high {
                return rounded(near[2][sample], far[2][sample]).within(0.0, 1.0);
            }
            // In front of the nearer surface, drops have a known mean age; what the farther surface reveals in
            // addition may have any age.
            let [least, most] = [&near, &far].map(|planes| f64::from(planes[3][sample]));
            if least > 0.0 && depths[sample].clear && self.brush.soft > 0.0 {
                let more = (most - least) / most + 2.0 * LITERAL;
                let mean = rounded(near[2][sample], near[2][sample]);
                Span { low: mean.low * (1.0 - more), high: mean.high + more * (1.0 - mean.low), clear: true }
                    .within(0.0, 1.0)
            } else {
                Span::unclear(0.0, 1.0)
            }
        });
        Ok(())
    }

    fn reference(&self, inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        let dabs = self.truth()?;
        let SpraySample { alpha, depth, age, .. } = dabs.at(inputs.at, inputs.view(&self.view, Channel::Depth));
        let output = |output| match output {
            Out::Alpha => Reference::Mask(alpha),
            Out::Depth => Reference::Field(vec![depth]),
            Out::Age => Reference::Mask(age),
        };
        Ok(Out::ALL.map(output).into())
    }

    fn left_out(&self) -> Vec<Omission> {
        let (count, of) = ((self.drops - self.dabs.len()) as f64, self.drops as f64);
        let why = "they are outside the picture, behind the camera, or faded";
        if count > 0.0 { vec![Omission { port: None, what: "drops", count, of, why }] } else { Vec::new() }
    }

    fn bytes(&self) -> usize {
        self.dabs.bytes() + self.run.bytes()
    }
}
