use trochoid_graph::{NodeId, Purpose};
use trochoid_image::Window;
use trochoid_key::content_key;
use trochoid_memory::{Heap, Instructions};

/// Which pixels are checked against the hull of their palette.
///
/// In either case every weight is checked against [0, 1], every partition against its sum, and every pixel against
/// the bounding box of its palette; where one of these checks fails, all pixels around it are judged. It is a theorem
/// that a mix with weights in [0, 1] stays in the hull; judging its pixels only guards against a kernel that breaks
/// it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Judging {
    /// Every pixel.
    #[default]
    All,
    /// Every 64th row, which takes about a hundredth of the time.
    Sampled,
}

content_key!(
    enum Judging {
        All,
        Sampled,
    }
);

/// Which optimizations run. None of them changes a bit of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// Leave out nodes, ports and channels that no output needs.
    pub demand: bool,
    /// Leave out branches whose weight is proved constant 0 or 1 by interval.
    pub prune: bool,
    /// Compute values that depend only on constants once, while planning.
    pub fold: bool,
    /// Compute equal operations, and equal nodes, once.
    pub merge: bool,
    /// Compute values that do not vary per pixel once per column, per row or per tile.
    pub hoist: bool,
    /// Fuse operations of the pointwise program, and jump over branches without weight.
    pub fuse: bool,
    /// Run the pointwise program as machine code, where the processor and the system allow it.
    pub compile: bool,
    /// Fill what filters read far beyond a tile over the whole picture first, and not again for every tile.
    pub hold: bool,
    /// Take the further samples of adaptive sampling at single pixels, not over whole tiles.
    pub sparse: bool,
}

content_key!(Switches { demand, prune, fold, merge, hoist, fuse, compile, hold, sparse });

impl Switches {
    /// Every optimization.
    pub const ALL: Self = Self {
        demand: true,
        prune: true,
        fold: true,
        merge: true,
        hoist: true,
        fuse: true,
        compile: true,
        hold: true,
        sparse: true,
    };
    /// No optimization.
    pub const NONE: Self = Self {
        demand: false,
        prune: false,
        fold: false,
        merge: false,
        hoist: false,
        fuse: false,
        compile: false,
        hold: false,
        sparse: false,
    };
}

/// Planes that a cache keeps from one picture to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// None.
    #[default]
    Nothing,
    /// Those nearest to the outputs, so that an edit refills only what depends on it.
    ForEdits,
    /// Those that are the same at the next frame.
    ForFrames,
}

/// How a plan is made and run. Settings never change what it computes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Settings {
    /// Which optimizations run.
    pub switches: Switches,
    /// Number of threads; 0 takes all cores.
    pub threads: usize,
    /// Largest width and height of a tile, in pixels; the plan chooses if `None`.
    pub tile: Option<(usize, usize)>,
    /// Instruction sets that kernels may use.
    pub instructions: Instructions,
    /// Number of samples in a picture from which compiling to machine code pays: compiling takes a few tenths of a
    /// millisecond.
    pub compile_from: usize,
    /// Which pixels are checked against the hull of their palette.
    pub judge: Judging,
    /// Most memory that a frame may take, in bytes: what nodes hold, tiles, and pictures that stay in memory
    /// ([`Plan::memory`](crate::Plan::memory)). The default is the limit of the program's [`Heap`], or 16 GiB if the
    /// heap has no limit.
    pub memory_limit: u64,
    /// Part of the picture to evaluate; the whole picture if `None`.
    pub region: Option<Window>,
    /// Whether stages may prepare for the region alone, which saves time and memory where one region is evaluated. Leave
    /// it off where one cache serves several regions.
    pub local: bool,
    /// Which of the planes that stages fill the cache keeps. Applies only where the whole picture is evaluated without
    /// buffers of the caller. Takes 4 bytes per sample for every channel filled, within the limit of the cache; call
    /// [`Cache::forget_unused`](crate::Cache::forget_unused) after each picture, to make room.
    pub keep: Keep,
    /// Whether programs record the extremes of weights and of results, for reports.
    pub(crate) audits: bool,
    /// Bytes that the caller's passes take beside the plan, as copies.
    pub(crate) copies: u64,
    /// What stages are prepared for. For bounds, every plane has bounds on its errors beside it, in channels that follow
    /// its own.
    pub(crate) purpose: Purpose,
    /// Stage whose own errors are taken to be 0, which shows how much they contribute to the bounds.
    pub(crate) exact: Option<NodeId>,
}

impl Settings {
    /// Whether every plane has bounds beside it.
    pub(crate) fn bounds(&self) -> bool {
        self.purpose == Purpose::Bounds
    }
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
            local: false,
            keep: Keep::Nothing,
            audits: true,
            copies: 0,
            purpose: Purpose::Pictures,
            exact: None,
        }
    }
}
