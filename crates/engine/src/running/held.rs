//! Lists the planes that an evaluation holds over the whole picture.

use super::keep::PlaneKeeper;
use super::memory::{MemoryAccount, Pictures};
use super::prepare::{Cache, PreparedStage, prepare};
use super::steps::Whole;
use crate::{EvalError, Monitor, Plan};
use std::collections::HashMap;
use trochoid_graph::NodeId;

/// Planes that an evaluation holds over the whole picture, since filters read far around tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeldPlanes {
    /// The stage.
    pub node: NodeId,
    /// Whether they are what the stage reads, as computed by the program before it; otherwise they are what it fills.
    pub before: bool,
    /// Number of planes for each sample of a pixel.
    pub channels: usize,
    /// Bytes of all of them.
    pub bytes: usize,
}

impl Plan<'_> {
    /// Returns the planes that an evaluation would hold over the whole picture, by fill in the order of evaluation. Prepares
    /// all stages, but fills nothing.
    ///
    /// # Errors
    /// Same as [`Plan::evaluate`].
    pub fn held(&self, cache: &mut Cache, monitor: &dyn Monitor) -> Result<Vec<HeldPlanes>, EvalError> {
        self.in_pool(|| {
            let (ready, account) = prepare(self, cache, monitor, Pictures::Rows)?;
            let keeper = self.keeper(&ready, &account, cache);
            let Some(pass) = self.whole_pass() else { return Ok(Vec::new()) };
            let held = keeper.whole(self, pass).into_iter().map(|(whole, channels, bytes)| {
                let (Whole::Fill(fill) | Whole::Taps(fill)) = whole;
                let before = matches!(whole, Whole::Taps(_));
                HeldPlanes { node: pass.fills[fill].node, before, channels, bytes }
            });
            Ok(held.collect())
        })
    }

    /// Decides which planes are kept and held.
    pub(super) fn keeper(
        &self,
        ready: &HashMap<NodeId, PreparedStage>,
        account: &MemoryAccount,
        cache: &mut Cache,
    ) -> PlaneKeeper {
        let bytes = [account.held(), account.whole()].map(|bytes| usize::try_from(bytes).unwrap_or(usize::MAX));
        PlaneKeeper::new(self, ready, bytes, cache)
    }
}
