//! Fills a stage's planes together with their bounds.

use trochoid_graph::{Block, Bound, Bounding, Connection, Inputs, NoBound, NodeError, Outputs, Prepared, SharedResult};
use trochoid_memory::Scratch;

/// Inputs of a stage, by port.
pub(crate) type Ports<'a> = Scratch<Scratch<Connection<'a>>>;
/// Planes for a stage to fill, by output.
type Planes<'a> = Vec<Vec<Option<&'a mut [f32]>>>;

/// What a stage did not compute from the planes of this block alone.
#[derive(Clone, Copy)]
pub(crate) enum Found<'f> {
    /// It is to find it now, for all samples.
    Now,
    /// This, if anything, at the first sample.
    Before(Option<&'f SharedResult>),
}

/// Fills a stage's planes. In each connection and output, the second half of the channels holds the bounds of the
/// first half. Returns the reason if the stage knows no bound, and what it found for all samples. A stage with `exact`
/// set counts as having no errors of its own.
pub(crate) fn fill_with_bounds<'p>(
    prepared: &dyn Prepared,
    exact: bool,
    block: &Block<'_>,
    ports: &Ports<'_>,
    cancelled: &(dyn Fn() -> bool + Sync),
    found: Found<'_>,
    planes: impl Iterator<Item: IntoIterator<Item = Option<&'p mut [f32]>>>,
) -> Result<(Option<NoBound>, Option<SharedResult>), NodeError> {
    let (values, bounds) = (half(ports, false), half(ports, true));
    let inputs = Inputs::new(&values).with_cancellation(cancelled);
    let found = match found {
        Found::Now => prepared.find(block, &inputs)?,
        Found::Before(found) => found.cloned(),
    };
    let inputs = inputs.with_found(found.as_ref());
    let limits = Inputs::new(&bounds).with_cancellation(cancelled);
    let mut planes: Planes<'_> = planes.map(|channels| channels.into_iter().collect()).collect();
    let mut targets: Planes<'_> = Vec::new();
    for planes in &mut planes {
        let middle = planes.len() / 2;
        targets.push(planes.split_off(middle));
    }
    let lent = planes.iter_mut().map(|planes| planes.iter_mut().map(|plane| plane.as_deref_mut()));
    prepared.fill(block, &inputs, &mut Outputs::new(lent))?;
    let filled: Vec<Vec<Option<&[f32]>>> =
        planes.iter().map(|planes| planes.iter().map(|plane| plane.as_deref()).collect()).collect();
    let bounding = Bounding { block, inputs: &inputs, bounds: &limits, filled: &filled };
    if exact {
        targets.iter_mut().flatten().flatten().for_each(|plane| plane.fill(Bound::EXACT.encode()));
        return Ok((None, found));
    }
    let lent = targets.iter_mut().map(|planes| planes.iter_mut().map(|plane| plane.as_deref_mut()));
    let none = prepared.bound(&bounding, &mut Outputs::new(lent)).err();
    if none.is_some() {
        targets.iter_mut().flatten().flatten().for_each(|plane| plane.fill(Bound::UNKNOWN.encode()));
    }
    Ok((none, found))
}

/// Returns the values of all connections, or their bounds.
fn half<'a>(ports: &Ports<'a>, second: bool) -> Ports<'a> {
    let mut half = ports.clone();
    for connection in half.iter_mut().flatten() {
        let middle = connection.planes.len() / 2;
        let bounds = connection.planes.drain(middle..).collect();
        if second {
            connection.planes = bounds;
        }
    }
    half
}
