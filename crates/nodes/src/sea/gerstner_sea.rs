//! GerstnerSea: a sum of trochoidal waves.

use crate::scene_support::{Parted, REST, SurfaceHandle, WAVES, memory, parted, stability};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use trochoid_graph::*;
use trochoid_image::Format;
use trochoid_scene::SeaSurface;
use trochoid_sea::{
    Convention, Dispersion, ExplicitWave, FoldOptions, Folding, GerstnerSpectrum, MAX_WAVES, Sea, Wave, WaveGroup,
};

pub(crate) static NODE: &dyn NodeType = &GerstnerSea;

struct GerstnerSea;

static DECLARATION: Declaration = Declaration {
    name: "GerstnerSea",
    end: End::Front,
    summary: "An endless sea: a sum of trochoidal waves with log-normal lengths, of waves and of crests set by hand.",
    formula: "θ = k(d · p₀) − ωt + φ;  x −= h·d·sin θ,  y += a·cos θ.  a ∝ L, scaled so that 4 × RMS of the sum is \
              `height`; ω = √(gk). Waves that a pixel cannot resolve fade by exp(−(kσ)²/2), σ = footprint/2. A group's waves \
              have k = d(2π/L + p/`along`) + e·q/`across`, |p|, |q| ≤ 1.8, a ∝ exp(−(p² + q²)/2), Σa = `height`, and \
              crests that meet at its focus.",
    edge_cases: "`count` 0 without `waves` and `groups` is a flat sea. Sharpness 0 is a sum of sinusoids; beyond 1 crests fold \
                 over. With convention \"thesis\" the sum is flat for many waves, and sharpness scales the height too.",
    source: "Thesis 3.2.1; Hinsinger, Neyret and Cani, Interactive Animation of Ocean Waves, 2002.",
    items: &[
        Knob::integer("count", 1000, 0, MAX_WAVES as i64, "Number of random waves.").scales().item(),
        Knob::number("wavelength", 20.0, 1e-3, 1e5, "Mean wavelength.").unit("m").item(),
        Knob::number("spread", 0.5, 0.0, 3.0, "Standard deviation of ln L.").item(),
        Knob::number("height", 1.0, 0.0, 1e4, "Significant wave height, 4 × RMS.").unit("m").item(),
        Knob::number("direction", 0.0, -3600.0, 3600.0, "Where waves travel: 0 is +X, 90 is +Z.")
            .unit("degrees")
            .item(),
        Knob::number("direction_spread", 30.0, 0.0, 360.0, "Standard deviation of the direction.")
            .unit("degrees")
            .item(),
        Knob::number("sharpness", 0.5, 0.0, 10.0, "0: sinusoids. 1: the sharpest crests reach the cusp.").item(),
        Knob::choice("dispersion", &["deep", "speed", "period"], "How frequency follows from length.").item(),
        Knob::number("speed", 5.0, 0.0, 1e4, "Speed of the crests, with dispersion \"speed\".").unit("m/s").item(),
        Knob::number("period", 4.0, 1e-3, 1e6, "Period of all waves, with dispersion \"period\".").unit("s").item(),
        Knob::choice("convention", &["settled", "thesis"], "Signs and weights as settled, or as printed.").item(),
        Knob::integer("seed", 0, 0, 1_000_000_000, "Which sea of all that have these figures.").item(),
        Knob::number("level", 0.0, -1e5, 1e5, "World y of the sea at rest.").unit("m").item(),
        Knob::number(
            "detail",
            1.0,
            0.05,
            4.0,
            "How fine waves are drawn: 1 as pixels resolve them; 0.5 as two pixels do, with a quarter of the vertices.",
        )
        .item(),
        List::of("waves", WAVE, 0, 10_000, "Waves set by hand, besides the random ones."),
        List::of("groups", GROUP, 0, 100, "Crests set by hand, each a packet of waves that meet at a place and time."),
    ],
    outputs: &[Output::new("surface", Kind::Surface, "The sea at the frame's time.")],
    revision: 1,
};

static WAVE: &[Item] = &[
    Knob::number("wavelength", 10.0, 1e-3, 1e6, "Crest to crest.").required().unit("m").item(),
    Knob::number("amplitude", 1.0, -1e4, 1e4, "Vertical amplitude.").required().unit("m").item(),
    Knob::number("direction", 0.0, -3600.0, 3600.0, "Where it travels: 0 is +X, 90 is +Z.").unit("degrees").item(),
    Knob::number("sharpness", 0.0, 0.0, 10.0, "Its share of the cusp: 0 is a sinusoid, 1 a cusp.").item(),
    Knob::number("phase", 0.0, -1e6, 1e6, "Phase at the origin at time 0.").unit("degrees").item(),
    Knob::number("speed", 0.0, 0.0, 1e4, "Speed of the crests; deep water decides if unset.")
        .optional()
        .unit("m/s")
        .item(),
];

static GROUP: &[Item] = &[
    Knob::number("wavelength", 30.0, 1e-3, 1e6, "Length of the middle wave.").required().unit("m").item(),
    Knob::number("height", 2.0, -1e4, 1e4, "Height of the crest over the sea at rest, at its focus.")
        .required()
        .unit("m")
        .item(),
    Knob::number("direction", 0.0, -3600.0, 3600.0, "Where it travels: 0 is +X, 90 is +Z.").unit("degrees").item(),
    Knob::number(
        "along",
        15.0,
        1e-3,
        1e6,
        "Standard deviation along its travel, ≥ 0.31 wavelengths; half of one if unset.",
    )
    .optional()
    .unit("m")
    .item(),
    Knob::number("across", 15.0, 1e-3, 1e6, "Standard deviation across its travel; half a wavelength if unset.")
        .optional()
        .unit("m")
        .item(),
    Knob::number("x", 0.0, -1e8, 1e8, "World x of the focus.").unit("m").item(),
    Knob::number("z", 0.0, -1e8, 1e8, "World z of the focus.").unit("m").item(),
    Knob::number("time", 0.0, -1e8, 1e8, "When the crests meet at the focus.").unit("s").item(),
    Knob::number("sharpness", 0.5, 0.0, 10.0, "Share of the cusp that the crest takes at its focus.").item(),
    Knob::number(
        "speed",
        0.0,
        -1e4,
        1e4,
        "Pace at which it travels unchanged; in deep water, if unset, it comes and goes.",
    )
    .optional()
    .unit("m/s")
    .item(),
    Knob::integer("waves_along", 5, 1, 100, "Waves along the travel; few let the crest return nearby.").item(),
    Knob::integer("waves_across", 5, 1, 100, "Waves across the travel.").item(),
    Knob::integer("seed", 0, 0, 1_000_000_000, "Which group of all that have these figures.").item(),
];

/// The waves that the knobs describe.
fn waves(node: &Settled) -> Result<Vec<Wave>, String> {
    let spectrum = GerstnerSpectrum {
        count: node.integer("count") as usize,
        wavelength: node.number("wavelength"),
        spread: node.number("spread"),
        height: node.number("height"),
        direction: node.number("direction").to_radians(),
        direction_spread: node.number("direction_spread").to_radians(),
        sharpness: node.number("sharpness"),
        dispersion: match node.text("dispersion") {
            "speed" => Dispersion::Speed(node.number("speed")),
            "period" => Dispersion::Period(node.number("period")),
            _ => Dispersion::Deep,
        },
        convention: if node.text("convention") == "thesis" { Convention::Thesis } else { Convention::Settled },
        seed: node.integer("seed") as u64,
    };
    let mut waves = spectrum.waves().map_err(|error| error.to_string())?;
    for wave in node.list("waves") {
        let wave = ExplicitWave {
            wavelength: wave.number("wavelength"),
            amplitude: wave.number("amplitude"),
            direction: wave.number("direction").to_radians(),
            sharpness: wave.number("sharpness"),
            phase: wave.number("phase").to_radians(),
            speed: wave.is_set("speed").then(|| wave.number("speed")),
        };
        waves.push(Wave::try_from(wave).map_err(|error| error.to_string())?);
    }
    for (index, group) in node.list("groups").iter().enumerate() {
        let half = group.number("wavelength") / 2.0;
        let or_half = |knob: &str| if group.is_set(knob) { group.number(knob) } else { half };
        let group = WaveGroup {
            wavelength: group.number("wavelength"),
            height: group.number("height"),
            direction: group.number("direction").to_radians(),
            along: or_half("along"),
            across: or_half("across"),
            focus: [group.number("x"), group.number("z")],
            time: group.number("time"),
            sharpness: group.number("sharpness"),
            speed: group.is_set("speed").then(|| group.number("speed")),
            waves: [group.integer("waves_along") as usize, group.integer("waves_across") as usize],
            seed: group.integer("seed") as u64,
        };
        let least = WaveGroup::LEAST_ALONG * group.wavelength;
        if group.along < least {
            return Err(format!(
                "groups[{index}] with \"along\" {} m; expected at least {least:.3} m, {} of its wavelength: a shorter \
                 one would need waves that run the other way; raise \"along\", or lower its \"wavelength\"",
                group.along,
                WaveGroup::LEAST_ALONG
            ));
        }
        waves.extend(group.waves().map_err(|error| format!("groups[{index}]: {error}"))?);
    }
    Ok(waves)
}

/// How far waves are from folding. The latest are remembered: a document is checked at every edit, and few touch its seas.
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

/// Seas whose folding is remembered.
const REMEMBERED: usize = 16;

impl NodeType for GerstnerSea {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        let waves = match waves(node) {
            Ok(waves) => waves,
            Err(error) => {
                let Parted { item, found, expected, remedy } = parted(&error, DECLARATION.items);
                let item = item.unwrap_or(if found.starts_with("group") { "groups" } else { "waves" });
                return check.error(item, found, expected, remedy);
            }
        };
        // What takes folds for breaking crests wants them.
        let wants = |user: User| matches!((user.ty, user.port), ("Spray", "sea") | ("FoldFoam" | "CrestFoam", "view"));
        if check.users().into_iter().any(wants) {
            return;
        }
        let folds = folding(waves);
        if folds.folded_share > FoldOptions::default().tolerated_share {
            let found = format!("crests that fold over on {:.2} % of the sea", 100.0 * folds.folded_share);
            let sharpness = node.number("sharpness") * folds.unfolded_scale;
            let remedy = if node.list("waves").is_empty() && node.list("groups").is_empty() {
                format!("a sharpness of {sharpness:.3} would not fold")
            } else {
                format!("all sharpnesses times {:.3} would not fold", folds.unfolded_scale)
            };
            check.warning("sharpness", found, "crests that do not fold", remedy);
        }
    }

    fn work(&self, node: &Settled, format: Format, _time: f64) -> Option<Work> {
        // A wave at a vertex, of which a picture of a sea has 1.5 a pixel, within limits.
        const WAVE: f64 = 4e-11;
        let group = |group: &Settled| group.number("waves_along") * group.number("waves_across");
        let waves =
            node.number("count") + node.list("waves").len() as f64 + node.list("groups").iter().map(group).sum::<f64>();
        let vertices = (1.5 * format.window().area() as f64).clamp(1e6, 8e6);
        let remedy = "lower \"count\", the waves of \"groups\", or the pixels";
        Some(Work { seconds: WAVE * waves * vertices, item: "count", remedy })
    }

    fn notes(&self, node: &Settled) -> Vec<String> {
        let Ok(waves) = waves(node) else { return Vec::new() };
        let count = waves.len();
        let folds = folding(waves);
        let verdict = if folds.folded_share > FoldOptions::default().tolerated_share {
            format!(
                "crests fold over on {:.2} % of the sea; with {:.3} times the sharpness they would not",
                100.0 * folds.folded_share,
                folds.unfolded_scale
            )
        } else if folds.unfolded_scale.is_finite() {
            format!("crests do not fold over, nor would they up to {:.3} times the sharpness", folds.unfolded_scale)
        } else {
            "crests do not fold over, however sharp".into()
        };
        let points = FoldOptions::default().samples;
        let proof = if folds.proved() {
            "proved for every place and time".into()
        } else {
            format!("estimated from {points} places")
        };
        vec![format!(
            "{count} waves; {verdict} ({proof}). In figures: least det J {:.3} (1 at rest, negative where folded), λ1 {:.3} \
             (less than 1 proves that nothing folds), Σq {:.3}",
            folds.jacobian_min, folds.lambda[0], folds.q_sum,
        )]
    }

    fn stability(&self, node: &Settled) -> Option<Stability> {
        Some(stability::waves(waves(node).ok()?))
    }

    fn spectrum(&self, node: &Settled) -> Option<Spectrum> {
        let waves = waves(node).ok()?;
        let harmonic = |wave: &Wave| Harmonic {
            wavelength: wave.wavelength,
            amplitude: wave.amplitude,
            direction: libm::atan2(wave.direction[1], wave.direction[0]).to_degrees(),
            sharpness: wave.compression(),
        };
        Some(Spectrum { waves: waves.iter().map(harmonic).collect(), unfolded: folding(waves).unfolded_scale })
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for GerstnerSea {
    fn timed(&self) -> bool {
        true
    }

    fn formatted(&self) -> bool {
        false
    }

    fn offers(&self) -> &'static [&'static str] {
        &[REST, WAVES]
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        memory::of_sea(node.number("detail"), reckoning)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let sea = Sea::new(waves(node).map_err(NodeError::new)?);
        let surface = SeaSurface::new(&sea, prepare.frame.time, node.number("level"));
        Ok(Box::new(Surging(Arc::new(surface.with_detail(node.number("detail"))))))
    }
}

struct Surging(SurfaceHandle);

impl Prepared for Surging {
    fn handle(&self) -> Option<Handle> {
        Some(Arc::new(self.0.clone()))
    }

    fn reference(&self, _inputs: &References<'_>) -> Result<Vec<Reference>, NodeError> {
        Ok(vec![Reference::Handle(Arc::new(self.0.clone()))])
    }
}
