//! Shapes of brush stamps.

use super::dab::LANES;
use trochoid_sea::spray::Droplet;

/// Share of the largest radius from which drops of mixed stamps are ragged.
const LARGE: f64 = 0.4;

/// Kind of stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Stamp {
    /// Ragged stamps for large drops, discs and streaks for small ones.
    #[default]
    Mixed,
    /// Discs.
    Disc,
    /// Strokes along the motion.
    Streak,
    /// Strokes along the motion, torn by bristles.
    Ragged,
}

/// Shape of one stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Disc,
    Streak,
    Ragged,
}

impl Stamp {
    pub(super) fn form(self, drop: &Droplet) -> Form {
        match self {
            Self::Disc => Form::Disc,
            Self::Streak => Form::Streak,
            Self::Ragged => Form::Ragged,
            Self::Mixed if drop.share >= LARGE => Form::Ragged,
            Self::Mixed if drop.shape & 1 == 0 => Form::Disc,
            Self::Mixed => Form::Streak,
        }
    }
}

/// The print that a stamp leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Print {
    form: Form,
    /// Cells of noise from the middle to the end, and from the middle to the side.
    cells: [f64; 2],
    /// Strength of tearing by noise: 0 for stamps that are too small to show it.
    torn: f64,
    /// Share of the paint that is lost with age.
    worn: f64,
    seed: u32,
}

/// Cells of noise across half a stamp, which is the number of bristles.
const BRISTLES: f64 = 2.6;
/// Most cells along half a stamp.
const MOST: f64 = 6.0;

impl Print {
    /// Makes the print of a drop with this half length and half width in pixels.
    pub(super) fn new(form: Form, drop: &Droplet, [length, width]: [f64; 2]) -> Self {
        Self {
            form,
            cells: [(0.8 * BRISTLES * length / width).min(MOST), BRISTLES],
            torn: ((width - 1.0) / 3.0).clamp(0.0, 1.0),
            worn: drop.age,
            seed: (drop.shape >> 32) as u32,
        }
    }

    /// Returns the share of the paint at a position in the stamp whose squared distance from the middle is 1 −
    /// `inside`.
    #[inline(always)]
    pub(super) fn cover(&self, along: f64, across: f64, inside: f64) -> f64 {
        match self.form {
            Form::Disc | Form::Streak => (2.0 * inside).min(1.0),
            Form::Ragged => self.ragged(along, across, inside),
        }
    }

    /// Does the same at positions side by side.
    #[inline(always)]
    pub(super) fn covers(&self, along: [f64; LANES], across: [f64; LANES], inside: [f64; LANES]) -> [f64; LANES] {
        let mut covers = [0.0; LANES];
        match self.form {
            Form::Disc | Form::Streak => {
                for (cover, inside) in covers.iter_mut().zip(inside) {
                    *cover = (2.0 * inside).min(1.0);
                }
            }
            Form::Ragged => {
                for (lane, cover) in covers.iter_mut().enumerate() {
                    *cover = self.ragged(along[lane], across[lane], inside[lane]);
                }
            }
        }
        covers
    }

    #[inline(always)]
    fn ragged(&self, along: f64, across: f64, inside: f64) -> f64 {
        let [x, y] = [along * self.cells[0], across * self.cells[1]];
        let rough = 0.65 * noise(self.seed, x, y) + 0.35 * noise(!self.seed, 2.1 * x, 2.1 * y);
        // Paint remains where there was enough of it: less toward the edge, and with age.
        let paint = inside * (1.0 - 0.6 * self.worn);
        let t = ((1.1 * paint + self.torn * 1.6 * (rough - 0.55) - 0.05) / 0.6).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t) * (paint / 0.3).min(1.0)
    }
}

/// Returns smooth noise in [0, 1], with one random number per unit of each axis.
#[inline(always)]
fn noise(seed: u32, x: f64, y: f64) -> f64 {
    let (column, row) = (x.floor(), y.floor());
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (u, v) = (ease(x - column), ease(y - row));
    let (column, row) = (column as i32 as u32, row as i32 as u32);
    let corner = |i: u32, j: u32| {
        let line = mix(seed ^ row.wrapping_add(j).wrapping_mul(0x9e37_79b9));
        f64::from(mix(line ^ column.wrapping_add(i))) / f64::from(u32::MAX)
    };
    let along = |j: u32| {
        let (a, b) = (corner(0, j), corner(1, j));
        a + (b - a) * u
    };
    let (a, b) = (along(0), along(1));
    a + (b - a) * v
}

/// Spreads the bits of a number over all of its bits: a bijection (Wellons, hash-prospector, "lowbias32").
#[inline(always)]
fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}
