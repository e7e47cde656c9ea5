//! How far rounding may carry what bursts add to a cell.
//!
//! Near its rim a burst adds little, but the place of a cell is as uncertain there as in its middle. These bounds are
//! therefore absolute: what moves a cell by an error moves a profile by its steepest slope times that. They belong to
//! the times, places, headings, shares and lengths of paths that f64 computes, which the definition takes as given.

use std::f64::consts::{PI, TAU};

use super::ROUNDING;
use super::bursts::ActiveBurst;
use crate::toon::{Basin, Combine, Shape, ToonSea};

/// What one burst adds.
struct Share {
    /// Its center and its reach along z, in meters.
    z: f64,
    reach: f64,
    /// How far rounding may carry what it adds, if that is little.
    off: f64,
    /// The most that it adds to a cell.
    most: f64,
}

/// Returns how far the sum of bursts may be off in any cell: rows know which of them may reach their cells. A sum of n
/// numbers takes n roundings.
fn crowded(basin: &Basin, shares: impl Iterator<Item = Share>) -> f64 {
    let mut rows = vec![[0.0; 3]; basin.rows];
    for Share { z, reach, off, most } in shares {
        // A row more at both ends covers the rounding of this. Numbers out of range become the nearest in range.
        let first = ((z - reach) / basin.spacing - 1.0) as usize;
        let end = (((z + reach) / basin.spacing + 2.0) as usize).min(basin.rows);
        for row in rows.iter_mut().take(end).skip(first) {
            let added = [off.min(2.0 * most), most, ROUNDING];
            row.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
        }
    }
    rows.iter().fold(0.0, |largest: f64, [off, most, roundings]| largest.max(off + most * roundings))
}

/// Returns the error of the coordinates of cells relative to a burst, within a distance from it, in meters.
///
/// A product with the spacing is rounded, then a difference: both coordinates are off by a rounding of the basin's size
/// and one of the distance, which is √2 of that in any direction. A turn takes two products and a sum.
fn misplaced(basin: &Basin, distance: f64) -> f64 {
    let size = basin.columns.max(basin.rows) as f64 * basin.spacing;
    ROUNDING * (1.5 * size + 4.0 * distance)
}

/// Returns the same relative to radii, whose inverses are given: these take five roundings, and their product one.
fn misscaled(basin: &Basin, [along, across]: [f64; 2]) -> f64 {
    misplaced(basin, 1.0 / along.min(across)) * along.max(across) + 6.0 * ROUNDING
}

/// Returns the bound on the force of bursts.
///
/// A distance is off by √2 times the error of its coordinates and three roundings, its sum with the shift by two. A
/// cosine is at most π times as steep, and off by ten roundings itself; sums and factors take less than twenty.
pub(super) fn force<'a>(sea: &ToonSea, bursts: impl Iterator<Item = &'a ActiveBurst<'a>>) -> f64 {
    let shares = bursts.map(|active| {
        let profile = active.profile(sea.behavior.shape);
        let off = PI * (1.5 * misscaled(&sea.basin, profile.inverse) + 5.0 * ROUNDING) + 30.0 * ROUNDING;
        let factor = (sea.injection() * profile.factor).abs();
        let reach = match sea.behavior.shape {
            Shape::Intended => 1.0 / profile.inverse[0].min(profile.inverse[1]),
            Shape::Literal => f64::INFINITY,
        };
        Share { z: active.center[1], reach, off: factor * off, most: 2.0 * factor }
    });
    crowded(&sea.basin, shares)
}

/// Returns the bound on how deep cells are within the distance of the rift.
///
/// A distance is off by the error of its coordinates, whatever the direction, and two roundings; the difference takes
/// one.
pub(super) fn rift<'a>(sea: &ToonSea, bursts: impl Iterator<Item = &'a ActiveBurst<'a>>) -> f64 {
    let distance = sea.behavior.rift.distance;
    let off = misplaced(&sea.basin, distance) + 3.0 * ROUNDING * distance;
    match sea.behavior.rift.combine {
        Combine::Nearest => bursts.map(|_| off.min(distance)).fold(0.0, f64::max),
        Combine::Sum => {
            let share = |active: &ActiveBurst<'_>| Share { z: active.center[1], reach: distance, off, most: distance };
            crowded(&sea.basin, bursts.map(share))
        }
    }
}

/// Returns the bound on the weight that bursts add to drift lines, and on its products with cosines and sines.
///
/// The square of a distance is off by 2√2 times the error of its coordinates and by four roundings, and so is what
/// remains of 1. Its square is twice as uncertain. Angles are sums of lengths times the frequency.
pub(super) fn drift<'a>(sea: &ToonSea, bursts: impl Iterator<Item = &'a ActiveBurst<'a>>) -> f64 {
    let (drift, basin) = (&sea.behavior.drift, &sea.basin);
    let lag = drift.lag.abs();
    let shares = bursts.map(|active| {
        let inverse = active.drawn_inverse(sea);
        let reach = 1.0 / inverse[0].min(inverse[1]);
        let weight = 6.0 * misscaled(basin, inverse) + 12.0 * ROUNDING;
        // |l| is rounded off over 1.5 cells.
        let length = reach + lag * (reach + 1.5 * basin.spacing) + active.burst.lane.abs();
        let moved = misplaced(basin, reach) * (1.0 + lag) + 8.0 * ROUNDING * length;
        let angle = TAU * (moved * drift.frequency() + ROUNDING) + 12.0 * ROUNDING;
        Share { z: active.center[1], reach, off: weight + angle, most: 1.0 }
    });
    crowded(basin, shares)
}
