use super::error::within;
use super::{Basin, Instability, ToonError, ToonParameter};
use trochoid_key::{ContentKey, KeyHasher, content_key};

/// Literal steps per second.
pub const LITERAL_HZ: f64 = 60.0;

/// The two coefficients of the recurrence h' = c₁(2·Lm(h) − h₋) + c₂·h.
///
/// c₁ is damping and Courant number at once: in the continuum γ·dt = (1−c₁)/(1+c₁), c·dt/dx = √(c₁/(1+c₁)) and
/// (ω₀·dt)² = 2(1−c₁−c₂)/(1+c₁).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixing {
    /// Weight of the neighbors and of the previous step.
    pub c1: f64,
    /// Weight of the height itself.
    pub c2: f64,
}

content_key!(Mixing { c1, c2 });

impl Default for Mixing {
    fn default() -> Self {
        Self { c1: 0.3, c2: 0.65 }
    }
}

impl Mixing {
    /// Returns 1 − c₁ − c₂: the share that a step takes from a level sea, and the scale of bursts with which a
    /// resting burst reaches its own height (in the mean over the basin).
    ///
    /// It has the precision of the number itself, however much c₁ and c₂ cancel it.
    pub fn loss(&self) -> f64 {
        // The difference of two numbers, and what its rounding lost.
        let less = |a: f64, b: f64| {
            let difference = a - b;
            let taken = difference - a;
            (difference, (a - (difference - taken)) - (b + taken))
        };
        let (first, lost) = less(1.0, self.c1);
        let (second, also_lost) = less(first, self.c2);
        second + (lost + also_lost)
    }
}

/// Waves in the continuum: h_tt + 2γ·h_t + ω₀²·h = c²∇²h + push·bursts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Physics {
    /// Speed c of short waves, in m/s.
    pub speed: f64,
    /// Damping γ, in 1/s.
    pub damping: f64,
    /// Frequency ω₀ of a level sea, in rad/s, which pulls it back to rest.
    pub frequency: f64,
    /// Acceleration in 1/s² per meter of a burst; if `None`, ω₀², with which a resting burst reaches its own height in
    /// the mean.
    pub push: Option<f64>,
}

content_key!(Physics { speed, damping, frequency, push });

/// How the height field moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// The printed recurrence, step ⌊60·t⌋: at 30 frames per second the picture moves by two steps per frame, at 24
    /// unevenly.
    Literal(Mixing),
    /// The recurrence raised to any power in its own basis: the literal look at any frame rate. Equal to it at 60 Hz.
    Resampled {
        /// Coefficients of a literal step.
        mixing: Mixing,
        /// Steps per second at which bursts act.
        rate: f64,
    },
    /// The exact solution of the wave equation on the grid, for any stiffness.
    Physical {
        /// Parameters of the waves.
        physics: Physics,
        /// Steps per second at which bursts act.
        rate: f64,
    },
}

impl ContentKey for Motion {
    fn feed(&self, hasher: &mut KeyHasher) {
        match self {
            Self::Literal(mixing) => (0_u8, mixing).feed(hasher),
            Self::Resampled { mixing, rate } => (1_u8, mixing, rate).feed(hasher),
            Self::Physical { physics, rate } => (2_u8, physics, rate).feed(hasher),
        }
    }
}

impl Default for Motion {
    fn default() -> Self {
        Self::Resampled { mixing: Mixing::default(), rate: LITERAL_HZ }
    }
}

impl Motion {
    /// Returns the steps per second.
    pub fn rate(&self) -> f64 {
        match *self {
            Self::Literal(_) => LITERAL_HZ,
            Self::Resampled { rate, .. } | Self::Physical { rate, .. } => rate,
        }
    }

    pub(crate) fn validate(&self, basin: &Basin) -> Result<(), ToonError> {
        within(ToonParameter::Rate, self.rate(), (1e-3, 1e4), "0.001 to 10,000 steps a second")?;
        match *self {
            Self::Literal(mixing) => Instability::check(mixing, basin).map_err(ToonError::Unstable),
            Self::Resampled { mixing, .. } => {
                Instability::check(mixing, basin).map_err(ToonError::Unstable)?;
                // The roots of g² − b·g + c₁ must be positive or complex: b > −2√c₁, where the least b is at an end
                // of the spectrum.
                let least = basin.gaps().map(|gap| 2.0 * mixing.c1 * (1.0 - gap) + mixing.c2);
                let real = mixing.c1 > 0.0 && least.iter().all(|&b| b > -2.0 * libm::sqrt(mixing.c1));
                if real { Ok(()) } else { Err(ToonError::NotResampled { found: [mixing.c1, mixing.c2] }) }
            }
            Self::Physical { physics, .. } => {
                let range = (0.0, 1e6);
                within(ToonParameter::Speed, physics.speed, range, "0 to 1e6 m/s")?;
                within(ToonParameter::Damping, physics.damping, range, "0 to 1e6 per second")?;
                within(ToonParameter::Frequency, physics.frequency, range, "0 to 1e6 rad/s")?;
                within(
                    ToonParameter::Push,
                    physics.push.unwrap_or(0.0),
                    (-1e12, 1e12),
                    "a finite number per second squared",
                )
            }
        }
    }
}
