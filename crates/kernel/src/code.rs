//! Instructions to which programs are compiled.

use crate::audit::ValueRule;
use crate::native::Native;
use trochoid_graph::{NodeId, Program, Slot};
use trochoid_memory::Instructions;

/// Number of samples in a chunk.
pub const CHUNK: usize = 128;

/// A chunk of samples, aligned to cache lines.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Chunk(pub [f32; CHUNK]);

impl Chunk {
    /// A chunk of zeros.
    pub const ZERO: Self = Self([0.0; CHUNK]);
}

/// Number of samples in a block.
pub const BLOCK: usize = 4 * CHUNK;

/// Samples without a place in a picture, of one plane or channel, aligned to cache lines.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct Block(pub [f32; BLOCK]);

impl Block {
    /// A block of zeros.
    pub const ZERO: Self = Self([0.0; BLOCK]);
}

/// Source of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Row {
    /// One of the machine's chunks.
    Own(u32),
    /// Plane from outside.
    Plane(u32),
    /// Value that was computed once for the tile, and varies along x.
    Column(u32),
    /// Value that was computed once for the row of pixels.
    Line(u32),
}

/// Source of a color.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ColorOperand {
    /// The accumulator.
    Last,
    Rows([Row; 3]),
    Constant([f32; 3]),
    /// Mix of two constants, which is never stored.
    Pair {
        from: [f32; 3],
        to: [f32; 3],
        by: Row,
    },
}

/// One instruction. Instructions that make a color leave it in the accumulator.
#[derive(Clone, Debug)]
pub(crate) enum Instruction {
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
    Load(ColorOperand),
    Mix {
        a: ColorOperand,
        b: ColorOperand,
        t: Row,
        /// Root that this color belongs to, if the color has no other use; it is written straight to its destination.
        out: Option<u32>,
    },
    /// The mix by y of two pairs mixed by x.
    Patch {
        corners: [[f32; 3]; 4],
        x: Row,
        y: Row,
    },
    Blend {
        colors: Vec<ColorOperand>,
        weights: Vec<Row>,
    },
    /// Saves the accumulator, which nothing reads after that.
    Keep([u32; 3]),
    /// Checks weights against [0, 1].
    AuditMask(Row),
    /// Checks weights against [0, 1] and their sum against 1.
    AuditPartition(Vec<Row>),
    /// Checks a plane of the caller against the rule of its kind.
    Check {
        plane: u32,
        index: u32,
    },
    /// If all of `t` is `closed`, loads `otherwise` and jumps over `skip` instructions.
    Gate {
        t: Row,
        closed: f32,
        otherwise: ColorOperand,
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
    pub(crate) list: Vec<Instruction>,
    /// Number of its own chunks.
    pub(crate) own: usize,
    /// Its own chunks that hold a constant throughout.
    pub(crate) constants: Vec<(u32, f32)>,
    /// First output channel and number of channels, by root.
    pub(crate) roots: Vec<(usize, usize)>,
    /// Whether a root is a color, by root.
    pub(crate) colors: Vec<bool>,
    /// Whether the extremes of weights and of results are recorded.
    pub(crate) audits: bool,
    /// Planes that are checked against the rule of their kind: the plane and the rule, by index.
    pub(crate) checks: Vec<(u32, ValueRule)>,
}

impl Code {
    /// Returns the number of output channels.
    pub(crate) fn channels(&self) -> usize {
        self.roots.iter().map(|(_, count)| count).sum()
    }

    /// Returns whether a root is a color.
    #[cfg(feature = "jit")]
    pub(crate) fn is_color(&self, root: usize) -> bool {
        self.colors[root]
    }

    /// Returns the number of chunks that the code needs to run: its own, and the accumulator.
    pub(crate) fn chunks(&self) -> usize {
        self.own + 3
    }
}

/// Program and roots from which a compiled program was made.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The program.
    pub program: Program,
    /// Positions of the operations whose values are the results.
    pub roots: Vec<u32>,
}

/// A compiled program.
#[derive(Clone, Debug, Default)]
pub struct CompiledProgram {
    /// Planes read, in the order in which the machine expects them.
    pub planes: Vec<Slot>,
    /// Runs once per tile, over its columns.
    pub(crate) column: Code,
    /// Runs once per row, over one chunk.
    pub(crate) row: Code,
    /// Runs over every pixel.
    pub(crate) main: Code,
    /// Nodes that the operations came from, and the relative cost of each operation per pixel, for reports.
    pub costs: Vec<(NodeId, f64)>,
    /// The main code as machine code.
    pub(crate) native: Option<Native>,
    /// Number of channels, by root.
    pub roots: Vec<usize>,
    /// Instruction sets that the machine may use.
    pub instructions: Instructions,
    /// What it was compiled from, if bounds on errors are requested.
    pub origin: Origin,
    /// Fault built into the kernels, so that tests see whether it is noticed.
    #[cfg(feature = "faults")]
    pub fault: Fault,
}

impl CompiledProgram {
    /// Returns the number of chunks that a machine needs to run it.
    pub fn chunks(&self) -> usize {
        [&self.column, &self.row, &self.main].map(Code::chunks).into_iter().sum()
    }

    /// Makes the machine code, if there is any, so that no run has to wait for it.
    pub fn make_ready(&self) {
        if let Some(native) = &self.native {
            native.make_ready();
        }
    }
}

/// A deliberately broken kernel.
#[cfg(feature = "faults")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fault {
    /// The kernels are sound.
    #[default]
    None,
    /// Mix overshoots its second color.
    MixOvershoots,
    /// Partitions sum to a little less than 1.
    PartitionLeaks,
    /// Clamp lets a mask reach beyond 1.
    ClampLeaks,
    /// Mix returns NaN at one pixel of a chunk.
    MixLosesOne,
}

/// A plane over a tile, wherever its rows are in memory.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// Samples, row by row.
    pub samples: &'a [f32],
    /// Index of the tile's first sample.
    pub start: usize,
    /// Distance from one row to the next; 0 if one row serves for all.
    pub stride: usize,
}

impl<'a> Plane<'a> {
    /// Returns the first `width` samples of row y.
    #[inline(always)]
    pub fn row(&self, y: usize, width: usize) -> &'a [f32] {
        let start = self.start + y * self.stride;
        &self.samples[start..start + width]
    }
}
