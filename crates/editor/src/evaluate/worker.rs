//! The handle to the thread that evaluates.

use super::blame::Question;
use super::evaluator::Evaluator;
use super::queue::{Queue, Requests};
use super::request::{Job, News};
use super::shown::Display;
use super::subject::Subject;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use trochoid::{Picture, WorkingSpace};

/// A handle to the thread, which ends with it.
pub struct Worker {
    queue: Arc<Queue>,
    news: Receiver<News>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread; `wake` is called whenever there are news.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let queue = Arc::new(Queue::default());
        let (sender, news) = channel();
        let theirs = queue.clone();
        let thread = std::thread::Builder::new()
            .name("evaluate".into())
            .spawn(move || Evaluator::new(&theirs, &sender, &wake).work())?;
        Ok(Self { queue, news, thread: Some(thread) })
    }

    /// Lets each picture take so long besides.
    #[cfg(test)]
    pub(crate) fn slow_down(&self, by: Duration) {
        self.queue.slow_down(by);
    }

    /// Asks for a picture, in place of all that was asked for before.
    pub fn evaluate(&self, job: Job) {
        self.queue.change(true, |requests| {
            requests.shown = None;
            requests.question = None;
            requests.ahead.clear();
            requests.job = Some(job);
        });
    }

    /// Asks for pictures of further frames in their order, in place of those that were asked for and are not begun.
    pub fn ahead(&self, jobs: impl IntoIterator<Item = Job>) {
        self.queue.change(false, |requests| {
            let making = requests.making;
            requests.ahead = jobs.into_iter().filter(|job| making != Some((job.generation, job.frame))).collect();
        });
    }

    /// Asks for a picture to be shown otherwise.
    pub fn show(&self, generation: u64, picture: Arc<Picture>, space: WorkingSpace, display: Display) {
        self.queue.change(false, |requests| requests.shown = Some((generation, picture, space, display)));
    }

    /// Asks for a picture that is held beside to be shown otherwise.
    pub fn show_held(&self, number: u64, picture: Arc<Picture>, space: WorkingSpace, display: Display) {
        self.queue.change(false, |requests| requests.held = Some((number, picture, space, display)));
    }

    /// Asks what a pixel of a finished picture is made of, in place of what was asked before.
    pub fn blame(&self, question: Question) {
        self.queue.change(false, |requests| requests.question = Some(question));
    }

    /// Asks for small pictures of all nodes of a document at a frame; which is looked at does not matter.
    pub fn thumbnails(&self, subject: Subject, frame: i64) {
        self.queue.change(false, |requests| requests.thumbnails = Some((subject, frame)));
    }

    /// Stops what is being done, and forgets what was to be done but for a picture that is held beside.
    pub fn stop(&self) {
        self.queue.change(true, |requests| {
            let (closed, making) = (requests.closed, requests.making);
            *requests = Requests { closed, making, held: requests.held.take(), ..Requests::default() };
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
        self.queue.change(true, |requests| requests.closed = true);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
