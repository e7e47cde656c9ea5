//! Prepares stages once a frame, and keeps what the next frame can use.

use crate::{EvalError, Monitor, Plan};
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;
use trochoid_graph::{Body, Handle, NodeError, NodeId, Prepare, Prepared};

type Key = (String, Vec<Vec<bool>>);

/// What stages prepared for the frame before, by content key, so that what does not change is not done again.
#[derive(Default)]
pub struct Cache {
    kept: HashMap<Key, Arc<dyn Prepared>>,
}

impl Cache {
    /// An empty cache.
    pub fn new() -> Self {
        Self::default()
    }
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Cache of {} nodes", self.kept.len())
    }
}

/// A prepared stage and how it came to be.
pub(crate) struct Ready {
    pub(crate) prepared: Arc<dyn Prepared>,
    pub(crate) seconds: f64,
    pub(crate) cached: bool,
}

/// Prepares every stage of a plan, inputs first. The cache then holds exactly this frame's.
pub(crate) fn prepare(
    plan: &Plan<'_>,
    cache: &mut Cache,
    monitor: &dyn Monitor,
) -> Result<HashMap<NodeId, Ready>, EvalError> {
    let mut ready: HashMap<NodeId, Ready> = HashMap::new();
    let mut kept = HashMap::new();
    for (id, wanted) in &plan.prepares {
        if monitor.cancelled() {
            return Err(EvalError::Cancelled);
        }
        let node = plan.graph.node(*id);
        let (Body::Stage(stage), Some(settled)) = (node.ty.body(), &plan.settled[id.0]) else { continue };
        let key = (plan.keys[id.0].clone(), wanted.clone());
        let entry = match cache.kept.get(&key) {
            Some(prepared) => Ready { prepared: prepared.clone(), seconds: 0.0, cached: true },
            None => {
                monitor.preparing(&node.name);
                let started = Instant::now();
                let handles = |id: NodeId| -> Option<Handle> { ready.get(&id)?.prepared.handle() };
                let cancelled = || monitor.cancelled();
                let prepare = Prepare::new(&plan.context, wanted, &handles, &cancelled);
                let prepared =
                    stage.prepare(settled, &prepare).map_err(|error| node_error(plan, *id, error, monitor))?;
                Ready { prepared: prepared.into(), seconds: started.elapsed().as_secs_f64(), cached: false }
            }
        };
        kept.insert(key, entry.prepared.clone());
        ready.insert(*id, entry);
    }
    cache.kept = kept;
    Ok(ready)
}

/// A node's error with its name; a node that stopped because it was asked to has no error of its own.
pub(crate) fn node_error(plan: &Plan<'_>, id: NodeId, error: NodeError, monitor: &dyn Monitor) -> EvalError {
    if monitor.cancelled() {
        return EvalError::Cancelled;
    }
    let node = plan.graph.node(id);
    EvalError::Node { node: node.name.clone(), ty: node.ty.declaration().name.into(), message: error.message }
}
