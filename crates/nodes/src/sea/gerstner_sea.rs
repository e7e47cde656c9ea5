//! GerstnerSea: a sum of trochoidal waves.

use super::{profile, stability};
use crate::geometry::{PreparedSurface, memory};
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::SeaSurface;
use trochoid_sea::{
    Convention, Dispersion, ExplicitWave, FoldOptions, Folding, GerstnerSpectrum, MAX_WAVES, Sea, SpectrumError, Wave,
    WaveError, WaveGroup, WaveParameter,
};

/// An endless sea: a sum of trochoidal waves with log-normally distributed wavelengths, plus waves and crests set by
/// hand.
///
/// # Formula
/// θ = k(d · p₀) − ωt + φ;  (x, z) −= h·d·sin θ,  y += a·cos θ.  a ∝ L, scaled so that 4 × RMS of the sum is `height`;
/// ω = √(gk). h = `sharpness`/k for a wave set by hand; for n random ones, h = q/k with q =
/// `sharpness`·√(2/n)/min(√(2n), 2.5). Waves too short for a pixel fade by exp(−(kσ)²/2), σ = footprint/2. A group's
/// waves have k = d(2π/L + p/`along`) + e·q/`across`, |p|, |q| ≤ 1.8, a ∝ exp(−(p² + q²)/2), Σa = `height`, and their
/// crests meet at its focus. How waves are drawn at random, and what a footprint is: see Definitions in the book.
///
/// # Edge cases
/// `count` 0 without `waves` and `groups` is a flat sea. Sharpness 0 gives a sum of sinusoids; above 1, crests fold
/// over. With convention "thesis", the sum is flat for many waves, and sharpness also scales the height: the
/// weight of each random wave is 1/n. For weights of your own, set the `waves` by hand: an amplitude holds its weight.
///
/// # Source
/// Thesis 3.2.1; Hinsinger, Neyret and Cani, Interactive Animation of Ocean Waves, 2002.
#[derive(Clone, Node)]
#[node(stage, end = Front, revision = 1, role = Sea, offers(Rest, Waves), output(surface: Kind::Surface = "The sea at the frame's time."))]
#[also_called("Sea", "Ocean", "Water", "Waves", "Gerstner", "OceanModifier")]
pub(crate) struct GerstnerSea {
    /// Number of random waves.
    #[knob(default = 1000, range = 0..=MAX_WAVES as i64, affects_cost)]
    count: i64,
    /// Mean wavelength L.
    #[knob(default = 20.0, range = 1e-3..=1e5, unit = "m")]
    wavelength: f64,
    /// Standard deviation of ln L.
    #[knob(default = 0.5, range = 0.0..=3.0)]
    spread: f64,
    /// Significant wave height: 4 times the root mean square of the height.
    #[knob(default = 1.0, range = 0.0..=1e4, unit = "m")]
    height: f64,
    /// Mean direction of travel: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -3600.0..=3600.0, unit = "degrees")]
    direction: f64,
    /// Standard deviation of the direction of travel.
    #[knob(default = 30.0, range = 0.0..=360.0, unit = "degrees")]
    direction_spread: f64,
    /// Sharpness of the crests: 0 gives sinusoids; at 1 the sharpest crests reach a cusp.
    #[knob(default = 0.5, range = 0.0..=10.0)]
    sharpness: f64,
    /// Relation of frequency to wavelength: that of "deep" water, one "speed" of all crests, or one "period" of all
    /// waves.
    dispersion: DispersionKind,
    /// Speed of the crests, for dispersion "speed".
    #[knob(default = 5.0, range = 0.0..=1e4, unit = "m/s")]
    speed: f64,
    /// Period of all waves, for dispersion "period".
    #[knob(default = 4.0, range = 1e-3..=1e6, unit = "s")]
    period: f64,
    /// Signs and weights of the waves: "settled" as corrected here, "thesis" as printed in the thesis.
    convention: WaveConvention,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
    /// World y of the sea at rest.
    #[knob(default = 0.0, range = -1e5..=1e5, unit = "m", places = Level)]
    pub(super) level: f64,
    /// Fineness of the drawn waves: 1 resolves what a pixel resolves; 0.5 only what two pixels do, with a quarter of
    /// the vertices.
    #[knob(default = 1.0, range = 0.05..=4.0)]
    detail: f64,
    /// Waves set by hand, added to the random ones.
    #[list(0..=10_000)]
    waves: Vec<ManualWave>,
    /// Crests set by hand; each is a group of waves that meet at a given place and time.
    #[list(0..=100)]
    groups: Vec<Group>,
}

#[derive(Clone, Items)]
struct ManualWave {
    /// Wavelength: distance from crest to crest.
    #[knob(range = 1e-3..=1e6, unit = "m", required)]
    wavelength: f64,
    /// Vertical amplitude.
    #[knob(range = -1e4..=1e4, unit = "m", required)]
    amplitude: f64,
    /// Direction of travel: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -3600.0..=3600.0, unit = "degrees")]
    direction: f64,
    /// Sharpness of the crests: 0 is a sinusoid, 1 a cusp.
    #[knob(default = 0.0, range = 0.0..=10.0)]
    sharpness: f64,
    /// Phase at the origin at time 0.
    #[knob(default = 0.0, range = -1e6..=1e6, unit = "degrees")]
    phase: f64,
    /// Speed of the crests; if unset, that of deep water.
    #[knob(range = 0.0..=1e4, unit = "m/s")]
    speed: Option<f64>,
}

#[derive(Clone, Items)]
struct Group {
    /// Wavelength of the group's middle wave.
    #[knob(range = 1e-3..=1e6, unit = "m", required)]
    wavelength: f64,
    /// Height of the crest above the sea at rest, at the focus.
    #[knob(range = -1e4..=1e4, unit = "m", required)]
    height: f64,
    /// Direction of travel: 0 is +X, 90 is +Z.
    #[knob(default = 0.0, range = -3600.0..=3600.0, unit = "degrees", places = Heading)]
    direction: f64,
    /// Standard deviation of the group along its travel, at least 0.31 wavelengths; if unset, half a wavelength.
    #[knob(range = 1e-3..=1e6, unit = "m")]
    along: Option<f64>,
    /// Standard deviation of the group across its travel; if unset, half a wavelength.
    #[knob(range = 1e-3..=1e6, unit = "m")]
    across: Option<f64>,
    /// World x of the focus.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "m", places = X)]
    x: f64,
    /// World z of the focus.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "m", places = Z)]
    z: f64,
    /// Time at which the crests meet at the focus.
    #[knob(default = 0.0, range = -1e8..=1e8, unit = "s")]
    time: f64,
    /// Sharpness of the crest at the focus: 0 is sinusoidal, 1 a cusp.
    #[knob(default = 0.5, range = 0.0..=10.0)]
    sharpness: f64,
    /// Speed at which the group travels unchanged; if unset, it disperses as in deep water, so that the crest rises
    /// and subsides.
    #[knob(range = -1e4..=1e4, unit = "m/s")]
    speed: Option<f64>,
    /// Number of waves along the travel; with few, the crest recurs nearby.
    #[knob(default = 5, range = 1..=100)]
    waves_along: i64,
    /// Number of waves across the travel.
    #[knob(default = 5, range = 1..=100)]
    waves_across: i64,
    /// Random seed.
    #[knob(default = 0, range = 0..=1_000_000_000)]
    seed: i64,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum DispersionKind {
    Deep,
    Speed,
    Period,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum WaveConvention {
    Settled,
    Thesis,
}

/// Reasons why the knobs do not describe a sea.
#[derive(Debug, thiserror::Error)]
enum SeaError {
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    #[error(transparent)]
    ManualWave(#[from] WaveError),
    #[error("groups[{index}]: {error}")]
    Group { index: usize, error: WaveError },
    #[error("{}; expected {}; {}", short(*.index, *.along), long_enough(*.least), SHORT)]
    Short { index: usize, along: f64, least: f64 },
}

/// Remedy for a group that is too short.
const SHORT: &str = "raise \"along\", or lower its \"wavelength\"";

fn short(index: usize, along: f64) -> String {
    format!("groups[{index}] with \"along\" {along} m")
}

fn long_enough(least: f64) -> String {
    let ratio = WaveGroup::LEAST_ALONG;
    format!("at least {least:.3} m, {ratio} of its wavelength: a shorter group would need waves that travel backward")
}

impl SeaError {
    /// Reports the refusal on the knob it comes from.
    fn report(&self, check: &mut Check<'_>) {
        const CHANGE: &str = "change it";
        match self {
            Self::Spectrum(SpectrumError::Count(found)) => {
                let (found, expected) = (format!("{found} waves"), format!("at most {MAX_WAVES}"));
                check.error(GerstnerSea::COUNT, found, expected, "lower \"count\"");
            }
            Self::Spectrum(SpectrumError::Knob(WaveError { parameter, found, expected })) => {
                check.error(GerstnerSea::of_spectrum(*parameter), format!("{parameter} {found}"), expected, CHANGE);
            }
            Self::ManualWave(WaveError { parameter, found, expected }) => {
                check.error(GerstnerSea::WAVES, format!("{parameter} {found}"), expected, CHANGE);
            }
            Self::Group { index, error: WaveError { parameter, found, expected } } => {
                check.error(GerstnerSea::GROUPS, format!("groups[{index}]: {parameter} {found}"), expected, CHANGE);
            }
            Self::Short { index, along, least } => {
                check.error(GerstnerSea::GROUPS, short(*index, *along), long_enough(*least), SHORT);
            }
        }
    }
}

impl ManualWave {
    fn wave(&self) -> Result<Wave, WaveError> {
        Wave::try_from(ExplicitWave {
            wavelength: self.wavelength,
            amplitude: self.amplitude,
            direction: self.direction.to_radians(),
            sharpness: self.sharpness,
            phase: self.phase.to_radians(),
            speed: self.speed,
        })
    }
}

impl Group {
    fn waves(&self, index: usize) -> Result<Vec<Wave>, SeaError> {
        let half = self.wavelength / 2.0;
        let group = WaveGroup {
            wavelength: self.wavelength,
            height: self.height,
            direction: self.direction.to_radians(),
            along: self.along.unwrap_or(half),
            across: self.across.unwrap_or(half),
            focus: [self.x, self.z],
            time: self.time,
            sharpness: self.sharpness,
            speed: self.speed,
            waves: [self.waves_along as usize, self.waves_across as usize],
            seed: self.seed as u64,
        };
        let least = WaveGroup::LEAST_ALONG * group.wavelength;
        if group.along < least {
            return Err(SeaError::Short { index, along: group.along, least });
        }
        group.waves().map_err(|error| SeaError::Group { index, error })
    }

    /// Returns the number of waves in the group.
    fn count(&self) -> f64 {
        self.waves_along as f64 * self.waves_across as f64
    }
}

impl GerstnerSea {
    /// Returns the waves that the knobs describe.
    fn waves(&self) -> Result<Vec<Wave>, SeaError> {
        let spectrum = GerstnerSpectrum {
            count: self.count as usize,
            wavelength: self.wavelength,
            spread: self.spread,
            height: self.height,
            direction: self.direction.to_radians(),
            direction_spread: self.direction_spread.to_radians(),
            sharpness: self.sharpness,
            dispersion: match self.dispersion {
                DispersionKind::Deep => Dispersion::Deep,
                DispersionKind::Speed => Dispersion::Speed(self.speed),
                DispersionKind::Period => Dispersion::Period(self.period),
            },
            convention: match self.convention {
                WaveConvention::Settled => Convention::Settled,
                WaveConvention::Thesis => Convention::Thesis,
            },
            seed: self.seed as u64,
        };
        let mut waves = spectrum.waves()?;
        for wave in &self.waves {
            waves.push(wave.wave()?);
        }
        for (index, group) in self.groups.iter().enumerate() {
            waves.extend(group.waves(index)?);
        }
        Ok(waves)
    }

    /// Returns the knob or list with the sharpest waves, and which numbers to lower so that no crests fold.
    fn less_sharp(&self, factor: f64) -> (ItemName, String) {
        const NAMED: usize = 4;
        let random = (self.count > 0).then(|| (Self::SHARPNESS, "\"sharpness\"".to_string(), self.sharpness));
        let listed = |item: ItemName, list: &'static str, all: Vec<f64>| {
            let named = move |(index, sharpness)| (item, format!("the \"sharpness\" of {list}[{index}]"), sharpness);
            all.into_iter().enumerate().map(named)
        };
        let waves = listed(Self::WAVES, "waves", self.waves.iter().map(|wave| wave.sharpness).collect());
        let groups = listed(Self::GROUPS, "groups", self.groups.iter().map(|group| group.sharpness).collect());
        let mut sharp: Vec<(ItemName, String, f64)> = random.into_iter().chain(waves).chain(groups).collect();
        sharp.retain(|(.., sharpness)| *sharpness > 0.0);
        // Stable: of equals, the first in the document.
        sharp.sort_by(|(.., a), (.., b)| b.total_cmp(a));
        match sharp.as_slice() {
            [] => (Self::SHARPNESS, "lower \"sharpness\"".into()),
            [(item, name, sharpness)] => (*item, format!("lower {name} to {:.3}", sharpness * factor)),
            [(item, ..), ..] => {
                let mut names: Vec<&str> = sharp.iter().map(|(_, name, _)| name.as_str()).take(NAMED).collect();
                names.extend((sharp.len() > NAMED).then_some("every other one"));
                (*item, format!("multiply by {factor:.3}: {}", names.join(", ")))
            }
        }
    }

    /// Returns the knob that a parameter of the spectrum comes from.
    fn of_spectrum(parameter: WaveParameter) -> ItemName {
        match parameter {
            WaveParameter::Wavelength | WaveParameter::WavelengthInGroup => Self::WAVELENGTH,
            WaveParameter::Spread => Self::SPREAD,
            WaveParameter::Height | WaveParameter::Amplitude => Self::HEIGHT,
            WaveParameter::Direction => Self::DIRECTION,
            WaveParameter::DirectionSpread => Self::DIRECTION_SPREAD,
            WaveParameter::Sharpness => Self::SHARPNESS,
            WaveParameter::Speed => Self::SPEED,
            WaveParameter::Period | WaveParameter::Frequency => Self::PERIOD,
            WaveParameter::Waves => Self::COUNT,
            // These occur only in groups and ripples.
            WaveParameter::Phase
            | WaveParameter::Along
            | WaveParameter::Across
            | WaveParameter::Focus
            | WaveParameter::Time => Self::WAVES,
        }
    }
}

/// Returns how far waves are from folding. The latest results are cached: every edit checks the document, and few
/// edits change a sea.
fn folding(waves: Vec<Wave>) -> Folding {
    static KNOWN: Mutex<VecDeque<(Vec<Wave>, Folding)>> = Mutex::new(VecDeque::new());
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, found)) = known().iter().find(|(same, _)| *same == waves) {
        return *found;
    }
    let found = Sea::new(waves.clone()).folding(FoldOptions::default());
    let mut known = known();
    known.truncate(REMEMBERED - 1);
    known.push_front((waves, found));
    found
}

/// Number of seas whose folding is cached.
const REMEMBERED: usize = 16;

/// Whether the folded share is large enough to be visible.
fn is_folded(folds: &Folding) -> bool {
    folds.folded_share > FoldOptions::default().tolerated_share
}

impl Node for GerstnerSea {
    fn check(&self, check: &mut Check<'_>) {
        let waves = match self.waves() {
            Ok(waves) => waves,
            Err(refused) => return refused.report(check),
        };
        // Nodes that take folds for breaking crests want them: no warning.
        if check.consumers().iter().any(|consumer| consumer.wants.contains(&Offer::Folds)) {
            return;
        }
        let folds = folding(waves);
        if is_folded(&folds) {
            let found = format!("crests that fold over on {:.2} % of the sea", 100.0 * folds.folded_share);
            let (item, remedy) = self.less_sharp(folds.unfolded_scale);
            check.warning(item, found, "crests that do not fold", remedy);
        }
    }

    fn work(&self, format: Format, _time: f64) -> Option<Work> {
        // Seconds per wave and vertex, whose number is within limits.
        const WAVE: f64 = 4e-11;
        let grouped: f64 = self.groups.iter().map(Group::count).sum();
        let waves = self.count as f64 + self.waves.len() as f64 + grouped;
        let vertices = (SeaSurface::VERTICES_PER_PIXEL * format.window().area() as f64).clamp(1e6, 8e6);
        let remedy = "lower \"count\", the number of waves in \"groups\", or the number of pixels";
        Some(Work { seconds: WAVE * waves * vertices, item: Self::COUNT, remedy })
    }

    fn notes(&self, _times: FrameTimes) -> Vec<String> {
        let Ok(waves) = self.waves() else { return Vec::new() };
        let (count, noun) = (waves.len(), if waves.len() == 1 { "wave" } else { "waves" });
        let folds = folding(waves);
        let verdict = if is_folded(&folds) {
            format!(
                "crests fold over on {:.2} % of the sea; with {:.3} times the sharpness, they would not",
                100.0 * folds.folded_share,
                folds.unfolded_scale
            )
        } else if folds.jacobian_min < 0.0 {
            "crests fold over on less than a thousandth of the sea".into()
        } else if folds.unfolded_scale.is_finite() {
            format!(
                "crests do not fold over; with up to {:.3} times the sharpness, they still would not",
                folds.unfolded_scale
            )
        } else {
            "crests do not fold over at any sharpness".into()
        };
        let points = FoldOptions::default().samples;
        let proof = if folds.proved() {
            "proved for every place and time".into()
        } else {
            format!("estimated from {points} points")
        };
        vec![format!(
            "{count} {noun}; {verdict} ({proof}). In figures: least det J {:.3} (1 at rest, negative where folded), λ1 {:.3} \
             (less than 1 proves that nothing folds), Σq {:.3}",
            folds.jacobian_min, folds.lambda[0], folds.q_sum,
        )]
    }

    fn dynamics(&self) -> Option<&dyn Dynamics> {
        Some(self)
    }
}

impl Dynamics for GerstnerSea {
    fn stability(&self) -> Option<Stability> {
        Some(stability::waves(self.waves().ok()?))
    }

    fn spectrum(&self) -> Option<Spectrum> {
        let waves = self.waves().ok()?;
        let lengths = LengthDistribution { count: self.count as usize, mean: self.wavelength, spread: self.spread };
        Some(Spectrum {
            waves: profile::harmonics(&waves),
            unfolded: folding(waves).unfolded_scale,
            lengths: (self.count > 0).then_some(lengths),
        })
    }

    fn profile(&self, line: &ProfileLine, time: f64) -> Option<Profile> {
        Some(profile::of_waves(self.waves().ok()?, line, time))
    }
}

impl Stage for GerstnerSea {
    fn depends_on_time(&self) -> bool {
        true
    }

    fn depends_on_format(&self) -> bool {
        false
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        memory::of_sea(self.detail, context)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = Sea::new(self.waves()?);
        let surface = SeaSurface::new(&sea, prepare.frame.time, self.level);
        Ok(Box::new(PreparedSurface::new(surface.with_detail(self.detail))))
    }
}
