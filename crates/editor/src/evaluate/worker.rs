//! Handle to the evaluation thread and the thread that knows recipes.

use super::blame::Question;
use super::evaluator::Evaluator;
use super::graphics::Graphics;
use super::known::Known;
use super::lane::Lane;
use super::queue::{Queue, Requests, Wanted};
use super::request::{Job, News};
use super::shown::Display;
use super::subject::Subject;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use trochoid::{Picture, WorkingSpace};

/// Handle to the threads, which end when the handle is dropped.
pub struct Worker {
    queue: Arc<Queue>,
    news: Receiver<News>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl Worker {
    /// Starts the threads; `wake` is called whenever there is news.
    ///
    /// # Errors
    /// Fails if the system cannot start a thread.
    pub fn new(graphics: &Graphics, wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let (sender, news) = channel();
        let (known, wake) = (Arc::new(Known::default()), Arc::new(wake));
        let mut worker = Self { queue: Arc::default(), news, threads: Vec::new() };
        let thread = |name: &str| std::thread::Builder::new().name(name.into());
        let theirs = (worker.queue.clone(), known.clone(), sender.clone(), wake.clone(), graphics.clone());
        worker.threads.push(thread("evaluate").spawn(move || {
            let (queue, known, sender, wake, graphics) = theirs;
            Evaluator::new(&queue, &known, &sender, &*wake, graphics).work();
        })?);
        let theirs = worker.queue.clone();
        worker.threads.push(thread("recipes").spawn(move || known.answer(&theirs, &sender, &*wake))?);
        Ok(worker)
    }

    /// Lets the next picture panic.
    #[cfg(test)]
    pub(crate) fn break_once(&self) {
        self.queue.break_once();
    }

    /// Sets the extra time per picture.
    #[cfg(test)]
    pub(crate) fn slow_down(&self, by: Duration) {
        self.queue.slow_down(by);
    }

    /// Requests a picture, replacing all earlier requests of the viewer; before it the recipe if `weighs`, as [`Self::mix`]
    /// does.
    pub fn evaluate(&self, job: Job, weighs: bool) {
        let lane = Lane::of(job.generation);
        self.queue.change(Some(lane), |requests| {
            match lane {
                Lane::First => {
                    requests.ahead.clear();
                    (requests.known_mixture, requests.mixture) = (weighs.then(|| job.clone()), None);
                }
                Lane::Second => requests.has_second = true,
            }
            let wanted = &mut requests.wanted[lane as usize];
            *wanted = Wanted { job: Some(job), held: wanted.held.take(), ..Wanted::default() };
        });
    }

    /// Requests further frames in this order, replacing those that have not started.
    pub fn ahead(&self, jobs: impl IntoIterator<Item = Job>) {
        self.queue.change(None, |requests| {
            let making = requests.making;
            requests.ahead = jobs.into_iter().filter(|job| making != Some((job.generation, job.frame))).collect();
        });
    }

    /// Tells how many bytes the frames take that are kept for playback: so much less is kept here.
    pub fn hold(&self, bytes: usize) {
        self.queue.hold(bytes);
    }

    /// Requests a picture with other display settings.
    pub fn show(&self, generation: u64, picture: Arc<Picture>, space: WorkingSpace, display: Display) {
        let shown = Some((generation, picture, space, display));
        self.queue.change(None, |requests| requests.wanted[Lane::of(generation) as usize].shown = shown);
    }

    /// Requests the held picture with other display settings.
    pub fn show_held(&self, number: u64, picture: Arc<Picture>, space: WorkingSpace, display: Display) {
        let held = Some((number, picture, space, display));
        self.queue.change(None, |requests| requests.wanted[Lane::of(number) as usize].held = held);
    }

    /// Requests the composition of a pixel in a finished picture, replacing an earlier request.
    pub fn blame(&self, question: Question) {
        let lane = Lane::of(question.generation);
        self.queue.change(None, |requests| requests.wanted[lane as usize].question = Some(question));
    }

    /// Requests the recipe of a picture.
    pub fn mix(&self, job: Job) {
        self.queue.change(None, |requests| {
            requests.mixture = None;
            requests.known_mixture = Some(job);
        });
    }

    /// Requests thumbnails of all nodes of a document at a frame; the node and output of the subject are ignored.
    pub fn thumbnails(&self, subject: Subject, frame: i64) {
        self.queue.change(None, |requests| requests.thumbnails = Some((subject, frame)));
    }

    /// Cancels the running task of a viewer and all of its requests except that for the held picture; for the first viewer
    /// also everything that belongs to no viewer.
    pub fn stop(&self, lane: Lane) {
        self.queue.change(Some(lane), |requests| {
            let [first, second] = std::mem::take(&mut requests.wanted);
            let held = |wanted: Wanted| Wanted { held: wanted.held, ..Wanted::default() };
            let (closed, making, has_second) = (requests.closed, requests.making, requests.has_second);
            match lane {
                Lane::First => {
                    let wanted = [held(first), second];
                    *requests = Requests { closed, making, has_second, wanted, ..Requests::default() };
                }
                Lane::Second => (requests.wanted, requests.has_second) = ([first, held(second)], false),
            }
        });
    }

    /// Returns the messages since the last call.
    pub fn news(&self) -> impl Iterator<Item = News> {
        self.news.try_iter()
    }

    /// Waits up to `time` for a message.
    pub fn wait(&self, time: Duration) -> Option<News> {
        self.news.recv_timeout(time).ok()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.queue.change(Some(Lane::First), |requests| requests.closed = true);
        self.queue.change(Some(Lane::Second), |_| ());
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
