//! Data that stages leave for other processes.

use std::fmt::Debug;
use trochoid_key::Key;

/// Place where stages leave what took them long, for other processes and machines: a simulation up to a step.
///
/// Entries with one key form a series, such as a simulation's states, and have ascending numbers, such as their steps.
/// An entry is the same bytes whoever made it. A store may refuse or forget any entry, so a stage must be able to do
/// without.
pub trait Store: Debug + Send + Sync {
    /// Returns the entry of a series with the largest number above `least` and up to `most`.
    fn find(&self, series: Key, least: u64, most: u64) -> Option<StoredEntry>;

    /// Returns the data of an entry, unchanged since it was kept; `None` if that cannot be said.
    fn read(&self, series: Key, entry: &StoredEntry) -> Option<Vec<u8>>;

    /// Keeps an entry, if possible.
    fn keep(&self, series: Key, number: u64, seconds: f64, data: &[u8]);

    /// Returns whether reading so many bytes takes less time than making them, which takes `seconds`.
    fn reading_pays(&self, bytes: u64, seconds: f64) -> bool;

    /// Returns whether keeping so many bytes takes little time compared with making them, which took `seconds`.
    fn keeping_pays(&self, bytes: u64, seconds: f64) -> bool;
}

/// Entry of a [`Store`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredEntry {
    /// Number in its series.
    pub number: u64,
    /// Number of bytes of its data.
    pub bytes: u64,
    /// Seconds that it took to make the data without a store.
    pub seconds: f64,
}
