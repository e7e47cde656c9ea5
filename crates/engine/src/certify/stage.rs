//! A stage's planes with their bounds.

use std::cell::RefCell;
use trochoid_graph::{Block, Bound, Bounding, Connection, Inputs, NoBound, NodeError, Outputs, Prepared};

thread_local! {
    /// The stages that told of no bound on this thread since somebody asked, each by the address of what it prepared.
    static UNBOUNDED: RefCell<Vec<(usize, NoBound)>> = const { RefCell::new(Vec::new()) };
}

/// The address of what a stage prepared, as [`take_unbounded`] knows it.
pub(crate) fn address(prepared: &dyn Prepared) -> usize {
    std::ptr::from_ref(prepared).cast::<()>() as usize
}

/// The stages that told of no bound on this thread since the last call.
pub(crate) fn take_unbounded() -> Vec<(usize, NoBound)> {
    UNBOUNDED.take()
}

/// What a stage is given, by port.
pub(crate) type Ports<'a> = Vec<(&'static str, Vec<Connection<'a>>)>;
/// What it is to fill, by output.
pub(crate) type Planes<'a> = Vec<Vec<Option<&'a mut [f32]>>>;

/// Fills a stage's planes: of each connection and output, the second half of the channels holds the bounds of the first.
pub(crate) fn fill_with_bounds(
    prepared: &dyn Prepared,
    block: &Block<'_>,
    ports: &Ports<'_>,
    cancelled: &(dyn Fn() -> bool + Sync),
    mut planes: Planes<'_>,
) -> Result<(), NodeError> {
    let (values, bounds) = (half(ports, false), half(ports, true));
    let inputs = Inputs::new(&values).with_cancellation(cancelled);
    let limits = Inputs::new(&bounds).with_cancellation(cancelled);
    let mut targets: Planes<'_> = Vec::new();
    for planes in &mut planes {
        let middle = planes.len() / 2;
        targets.push(planes.split_off(middle));
    }
    let lent = planes.iter_mut().map(|planes| planes.iter_mut().map(|plane| plane.as_deref_mut()).collect());
    prepared.fill(block, &inputs, &mut Outputs::new(lent.collect()))?;
    let filled: Vec<Vec<Option<&[f32]>>> =
        planes.iter().map(|planes| planes.iter().map(|plane| plane.as_deref()).collect()).collect();
    let bounding = Bounding { block, inputs: &inputs, bounds: &limits, filled: &filled };
    let lent = targets.iter_mut().map(|planes| planes.iter_mut().map(|plane| plane.as_deref_mut()).collect());
    if let Err(why) = prepared.bound(&bounding, &mut Outputs::new(lent.collect())) {
        UNBOUNDED.with_borrow_mut(|told| {
            let entry = (address(prepared), why);
            if !told.contains(&entry) {
                told.push(entry);
            }
        });
        targets.iter_mut().flatten().flatten().for_each(|plane| plane.fill(Bound::UNKNOWN.encode()));
    }
    Ok(())
}

/// The values of all connections, or their bounds.
fn half<'a>(ports: &Ports<'a>, second: bool) -> Ports<'a> {
    let mut half = ports.clone();
    for connection in half.iter_mut().flat_map(|(_, connections)| connections) {
        let bounds = connection.planes.split_off(connection.planes.len() / 2);
        if second {
            connection.planes = bounds;
        }
    }
    half
}
