//! Trails, which every cell keeps for itself: all steps of a row in turn, while it is in the cache.

use fearless_simd::Level;
use rayon::prelude::*;

use super::DRIFTS;
use super::bursts::{ActiveBurst, Ellipse};
use super::doubt::largest;
use super::rows::{Interval, Step, Sums};
use super::{plain, roundings};
use crate::toon::trail::decayed;
use crate::toon::{LITERAL_HZ, ToonSea, TrailFields};

/// Rift and drift of all cells; empty if not wanted.
#[derive(Clone, Debug)]
pub(super) struct Trails {
    pub(super) rift: Vec<f64>,
    /// Row by row, one field of drift after another.
    drift: Vec<f64>,
    /// Largest absolute values of rift and drift so far.
    pub(super) peaks: [f64; 2],
    /// How far rounding may have carried what bursts add to them at a time, whenever that was.
    pub(super) added_off: [f64; 2],
}

impl Trails {
    /// Returns a sea at rest.
    pub(super) fn new(sea: &ToonSea, wanted: TrailFields) -> Self {
        let cells = sea.basin.cells();
        Self {
            rift: vec![0.0; if wanted.rift { cells } else { 0 }],
            drift: vec![0.0; if wanted.drift { DRIFTS * cells } else { 0 }],
            peaks: [0.0; 2],
            added_off: [0.0; 2],
        }
    }

    /// Lets intervals of so many seconds pass, under the bursts of one time each, by plain loops or in vectors.
    pub(super) fn pass(&mut self, sea: &ToonSea, times: &[f64], seconds: f64, is_plain: bool) {
        let columns = sea.basin.columns;
        let Self { rift, drift, peaks, added_off } = self;
        let mut add = |field: usize, off: f64| added_off[field] = added_off[field].max(off);
        if is_plain {
            for &time in times {
                let bursts = ActiveBurst::all(sea, time);
                let row = |row: usize| plain::Row { sea, bursts: &bursts, row };
                let rows = rift.par_chunks_mut(columns).enumerate();
                rows.for_each(|(index, values)| row(index).rift(seconds, values));
                let rows = drift.par_chunks_mut(DRIFTS * columns).enumerate();
                rows.for_each(|(index, values)| row(index).drift(seconds, values));
                *peaks = [peaks[0].max(largest(rift)), peaks[1].max(largest(drift))];
                if !rift.is_empty() {
                    add(0, roundings::rift(sea, bursts.iter()));
                }
                if !drift.is_empty() {
                    add(1, roundings::drift(sea, bursts.iter()));
                }
            }
            return;
        }
        let level = Level::new();
        let behavior = &sea.behavior;
        if !rift.is_empty() {
            let (left, added) = decayed(behavior.rift.decay, seconds * LITERAL_HZ);
            let interval = Interval { left, added: behavior.rift.gain * added, renewal: 0.0 };
            let torn = steps(sea, times, ActiveBurst::torn);
            let most = sweep(rift, columns, &torn, |step, row, sums, values, is_still| {
                step.rift(level, interval, row, sums, values, is_still)
            });
            peaks[0] = peaks[0].max(most);
            torn.iter().for_each(|step| add(0, roundings::rift(sea, step.active())));
        }
        if !drift.is_empty() {
            let (left, added) = decayed(behavior.drift.decay, seconds * LITERAL_HZ);
            let interval = Interval { left, added, renewal: behavior.drift.renewal * seconds * LITERAL_HZ };
            let drawn = steps(sea, times, ActiveBurst::drawn);
            let most = sweep(drift, DRIFTS * columns, &drawn, |step, row, sums, values, is_still| {
                step.drift(level, interval, row, sums, values, is_still)
            });
            peaks[1] = peaks[1].max(most);
            drawn.iter().for_each(|step| add(1, roundings::drift(sea, step.active())));
        }
    }

    /// Returns all fields of drift.
    pub(super) fn drifts(&self, sea: &ToonSea) -> [Vec<f64>; DRIFTS] {
        let columns = sea.basin.columns;
        std::array::from_fn(|field| {
            self.drift.chunks(DRIFTS * columns).flat_map(|row| &row[field * columns..][..columns]).copied().collect()
        })
    }

    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        (self.rift.len() + self.drift.len()) * size_of::<f64>()
    }
}

/// Returns the bursts of some times, which count within an ellipse.
fn steps<'a>(sea: &'a ToonSea, times: &[f64], ellipse: fn(&ActiveBurst<'a>, &ToonSea) -> Ellipse) -> Vec<Step<'a>> {
    times.iter().map(|&time| Step::new(sea, time, |burst| Some(ellipse(burst, sea)))).collect()
}

/// Passes all steps over each row of fields; `pass` is told whether all values of a row are 0, and returns the largest of
/// those that did not only decay. Returns the largest of all.
fn sweep(
    values: &mut [f64],
    length: usize,
    steps: &[Step<'_>],
    pass: impl Fn(&Step<'_>, usize, &mut Sums, &mut [f64], bool) -> f64 + Sync,
) -> f64 {
    let rows = values.par_chunks_mut(length).enumerate();
    let peaks = rows.map_init(Sums::default, |sums, (row, values)| {
        let was_still = largest(values) == 0.0;
        let mut peak = 0.0_f64;
        for step in steps {
            peak = peak.max(pass(step, row, sums, values, was_still && peak == 0.0));
        }
        peak
    });
    peaks.reduce(|| 0.0, f64::max)
}
