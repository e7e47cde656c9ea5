//! What stages are given, and what they fill.

use crate::{FrameContext, Handle, NodeError, NodeId, Settled, Source, ViewChannel};
use trochoid_image::Window;

/// What [`Stage::prepare`](crate::Stage::prepare) is given.
pub struct Prepare<'a> {
    /// The frame.
    pub frame: &'a FrameContext,
    /// For each output, which of its channels are wanted.
    pub wanted: &'a [Vec<bool>],
    handles: &'a dyn Fn(NodeId) -> Option<Handle>,
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Prepare<'a> {
    /// Made by the engine.
    pub fn new(
        frame: &'a FrameContext,
        wanted: &'a [Vec<bool>],
        handles: &'a dyn Fn(NodeId) -> Option<Handle>,
        cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        Self { frame, wanted, handles, cancelled }
    }

    /// The handles of everything connected to a port, as `T`.
    ///
    /// # Errors
    /// The connected node hands on something else: a bug of that node, reported rather than hidden.
    pub fn handles<T: Clone + 'static>(&self, node: &Settled, port: &str) -> Result<Vec<T>, NodeError> {
        node.all(port)
            .iter()
            .filter_map(|source| if let Source::Output { node, .. } = source { Some(*node) } else { None })
            .map(|id| {
                (self.handles)(id).and_then(|handle| handle.downcast_ref::<T>().cloned()).ok_or_else(|| {
                    NodeError::new(format!("\"{port}\" is connected to a node that hands on nothing usable"))
                })
            })
            .collect()
    }

    /// The handle of the first node connected to a port, whatever it holds; `None` where the port is open.
    pub fn handle_of(&self, node: &Settled, port: &str) -> Option<Handle> {
        match node.all(port).first() {
            Some(Source::Output { node, .. }) => (self.handles)(*node),
            _ => None,
        }
    }

    /// Whether the user has asked to stop.
    pub fn cancelled(&self) -> bool {
        (self.cancelled)()
    }
}

/// A block of samples: one sample of each pixel of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// The pixels.
    pub window: Window,
    /// Where in its pixel the sample lies, from the upper left corner, in pixels.
    pub offset: [f64; 2],
}

/// The channels of one connection over a block, each where asked for.
pub type Connection<'a> = Vec<Option<&'a [f32]>>;

/// The planes connected to a stage's ports over a block, row by row.
pub struct Inputs<'a> {
    planes: &'a [(&'static str, Vec<Connection<'a>>)],
}

impl<'a> Inputs<'a> {
    /// Made by the engine: for each port, for each connection, for each channel, its plane where asked for.
    pub fn new(planes: &'a [(&'static str, Vec<Connection<'a>>)]) -> Self {
        Self { planes }
    }

    /// The channels of connection `index` of a port.
    ///
    /// # Panics
    /// The node declares no such port, or has no such connection.
    pub fn planes(&self, port: &str, index: usize) -> &[Option<&'a [f32]>] {
        match self.planes.iter().find(|(name, _)| *name == port) {
            Some((_, connections)) => &connections[index],
            None => unreachable!("the node type does not declare \"{port}\""),
        }
    }

    /// A channel of the view connected to a port that the node prefers, where the view supplies it.
    pub fn view_if_any(&self, port: &str, channel: ViewChannel) -> Option<&'a [f32]> {
        self.planes(port, 0)[channel as usize]
    }

    /// A channel of the view connected to a port.
    ///
    /// # Panics
    /// The node did not ask for it: a bug of that node, caught by its first test.
    pub fn view(&self, port: &str, channel: ViewChannel) -> &'a [f32] {
        match self.planes(port, 0)[channel as usize] {
            Some(plane) => plane,
            None => unreachable!("the node did not ask for {channel:?}"),
        }
    }
}

/// The planes that a stage is to fill over a block.
pub struct Outputs<'a> {
    planes: Vec<Vec<Option<&'a mut [f32]>>>,
}

impl<'a> Outputs<'a> {
    /// Made by the engine: for each output, for each channel, its plane where wanted.
    pub fn new(planes: Vec<Vec<Option<&'a mut [f32]>>>) -> Self {
        Self { planes }
    }

    /// Takes the plane of a channel, or `None` where nobody wants it.
    pub fn take(&mut self, output: usize, channel: usize) -> Option<&'a mut [f32]> {
        self.planes.get_mut(output)?.get_mut(channel)?.take()
    }
}
