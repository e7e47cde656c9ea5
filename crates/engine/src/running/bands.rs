//! Destinations of finished rows: planes in memory, or a sink that takes them band by band.

use crate::{EvalError, Sink};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use trochoid_image::{Plane, Window};
use trochoid_memory::Scratch;

/// Rows of every channel of every output.
pub(crate) type Rows<'a> = Scratch<Scratch<&'a mut [f32]>>;

/// The same in memory of its own.
pub(crate) type OwnRows = Vec<Vec<Vec<f32>>>;

/// Hands out the tiles of bands of full rows, from the top down. Threads share the tiles of a band.
pub(crate) struct Bands<'a> {
    windows: Vec<Window>,
    /// Largest width of a tile, and number of tiles in a band.
    width: usize,
    columns: usize,
    /// Index of the next tile.
    next: AtomicUsize,
    /// Number of channels by output.
    channels: Vec<usize>,
    destination: Destination<'a>,
}

enum Destination<'a> {
    /// Each band's rows.
    Planes(Vec<Mutex<Rows<'a>>>),
    Sink {
        sink: &'a dyn Sink,
        /// By band: rows of which some tiles are done, and some are not.
        open: Vec<Mutex<Option<Open>>>,
        /// Buffers that no band uses at the moment.
        spare: Mutex<Vec<OwnRows>>,
    },
}

struct Open {
    rows: OwnRows,
    /// Number of tiles that are not done.
    left: usize,
}

impl<'a> Bands<'a> {
    /// Makes bands of planes, in tiles of a width and a height.
    pub(crate) fn of_planes(
        pictures: Vec<&'a mut Vec<Plane>>,
        window: Window,
        (width, height): (usize, usize),
    ) -> Self {
        let windows: Vec<Window> = window.tiles(window.width(), height).collect();
        let channels = pictures.iter().map(|planes| planes.len()).collect();
        let mut bands: Vec<Rows<'a>> =
            windows.iter().map(|_| pictures.iter().map(|_| Scratch::new()).collect()).collect();
        for (output, planes) in pictures.into_iter().enumerate() {
            for plane in planes {
                for (band, rows) in bands.iter_mut().zip(plane.samples_mut().chunks_mut(window.width() * height)) {
                    band[output].push(rows);
                }
            }
        }
        let destination = Destination::Planes(bands.into_iter().map(Mutex::new).collect());
        Self::new(windows, window.width().div_ceil(width), width, channels, destination)
    }

    /// Makes bands for a sink, in tiles of a width and a height.
    pub(crate) fn of_sink(
        sink: &'a dyn Sink,
        channels: Vec<usize>,
        window: Window,
        (width, height): (usize, usize),
    ) -> Self {
        let windows: Vec<Window> = window.tiles(window.width(), height).collect();
        let open = windows.iter().map(|_| Mutex::new(None)).collect();
        let destination = Destination::Sink { sink, open, spare: Mutex::new(Vec::new()) };
        Self::new(windows, window.width().div_ceil(width), width, channels, destination)
    }

    fn new(
        windows: Vec<Window>,
        columns: usize,
        width: usize,
        channels: Vec<usize>,
        destination: Destination<'a>,
    ) -> Self {
        Self { windows, width, columns, next: AtomicUsize::new(0), channels, destination }
    }

    /// Returns the number of tiles.
    pub(crate) fn tiles(&self) -> usize {
        self.windows.len() * self.columns
    }

    /// Runs `work` over the next tile, which gets the window of the rows that it writes into, and hands on its result;
    /// returns `false` if no tile is left. `own` is memory of the thread.
    pub(crate) fn work(
        &self,
        own: &mut OwnRows,
        work: &mut dyn FnMut(Window, &mut Rows<'_>) -> Result<(), EvalError>,
    ) -> Result<bool, EvalError> {
        let index = self.next.fetch_add(1, Ordering::Relaxed);
        let (band, column) = (index / self.columns.max(1), index % self.columns.max(1));
        let Some(&window) = self.windows.get(band) else { return Ok(false) };
        if self.columns > 1 {
            let x0 = window.x0 + (column * self.width) as i64;
            let tile = Window { x0, x1: window.x1.min(x0 + self.width as i64), ..window };
            self.resize(own, tile);
            work(tile, &mut rows_of(own))?;
            self.put(band, tile, own)?;
            return Ok(true);
        }
        match &self.destination {
            Destination::Planes(bands) => work(window, &mut locked(&bands[band]))?,
            Destination::Sink { sink, spare, .. } => {
                let mut rows = locked(spare).pop().unwrap_or_default();
                self.resize(&mut rows, window);
                work(window, &mut rows_of(&mut rows))?;
                sink.take(window, &slices_of(&rows))?;
                locked(spare).push(rows);
            }
        }
        Ok(true)
    }

    /// Puts a tile among the rows of its band, and hands the band on with its last tile.
    fn put(&self, band: usize, tile: Window, own: &OwnRows) -> Result<(), EvalError> {
        let window = self.windows[band];
        match &self.destination {
            Destination::Planes(bands) => copy(own, tile, &mut locked(&bands[band]), window),
            Destination::Sink { sink, open, spare } => {
                let mut slot = locked(&open[band]);
                let opened = slot.get_or_insert_with(|| {
                    let mut rows = locked(spare).pop().unwrap_or_default();
                    self.resize(&mut rows, window);
                    Open { rows, left: self.columns }
                });
                copy(own, tile, &mut rows_of(&mut opened.rows), window);
                opened.left -= 1;
                if opened.left == 0
                    && let Some(done) = slot.take()
                {
                    drop(slot);
                    sink.take(window, &slices_of(&done.rows))?;
                    locked(spare).push(done.rows);
                }
            }
        }
        Ok(())
    }

    /// Makes rows as large as a window.
    fn resize(&self, rows: &mut OwnRows, window: Window) {
        rows.resize_with(self.channels.len(), Vec::new);
        for (channels, count) in rows.iter_mut().zip(&self.channels) {
            channels.resize_with(*count, Vec::new);
            channels.iter_mut().for_each(|rows| rows.resize(window.area(), 0.0));
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn rows_of(rows: &mut OwnRows) -> Rows<'_> {
    rows.iter_mut().map(|channels| channels.iter_mut().map(Vec::as_mut_slice).collect()).collect()
}

fn slices_of(rows: &OwnRows) -> Vec<Vec<&[f32]>> {
    rows.iter().map(|channels| channels.iter().map(Vec::as_slice).collect()).collect()
}

/// Copies the rows of a tile to those of its band.
fn copy(from: &OwnRows, tile: Window, to: &mut Rows<'_>, band: Window) {
    let (width, stride, x) = (tile.width(), band.width(), (tile.x0 - band.x0) as usize);
    for (from, to) in from.iter().flatten().zip(to.iter_mut().flatten()) {
        for (from, to) in from.chunks_exact(width).zip(to.chunks_exact_mut(stride)) {
            to[x..x + width].copy_from_slice(from);
        }
    }
}
