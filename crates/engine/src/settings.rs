use trochoid_graph::NodeId;
use trochoid_image::Window;
use trochoid_key::content_key;
use trochoid_memory::{Heap, Instructions};

/// Which pixels are held against the hull of their palette.
///
/// Whatever the choice, every weight is held against [0, 1], every partition against its sum, and every pixel against the
/// box of its palette; where one of these fails, all pixels around it are judged. That a mix with weights in [0, 1] stays
/// in the hull is a theorem; judging its pixels only guards against a kernel that breaks it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Judging {
    /// Every pixel.
    #[default]
    All,
    /// Every 64th row, for about a hundredth of the time.
    Sampled,
}

content_key!(
    enum Judging {
        All,
        Sampled,
    }
);

/// Which optimizations run; none changes a bit of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// Leave out nodes, ports and channels that no output needs.
    pub demand: bool,
    /// Leave out branches whose weight is proved constant 0 or 1 by interval.
    pub prune: bool,
    /// Compute what depends on constants alone once.
    pub fold: bool,
    /// Compute equal operations, and equal nodes, once.
    pub merge: bool,
    /// Compute per column, per row or per tile what varies no further.
    pub hoist: bool,
    /// Fold operations of the pointwise program into each other, and jump over branches without weight.
    pub fuse: bool,
    /// Run the pointwise program as machine code, where the processor and the system allow it.
    pub compile: bool,
}

content_key!(Switches { demand, prune, fold, merge, hoist, fuse, compile });

impl Switches {
    /// Every optimization.
    pub const ALL: Self =
        Self { demand: true, prune: true, fold: true, merge: true, hoist: true, fuse: true, compile: true };
    /// No optimization.
    pub const NONE: Self =
        Self { demand: false, prune: false, fold: false, merge: false, hoist: false, fuse: false, compile: false };
}

/// How a plan is made and run; never what it computes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Settings {
    /// Which optimizations run.
    pub switches: Switches,
    /// Threads; 0 takes all cores.
    pub threads: usize,
    /// Largest width and height of a tile, pixels; chosen by the plan if `None`.
    pub tile: Option<(usize, usize)>,
    /// Instruction sets that kernels may use.
    pub instructions: Instructions,
    /// Samples of a picture from which on compiling to machine code pays: it takes a few tenths of a millisecond.
    pub compile_from: usize,
    /// Which pixels are held against the hull of their palette.
    pub judge: Judging,
    /// Most memory that a frame may take, bytes: what nodes hold, tiles, and pictures that stay in memory
    /// ([`Plan::memory`](crate::Plan::memory)). By default 16 GiB, or what the program's [`Heap`] is bounded to.
    pub memory_limit: u64,
    /// The part of the picture to evaluate; all of it if `None`.
    pub region: Option<Window>,
    /// Whether the cache keeps what stages fill, where the whole picture is evaluated with one sample a pixel and without
    /// buffers of the caller, so that an edit fills again only what depends on it: for an editor's previews. Takes
    /// 4 bytes a pixel of every channel that is filled, within the cache's limit.
    pub keep: bool,
    /// Whether every plane has bounds on its errors beside it, as channels behind its own.
    pub(crate) bounds: bool,
    /// A stage whose own errors count as none, to see what they make of the bounds.
    pub(crate) exact: Option<NodeId>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            switches: Switches::ALL,
            threads: 0,
            tile: None,
            instructions: Instructions::Best,
            compile_from: 1 << 16,
            judge: Judging::All,
            memory_limit: match Heap::allowed() {
                usize::MAX => 16 << 30,
                allowed => allowed as u64,
            },
            region: None,
            keep: false,
            bounds: false,
            exact: None,
        }
    }
}
