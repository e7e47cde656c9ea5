//! What is known of earlier texts: the thread that finds the recipe of a picture of which only colors changed, while the
//! evaluation thread is busy with another one.

use super::lens::{Lens, LensError, lens};
use super::mixture::{KnownRecipe, Mixture};
use super::queue::Queue;
use super::request::{Job, News};
use super::subject::Subject;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What the threads know together.
#[derive(Default)]
pub(super) struct Known {
    /// The last lens of each viewer, newest first.
    lenses: Mutex<Vec<(Subject, Arc<Lens>)>>,
    recipe: Mutex<Option<KnownRecipe>>,
}

impl Known {
    /// Returns the graph that shows a subject, built once if it is one of the last two.
    pub(super) fn lens(&self, subject: &Subject) -> Result<Arc<Lens>, LensError> {
        // A thread that needs the same graph waits until it is built.
        let mut last = locked(&self.lenses);
        if let Some((_, lens)) = last.iter().find(|(known, _)| known.is(subject)) {
            return Ok(lens.clone());
        }
        let made = Arc::new(lens(subject)?);
        last.insert(0, (subject.clone(), made.clone()));
        last.truncate(2);
        Ok(made)
    }

    /// Replaces the recipe.
    pub(super) fn set_recipe(&self, recipe: Option<KnownRecipe>) {
        *locked(&self.recipe) = recipe;
    }

    /// Returns the memory of the recipe, in bytes.
    pub(super) fn bytes(&self) -> usize {
        locked(&self.recipe).as_ref().map_or(0, KnownRecipe::bytes)
    }

    /// Answers requests for recipes until the queue is closed. A recipe that is not known is evaluated later.
    pub(super) fn answer(&self, queue: &Queue, news: &Sender<News>, wake: &(dyn Fn() + Send + Sync)) {
        while let Some((job, stamp)) = queue.next_known() {
            let answer = match self.mixture(&job) {
                Some(mixture) => News::Mixture(Box::new(mixture)),
                None => News::UnknownMixture { generation: queue.unknown(job, stamp) },
            };
            // Sending fails only while the window closes.
            let _ = news.send(answer);
            wake();
        }
    }

    fn mixture(&self, job: &Job) -> Option<Mixture> {
        let lens = self.lens(&job.subject).ok()?;
        let place = (job.frame, job.proxy, job.region);
        locked(&self.recipe).as_ref()?.mixture(job.generation, &job.subject, &lens, job.frame, &place)
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
