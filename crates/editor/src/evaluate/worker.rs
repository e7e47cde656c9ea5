//! The thread that evaluates.

use super::blame::{self, Question};
use super::lens::{Lens, OUTPUT, lens, of_every_node};
use super::shown::{self, Display};
use super::wish::{Job, News, Result, Subject, Thumbnail};
use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use trochoid::{
    Buffers, Cache, CheckedGraph, EvalError, Format, Monitor, Picture, Plan, Settings, Window, WorkingSpace,
};

/// What is to be done, the more urgent first.
#[derive(Default)]
struct Desk {
    job: Option<Job>,
    shown: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    held: Option<(u64, Arc<Picture>, WorkingSpace, Display)>,
    question: Option<Question>,
    thumbnails: Option<(Subject, i64)>,
    ahead: VecDeque<Job>,
    /// The frame that is being made ahead, and whose it is.
    making: Option<(u64, i64)>,
    closed: bool,
}

impl Desk {
    fn is_empty(&self) -> bool {
        self.job.is_none()
            && self.shown.is_none()
            && self.held.is_none()
            && self.question.is_none()
            && self.thumbnails.is_none()
            && self.ahead.is_empty()
    }
}

struct Office {
    desk: Mutex<Desk>,
    bell: Condvar,
    /// Grows with everything that makes what is being done out of date.
    newest: AtomicU64,
    /// Milliseconds that each picture takes besides, for tests.
    #[cfg(test)]
    pace: AtomicU64,
}

impl Office {
    #[cfg(test)]
    fn pace(&self, cancelled: impl Fn() -> bool) {
        let pace = Duration::from_millis(self.pace.load(Ordering::Relaxed));
        let started = Instant::now();
        while started.elapsed() < pace && !cancelled() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A handle to the thread, which ends with it.
pub struct Worker {
    office: Arc<Office>,
    news: Receiver<News>,
    thread: Option<std::thread::JoinHandle<()>>,
}

/// Memory for what stages have prepared, bytes.
const CACHE: usize = 3 << 30;
/// Pictures that take no longer need no coarse one before them.
const AT_ONCE: Duration = Duration::from_millis(90);
/// Width and height of thumbnails, at most.
pub(super) const THUMBNAIL: [u32; 2] = [128, 80];

impl Worker {
    /// Starts the thread; `wake` is called whenever there are news.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let office = Arc::new(Office {
            desk: Mutex::default(),
            bell: Condvar::new(),
            newest: AtomicU64::new(0),
            #[cfg(test)]
            pace: AtomicU64::new(0),
        });
        let (sender, news) = channel();
        let theirs = office.clone();
        let thread = std::thread::Builder::new().name("evaluate".into()).spawn(move || {
            let mut hand = Hand {
                office: &theirs,
                news: &sender,
                wake: &wake,
                cache: Cache::with_limit(CACHE),
                last: None,
                lens: None,
            };
            hand.work();
        })?;
        Ok(Self { office, news, thread: Some(thread) })
    }

    /// Lets each picture take so long besides.
    #[cfg(test)]
    pub(crate) fn slow_down(&self, by: Duration) {
        self.office.pace.store(by.as_millis() as u64, Ordering::Relaxed);
    }

    fn change(&self, cancels: bool, change: impl FnOnce(&mut Desk)) {
        change(&mut self.office.desk());
        if cancels {
            self.office.newest.fetch_add(1, Ordering::Relaxed);
        }
        self.office.bell.notify_one();
    }

    /// Asks for a picture, in place of all that was asked for before.
    pub fn evaluate(&self, job: Job) {
        self.change(true, |desk| {
            desk.shown = None;
            desk.question = None;
            desk.ahead.clear();
            desk.job = Some(job);
        });
    }

    /// Asks for pictures of further frames in their order, in place of those that were asked for and are not begun.
    pub fn ahead(&self, jobs: impl IntoIterator<Item = Job>) {
        self.change(false, |desk| {
            let making = desk.making;
            desk.ahead = jobs.into_iter().filter(|job| making != Some((job.generation, job.frame))).collect();
        });
    }

    /// Asks for a picture to be shown otherwise.
    pub fn show(&self, generation: u64, picture: Arc<Picture>, space: WorkingSpace, display: Display) {
        self.change(false, |desk| desk.shown = Some((generation, picture, space, display)));
    }

    /// Asks for a picture that is held beside to be shown otherwise.
    pub fn show_held(&self, number: u64, picture: Arc<Picture>, space: WorkingSpace, display: Display) {
        self.change(false, |desk| desk.held = Some((number, picture, space, display)));
    }

    /// Asks what a pixel of a finished picture is made of, in place of what was asked before.
    pub fn blame(&self, question: Question) {
        self.change(false, |desk| desk.question = Some(question));
    }

    /// Asks for small pictures of all nodes of a document at a frame; which is looked at does not matter.
    pub fn thumbnails(&self, subject: Subject, frame: i64) {
        self.change(false, |desk| desk.thumbnails = Some((subject, frame)));
    }

    /// Stops what is being done, and forgets what was to be done but for a picture that is held beside.
    pub fn stop(&self) {
        self.change(true, |desk| {
            let (closed, making) = (desk.closed, desk.making);
            *desk = Desk { closed, making, held: desk.held.take(), ..Desk::default() };
        });
    }

    /// What has happened since.
    pub fn news(&self) -> impl Iterator<Item = News> {
        self.news.try_iter()
    }

    /// What happens next, if anything does within a time.
    pub fn wait(&self, time: Duration) -> Option<News> {
        self.news.recv_timeout(time).ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.change(true, |desk| desk.closed = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the thread holds.
struct Hand<'o> {
    office: &'o Office,
    news: &'o Sender<News>,
    wake: &'o (dyn Fn() + Send + Sync),
    cache: Cache,
    /// How long a picture took, and how many samples it had, of what was looked at last.
    last: Option<(Duration, u64)>,
    lens: Option<(Subject, Arc<Lens>)>,
}

enum Task {
    Picture(Job),
    Show(u64, Arc<Picture>, WorkingSpace, Display),
    Held(u64, Arc<Picture>, WorkingSpace, Display),
    Blame(Question),
    Thumbnails(Subject, i64),
    Ahead(Job),
}

impl Hand<'_> {
    fn tell(&self, news: News) {
        // Nobody listens while the window closes.
        let _ = self.news.send(news);
        (self.wake)();
    }

    fn work(&mut self) {
        loop {
            let task = {
                let mut desk = self.office.desk();
                while desk.is_empty() && !desk.closed {
                    desk = self.office.bell.wait(desk).unwrap_or_else(PoisonError::into_inner);
                }
                if desk.closed {
                    return;
                }
                // What is held goes first, so that both change as one.
                if let Some((number, picture, space, display)) = desk.held.take() {
                    Task::Held(number, picture, space, display)
                } else if let Some((generation, picture, space, display)) = desk.shown.take() {
                    Task::Show(generation, picture, space, display)
                } else if let Some(job) = desk.job.take() {
                    Task::Picture(job)
                } else if let Some(question) = desk.question.take() {
                    Task::Blame(question)
                } else if let Some(job) = desk.ahead.pop_front() {
                    // Frames are waited for; small pictures of nodes are not.
                    desk.making = Some((job.generation, job.frame));
                    Task::Ahead(job)
                } else if let Some((subject, frame)) = desk.thumbnails.take() {
                    Task::Thumbnails(subject, frame)
                } else {
                    continue;
                }
            };
            let stamp = self.office.newest.load(Ordering::Relaxed);
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
                    let monitor = Watch { office: self.office, stamp, yields: Yields::Never, progress: None };
                    if let Some(blamed) = blame::answer(&question, &lens, &mut self.cache, &monitor) {
                        self.tell(News::Blame(Box::new(blamed)));
                    }
                }
                Task::Thumbnails(subject, frame) => self.small(&subject, frame, stamp),
                Task::Ahead(job) => {
                    self.ahead(job, stamp);
                    self.office.desk().making = None;
                }
            }
        }
    }

    /// Makes a frame before it is shown.
    fn ahead(&mut self, job: Job, stamp: u64) {
        let (generation, frame) = (job.generation, job.frame);
        let monitor = Watch { office: self.office, stamp, yields: Yields::Short, progress: None };
        let made = match self.lens(&job.subject) {
            Ok(lens) => evaluate(&job, &lens, job.proxy, true, &mut self.cache, &monitor),
            Err(message) => Err(Failure::Because(message, None)),
        };
        match made {
            Ok(result) => self.tell(News::Ahead(Box::new(result))),
            Err(Failure::Because(..)) => self.tell(News::AheadFailed { generation, frame }),
            Err(Failure::Cancelled) => {
                let mut desk = self.office.desk();
                if self.office.newest.load(Ordering::Relaxed) == stamp {
                    // Something short came between: it is waited for all the same.
                    desk.ahead.push_front(job);
                }
            }
        }
    }

    /// The graph that shows a subject, made once.
    fn lens(&mut self, subject: &Subject) -> std::result::Result<Arc<Lens>, String> {
        if let Some((_, lens)) = self.lens.as_ref().filter(|(known, _)| known.is(subject)) {
            return Ok(lens.clone());
        }
        let same_node = |known: &Subject| {
            (known.node, known.output) == (subject.node, subject.output)
                && known.sheet.nodes.len() == subject.sheet.nodes.len()
        };
        if !self.lens.as_ref().is_some_and(|(known, _)| same_node(known)) {
            self.last = None;
        }
        let mut lens = lens(&subject.sheet, subject.node, subject.output, &subject.name, &subject.folder)?;
        lens.graph = lens.graph.with_access(subject.access.clone());
        let lens = Arc::new(lens);
        self.lens = Some((subject.clone(), lens.clone()));
        Ok(lens)
    }

    /// Makes a picture, coarse ones before it where it takes long.
    fn picture(&mut self, job: &Job, stamp: u64) {
        let lens = match self.lens(&job.subject) {
            Ok(lens) => lens,
            Err(message) => {
                let generation = job.generation;
                let (node, begun, refused) = (None, false, Vec::new());
                return self.tell(News::Failed { generation, message, node, begun, refused });
            }
        };
        let format = lens.graph.format();
        let samples = |shrink: u32| {
            u64::from(format.width() / shrink) * u64::from(format.height() / shrink) * u64::from(format.samples())
        };
        let expected = self.last.map(|(time, pixels)| time.mul_f64(samples(job.proxy) as f64 / pixels.max(1) as f64));
        let mut sizes = Vec::new();
        if job.progressive && expected.is_none_or(|time| time > AT_ONCE) {
            let long = expected.is_none_or(|time| time > Duration::from_millis(900));
            sizes.extend([8, 3].into_iter().filter(|shrink| *shrink > job.proxy && (*shrink == 8 || long)));
        }
        sizes.push(job.proxy);
        for shrink in sizes {
            let tell = |share: f32| {
                let _ = self.news.send(News::Progress { generation: job.generation, share });
                (self.wake)();
            };
            let finished = shrink == job.proxy;
            let told = Told::new(&tell);
            let monitor = Watch {
                office: self.office,
                stamp,
                yields: Yields::Never,
                progress: if finished { Some(&told) } else { None },
            };
            let started = Instant::now();
            match evaluate(job, &lens, shrink, finished, &mut self.cache, &monitor) {
                Ok(result) => {
                    if job.region.is_none() {
                        self.last = Some((started.elapsed(), samples(shrink)));
                    }
                    self.tell(News::Picture(Box::new(result)));
                }
                Err(Failure::Cancelled) => return,
                Err(Failure::Because(message, node)) => {
                    let (generation, begun, refused) = (job.generation, true, lens.refused(job.frame));
                    return self.tell(News::Failed { generation, message, node, begun, refused });
                }
            }
        }
        self.cache.forget_unused();
    }

    fn small(&mut self, subject: &Subject, frame: i64, stamp: u64) {
        let Some(graph) = of_every_node(&subject.sheet, &subject.name, &subject.folder) else { return };
        let graph = graph.with_access(subject.access.clone());
        let monitor = Watch { office: self.office, stamp, yields: Yields::Always, progress: None };
        let format = graph.format();
        let shrink = (format.width() as f32 / THUMBNAIL[0] as f32).max(format.height() as f32 / THUMBNAIL[1] as f32);
        let side = |side: u32| ((side as f32 / shrink.max(1.0)).round() as u32).max(1);
        let Ok(format) = Format::new(side(format.width()), side(format.height()), 1) else { return };
        let graph = graph.drawn_at(format);
        let mut settings = Settings::default();
        settings.keep = true;
        let Ok(plan) = Plan::new(&graph, &[], frame, &[], &settings) else { return };
        let evaluated = match plan.evaluate(&Buffers::new(), &mut self.cache, &monitor) {
            Ok(evaluated) => evaluated,
            Err(EvalError::Cancelled) if self.office.newest.load(Ordering::Relaxed) == stamp => {
                // Something short came between: what stages have prepared is kept meanwhile.
                self.office.desk().thumbnails.get_or_insert((subject.clone(), frame));
                return;
            }
            Err(_) => return,
        };
        let pictures = evaluated.pictures.iter().map(|picture| Thumbnail {
            node: graph.outputs()[picture.output].name.clone(),
            screen: shown::screen(picture, graph.space(), &Display::default()),
        });
        self.tell(News::Thumbnails(pictures.collect()));
    }
}

enum Failure {
    Cancelled,
    /// Why, and the node that it was.
    Because(String, Option<String>),
}

fn evaluate(
    job: &Job,
    lens: &Arc<Lens>,
    shrink: u32,
    finished: bool,
    cache: &mut Cache,
    monitor: &Watch<'_>,
) -> std::result::Result<Result, Failure> {
    let because = |error: &dyn std::fmt::Display| {
        Failure::Because(crate::prose::here(&lens.in_document(&error.to_string(), &job.subject)), None)
    };
    let started = Instant::now();
    #[cfg(test)]
    monitor.office.pace(|| monitor.cancelled());
    let graph = drawn(lens, shrink, finished).map_err(|error| because(&error))?;
    let graph = graph.as_ref();
    let format = graph.format();
    let mut settings = Settings::default();
    settings.region = job.region.map(|region| part(region, format));
    // What an edit leaves alone is there at once in coarse pictures.
    settings.keep = !finished;
    let plan = Plan::new(graph, &[OUTPUT], job.frame, &[], &settings).map_err(|error| because(&error))?;
    let mut frame = match plan.evaluate(&Buffers::new(), cache, monitor) {
        Ok(frame) => frame,
        Err(EvalError::Cancelled) => return Err(Failure::Cancelled),
        Err(error) => {
            let Failure::Because(message, _) = because(&error) else { return Err(Failure::Cancelled) };
            let node = if let EvalError::Node { node, .. } = error { Some(node) } else { None };
            return Err(Failure::Because(message, node));
        }
    };
    let picture = frame.pictures.pop().ok_or_else(|| because(&"nothing was evaluated"))?;
    let screen = shown::screen(&picture, graph.space(), &job.display);
    Ok(Result {
        generation: job.generation,
        frame: job.frame,
        shrunk: shrink,
        finished,
        subject: job.subject.clone(),
        lens: lens.clone(),
        format,
        picture: Arc::new(picture),
        screen: Arc::new(screen),
        display: job.display,
        nodes: Arc::new(frame.nodes),
        seconds: (frame.seconds, started.elapsed().as_secs_f64()),
    })
}

/// A lens' graph for pictures that are so many times smaller.
pub(super) fn drawn(lens: &Lens, shrink: u32, finished: bool) -> std::result::Result<Cow<'_, CheckedGraph>, String> {
    if shrink == 1 {
        return Ok(Cow::Borrowed(&lens.graph));
    }
    let whole = lens.graph.format();
    let side = |side: u32| side.div_ceil(shrink).max(1);
    // A coarse picture is seen for a moment only: one sample a pixel.
    let samples = if finished { whole.samples() } else { 1 };
    let format = Format::new(side(whole.width()), side(whole.height()), samples).map_err(|error| error.to_string())?;
    Ok(Cow::Owned(lens.graph.clone().drawn_at(format.with_shading(whole.shading()))))
}

/// The pixels of a part of the picture, at least one.
fn part(region: [f32; 4], format: Format) -> Window {
    let pixels = |share: f32, side: u32| (f64::from(share) * f64::from(side)).round() as i64;
    let window = format.window();
    let (x0, y0) = (pixels(region[0], format.width()), pixels(region[1], format.height()));
    let (x1, y1) = (pixels(region[2], format.width()), pixels(region[3], format.height()));
    let x0 = x0.clamp(window.x0, window.x1 - 1);
    let y0 = y0.clamp(window.y0, window.y1 - 1);
    Window { x0, y0, x1: x1.clamp(x0 + 1, window.x1), y1: y1.clamp(y0 + 1, window.y1) }
}

/// Tells how far an evaluation is, but not more often than anybody can see.
struct Told<'t> {
    tell: &'t (dyn Fn(f32) + Sync),
    last: Mutex<Instant>,
}

impl<'t> Told<'t> {
    fn new(tell: &'t (dyn Fn(f32) + Sync)) -> Self {
        Self { tell, last: Mutex::new(Instant::now()) }
    }
}

/// What else is more urgent.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Yields {
    /// Nothing.
    Never,
    /// What is looked at now.
    Short,
    /// Frames that come next, too.
    Always,
}

/// Stops what is out of date.
struct Watch<'o> {
    office: &'o Office,
    stamp: u64,
    yields: Yields,
    progress: Option<&'o Told<'o>>,
}

impl Monitor for Watch<'_> {
    fn progress(&self, done: usize, total: usize) {
        let Some(told) = self.progress else { return };
        let mut last = told.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.elapsed() > Duration::from_millis(60) {
            *last = Instant::now();
            (told.tell)(done as f32 / total.max(1) as f32);
        }
    }

    fn cancelled(&self) -> bool {
        self.office.newest.load(Ordering::Relaxed) != self.stamp
            || (self.yields != Yields::Never && {
                let desk = self.office.desk();
                let short =
                    desk.job.is_some() || desk.shown.is_some() || desk.held.is_some() || desk.question.is_some();
                short || (self.yields == Yields::Always && !desk.ahead.is_empty())
            })
    }
}
