use trochoid_image::Window;

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
    /// Run the pointwise program row by row in cache, rather than operation by operation over the tile.
    pub fuse: bool,
}

impl Switches {
    /// Every optimization.
    pub const ALL: Self = Self { demand: true, prune: true, fold: true, merge: true, hoist: true, fuse: true };
    /// No optimization.
    pub const NONE: Self = Self { demand: false, prune: false, fold: false, merge: false, hoist: false, fuse: false };
}

/// How a plan is made and run; never what it computes.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Settings {
    /// Which optimizations run.
    pub switches: Switches,
    /// Threads; 0 takes all cores.
    pub threads: usize,
    /// Largest width and height of a tile, pixels.
    pub tile: (usize, usize),
    /// Most memory for pictures, bytes.
    pub memory_limit: u64,
    /// The part of the picture to evaluate; all of it if `None`.
    pub region: Option<Window>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { switches: Switches::ALL, threads: 0, tile: (256, 16), memory_limit: 16 << 30, region: None }
    }
}
