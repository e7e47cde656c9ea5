//! Strips of a picture that represent the whole picture.

use super::error::TargetError;
use trochoid_engine::{Buffers, Cache, Monitor, Plan, Settings};
use trochoid_graph::CheckedGraph;
use trochoid_image::Window;

/// Width of each strip as a fraction of the picture's width, and positions of the strips. They are upright, so that
/// each has sky and water.
const SHARE: i64 = 24;
const PLACES: [i64; 3] = [4, 11, 18];

/// Returns upright strips that cover an eighth of the picture in total.
pub(super) fn strips(window: Window) -> [Window; 3] {
    let width = window.width() as i64;
    PLACES.map(|place| {
        let start = window.x0 + place * width / SHARE;
        let end = (window.x0 + (place + 1) * width / SHARE).max(start + 1).min(window.x1);
        Window::new(start.min(end - 1), window.y0, end, window.y1)
    })
}

/// Predicts the seconds for evaluating outputs at a frame: prepares everything, and extrapolates from strips of the
/// picture.
///
/// # Errors
/// The outputs cannot be planned or evaluated.
pub fn predict(
    graph: &CheckedGraph,
    outputs: &[&str],
    frame: i64,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<f64, TargetError> {
    let whole = graph.format().window();
    let mut cache = Cache::new();
    let (mut prepared, mut tiles, mut area) = (0.0, 0.0, 0);
    for (index, strip) in strips(whole).into_iter().enumerate() {
        let mut settings = settings.clone();
        settings.region = Some(strip);
        let plan = Plan::new(graph, outputs, frame, &[], &settings)?;
        let seconds = plan.evaluate(&Buffers::new(), &mut cache, monitor)?.seconds;
        if index == 0 {
            prepared = seconds.prepare + seconds.hull;
        }
        tiles += seconds.tiles;
        area += strip.area();
    }
    Ok(prepared + tiles * whole.area() as f64 / area as f64)
}
