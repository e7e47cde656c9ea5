//! Destinations of finished rows: planes in memory, or a sink that takes them band by band.

use crate::{EvalError, Sink};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid_image::{Plane, Window};

/// Rows of every channel of every output.
pub(crate) type Rows<'a> = Vec<Vec<&'a mut [f32]>>;

/// Hands out bands of full rows, from the top down.
pub(crate) struct Bands<'a> {
    windows: Vec<Window>,
    next: AtomicUsize,
    destination: Destination<'a>,
}

enum Destination<'a> {
    /// Each band's rows, until a worker takes them.
    Planes(Vec<Mutex<Option<Rows<'a>>>>),
    Sink {
        sink: &'a dyn Sink,
        /// Number of channels by output.
        channels: Vec<usize>,
        /// Buffers that no worker uses at the moment.
        spare: Mutex<Vec<Vec<Vec<Vec<f32>>>>>,
    },
}

impl<'a> Bands<'a> {
    /// Makes bands of planes, `height` rows each.
    pub(crate) fn of_planes(pictures: Vec<&'a mut Vec<Plane>>, window: Window, height: usize) -> Self {
        let width = window.width();
        let windows: Vec<Window> = window.tiles(width, height).collect();
        let mut bands: Vec<Rows<'a>> = windows.iter().map(|_| pictures.iter().map(|_| Vec::new()).collect()).collect();
        for (output, planes) in pictures.into_iter().enumerate() {
            for plane in planes {
                for (band, rows) in bands.iter_mut().zip(plane.samples_mut().chunks_mut(width * height)) {
                    band[output].push(rows);
                }
            }
        }
        let destination = Destination::Planes(bands.into_iter().map(|band| Mutex::new(Some(band))).collect());
        Self { windows, next: AtomicUsize::new(0), destination }
    }

    /// Makes bands for a sink, `height` rows each.
    pub(crate) fn of_sink(sink: &'a dyn Sink, channels: Vec<usize>, window: Window, height: usize) -> Self {
        let windows = window.tiles(window.width(), height).collect();
        let destination = Destination::Sink { sink, channels, spare: Mutex::new(Vec::new()) };
        Self { windows, next: AtomicUsize::new(0), destination }
    }

    pub(crate) fn count(&self) -> usize {
        self.windows.len()
    }

    /// Runs `work` over the next band and hands on its result; returns `false` if no band is left.
    pub(crate) fn work(
        &self,
        work: &mut dyn FnMut(Window, &mut Rows<'_>) -> Result<(), EvalError>,
    ) -> Result<bool, EvalError> {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        let Some(&window) = self.windows.get(index) else { return Ok(false) };
        match &self.destination {
            Destination::Planes(bands) => {
                let taken = bands[index].lock().unwrap_or_else(PoisonError::into_inner).take();
                if let Some(mut rows) = taken {
                    work(window, &mut rows)?;
                }
            }
            Destination::Sink { sink, channels, spare } => {
                let spare = || spare.lock().unwrap_or_else(PoisonError::into_inner);
                let found = spare().pop();
                let mut buffers =
                    found.unwrap_or_else(|| channels.iter().map(|&count| vec![Vec::new(); count]).collect());
                for buffer in buffers.iter_mut().flatten() {
                    buffer.resize(window.area(), 0.0);
                }
                let mut rows: Rows<'_> =
                    buffers.iter_mut().map(|planes| planes.iter_mut().map(Vec::as_mut_slice).collect()).collect();
                work(window, &mut rows)?;
                let done: Vec<Vec<&[f32]>> =
                    buffers.iter().map(|planes| planes.iter().map(Vec::as_slice).collect()).collect();
                sink.take(window, &done)?;
                spare().push(buffers);
            }
        }
        Ok(true)
    }
}
