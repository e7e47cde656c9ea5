//! Options and uses of a folder in which runs leave simulations for each other.

use crate::failure::{FAILED, Failure};
use std::path::PathBuf;
use std::sync::Arc;
use trochoid::{Cache, FolderStore};

/// Options of the folder.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct StoreOptions {
    /// Keep the states of long simulations in this folder, from which other runs and machines go on; used only where that
    /// is faster than simulating anew. The pictures are the same
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<PathBuf>,
    /// Most bytes in the folder of --cache: what was not used for longest is removed [default: 10GB]
    #[arg(long, value_name = "SIZE", value_parser = trochoid_terminal::size, requires = "cache")]
    pub(crate) cache_limit: Option<u64>,
}

/// Default limit.
const LIMIT: u64 = 10_000_000_000;

impl StoreOptions {
    /// Opens the folder, if one is given.
    ///
    /// # Errors
    /// It cannot be read or made.
    pub(super) fn open(&self) -> Result<Option<Arc<FolderStore>>, Failure> {
        let open = |folder: &PathBuf| FolderStore::new(folder, self.cache_limit.unwrap_or(LIMIT));
        let store = self.cache.as_ref().map(open).transpose();
        store.map(|store| store.map(Arc::new)).map_err(|error| {
            let message = format!("--cache {error}; expected a folder, or a path where one can be made");
            Failure { code: FAILED, ..Failure::usage(message, "name another folder") }
        })
    }
}

/// Returns the memory of a run, with the folder.
pub(super) fn cache(store: Option<&Arc<FolderStore>>) -> Cache {
    match store {
        Some(store) => Cache::new().with_store(store.clone()),
        None => Cache::new(),
    }
}

/// Returns a note on what was done with the folder, and warnings of what did not work.
pub(super) fn notes(store: &FolderStore) -> Vec<String> {
    let uses = store.uses();
    let states = |count: u64| if count == 1 { "1 state".into() } else { format!("{count} states") };
    let used = (uses.read + uses.kept > 0)
        .then(|| format!("note: --cache: went on from {}, kept {}", states(uses.read), states(uses.kept)));
    let damaged = (uses.damaged > 0).then(|| {
        format!(
            "warning: --cache: found {} damaged, and simulated anew; expected files as they were written\n  remedy: look \
             after the disk; the pictures are right",
            if uses.damaged == 1 { "1 file".into() } else { format!("{} files", uses.damaged) }
        )
    });
    let refused = uses.refused.map(|error| {
        format!(
            "warning: --cache: {error}; the simulation is not kept\n  remedy: let the user of this program write there; the \
             pictures are right"
        )
    });
    used.into_iter().chain(damaged).chain(refused).collect()
}
