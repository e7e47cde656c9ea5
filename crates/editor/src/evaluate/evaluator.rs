//! The evaluation thread: its state, and how it performs its tasks.

use super::blame::{self, Question};
use super::error::PictureError;
use super::graphics::Graphics;
use super::known::Known;
use super::lane::Lane;
use super::lens::{Lens, LensError, of_every_node};
use super::mixture::{KnownRecipe, LIMIT, Mixture};
use super::picture::{Failure, evaluate, part};
use super::queue::{Cancellation, Progress, Queue, Task, Wanted, Yields};
use super::request::{Job, News, Thumbnail};
use super::shown::{self, Display};
use super::subject::Subject;
use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};
use trochoid::{Buffers, Cache, EvalError, Format, Keep, Kind, PackError, PackedRecipe, Plan, Settings};

/// Memory limit for all that is kept from picture to picture, in bytes: prepared stages, planes, frames for playback, and
/// the recipe.
const KEPT: usize = 3 << 28;
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

/// What a viewer looked at last.
#[derive(Default)]
struct Last {
    subject: Option<Subject>,
    /// Time and number of samples of its last picture, to predict the next one.
    time: Option<(Duration, u64)>,
    /// Whether it was finished since the cache forgot what is not used.
    is_done: bool,
}

/// State of the evaluation thread.
pub(super) struct Evaluator<'o> {
    queue: &'o Queue,
    news: &'o Sender<News>,
    wake: &'o (dyn Fn() + Send + Sync),
    cache: Cache,
    /// What each viewer looked at last.
    last: [Last; 2],
    known: &'o Known,
    graphics: Graphics,
}

impl<'o> Evaluator<'o> {
    pub(super) fn new(
        queue: &'o Queue,
        known: &'o Known,
        news: &'o Sender<News>,
        wake: &'o (dyn Fn() + Send + Sync),
        graphics: Graphics,
    ) -> Self {
        Self { queue, news, wake, cache: Cache::with_limit(KEPT), last: Default::default(), known, graphics }
    }

    fn tell(&self, news: News) {
        // Sending fails only while the window closes.
        let _ = self.news.send(news);
        (self.wake)();
    }

    /// Performs tasks until the queue is closed.
    pub(super) fn work(&mut self) {
        while let Some(task) = self.queue.next() {
            let lane = task.lane();
            let stamp = self.queue.stamp(lane);
            self.leave(self.known.bytes());
            let failure = failed(&task);
            let done = std::panic::catch_unwind(AssertUnwindSafe(|| self.perform(task, stamp)));
            self.queue.requests().making = None;
            if let Err(panic) = done {
                // What was half done is given up; the next task starts afresh.
                self.cache = Cache::with_limit(KEPT);
                self.last = Default::default();
                self.known.set_recipe(None);
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| text.to_string()));
                if let Some(news) = failure {
                    self.tell(news(text.unwrap_or_default()));
                }
            }
        }
    }

    fn perform(&mut self, task: Task, stamp: u64) {
        match task {
            // What is shown anew may already be on the graphics card; what was just evaluated is not.
            Task::Show(generation, picture, space, display) => {
                let screen = Arc::new(self.graphics.screen(&picture, space, &display));
                self.tell(News::Shown { generation, display, screen });
            }
            Task::Held(number, picture, space, display) => {
                let screen = Arc::new(self.graphics.screen(&picture, space, &display));
                self.tell(News::Held { number, display, screen });
            }
            Task::Picture(job) => self.picture(job, stamp),
            Task::Blame(question) => self.blame(question, stamp),
            Task::Mixture(job) => self.mixture(job, stamp),
            Task::Thumbnails(subject, frame) => self.small(&subject, frame, stamp),
            Task::Ahead(job) => self.ahead(job, stamp),
        }
    }

    /// Limits the cache to what frames for playback, and a recipe of some bytes, leave of all that is kept.
    fn leave(&mut self, recipe: usize) {
        self.cache.limit_to(KEPT.saturating_sub(self.queue.held() + recipe));
    }

    /// Answers of what a pixel is made.
    fn blame(&mut self, question: Question, stamp: u64) {
        let lane = Lane::of(question.generation);
        let Ok(lens) = self.lens(lane, &question.subject) else { return };
        let monitor = Cancellation { queue: self.queue, lane, stamp, yields: yields(lane), progress: None };
        match blame::answer(&question, &lens, &mut self.cache, &monitor) {
            Some(blamed) => self.tell(News::Blame(Box::new(blamed))),
            None => self.resume(lane, stamp, |wanted| _ = wanted.question.get_or_insert(question)),
        }
    }

    /// Requests a task of the second viewer again if the first one interrupted it, unless there is a newer request.
    fn resume(&self, lane: Lane, stamp: u64, again: impl FnOnce(&mut Wanted)) {
        let mut requests = self.queue.requests();
        if lane == Lane::Second && self.queue.stamp(lane) == stamp && requests.has_second {
            again(&mut requests.wanted[lane as usize]);
        }
    }

    /// Evaluates a frame ahead of playback.
    fn ahead(&mut self, job: Job, stamp: u64) {
        let (generation, frame) = (job.generation, job.frame);
        let lane = Lane::First;
        let monitor = Cancellation { queue: self.queue, lane, stamp, yields: Yields::First, progress: None };
        let made = match self.lens(lane, &job.subject) {
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
                if self.queue.stamp(Lane::First) == stamp {
                    // A more urgent task interrupted this job, which is still needed.
                    requests.ahead.push_front(job);
                }
            }
        }
    }

    /// Returns the graph that shows a subject.
    fn lens(&mut self, lane: Lane, subject: &Subject) -> Result<Arc<Lens>, LensError> {
        let seen = &mut self.last[lane as usize];
        if seen.subject.as_ref().is_some_and(|last| last.is(subject)) {
            return self.known.lens(subject);
        }
        let same_node = |known: &Subject| {
            (known.node, known.output) == (subject.node, subject.output)
                && known.sheet.prefix() == subject.sheet.prefix()
                && known.sheet.nodes.len() == subject.sheet.nodes.len()
        };
        if !seen.subject.as_ref().is_some_and(same_node) {
            seen.time = None;
        }
        seen.subject = Some(subject.clone());
        self.known.lens(subject)
    }

    /// Evaluates a picture, after coarse previews if it takes long.
    fn picture(&mut self, job: Job, stamp: u64) {
        let lane = Lane::of(job.generation);
        let lens = match self.lens(lane, &job.subject) {
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
        let expected = self.last[lane as usize]
            .time
            .map(|(time, pixels)| time.mul_f64(samples(job.proxy) as f64 / pixels.max(1) as f64));
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
                lane,
                stamp,
                yields: yields(lane),
                progress: if finished { Some(&told) } else { None },
            };
            let started = Instant::now();
            // What an edit does not touch is there at once.
            match evaluate(&job, &lens, shrink, finished, Keep::ForEdits, &mut self.cache, &monitor) {
                Ok(result) => {
                    if job.region.is_none() {
                        self.last[lane as usize].time = Some((started.elapsed(), samples(shrink)));
                    }
                    let whole = result.work().mul_f64(samples(job.proxy) as f64 / samples(shrink).max(1) as f64);
                    if shrink == COARSE && !finished && whole > LONG && BETWEEN > job.proxy {
                        sizes.push(BETWEEN);
                    }
                    self.tell(News::Picture(Box::new(result)));
                }
                Err(Failure::Cancelled) => {
                    return self.resume(lane, stamp, |wanted| _ = wanted.job.get_or_insert(job));
                }
                Err(Failure::Because(error)) => {
                    let (generation, why, refused) = (job.generation, Arc::new(error), lens.refused(job.frame));
                    return self.tell(News::Failed { generation, why, begun: true, refused });
                }
            }
        }
        self.forget(lane);
    }

    /// Lets the cache forget what no open viewer used for its last picture.
    fn forget(&mut self, lane: Lane) {
        self.last[lane as usize].is_done = true;
        let has_second = self.queue.requests().has_second;
        if self.last[0].is_done && (self.last[1].is_done || !has_second) {
            self.cache.forget_unused();
            self.last.iter_mut().for_each(|seen| seen.is_done = false);
        }
    }

    /// Evaluates the recipe of a picture.
    fn mixture(&mut self, job: Job, stamp: u64) {
        let generation = job.generation;
        let without = |why: &str| News::Unmixed { generation, why: why.into() };
        let lane = Lane::First;
        let Ok(lens) = self.lens(lane, &job.subject) else {
            return self.tell(without("There is no picture, so no color has a share of it."));
        };
        if lens.graph.outputs()[0].kind != Kind::Color {
            return self.tell(without("Only colors have a recipe: view a Color output."));
        }
        // The one before is needed no more, and both would not fit.
        self.known.set_recipe(None);
        self.leave(LIMIT);
        let tell = |share: f32| {
            let _ = self.news.send(News::Mixing { generation, share });
            (self.wake)();
        };
        let told = Progress::new(&tell);
        let monitor = Cancellation { queue: self.queue, lane, stamp, yields: Yields::Viewers, progress: Some(&told) };
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
                if self.queue.stamp(Lane::First) == stamp {
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
        let lane = Lane::First;
        let monitor = Cancellation { queue: self.queue, lane, stamp, yields: Yields::Always, progress: None };
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
            Err(EvalError::Cancelled) if self.queue.stamp(lane) == stamp => {
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

/// Returns what is told of a task that panics with a text, if somebody waits for it.
fn failed(task: &Task) -> Option<Box<dyn FnOnce(String) -> News>> {
    let why = PictureError::Panic;
    match task {
        Task::Picture(Job { generation, .. }) => {
            let generation = *generation;
            let news =
                move |text| News::Failed { generation, why: Arc::new(why(text)), begun: true, refused: Vec::new() };
            Some(Box::new(news))
        }
        Task::Ahead(Job { generation, frame, .. }) => {
            let (generation, frame) = (*generation, *frame);
            Some(Box::new(move |_| News::AheadFailed { generation, frame }))
        }
        Task::Mixture(Job { generation, .. }) => {
            let generation = *generation;
            Some(Box::new(move |text| News::Unmixed { generation, why: why(text).to_string() }))
        }
        _ => None,
    }
}

/// Returns the requests that interrupt the pictures of a viewer.
fn yields(lane: Lane) -> Yields {
    if lane == Lane::First { Yields::Never } else { Yields::First }
}
