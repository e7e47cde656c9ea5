//! The same drops by plain loops in f64: every step of a lifetime, every cell, every candidate, the sum over all
//! waves.

use super::Spray;
use super::birth::{Birth, Droplet, Water};
use crate::{Sea, SeaFrame};

/// Returns the births of every step that matters at a time, over a sea that rests at world y = `level`.
///
/// Slow: cells × steps × waves.
pub fn births(spray: &Spray, sea: &Sea, level: f64, time: f64) -> Vec<Birth> {
    let mut births = Vec::new();
    for step in spray.steps(time) {
        let frame = sea.at(spray.moment(step));
        for cell in spray.cells().iter() {
            let mut jacobian = None;
            spray.candidates(cell, step, |candidate, needed| {
                let folded = || frame.evaluate(spray.middle(cell), spray.cell).jacobian();
                if *jacobian.get_or_insert_with(folded) < needed {
                    let water = water(&frame, candidate.rest(spray), spray.cell, level);
                    births.push(spray.birth(&candidate, &water));
                }
            });
        }
    }
    births
}

/// Returns the drops that are alive at a time, in the order of [`SprayRun::at`](super::SprayRun::at); without a
/// level, only those of bursts.
pub fn drops(spray: &Spray, sea: &Sea, level: Option<f64>, time: f64) -> Vec<Droplet> {
    let born = level.map(|level| births(spray, sea, level, time)).unwrap_or_default();
    let born = born.into_iter().chain(spray.thrown(time));
    born.filter_map(|birth| spray.droplet(&birth, level, time)).collect()
}

/// Returns the state of a sea that rests at world y = `level`.
fn water(frame: &SeaFrame, [x, z]: [f64; 2], footprint: f64, level: f64) -> Water {
    let sample = frame.evaluate([x, z], footprint);
    let [dx, dy, dz] = sample.displacement;
    Water { position: [x + dx, level + dy, z + dz], velocity: sample.velocity }
}
