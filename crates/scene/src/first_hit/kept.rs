//! Keeps the cells of a sea for the cameras that see it.

use super::cells::{NoCells, SeaCells};
use crate::{Projector, SeaSurface};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

/// Most cameras whose cells are kept.
const MOST: usize = 4;
/// Number of rays of a camera from which cells are made: they take as long as some hundred rays without them.
const WORTH: usize = 200;

/// The cells of a sea by camera.
#[derive(Debug, Default)]
pub(crate) struct KeptCells {
    views: RwLock<Vec<Arc<KeptView>>>,
}

/// The cells of a sea for one camera.
#[derive(Debug)]
pub(crate) struct KeptView {
    projector: Projector,
    /// Number of rays searched without cells.
    rays: AtomicUsize,
    cells: OnceLock<Result<SeaCells, NoCells>>,
}

impl KeptView {
    /// Returns the cells, if they have been made.
    pub(crate) fn cells(&self) -> Option<&Result<SeaCells, NoCells>> {
        self.cells.get()
    }
}

impl KeptCells {
    fn view(&self, projector: &Projector) -> Arc<KeptView> {
        // The distance between vertices does not matter to rays.
        let wanted = Projector { fineness: 1.0, ..*projector };
        let find = |views: &[Arc<KeptView>]| views.iter().find(|view| view.projector == wanted).cloned();
        if let Some(view) = find(&self.views.read().unwrap_or_else(PoisonError::into_inner)) {
            return view;
        }
        let mut views = self.views.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(view) = find(&views) {
            return view;
        }
        if views.len() == MOST {
            views.remove(0);
        }
        let view = Arc::new(KeptView { projector: wanted, rays: AtomicUsize::new(0), cells: OnceLock::new() });
        views.push(view.clone());
        view
    }

    /// Makes the cells for a camera, on all threads, unless `stop` says that they are no longer needed.
    pub(crate) fn prepare(&self, sea: &SeaSurface, projector: &Projector, stop: &(dyn Fn() -> bool + Sync)) {
        let view = self.view(projector);
        if view.cells.get().is_none() {
            // Not within the lock's own initialization: waiting for other threads there could wait for itself.
            let made = SeaCells::new(sea, projector, true, stop);
            if !matches!(made, Err(NoCells::Stopped)) {
                // Another thread may have been faster; both results are the same.
                let _ = view.cells.set(made);
            }
        }
    }

    /// Returns what is kept for a camera whose ray is to be searched. After some rays the cells are made, on this
    /// thread alone.
    pub(crate) fn for_ray(&self, sea: &SeaSurface, projector: &Projector) -> Arc<KeptView> {
        let view = self.view(projector);
        if view.cells.get().is_none() && view.rays.fetch_add(1, Ordering::Relaxed) >= WORTH {
            view.cells.get_or_init(|| SeaCells::new(sea, projector, false, &|| false));
        }
        view
    }
}
