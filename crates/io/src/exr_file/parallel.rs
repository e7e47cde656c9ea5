//! Bands shared out to threads.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Does all items, started in their order, `at_once` of them at a time, until one fails.
///
/// Each thread keeps its scratch from item to item. Items near each other are in work at the same time, so whoever puts
/// results back in order holds few of them.
pub(super) fn in_order<I, S, E>(
    items: I,
    at_once: usize,
    work: impl Fn(&mut S, I::Item) -> Result<(), E> + Sync,
) -> Result<(), E>
where
    I: Iterator + Send,
    S: Default,
    E: Send,
{
    let queue = Mutex::new(Some(items));
    let next = || lock(&queue).as_mut().and_then(Iterator::next);
    let threads = at_once.clamp(1, rayon::current_num_threads());
    (0..threads).into_par_iter().with_max_len(1).try_for_each(|_| {
        let mut scratch = S::default();
        while let Some(item) = next() {
            if let Err(error) = work(&mut scratch, item) {
                // The others stop after the item they have.
                *lock(&queue) = None;
                return Err(error);
            }
        }
        Ok(())
    })
}

/// The guarded value, also after a panic elsewhere: what is guarded here is changed by single steps.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
