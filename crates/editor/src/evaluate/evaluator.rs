//! The evaluation thread: its state, and how it performs its tasks.

use super::blame;
use super::known::Known;
use super::lens::{Lens, LensError, of_every_node};
use super::mixture::{KnownRecipe, LIMIT, Mixture};
use super::picture::{Failure, evaluate, part};
use super::queue::{Cancellation, Progress, Queue, Task, Yields};
use super::request::{Job, News, Thumbnail};
use super::shown::{self, Display};
use super::subject::Subject;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};
use trochoid::{Buffers, Cache, EvalError, Format, Keep, Kind, PackError, PackedRecipe, Plan, Settings};

/// Memory limit for prepared stages and for planes that are kept from picture to picture, in bytes.
const CACHE: usize = 5 << 28;
/// Pictures expected to take no longer than this are evaluated without a coarse preview.
const AT_ONCE: Duration = Duration::from_millis(90);
/// Factor by which the first, coarse picture is smaller.
const COARSE: u32 = 8;
/// Factor by which the picture between the coarse one and the whole one is smaller.
const BETWEEN: u32 = 3;
/// Whole pictures expected to take longer than this have one before them.
const LONG: Duration = Duration::from_millis(900);
/// Maximum width and height of thumbnails.
const THUMBNAIL: [u32; 2] = [128, 80];

/// State of the evaluation thread.
pub(super) struct Evaluator<'o> {
    queue: &'o Queue,
    news: &'o Sender<News>,
    wake: &'o (dyn Fn() + Send + Sync),
    cache: Cache,
    /// Time and number of samples of the last picture of the viewed result, to predict the next one.
    last: Option<(Duration, u64)>,
    /// The last subject.
    subject: Option<Subject>,
    known: &'o Known,
}

impl<'o> Evaluator<'o> {
    pub(super) fn new(
        queue: &'o Queue,
        known: &'o Known,
        news: &'o Sender<News>,
        wake: &'o (dyn Fn() + Send + Sync),
    ) -> Self {
        Self { queue, news, wake, cache: Cache::with_limit(CACHE), last: None, subject: None, known }
    }

    fn tell(&self, news: News) {
        // Sending fails only while the window closes.
        let _ = self.news.send(news);
        (self.wake)();
    }

    /// Performs tasks until the queue is closed.
    pub(super) fn work(&mut self) {
        while let Some(task) = self.queue.next() {
            let stamp = self.queue.stamp();
            match task {
                Task::Show(generation, picture, space, display) => {
                    let screen = Arc::new(shown::screen(&picture, space, &display));
                    self.tell(News::Shown { generation, display, screen });
                }
                Task::Held(number, picture, space, display) => {
                    let screen = Arc::new(shown::screen(&picture, space, &display));
                    self.tell(News::Held { number, display, screen });
                }
                Task::Picture(job) => self.picture(&job, stamp),
                Task::Blame(question) => {
                    let Ok(lens) = self.lens(&question.subject) else { continue };
                    let monitor = Cancellation { queue: self.queue, stamp, yields: Yields::Never, progress: None };
                    if let Some(blamed) = blame::answer(&question, &lens, &mut self.cache, &monitor) {
                        self.tell(News::Blame(Box::new(blamed)));
                    }
                }
                Task::Mixture(job) => self.mixture(job, stamp),
                Task::Thumbnails(subject, frame) => self.small(&subject, frame, stamp),
                Task::Ahead(job) => {
                    self.ahead(job, stamp);
                    self.queue.requests().making = None;
                }
            }
        }
    }

    /// Evaluates a frame ahead of playback.
    fn ahead(&mut self, job: Job, stamp: u64) {
        let (generation, frame) = (job.generation, job.frame);
        let monitor = Cancellation { queue: self.queue, stamp, yields: Yields::Short, progress: None };
        let made = match self.lens(&job.subject) {
            Ok(lens) => evaluate(&job, &lens, job.proxy, true, Keep::ForFrames, &mut self.cache, &monitor),
            Err(error) => Err(error.into()),
        };
        match made {
            Ok(result) => {
                self.cache.forget_unused();
                self.tell(News::Ahead(Box::new(result)));
            }
            Err(Failure::Because(..)) => self.tell(News::AheadFailed { generation, frame }),
            Err(Failure::Cancelled) => {
                let mut requests = self.queue.requests();
                if self.queue.stamp() == stamp {
                    // A more urgent task interrupted this job, which is still needed.
                    requests.ahead.push_front(job);
                }
            }
        }
    }

    /// Returns the graph that shows a subject.
    fn lens(&mut self, subject: &Subject) -> Result<Arc<Lens>, LensError> {
        if self.subject.as_ref().is_some_and(|last| last.is(subject)) {
            return self.known.lens(subject);
        }
        let same_node = |known: &Subject| {
            (known.node, known.output) == (subject.node, subject.output)
                && known.sheet.prefix() == subject.sheet.prefix()
                && known.sheet.nodes.len() == subject.sheet.nodes.len()
        };
        if !self.subject.as_ref().is_some_and(same_node) {
            self.last = None;
        }
        self.subject = Some(subject.clone());
        self.known.lens(subject)
    }

    /// Evaluates a picture, after coarse previews if it takes long.
    fn picture(&mut self, job: &Job, stamp: u64) {
        let lens = match self.lens(&job.subject) {
            Ok(lens) => lens,
            Err(error) => {
                let (generation, why) = (job.generation, Arc::new(error.into()));
                return self.tell(News::Failed { generation, why, begun: false, refused: Vec::new() });
            }
        };
        let format = lens.graph.format();
        let samples = |shrink: u32| {
            u64::from(format.width() / shrink) * u64::from(format.height() / shrink) * u64::from(format.samples())
        };
        let expected = self.last.map(|(time, pixels)| time.mul_f64(samples(job.proxy) as f64 / pixels.max(1) as f64));
        // A coarse picture comes first, and if that tells of long work, one in between.
        let is_long = job.progressive && expected.is_none_or(|time| time > AT_ONCE);
        let mut sizes = vec![job.proxy];
        if is_long && COARSE > job.proxy {
            sizes.push(COARSE);
        }
        while let Some(shrink) = sizes.pop() {
            let tell = |share: f32| {
                let _ = self.news.send(News::Progress { generation: job.generation, share });
                (self.wake)();
            };
            let finished = shrink == job.proxy;
            let told = Progress::new(&tell);
            let monitor = Cancellation {
                queue: self.queue,
                stamp,
                yields: Yields::Never,
                progress: if finished { Some(&told) } else { None },
            };
            let started = Instant::now();
            // What an edit does not touch is there at once.
            match evaluate(job, &lens, shrink, finished, Keep::ForEdits, &mut self.cache, &monitor) {
                Ok(result) => {
                    if job.region.is_none() {
                        self.last = Some((started.elapsed(), samples(shrink)));
                    }
                    let whole = result.work().mul_f64(samples(job.proxy) as f64 / samples(shrink).max(1) as f64);
                    if shrink == COARSE && !finished && whole > LONG && BETWEEN > job.proxy {
                        sizes.push(BETWEEN);
                    }
                    self.tell(News::Picture(Box::new(result)));
                }
                Err(Failure::Cancelled) => return,
                Err(Failure::Because(error)) => {
                    let (generation, why, refused) = (job.generation, Arc::new(error), lens.refused(job.frame));
                    return self.tell(News::Failed { generation, why, begun: true, refused });
                }
            }
        }
        self.cache.forget_unused();
    }

    /// Evaluates the recipe of a picture.
    fn mixture(&mut self, job: Job, stamp: u64) {
        let generation = job.generation;
        let without = |why: &str| News::Unmixed { generation, why: why.into() };
        let Ok(lens) = self.lens(&job.subject) else {
            return self.tell(without("There is no picture, so no color has a share of it."));
        };
        if lens.graph.outputs()[0].kind != Kind::Color {
            return self.tell(without("Only colors have a recipe: view a Color output."));
        }
        // The one before is needed no more, and both would not fit.
        self.known.set_recipe(None);
        let tell = |share: f32| {
            let _ = self.news.send(News::Mixing { generation, share });
            (self.wake)();
        };
        let told = Progress::new(&tell);
        let monitor = Cancellation { queue: self.queue, stamp, yields: Yields::Short, progress: Some(&told) };
        let region = |format| job.region.map(|region| part(region, format));
        let made = match lens.drawn(job.proxy, true) {
            Ok(graph) => {
                let region = region(graph.format());
                PackedRecipe::evaluate(&graph, 0, job.frame, region, LIMIT, &mut self.cache, &monitor)
            }
            Err(_) => return self.tell(without("There is no picture, so no color has a share of it.")),
        };
        match made {
            Ok(recipe) => {
                let (recipe, place) = (Arc::new(recipe), (job.frame, job.proxy, job.region));
                self.known.set_recipe(Some(KnownRecipe::new(&job.subject, &lens, &place, recipe.clone())));
                let (names, colors) = (recipe.info().names.clone(), recipe.info().colors.clone());
                self.tell(News::Mixture(Box::new(Mixture { generation, recipe, names, colors })));
            }
            Err(PackError::Evaluate(EvalError::Cancelled)) => {
                let mut requests = self.queue.requests();
                if self.queue.stamp() == stamp {
                    // A more urgent task interrupted; prepared stages stay in the cache.
                    requests.mixture.get_or_insert(job);
                }
            }
            Err(error) => self.tell(News::Unmixed { generation, why: error.to_string() }),
        }
    }

    /// Evaluates thumbnails of all nodes.
    fn small(&mut self, subject: &Subject, frame: i64, stamp: u64) {
        let Some((graph, names)) = of_every_node(subject) else { return };
        let monitor = Cancellation { queue: self.queue, stamp, yields: Yields::Always, progress: None };
        let format = graph.format();
        let shrink = (format.width() as f32 / THUMBNAIL[0] as f32).max(format.height() as f32 / THUMBNAIL[1] as f32);
        let side = |side: u32| ((side as f32 / shrink.max(1.0)).round() as u32).max(1);
        let Ok(format) = Format::new(side(format.width()), side(format.height()), 1) else { return };
        let graph = graph.with_scaled_format(format);
        let mut settings = Settings::default();
        settings.keep = Keep::ForEdits;
        let Ok(plan) = Plan::new(&graph, &[], frame, &[], &settings) else { return };
        let evaluated = match plan.evaluate(&Buffers::new(), &mut self.cache, &monitor) {
            Ok(evaluated) => evaluated,
            Err(EvalError::Cancelled) if self.queue.stamp() == stamp => {
                // A more urgent task interrupted; prepared stages stay in the cache.
                self.queue.requests().thumbnails.get_or_insert((subject.clone(), frame));
                return;
            }
            Err(_) => return,
        };
        let pictures = evaluated.pictures.iter().map(|picture| Thumbnail {
            node: names[picture.output].clone(),
            screen: shown::screen(picture, graph.space(), &Display::default()),
        });
        self.tell(News::Thumbnails(pictures.collect()));
    }
}
