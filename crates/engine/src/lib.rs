//! Plans and evaluates checked graphs: finds what is needed, prunes, fuses, fills tiles on all cores, and counts the
//! pixels that left the hull.
//!
//! The engine knows no node. It sees the pointwise program to which back-end nodes lower, and stages that prepare
//! once per frame and then fill tiles. [`Plan::new`] decides what is needed, in which order, and why the rest is left
//! out; [`Plan::evaluate`] returns a [`Frame`]. The output is bit-identical for every tile size, number of threads,
//! and switch of [`Switches`]. [`ReferenceFrame`] is the slow f64 evaluator against which everything is checked.
//!
//! Data flows one way: `planning` makes plans, `running` executes them. Both build on the crate `trochoid-kernel`,
//! which compiles programs and runs them over chunks of samples, and on `rules`, which derive further facts about
//! each operation (interval, error and blame). `look` runs a plan over a renderer's own samples instead of a picture.

mod judge;
mod look;
mod planning;
mod rules;
mod running;
mod settings;

pub use look::{Batch, Illegal, Look, NotPointwise, PictureError, Samples, SamplesMut, ShadeError, Shader, Slot};
pub use planning::explain::{Account, Channels, Evidence, Fate, ProofStep};
pub use planning::left_out::LeftOut;
pub use planning::plan::{BindingFault, Plan, PlanError};
pub use planning::pointwise::PointwiseProgram;
pub use rules::interval::Interval;
pub use running::buffer_fault::BufferFault;
pub use running::buffers::Buffers;
pub use running::certify::{AccuracyLimit, Certified, CertifiedPixels, Certifier, Distribution};
pub use running::foreign::ForeignError;
pub use running::frame::{EvalError, Frame, Monitor, NodeReport, Phases, Picture, Silent, State};
pub use running::held::HeldPlanes;
pub use running::inspect::{Blame, InspectedPixel, Inspection};
pub use running::memory::{MemoryAccount, MemoryConsumer, Pictures};
pub use running::prepare::Cache;
pub use running::reference::{ReferenceError, ReferenceFrame, ReferencePixel};
pub use running::run::Sink;
pub use settings::{Judging, Keep, Settings, Switches};
pub use trochoid_memory::Instructions;
pub use trochoid_weights::{Apportioner, Audit, Hull, StoredSample, Storing, paint};

/// What the tests of this crate see beside its interface. They stand outside, in `tests/engine`, so that the engine is
/// not compiled a second time for them. Nothing of it is part of the interface.
#[doc(hidden)]
pub mod inside {
    use trochoid_graph::{Op, Slot};
    use trochoid_kernel::{CompiledProgram, Plane, TakeRow};

    /// Number of channels by which the bounds of an output follow its values.
    pub const BOUNDS: usize = crate::planning::bounds::BOUNDS;

    /// Bounds an operation's result from the intervals of its operands and of planes.
    pub fn interval(
        op: &Op,
        of: &dyn Fn(u32) -> Vec<crate::Interval>,
        slot: &dyn Fn(&Slot, usize) -> crate::Interval,
    ) -> Vec<crate::Interval> {
        crate::rules::interval::interval(op, of, slot)
    }

    /// Computes values and bounds of a program over a tile of one sample.
    pub fn trace(program: &CompiledProgram, planes: &[Plane<'_>], take: TakeRow<'_>) {
        crate::running::certify::Trace::new(program).tile(planes, 1, 1, take);
    }

    /// Returns the program of each pass, which tests break.
    pub fn programs<'p>(plan: &'p mut crate::Plan<'_>) -> impl Iterator<Item = &'p mut CompiledProgram> {
        plan.passes.iter_mut().map(|pass| &mut pass.program)
    }

    /// Returns how often colors are mixed, one after the other, in the first output.
    pub fn mix_levels(plan: &crate::Plan<'_>) -> usize {
        plan.outputs[0].mix_levels
    }
}
