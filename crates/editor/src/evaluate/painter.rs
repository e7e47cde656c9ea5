//! Painting of pictures from their recipes on a thread of its own, so that a color that is dragged never waits for an
//! evaluation. Newest request first.

use super::shown::{Display, Encoder, Screen};
use rayon::prelude::*;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use trochoid::{PackedRecipe, Window};

/// Share of its brightness that a pixel without the looked for color keeps.
const DIMMED: f32 = 0.12;

/// Request for a painted picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Painting {
    /// Generation number of the picture that it stands for.
    pub generation: u64,
    /// Recipe of the picture.
    pub recipe: SharedRecipe,
    /// A color for each name of the recipe, in the working space.
    pub colors: Vec<[f64; 3]>,
    /// Weights whose places stand out; all others are dimmed.
    pub spot: Option<Vec<bool>>,
    /// Display settings.
    pub display: Display,
}

/// A recipe, the same only as itself.
#[derive(Clone, Debug)]
pub struct SharedRecipe(pub Arc<PackedRecipe>);

impl PartialEq for SharedRecipe {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

#[derive(Default)]
struct Requests {
    next: Option<Painting>,
    closed: bool,
}

#[derive(Default)]
struct Queue {
    requests: Mutex<Requests>,
    wake_up: Condvar,
}

impl Queue {
    fn requests(&self) -> MutexGuard<'_, Requests> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Requests)) {
        change(&mut self.requests());
        self.wake_up.notify_one();
    }

    /// Waits for the newest request; `None` once the queue is closed.
    fn next(&self) -> Option<Painting> {
        let mut requests = self.requests();
        loop {
            if requests.closed {
                return None;
            }
            if let Some(next) = requests.next.take() {
                return Some(next);
            }
            requests = self.wake_up.wait(requests).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Handle to the painting thread, which ends when the handle is dropped.
pub struct Painter {
    queue: Arc<Queue>,
    news: Receiver<(Painting, Arc<Screen>)>,
    thread: Option<JoinHandle<()>>,
}

impl Painter {
    /// Starts the thread; `wake` is called whenever a picture is painted.
    ///
    /// # Errors
    /// Fails if the system cannot start a thread.
    pub fn new(wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let queue = Arc::new(Queue::default());
        let (sender, news) = channel();
        let theirs = queue.clone();
        let work = move || paint_all(&theirs, &sender, &wake);
        let thread = std::thread::Builder::new().name("paint".into()).spawn(work)?;
        Ok(Self { queue, news, thread: Some(thread) })
    }

    /// Requests a picture, replacing a request that was not started.
    pub fn paint(&self, painting: Painting) {
        self.queue.change(|requests| requests.next = Some(painting));
    }

    /// Returns the pictures painted since the last call.
    pub fn news(&self) -> impl Iterator<Item = (Painting, Arc<Screen>)> {
        self.news.try_iter()
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        self.queue.change(|requests| requests.closed = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn paint_all(queue: &Queue, news: &Sender<(Painting, Arc<Screen>)>, wake: &dyn Fn()) {
    let mut last: Option<(Painting, Arc<Screen>)> = None;
    while let Some(painting) = queue.next() {
        let screen = painted(&painting, last.take());
        last = Some((painting.clone(), screen.clone()));
        // Sending fails only while the window closes.
        let _ = news.send((painting, screen));
        wake();
    }
}

/// Paints a picture: only the tiles whose colors are others than those of the last one, if that can be.
fn painted(painting: &Painting, last: Option<(Painting, Arc<Screen>)>) -> Arc<Screen> {
    let recipe = &painting.recipe.0;
    let window = recipe.window();
    let last = last.filter(|(last, _)| {
        (&last.recipe, &last.spot, last.display) == (&painting.recipe, &painting.spot, painting.display)
    });
    let (changed, mut screen) = match last {
        Some((last, screen)) => {
            let changed = last.colors.iter().zip(&painting.colors).map(|(old, new)| old != new);
            (Some(changed.chain(recipe.info().has_images.then_some(false)).collect::<Vec<bool>>()), screen)
        }
        None => {
            let size = [window.width(), window.height()];
            (None, Arc::new(Screen { size, pixels: vec![255; 4 * window.area()] }))
        }
    };
    let encoder = Encoder::new(recipe.info().space, &painting.display);
    let pixels = &mut Arc::make_mut(&mut screen).pixels;
    let strips = pixels.par_chunks_mut(4 * window.width() * recipe.strip(0).height().max(1)).enumerate();
    strips.for_each(|(strip, rows)| paint_strip(painting, strip, changed.as_deref(), &encoder, rows));
    screen
}

fn paint_strip(painting: &Painting, strip: usize, changed: Option<&[bool]>, encoder: &Encoder, rows: &mut [u8]) {
    let recipe = &painting.recipe.0;
    let area = recipe.strip(strip);
    // Calls back with the bytes of each row of a tile.
    let each_row = |window: Window, rows: &mut [u8], put: &mut dyn FnMut(usize, &mut [u8])| {
        let [left, width] = [(window.x0 - area.x0) as usize, window.width()];
        for y in 0..window.height() {
            let start = 4 * (((window.y0 - area.y0) as usize + y) * area.width() + left);
            put(y * width, &mut rows[start..start + 4 * width]);
        }
    };
    let mut spot = Vec::new();
    if let Some(members) = &painting.spot {
        recipe.sum(strip, members, |_, sums| spot.push(sums.to_vec()));
    }
    recipe.paint(strip, &painting.colors, changed, |window, [r, g, b]| {
        let tile = (window.x0 - area.x0) as usize / recipe.tile_width();
        each_row(window, rows, &mut |start, bytes| {
            for (x, pixel) in bytes.chunks_exact_mut(4).enumerate() {
                let at = start + x;
                let mut color = encoder.pixel([r[at], g[at], b[at]]);
                if let Some(sums) = spot.get(tile) {
                    let light = DIMMED + (1.0 - DIMMED) * sums[at].clamp(0.0, 1.0);
                    color = color.map(|channel| (f32::from(channel) * light + 0.5) as u8);
                }
                pixel[..3].copy_from_slice(&color);
            }
        });
    });
}
