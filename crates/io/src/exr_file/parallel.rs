//! Distribution of bands to threads.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Processes all items, started in order, `at_once` of them at a time, until one fails.
///
/// Each thread keeps its scratch from item to item. Nearby items are processed at the same time, so a caller that
/// restores the order of the results holds few of them.
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
                // The other threads stop after their current item.
                *lock(&queue) = None;
                return Err(error);
            }
        }
        Ok(())
    })
}

/// Returns the guarded value, even after a panic in another thread: the values guarded here change in single steps.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
