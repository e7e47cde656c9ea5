//! Evaluation of a single picture.

use super::error::PictureError;
use super::lens::{Lens, OUTPUT};
use super::queue::Cancellation;
use super::request::{Job, Result};
use super::shown;
use std::sync::Arc;
use std::time::Instant;
#[cfg(test)]
use trochoid::Monitor;
use trochoid::{Buffers, Cache, EvalError, Format, Keep, Plan, Settings, Window};

/// Reason why there is no picture.
pub(super) enum Failure {
    /// A newer request made the picture obsolete.
    Cancelled,
    /// Reason.
    Because(PictureError),
}

impl<E: Into<PictureError>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Because(error.into())
    }
}

/// Evaluates a job through its lens with the resolution divided by `shrink`; `finished` says whether this is the
/// requested size rather than a coarse preview, and `keep` which planes are kept for the next one.
pub(super) fn evaluate(
    job: &Job,
    lens: &Arc<Lens>,
    shrink: u32,
    finished: bool,
    keep: Keep,
    cache: &mut Cache,
    monitor: &Cancellation<'_>,
) -> std::result::Result<Result, Failure> {
    let started = Instant::now();
    #[cfg(test)]
    monitor.queue.pace(|| monitor.cancelled());
    let graph = lens.drawn(shrink, finished)?;
    let graph = graph.as_ref();
    let format = graph.format();
    let mut settings = Settings::default();
    settings.region = job.region.map(|region| part(region, format));
    settings.keep = keep;
    let plan = Plan::new(graph, &[OUTPUT], job.frame, &[], &settings)?;
    let mut frame = match plan.evaluate(&Buffers::new(), cache, monitor) {
        Ok(frame) => frame,
        Err(EvalError::Cancelled) => return Err(Failure::Cancelled),
        Err(error) => return Err(lens.in_document(error, &job.subject).into()),
    };
    let picture = frame.pictures.pop().ok_or(PictureError::Nothing)?;
    let screen = shown::screen(&picture, graph.space(), &job.display);
    Ok(Result {
        generation: job.generation,
        frame: job.frame,
        shrunk: shrink,
        finished,
        subject: job.subject.clone(),
        lens: lens.clone(),
        format,
        window: settings.region.unwrap_or_else(|| format.window()),
        picture: Arc::new(picture),
        screen: Arc::new(screen),
        display: job.display.clone(),
        nodes: Arc::new(frame.nodes),
        seconds: (frame.seconds, started.elapsed().as_secs_f64()),
    })
}

/// Returns the pixels of a region, at least one.
pub(super) fn part(region: [f32; 4], format: Format) -> Window {
    let pixels = |share: f32, side: u32| (f64::from(share) * f64::from(side)).round() as i64;
    let window = format.window();
    let (x0, y0) = (pixels(region[0], format.width()), pixels(region[1], format.height()));
    let (x1, y1) = (pixels(region[2], format.width()), pixels(region[3], format.height()));
    let x0 = x0.clamp(window.x0, window.x1 - 1);
    let y0 = y0.clamp(window.y0, window.y1 - 1);
    Window { x0, y0, x1: x1.clamp(x0 + 1, window.x1), y1: y1.clamp(y0 + 1, window.y1) }
}
