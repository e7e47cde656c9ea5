//! Memory that nodes take at a frame, reckoned before any of it is taken.

use crate::{Connected, FrameContext, NodeId, Source};

/// About how much memory a node takes at a frame, bytes, and what to do where that is too much.
///
/// It is reckoned from knobs, the picture's format and the headers of files, where any of these can make it large. What is small
/// whatever they say counts as none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// What the node holds as long as the frame is made.
    pub held: u64,
    /// What it needs beside that while it prepares.
    pub working: u64,
    /// Of a surface, or of a view: what each view of the surfaces holds.
    pub seen: u64,
    /// What each thread that works on tiles holds for it: bytes a pixel of the tile, and at most. Nodes share the room, so that
    /// the most of them counts.
    pub thread: [u64; 2],
    /// Nodes with the same key hold it together.
    pub shared: Option<[u64; 3]>,
    /// What to make smaller.
    pub remedy: &'static str,
}

impl MemoryUse {
    /// What is held as long as the frame is made.
    pub fn held(bytes: u64, remedy: &'static str) -> Self {
        Self { held: bytes, remedy, ..Self::default() }
    }

    /// The same with what is needed beside it while the node prepares.
    #[must_use]
    pub fn working(self, bytes: u64) -> Self {
        Self { working: bytes, ..self }
    }

    /// The same where nodes with this key hold it together.
    #[must_use]
    pub fn shared(self, key: [u64; 3]) -> Self {
        Self { shared: Some(key), ..self }
    }

    /// The same where each thread that works on tiles holds so many bytes a pixel for it, and at most so many.
    #[must_use]
    pub fn thread(self, pixel: u64, most: u64) -> Self {
        Self { thread: [pixel, most], ..self }
    }

    /// The same of a surface, of which each view holds so many bytes.
    #[must_use]
    pub fn seen(self, bytes: u64) -> Self {
        Self { seen: bytes, ..self }
    }
}

/// What a node is given to reckon its memory.
pub struct Reckoning<'a> {
    /// The frame.
    pub frame: &'a FrameContext,
    /// For each output, which of its channels are wanted.
    pub wanted: &'a [Vec<bool>],
    of: &'a dyn Fn(NodeId) -> MemoryUse,
}

impl<'a> Reckoning<'a> {
    /// Made by the engine, with what the nodes before it take.
    pub fn new(frame: &'a FrameContext, wanted: &'a [Vec<bool>], of: &'a dyn Fn(NodeId) -> MemoryUse) -> Self {
        Self { frame, wanted, of }
    }

    /// What all that is connected to a port takes.
    pub fn all<'s>(&'s self, port: &'s impl Connected) -> impl Iterator<Item = MemoryUse> + 's {
        port.sources().iter().filter_map(|source| match source {
            Source::Output { node, .. } => Some((self.of)(*node)),
            _ => None,
        })
    }

    /// Pixels of the document's picture.
    pub fn pixels(&self) -> u64 {
        self.frame.format.window().area() as u64
    }
}

/// Bytes as a person reads them.
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
