//! The graph around a node, as its own checks see it.

use super::Draft;
use super::kinds::kind_of;
use crate::{Consumer, GraphContext, Item, Kind, Registry, Source, Upstream};

/// Returns, for each node, the nodes and ports that its outputs are connected to, without disabled nodes and nodes of
/// unknown type.
pub(super) fn direct_consumers(drafts: &[Draft<'_>]) -> Vec<Vec<(usize, Consumer)>> {
    let mut consumers = vec![Vec::new(); drafts.len()];
    for (index, draft) in drafts.iter().enumerate().filter(|(_, draft)| !draft.disabled) {
        let Some(ty) = draft.ty else { continue };
        for item in ty.declaration().items {
            let Item::Port(port) = item else { continue };
            for source in draft.record.all(port.name) {
                let Source::Output { node, .. } = source else { continue };
                consumers[node.0].push((index, Consumer { wants: port.wants }));
            }
        }
    }
    consumers
}

/// The graph around a node at a frame.
pub(super) struct Surroundings<'d, 'a> {
    pub(super) registry: &'d Registry,
    pub(super) drafts: &'d [Draft<'a>],
    pub(super) consumers: &'d [Vec<(usize, Consumer)>],
    pub(super) node: usize,
    pub(super) frame: f64,
}

impl GraphContext for Surroundings<'_, '_> {
    fn kind(&self, source: &Source<Vec<f64>>) -> Option<Kind> {
        kind_of(source, self.drafts)
    }

    fn upstream(&self, source: &Source<Vec<f64>>) -> Option<Upstream> {
        let Source::Output { node, .. } = source else { return None };
        let draft = self.drafts.get(node.0).filter(|draft| !draft.faulty)?;
        Some(Upstream { name: draft.name.into(), node: draft.ty?.settle(draft.record.settle(self.frame)) })
    }

    fn registry(&self) -> &Registry {
        self.registry
    }

    fn consumers(&self) -> Vec<Consumer> {
        let direct = &self.consumers[self.node];
        let views = direct.iter().filter(|(node, _)| self.drafts[*node].kinds.contains(&Kind::View));
        let of_views = views.flat_map(|(node, _)| &self.consumers[*node]);
        direct.iter().chain(of_views).map(|(_, user)| *user).collect()
    }
}
