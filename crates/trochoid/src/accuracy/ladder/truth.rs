//! Pixels evaluated by the f64 references.

use super::request::LadderRequest;
use crate::accuracy::TargetError;
use std::collections::BTreeSet;
use trochoid_engine::{Cache, EvalError, Monitor, ReferenceError, ReferenceFrame};
use trochoid_graph::CheckedGraph;
use trochoid_image::Window;

/// Pixels and their reference values.
pub(super) struct Truth {
    pub(super) pixels: Vec<[i64; 2]>,
    pub(super) values: Vec<Vec<f64>>,
}

impl Truth {
    pub(super) fn new(
        graph: &CheckedGraph,
        asked: &LadderRequest<'_>,
        regions: &[Window],
        monitor: &dyn Monitor,
    ) -> Result<Self, TargetError> {
        let request = &asked.request;
        let pixels = chosen(regions, asked.pixels);
        let name = request.outputs[0];
        let mut cache = Cache::new();
        let reference =
            ReferenceFrame::prepared(graph, &[name], request.frame, &mut cache, monitor).map_err(of_reference)?;
        let mut values = Vec::with_capacity(pixels.len());
        for (index, [x, y]) in pixels.iter().enumerate() {
            if monitor.cancelled() {
                return Err(EvalError::Cancelled.into());
            }
            values.push(reference.pixel(*x, *y)?);
            monitor.progress(index + 1, pixels.len());
        }
        Ok(Self { pixels, values })
    }
}

fn of_reference(error: ReferenceError) -> TargetError {
    match error {
        ReferenceError::Plan(error) => error.into(),
        ReferenceError::Eval(error) => error.into(),
    }
}

/// Chooses this many distinct pixels of some windows, spread evenly by multiples of the golden ratio.
pub(super) fn chosen(regions: &[Window], count: usize) -> Vec<[i64; 2]> {
    let total: usize = regions.iter().map(|region| region.area()).sum();
    let mut places: BTreeSet<usize> = BTreeSet::new();
    let mut step = 0_u64;
    while places.len() < count.min(total) {
        step += 1;
        // Weyl sequence: fractions of multiples of the golden ratio.
        let part = (step.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as f64 / 4_294_967_296.0;
        places.insert(((part * total as f64) as usize).min(total - 1));
    }
    let pixel = |mut place: usize| {
        for region in regions {
            if place < region.area() {
                let (x, y) = (place % region.width(), place / region.width());
                return [region.x0 + x as i64, region.y0 + y as i64];
            }
            place -= region.area();
        }
        unreachable!("places lie within the windows")
    };
    places.into_iter().map(pixel).collect()
}
