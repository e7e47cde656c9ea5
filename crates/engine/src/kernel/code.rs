//! What programs are compiled to.

use super::audit::Legal;
use super::native::Native;
use trochoid_graph::{NodeId, Program, Slot};
use trochoid_memory::Instructions;

/// Samples in a chunk.
pub(crate) const CHUNK: usize = 128;

/// A chunk of samples, on cache lines.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(crate) struct Chunk(pub(crate) [f32; CHUNK]);

impl Chunk {
    pub(crate) const ZERO: Self = Self([0.0; CHUNK]);
}

/// Where a chunk comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// One of the machine's.
    Own(u32),
    /// A plane from outside.
    Plane(u32),
    /// What was computed once for the tile, and varies along x.
    Column(u32),
    /// What was computed once for the row of pixels.
    Line(u32),
}

/// Where a color comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// The accumulator.
    Last,
    Rows([Row; 3]),
    Constant([f32; 3]),
    /// The mix of two constants, never stored.
    Pair {
        from: [f32; 3],
        to: [f32; 3],
        by: Row,
    },
}

/// One instruction. Colors are left in the accumulator.
#[derive(Clone, Debug)]
pub(crate) enum Work {
    Clamp {
        x: Row,
        min: f32,
        max: f32,
        to: u32,
    },
    Smooth {
        t: Row,
        to: u32,
    },
    Power {
        t: Row,
        p: f32,
        to: u32,
    },
    Step {
        x: Row,
        threshold: f32,
        to: u32,
    },
    Complement {
        t: Row,
        to: u32,
    },
    Product {
        t: Row,
        u: Row,
        to: u32,
    },
    /// Rounds weights so that they sum to exactly 1.
    Partition {
        weights: Vec<Row>,
        to: Vec<u32>,
    },
    Normalize {
        values: Vec<Row>,
        floor: f32,
        to: Vec<u32>,
    },
    Load(Source),
    Mix {
        a: Source,
        b: Source,
        t: Row,
        /// The root that this color is, if it is nothing else: written straight where it belongs.
        out: Option<u32>,
    },
    /// The mix by y of two pairs mixed by x.
    Patch {
        corners: [[f32; 3]; 4],
        x: Row,
        y: Row,
    },
    Blend {
        colors: Vec<Source>,
        weights: Vec<Row>,
    },
    /// Keeps the accumulator, which nobody reads after that.
    Keep([u32; 3]),
    /// Holds weights against [0, 1].
    AuditMask(Row),
    /// Holds weights against [0, 1] and their sum against 1.
    AuditPartition(Vec<Row>),
    /// Holds a plane of the caller against what its kind allows.
    Check {
        plane: u32,
        index: u32,
    },
    /// Where all of `t` is `closed`, takes `otherwise` and jumps over `skip` instructions.
    Gate {
        t: Row,
        closed: f32,
        otherwise: Source,
        skip: usize,
    },
    /// Writes a color root from the accumulator.
    OutColor(u32),
    /// Writes a root of scalars.
    OutRows {
        root: u32,
        rows: Vec<Row>,
    },
}

/// Straight-line code over chunks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Code {
    pub(crate) list: Vec<Work>,
    /// Number of chunks of its own.
    pub(crate) own: usize,
    /// Own chunks that hold a constant throughout.
    pub(crate) constants: Vec<(u32, f32)>,
    /// By root, its first output channel and how many it has.
    pub(crate) roots: Vec<(usize, usize)>,
    /// By root, whether it is a color.
    pub(crate) colors: Vec<bool>,
    /// The planes held against what their kind allows: by index, the plane and the rule.
    pub(crate) checks: Vec<(u32, Legal)>,
}

impl Code {
    /// Number of output channels.
    pub(crate) fn channels(&self) -> usize {
        self.roots.iter().map(|(_, count)| count).sum()
    }

    /// Whether a root is a color.
    #[cfg(feature = "jit")]
    pub(crate) fn is_color(&self, root: usize) -> bool {
        self.colors[root]
    }

    /// Number of chunks that it needs to run: its own, and the accumulator.
    pub(crate) fn chunks(&self) -> usize {
        self.own + 3
    }
}

/// What a compiled program was made from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Origin {
    pub(crate) program: Program,
    pub(crate) roots: Vec<u32>,
}

/// A compiled program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Compiled {
    /// Planes read, in the order in which the machine expects them.
    pub(crate) planes: Vec<Slot>,
    /// Run once a tile, over its columns.
    pub(crate) column: Code,
    /// Run once a row, over one chunk.
    pub(crate) row: Code,
    /// Run over everything.
    pub(crate) main: Code,
    /// The nodes that operations came from, and each one's relative cost a pixel, for reports.
    pub(crate) costs: Vec<(NodeId, f64)>,
    /// The main code as machine code.
    pub(crate) native: Option<Native>,
    /// By root, its number of channels.
    pub(crate) roots: Vec<usize>,
    /// What the machine may use.
    pub(crate) instructions: Instructions,
    /// What it was compiled from, where bounds on errors are asked for.
    pub(crate) origin: Origin,
    /// What the kernels do wrong, so that tests see whether anybody notices.
    #[cfg(test)]
    pub(crate) fault: Fault,
}

impl Compiled {
    /// Number of chunks that a machine needs to run it.
    pub(crate) fn chunks(&self) -> usize {
        [&self.column, &self.row, &self.main].map(Code::chunks).into_iter().sum()
    }
}

/// A deliberately broken kernel.
#[cfg(test)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Fault {
    #[default]
    None,
    /// Mix goes beyond its second color.
    MixOvershoots,
    /// Partitions sum to a little less than 1.
    PartitionLeaks,
    /// Clamp lets a mask reach beyond 1.
    ClampLeaks,
    /// Mix gives NaN at one pixel of a chunk.
    MixLosesOne,
}

/// A plane over a tile, wherever its rows lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane<'a> {
    pub(crate) samples: &'a [f32],
    /// The tile's first sample.
    pub(crate) start: usize,
    /// From one row to the next; 0 where one row stands for all.
    pub(crate) stride: usize,
}

impl<'a> Plane<'a> {
    /// The first `width` samples of row y.
    #[inline(always)]
    pub(crate) fn row(&self, y: usize, width: usize) -> &'a [f32] {
        let start = self.start + y * self.stride;
        &self.samples[start..start + width]
    }
}
