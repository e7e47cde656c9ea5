//! The meaning of graphs: kinds of value, the contract of nodes, documents and their validation.
//!
//! A *document* is JSON: nodes by name, each with a type, knobs and connections, and outputs. Checking it
//! against a [`Registry`] of node types gives a [`CheckedGraph`], or every fault as a [`Diagnostic`].
//!
//! A graph is evaluated frame by frame. At a frame every knob has one value. The output of a node is a value of one
//! of a closed set of [`Kind`]s. Front-end nodes make Fields and masks by any mathematics; back-end nodes make
//! Colors by convex operations only, which they express as a [`Program`] of a closed set of operations. No operation
//! makes a weight from a color, and colors are combined only by weights that are ≥ 0 and sum to 1. So every color of
//! an output lies in the convex hull of the control colors, whatever the passes contain.

// Derived code names this crate by its name.
extern crate self as trochoid_graph;

mod access;
mod animated;
mod bound;
mod bounding;
mod build;
mod check;
mod checked;
mod declare;
#[cfg(doctest)]
mod derive_tests;
mod diagnostic;
mod document;
mod expand;
mod faults;
mod fields;
mod formulas;
mod frame;
mod kind;
mod literal;
mod lowering;
mod manual;
mod memory;
mod node;
mod node_error;
mod opening;
mod profile;
mod program;
mod recipe;
mod record;
mod reference;
mod refusal;
mod registry;
mod scaling;
mod schema;
mod segment;
mod settled;
mod shell;
mod span;
mod spanned;
mod spectrum;
mod stability;
mod stage_io;
mod store;
mod terms;
mod tolerance;
mod work;

pub use access::{Access, AccessViolation, RefusedFile, Right, folders_to_allow, refusals, resolved};
pub use animated::{Animated, CurveKey, Interpolation};
pub use bound::{Bound, LITERAL, NoBound, REFERENCE};
pub use bounding::{Bounding, Spans};
pub use build::{Builder, Mask, Value, Weights, load, load_color};
pub use check::{FORMAT_VERSION, check, expected};
pub use checked::{
    CheckedGraph, CheckedNode, DocumentKnob, FileState, GroupUse, Guarantee, OutputSpec, PaletteColor, PaletteUse,
    Precision, file_states,
};
pub use declare::{
    Arity, Declaration, End, Files, Item, Knob, KnobDefault, KnobType, List, Offer, Output, Placing, Port, Role,
};
pub use diagnostic::{Diagnostic, DocumentPlace, Means, Severity, Statement, nearest};
pub use document::{Document, MAX_BYTES, MAX_FILE_BYTES, MAX_NODES};
pub use expand::{INPUT_ACCEPTS, input_accepts, input_kind};
pub use faults::{Check, Consumer, Fault, GraphContext, Upstream, one_of};
pub use fields::{
    Accepted, Choice, Connected, ItemName, Items, Many, One, Optional, OutputSet, PortId, ReadPort, ReadSetting,
    Reader, SoleOutput, port,
};
#[doc(hidden)]
pub use fields::{count_items, join_items};
pub use formulas::{Formula, FormulaFault, Formulas};
pub use frame::{FrameContext, escape_frame, escape_remedy, expand_frame, one_frame_pattern, split_frame};
pub use kind::{Accepts, Kind};
pub use literal::{LITERAL_SUM_TOLERANCE, literal, literal_error};
pub use lowering::Lowering;
pub use manual::{counted, smallest_node, smallest_record, stand_in};
pub use memory::{MemoryContext, MemoryUse, in_bytes};
pub use node::{
    Body, Computes, Declare, Dynamics, Handle, Node, NodeType, Omission, Paths, Pointwise, Prepared, Rate, Repair,
    SharedResult, Stage, Variance,
};
pub use node_error::{BadData, DataPlace, Failure, NodeError};
pub use profile::{FrameTimes, Profile, ProfileLine, ProfilePoint, Reached};
pub use program::{Color, Op, Partition, Program, Scalar, Slot, Type};
pub use recipe::{Control, Recipes};
pub use record::{NodeId, Record, Setting, Source, Values};
pub use reference::{Reference, References};
pub use refusal::{REFUSALS, Refusal, refusal};
pub use registry::Registry;
pub use schema::schema;
pub use segment::{CurveHandle, Segment};
pub use settled::Settled;
pub use shell::{quoted, quoted_path};
pub use span::Span;
pub use spanned::{MAX_DEPTH, MAX_VALUES};
pub use spectrum::{Harmonic, LengthDistribution, Spectrum};
pub use stability::{Figure, Relation, Stability, StabilityMap, StepErrorGroup, StepErrorRow, StepErrors, Verdict};
pub use stage_io::{Block, Connection, Inputs, Outputs, Pool, Prepare, Purpose};
pub use store::{Store, StoredEntry};
pub use terms::{Alias, OUTPUT_WORDS, Term};
pub use tolerance::Tolerance;
pub use trochoid_derive::{Choice, Items, Node, Outputs};
pub use trochoid_image::{Channel, ChannelSet};
pub use trochoid_key::{ContentKey, Key, KeyHasher, content_key};
pub use work::Work;
