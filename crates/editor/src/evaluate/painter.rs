//! Painting of pictures from their recipes on a thread of its own, so that a color that is dragged never waits for an
//! evaluation. Newest request first.

use super::graphics::Graphics;
use super::shown::{Display, Encoder, Screen};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;
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

/// A painted picture.
#[derive(Clone, Debug)]
pub struct Painted {
    /// The request.
    pub painting: Painting,
    /// The picture as it is displayed.
    pub screen: Arc<Screen>,
    /// Time at which it was ready.
    pub ready: Instant,
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
    news: Receiver<Painted>,
    thread: Option<JoinHandle<()>>,
}

impl Painter {
    /// Starts the thread; `wake` is called whenever a picture is painted.
    ///
    /// # Errors
    /// Fails if the system cannot start a thread.
    pub fn new(graphics: &Graphics, wake: impl Fn() + Send + 'static) -> std::io::Result<Self> {
        let queue = Arc::new(Queue::default());
        let (sender, news) = channel();
        let (theirs, graphics) = (queue.clone(), graphics.clone());
        let work = move || paint_all(&theirs, &graphics, &sender, &wake);
        let thread = std::thread::Builder::new().name("paint".into()).spawn(work)?;
        Ok(Self { queue, news, thread: Some(thread) })
    }

    /// Requests a picture, replacing a request that was not started.
    pub fn paint(&self, painting: Painting) {
        self.queue.change(|requests| requests.next = Some(painting));
    }

    /// Returns the pictures painted since the last call.
    pub fn news(&self) -> impl Iterator<Item = Painted> {
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

fn paint_all(queue: &Queue, graphics: &Graphics, news: &Sender<Painted>, wake: &dyn Fn()) {
    let mut canvas: Option<Canvas> = None;
    while let Some(painting) = queue.next() {
        let screen = match (graphics.paint(&painting), canvas.as_mut().filter(|canvas| canvas.takes(&painting))) {
            (Some(screen), _) => Arc::new(screen),
            (None, Some(canvas)) => {
                canvas.repaint(painting.clone());
                canvas.screen.clone()
            }
            (None, None) => canvas.insert(Canvas::new(painting.clone())).screen.clone(),
        };
        // Sending fails only while the window closes.
        let _ = news.send(Painted { painting, screen, ready: Instant::now() });
        wake();
    }
}

/// Most colors that differ from those of the kept picture before another one is kept.
const FEW: usize = 4;

/// A painted picture, in which single colors are changed.
pub(super) struct Canvas {
    painting: Painting,
    pub(super) screen: Arc<Screen>,
    /// The picture of some colors in the working space: red, green and blue.
    kept: [Vec<f32>; 3],
    of: Vec<[f64; 3]>,
}

impl Canvas {
    /// Paints the whole picture.
    pub(super) fn new(painting: Painting) -> Self {
        let recipe = painting.recipe.0.clone();
        let (window, of) = (recipe.window(), painting.colors.clone());
        let screen = Screen { size: [window.width(), window.height()], pixels: vec![255; 4 * window.area()] };
        let kept = [(); 3].map(|()| vec![0.0; window.area()]);
        let mut canvas = Self { painting, screen: Arc::new(screen), kept, of };
        let pixels = window.width() * recipe.strip(0).height().max(1);
        let [r, g, b] = &mut canvas.kept;
        let strips = r.par_chunks_mut(pixels).zip(g.par_chunks_mut(pixels)).zip(b.par_chunks_mut(pixels));
        strips.enumerate().for_each(|(strip, ((r, g), b))| {
            let area = recipe.strip(strip);
            recipe.paint(strip, &canvas.of, |tile, color| {
                for (kept, color) in [&mut *r, &mut *g, &mut *b].into_iter().zip(color) {
                    rows(area, tile).zip(color.chunks_exact(tile.width())).for_each(|(own, row)| {
                        kept[own].copy_from_slice(row);
                    });
                }
            });
        });
        canvas.show(None);
        canvas
    }

    /// Returns whether little has to be painted for a request.
    fn takes(&self, next: &Painting) -> bool {
        let own = &self.painting;
        let changed = self.of.iter().zip(&next.colors).filter(|(old, new)| old != new).count();
        (&own.recipe, &own.spot, &own.display) == (&next.recipe, &next.spot, &next.display) && changed <= FEW
    }

    /// Paints what differs.
    fn repaint(&mut self, next: Painting) {
        let last = std::mem::replace(&mut self.painting, next);
        let colors = self.of.iter().zip(&last.colors).zip(&self.painting.colors);
        // What was changed before is put back.
        let change = |((own, last), next): ((&[f64; 3], &[f64; 3]), &[f64; 3])| {
            (own != last || own != next).then(|| [0, 1, 2].map(|channel| next[channel] - own[channel]))
        };
        let images = self.painting.recipe.0.info().has_images.then_some(None);
        let changes: Vec<Option<[f64; 3]>> = colors.map(change).chain(images).collect();
        self.show(Some(&changes));
    }

    /// Converts the kept picture for the screen: all of it, or with changes of some colors the tiles that have them.
    fn show(&mut self, changes: Option<&[Option<[f64; 3]>]>) {
        let Self { painting, screen, kept, .. } = self;
        let recipe = &*painting.recipe.0;
        let window = recipe.window();
        let encoder = Encoder::new(recipe.info().space, &painting.display);
        let pixels = window.width() * recipe.strip(0).height().max(1);
        let bytes = &mut Arc::make_mut(screen).pixels;
        bytes.par_chunks_mut(4 * pixels).enumerate().for_each(|(strip, bytes)| {
            let area = recipe.strip(strip);
            let start = strip * pixels;
            let kept = kept.each_ref().map(|channel| &channel[start..start + area.area()]);
            let mut spot = Vec::new();
            if let Some(members) = &painting.spot {
                recipe.sum(strip, members, |_, sums| spot.push(sums.to_vec()));
            }
            let mut mixed = [(); 3].map(|()| vec![0.0; recipe.tile_width()]);
            let mut put = |tile: Window, changes: Option<[&[f32]; 3]>| {
                let weights = spot.get((tile.x0 - area.x0) as usize / recipe.tile_width());
                for (y, own) in rows(area, tile).enumerate() {
                    let within = y * tile.width()..(y + 1) * tile.width();
                    let bytes = &mut bytes[4 * own.start..4 * own.end];
                    let kept = kept.map(|channel| &channel[own.clone()]);
                    match changes {
                        Some(changes) => {
                            for ((sum, kept), change) in mixed.iter_mut().zip(kept).zip(changes) {
                                let change = &change[within.clone()];
                                sum.iter_mut().zip(kept).zip(change).for_each(|((sum, kept), by)| *sum = kept + by);
                            }
                            encoder.row(mixed.each_ref().map(|channel| &channel[..tile.width()]), bytes);
                        }
                        None => encoder.row(kept, bytes),
                    }
                    if let Some(weights) = weights {
                        dim(bytes, &weights[within]);
                    }
                }
            };
            match changes {
                Some(changes) => recipe.shift(strip, changes, |tile, sums| put(tile, Some(sums))),
                None => area.tiles(recipe.tile_width(), area.height()).for_each(|tile| put(tile, None)),
            }
        });
    }
}

/// Returns the pixels of each row of a tile within its strip.
fn rows(area: Window, tile: Window) -> impl Iterator<Item = Range<usize>> {
    let (left, width) = ((tile.x0 - area.x0) as usize, tile.width());
    (0..tile.height()).map(move |y| y * area.width() + left..y * area.width() + left + width)
}

/// Dims pixels that have little weight.
fn dim(bytes: &mut [u8], weights: &[f32]) {
    for (pixel, weight) in bytes.chunks_exact_mut(4).zip(weights) {
        let light = DIMMED + (1.0 - DIMMED) * weight.clamp(0.0, 1.0);
        pixel[..3].iter_mut().for_each(|byte| *byte = (f32::from(*byte) * light + 0.5) as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::{Cache, Silent, parse};

    /// The recipe of a picture that is no multiple of tiles in size.
    fn recipe() -> SharedRecipe {
        let text = r##"{
          "trochoid": 1, "format": { "width": 150, "height": 21 }, "working_space": "srgb",
          "palette": { "a": "#101a33", "b": "#f2ead2", "c": "#d8513a", "d": "#208040", "e": "#808080", "f": "#c0ffee" },
          "nodes": {
            "across": { "type": "ScreenX" }, "down": { "type": "ScreenY" },
            "right": { "type": "Clamp", "field": "across", "min": 0.6, "max": 0.9 },
            "ab": { "type": "Mix", "a": "palette.a", "b": "palette.b", "weight": "down" },
            "cd": { "type": "Mix", "a": "palette.c", "b": "palette.d", "weight": "down" },
            "abcd": { "type": "Mix", "a": "ab", "b": "cd", "weight": "right" },
            "ef": { "type": "Mix", "a": "palette.e", "b": "palette.f", "weight": "across" },
            "all": { "type": "Mix", "a": "abcd", "b": "ef", "weight": 0.25 }
          },
          "outputs": { "beauty": { "color": "all" } }
        }"##;
        let graph = parse("a.json", text, std::path::Path::new("."), &[]).unwrap().graph;
        let made = PackedRecipe::evaluate(&graph, 0, 1, None, 1 << 24, &mut Cache::new(), &Silent);
        SharedRecipe(Arc::new(made.unwrap()))
    }

    #[test]
    fn what_is_repainted_is_what_would_be_painted_anew() {
        let recipe = recipe();
        let own = recipe.0.info().colors.clone();
        for spot in [None, Some(vec![false, true, false, true, false, false])] {
            let painting = |colors: Vec<[f64; 3]>| {
                let (recipe, spot) = (recipe.clone(), spot.clone());
                Painting { generation: 1, recipe, colors, spot, display: Display::default() }
            };
            let mut canvas = Canvas::new(painting(own.clone()));
            let mut colors = own.clone();
            let mut few = 0;
            for step in 0..40_usize {
                // One color after another is changed, and put back after a while.
                colors[step % 6] = if step % 4 == 3 { own[step % 6] } else { [0.02 * step as f64, 0.5, 0.7] };
                let next = painting(colors.clone());
                match canvas.takes(&next) {
                    true => {
                        few += 1;
                        canvas.repaint(next.clone());
                    }
                    false => canvas = Canvas::new(next.clone()),
                }
                let anew = Canvas::new(next);
                let pixels = canvas.screen.pixels.iter().zip(&anew.screen.pixels);
                let off = pixels.map(|(a, b)| a.abs_diff(*b)).max();
                assert!(off <= Some(1), "step {step}: {off:?}");
            }
            assert!(few > 20, "{few} of 40 pictures were repainted in parts");
        }
    }
}
