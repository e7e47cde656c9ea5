//! Nodes at one frame.

use crate::{Body, Kind, Node, NodeId, NodeType, Pointwise, Source, Stage, Values};
use std::any::Any;
use std::ops::Deref;
use std::sync::Arc;

/// A node at one frame: the values of its items, and the node that its type reads from them.
#[derive(Clone)]
pub struct Settled {
    ty: &'static NodeType,
    values: Values,
    node: Arc<dyn Node>,
}

impl Settled {
    pub(crate) fn new(ty: &'static NodeType, values: Values) -> Self {
        let node = ty.read(&values);
        Self { ty, values, node }
    }

    /// Returns the node type.
    pub fn ty(&self) -> &'static NodeType {
        self.ty
    }

    /// Returns the node.
    pub fn node(&self) -> &dyn Node {
        &*self.node
    }

    /// Returns the node as the struct `T`, if it is of that type.
    pub fn get<T: Node>(&self) -> Option<&T> {
        (&*self.node as &dyn Any).downcast_ref()
    }

    /// Returns the kinds of the outputs.
    pub fn kinds(&self) -> Vec<Kind> {
        let declared = || self.ty.declaration().outputs.iter().map(|output| output.kind).collect();
        self.node.kinds().unwrap_or_else(declared)
    }

    /// Returns the body if the node is a stage.
    pub fn stage(&self) -> Option<&dyn Stage> {
        if let Body::Stage(stage) = self.node.body() { Some(stage) } else { None }
    }

    /// Returns the body if the node is pointwise.
    pub fn pointwise(&self) -> Option<&dyn Pointwise> {
        if let Body::Pointwise(pointwise) = self.node.body() { Some(pointwise) } else { None }
    }

    /// Calls `f` with every node that the result depends on.
    pub fn each_needed(&self, mut f: impl FnMut(NodeId)) {
        match self.node.identity() {
            Some(Source::Output { node, .. }) => f(*node),
            Some(_) => {}
            None => self.values.each_node(f),
        }
    }

    /// Returns the node with one layer of its colors, which then are plain colors.
    pub fn of_layer(&self, layer: usize) -> Self {
        Self::new(self.ty, self.values.clone().of_layer(self.ty.declaration().items, layer))
    }

    /// Redirects every connection to the node that `to` returns for its node.
    pub fn redirect(&mut self, to: &dyn Fn(NodeId) -> NodeId) {
        let before = self.values.clone();
        self.values.redirect(to);
        if self.values != before {
            self.node = self.ty.read(&self.values);
        }
    }
}

impl Deref for Settled {
    type Target = Values;

    fn deref(&self) -> &Values {
        &self.values
    }
}

impl PartialEq for Settled {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.ty, other.ty) && self.values == other.values
    }
}

impl std::fmt::Debug for Settled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct(self.ty.declaration().name).field("values", &self.values).finish_non_exhaustive()
    }
}
