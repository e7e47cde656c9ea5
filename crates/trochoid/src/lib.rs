//! A compositor whose pictures cannot leave their palette, with the sea built in.
//!
//! Load a document, plan an output at a frame, evaluate it:
//!
//! ```
//! use trochoid::{Buffers, Cache, Plan, Settings, Silent, parse};
//!
//! let document = r##"{
//!   "trochoid": 1,
//!   "format": { "width": 4, "height": 1 },
//!   "nodes": {
//!     "across": { "type": "ScreenX" },
//!     "ramp": { "type": "Mix", "a": "#000000", "b": "#ffffff", "weight": "across" }
//!   },
//!   "outputs": { "beauty": { "color": "ramp" } }
//! }"##;
//! let loaded = parse("ramp.json", document, std::path::Path::new("."), &[])?;
//! let plan = Plan::new(&loaded.graph, &["beauty"], 1, &[], &Settings::default())?;
//! let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent)?;
//! let picture = &frame.pictures[0];
//! assert_eq!(picture.planes[0].samples(), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);
//! assert_eq!(picture.audit.hull_exits, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Another renderer binds its own passes ([`Buffers`]) in place of nodes, or evaluates batches of shading
//! samples ([`ShadingPlan`]).

mod files;
mod judge;
mod load;
mod output;
mod report;
mod resume;
mod stability;
mod stream;

pub use files::{check_destination, write_whole};
pub use judge::{Miss, guarantee, held, misses, requirement};
pub use load::{LoadError, Loaded, load, missing_files, parse, registry};
pub use output::{OutputError, OutputFile, output_files, write_output};
pub use report::{RunReport, RunStatus, frame_report};
pub use resume::Fingerprints;
pub use stability::stability;
pub use stream::FileSink;
pub use trochoid_engine::{
    Audit, Buffers, Cache, Certified, Certifier, Distribution, EvalError, Frame, Instructions, Judging, LeftOut,
    Monitor, NodeReport, Phases, Picture, Plan, PlanError, ReferenceError, ReferenceFrame, Settings, ShadingPlan,
    Silent, Sink, State, Switches,
};
pub use trochoid_graph::{
    Accepts, Arity, CheckedGraph, CheckedNode, Declaration, Default as KnobDefault, Diagnostic, End, Figure, Guarantee,
    Item, Kind, Knob, NodeId, NodeType, OutputSpec, Port, Precision, REFUSALS, Refusal, Registry, Relation, Severity,
    Stability, StabilityMap, Takes, Verdict, Work, expected, nearest, refusal, schema,
};
pub use trochoid_image::{Format, Plane, Rgb, Shading, Window, WorkingSpace};
pub use trochoid_io as io;
pub use trochoid_io::discard_partial_files;

/// The version of Trochoid.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
