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
//! Other renderers bind their own passes ([`Buffers`]) in place of nodes, or evaluate batches of shading samples
//! ([`Look`]).
//!
//! # Features
//!
//! All features in this table are on by default. With `default-features = false`, the crate consists of the back end,
//! the engine, and the nodes that need nothing but the picture, which suffices for a renderer that binds its own
//! passes. A document with a node of a disabled feature is refused like one with an unknown node.
//!
//! | feature | provides |
//! |---|---|
//! | `scene` | cameras, lights, meshes, Render, and all passes of a view |
//! | `sea` | seas, spray, and what they carry; implies `scene` |
//! | `io` | Read, Decompose, Texture, ViewFromPasses, CryptoMask, writing of files, and [`certificate`]; implies `scene` |
//! | `jit` | machine code for pointwise programs; without it they run as compiled kernels, with bit-identical results |
//!
//! The feature `machine`, which is off by default, provides `memory_share`, a memory limit for this machine.

mod access;
pub mod accuracy;
mod asked;
#[cfg(feature = "io")]
pub mod certificate;
mod costs;
mod display;
#[cfg(feature = "io")]
mod exr_layer;
#[cfg(feature = "io")]
mod files;
#[cfg(feature = "io")]
mod inputs;
#[cfg(feature = "io")]
mod join;
mod judge;
#[cfg(feature = "io")]
mod layers;
mod load;
mod look;
#[cfg(feature = "machine")]
mod machine;
#[cfg(feature = "io")]
mod marks;
#[cfg(feature = "io")]
mod naming;
#[cfg(feature = "io")]
mod output;
#[cfg(feature = "io")]
mod output_file;
mod recipe;
mod report;
#[cfg(feature = "io")]
mod resume;
mod stability;
#[cfg(feature = "io")]
mod store;
#[cfg(feature = "io")]
mod stream;

pub use access::refused_files;
#[cfg(feature = "io")]
pub use access::refused_outputs;
pub use costs::{Cost, Costs, MeasureError, measure};
#[cfg(feature = "io")]
pub use files::{
    check_destination, check_destinations, check_replaced, check_replaced_by, claim, target, write_guarded, write_whole,
};
#[cfg(feature = "io")]
pub use inputs::InputFiles;
#[cfg(feature = "io")]
pub use join::{JoinError, Joined, join};
pub use judge::{Miss, guarantee, held, misses, requirement};
#[cfg(feature = "io")]
pub use layers::outputs_lost;
pub use load::{LoadError, Loaded, load, load_palette, load_within, missing_files, parse, parse_within, registry};
pub use look::{LookBuilder, LookError};
#[cfg(feature = "machine")]
pub use machine::memory_share;
#[cfg(feature = "io")]
pub use marks::{Form, GENERATOR, TABLE, is_ours, mark, marks};
#[cfg(feature = "io")]
pub use naming::{CompanionPattern, UNNAMED_FILE, companion_files, output_files};
#[cfg(feature = "io")]
pub use output::write_output;
#[cfg(feature = "io")]
pub use output_file::{ForeignFile, NameFault, NamePlace, NoDestination, OutputError, OutputFile};
pub use recipe::{PackError, PackedRecipe, RecipeInfo, Rounding};
#[cfg(feature = "io")]
pub use recipe::{Recipe, RecipeError, RecipeReader, RecipeScratch};
pub use report::{RunReport, RunStatus, frame_report};
#[cfg(feature = "io")]
pub use resume::Fingerprints;
pub use stability::{stability, stability_of, step_errors_of};
#[cfg(feature = "io")]
pub use store::{FolderStore, NoStore, StoreUses};
#[cfg(feature = "io")]
pub use stream::FileSink;
pub use trochoid_engine::{
    Account, AccuracyLimit, Audit, Batch, BindingFault, Blame, BufferFault, Buffers, Cache, Certified, CertifiedPixels,
    Certifier, Channels, Distribution, EvalError, Evidence, Fate, ForeignError, Frame, HeldPlanes, Hull, Illegal,
    InspectedPixel, Instructions, Interval, Judging, Keep, LeftOut, Look, MemoryAccount, MemoryConsumer, Monitor,
    NodeReport, NotPointwise, Phases, Picture, PictureError, Pictures, Plan, PlanError, ProofStep, ReferenceError,
    ReferenceFrame, ReferencePixel, Samples, SamplesMut, Settings, ShadeError, Shader, Silent, Sink, Slot, State,
    StoredSample, Storing, Switches, paint,
};
pub use trochoid_graph::{
    Accepts, Access, AccessViolation, Alias, Animated, Arity, BadData, Channel, CheckedGraph, CheckedNode, ContentKey,
    Control, CurveHandle, CurveKey, DataPlace, Declaration, Diagnostic, DocumentKnob, DocumentPlace, Dynamics, End,
    FORMAT_VERSION, Failure, Figure, Files, FrameTimes, GroupUse, Guarantee, Harmonic, INPUT_ACCEPTS, Interpolation,
    Item, Key, Kind, Knob, KnobDefault, KnobType, LengthDistribution, List, MAX_BYTES, Means, MemoryUse, NodeError,
    NodeId, NodeType, Offer, Omission, Output as NodeOutput, OutputSpec, PaletteColor, PaletteUse, Paths, Placing,
    Port, Precision, Profile, ProfileLine, ProfilePoint, REFUSALS, Reached, Recipes, Refusal, RefusedFile, Registry,
    Relation, Repair, Right, Role, Segment, Settled, Severity, Source, Spectrum, Stability, StabilityMap,
    StepErrorGroup, StepErrorRow, StepErrors, Store, StoredEntry, Term, Tolerance, Values, Verdict, Work, counted,
    escape_frame, expand_frame, expected, folders_to_allow, in_bytes, input_accepts, input_kind, nearest,
    one_frame_pattern, quoted, quoted_path, refusal, refusals, resolved, schema, smallest_node, smallest_record,
    split_frame, stand_in,
};
pub use trochoid_image::{
    Format, FormatError, HexError, Plane, Rgb, Shading, Window, WorkingSpace, oklab, oklch, parse_hex, shown_oklch,
    srgb_decode, srgb_encode,
};
#[cfg(feature = "io")]
pub use trochoid_io as io;
#[cfg(feature = "io")]
pub use trochoid_io::{clear_partial_files, discard_partial_files};
pub use trochoid_memory::{Exhausted, Heap, emptied, exit_at_once};

/// Version of Trochoid.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
