//! Estimates of the memory that nodes take at a frame, made before any of it is allocated.

use crate::{Connected, FrameContext, NodeId, Purpose, Source};

/// Estimate of the memory that a node takes at a frame, in bytes, and the remedy if it is too much.
///
/// The estimate follows from knobs, the picture's format and the headers of files, if any of them can make it large.
/// Memory that is always small counts as none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Memory that the node holds while the frame is made.
    pub held: u64,
    /// Additional memory while the node prepares.
    pub working: u64,
    /// For a surface or a view: memory that each view of the surfaces holds.
    pub per_view: u64,
    /// Memory that each thread working on tiles holds for the node: bytes per pixel that it reads for a tile, and the
    /// maximum in bytes. Nodes share this memory, so only the largest counts.
    pub thread: [u64; 2],
    /// Memory of what the node finds for all samples of a tile: bytes per pixel that it reads, for each node.
    pub found: u64,
    /// Key of shared memory: nodes with the same key hold it together.
    pub shared: Option<[u64; 3]>,
    /// Remedy: what to make smaller.
    pub remedy: &'static str,
}

impl MemoryUse {
    /// Makes an estimate of the memory held while the frame is made.
    pub fn held(bytes: u64, remedy: &'static str) -> Self {
        Self { held: bytes, remedy, ..Self::default() }
    }

    /// Sets the additional memory while the node prepares.
    #[must_use]
    pub fn working(self, bytes: u64) -> Self {
        Self { working: bytes, ..self }
    }

    /// Sets the key of the nodes that hold the memory together.
    #[must_use]
    pub fn shared(self, key: [u64; 3]) -> Self {
        Self { shared: Some(key), ..self }
    }

    /// Sets the memory that each thread working on tiles holds: bytes per pixel, and the maximum in bytes.
    #[must_use]
    pub fn thread(self, pixel: u64, most: u64) -> Self {
        Self { thread: [pixel, most], ..self }
    }

    /// Sets the memory of what the node finds for all samples of a tile, in bytes per pixel that it reads.
    #[must_use]
    pub fn found(self, pixel: u64) -> Self {
        Self { found: pixel, ..self }
    }

    /// Sets the memory that each view of the surface holds.
    #[must_use]
    pub fn per_view(self, bytes: u64) -> Self {
        Self { per_view: bytes, ..self }
    }
}

/// Arguments of [`Stage::memory`](crate::Stage::memory).
pub struct MemoryContext<'a> {
    /// Data that all nodes of the frame share.
    pub frame: &'a FrameContext,
    /// Whether each channel is wanted, by output.
    pub wanted: &'a [Vec<bool>],
    /// What the node is prepared for.
    pub purpose: Purpose,
    of: &'a dyn Fn(NodeId) -> MemoryUse,
}

impl<'a> MemoryContext<'a> {
    /// Makes the arguments, with the estimates of the nodes upstream; called by the engine.
    pub fn new(frame: &'a FrameContext, wanted: &'a [Vec<bool>], of: &'a dyn Fn(NodeId) -> MemoryUse) -> Self {
        Self { frame, wanted, purpose: Purpose::Pictures, of }
    }

    /// Sets what the node is prepared for; pictures by default.
    #[must_use]
    pub fn with_purpose(self, purpose: Purpose) -> Self {
        Self { purpose, ..self }
    }

    /// Returns the estimates of everything connected to a port.
    pub fn all<'s>(&'s self, port: &'s impl Connected) -> impl Iterator<Item = MemoryUse> + 's {
        port.sources().iter().filter_map(|source| match source {
            Source::Output { node, .. } => Some((self.of)(*node)),
            _ => None,
        })
    }

    /// Returns the number of pixels of the picture.
    pub fn pixels(&self) -> u64 {
        self.frame.format.window().area() as u64
    }
}

/// Formats a number of bytes for people.
///
/// ```
/// assert_eq!(trochoid_graph::in_bytes(3_760_000_000), "3.8 GB");
/// assert_eq!(trochoid_graph::in_bytes(999), "999 bytes");
/// ```
pub fn in_bytes(bytes: u64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")];
    match units.iter().find(|(unit, _)| bytes as f64 >= *unit) {
        Some((unit, name)) => format!("{:.1} {name}", bytes as f64 / unit),
        None => format!("{bytes} bytes"),
    }
}
