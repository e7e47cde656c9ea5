//! Keeps the cells of a sea for the cameras that see it.

use super::cells::{NoCells, SeaCells};
use crate::{Projector, SeaSurface};
use std::sync::{Arc, PoisonError, RwLock};

/// Most cameras whose cells are kept.
const MOST: usize = 4;

/// The cells of a sea by camera.
#[derive(Debug, Default)]
pub(crate) struct KeptCells {
    views: RwLock<Vec<KeptView>>,
}

/// What was made for a camera.
type KeptView = (Projector, Arc<Result<SeaCells, NoCells>>);

/// Returns a camera's projector without what does not matter to rays: the distance between vertices.
fn for_rays(projector: &Projector) -> Projector {
    Projector { fineness: 1.0, ..*projector }
}

impl KeptCells {
    /// Makes the cells for a camera, on all threads, unless `stop` says that they are no longer needed.
    pub(crate) fn prepare(&self, sea: &SeaSurface, projector: &Projector, stop: &(dyn Fn() -> bool + Sync)) {
        if self.of(projector).is_some() {
            return;
        }
        // Without the lock: a thread that waits for others may take up work that asks for cells.
        let made = SeaCells::new(sea, projector, stop);
        if matches!(made, Err(NoCells::Stopped)) {
            return;
        }
        let mut views = self.views.write().unwrap_or_else(PoisonError::into_inner);
        let wanted = for_rays(projector);
        // Another thread may have been faster; both results are the same.
        if views.iter().all(|(known, _)| *known != wanted) {
            if views.len() == MOST {
                views.remove(0);
            }
            views.push((wanted, Arc::new(made)));
        }
    }

    /// Returns what was made for a camera.
    pub(crate) fn of(&self, projector: &Projector) -> Option<Arc<Result<SeaCells, NoCells>>> {
        let wanted = for_rays(projector);
        let views = self.views.read().unwrap_or_else(PoisonError::into_inner);
        views.iter().find(|(known, _)| *known == wanted).map(|(_, made)| made.clone())
    }
}
