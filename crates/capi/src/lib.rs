//! The C interface: looks, shaders and pictures for renderers in C and C++ (`include/trochoid.h`).
//!
//! It translates between C and [`trochoid::Look`], and decides nothing itself. Foreign pointers need `unsafe`, so this crate
//! may use it, and has nothing else in it. Every function catches panics: none may cross into C.

#![allow(non_camel_case_types, reason = "names of C")]
// The contract of each function is in its documentation, which becomes the header.
#![allow(rustdoc::broken_intra_doc_links, reason = "they are comments of C, where brackets are no links")]
#![allow(clippy::missing_safety_doc, reason = "it would be the same sentence everywhere")]

mod batch;
mod error;
mod look;
mod options;
mod picture;
mod shader;
mod status;
mod text;
mod version;

pub use batch::{trochoid_in, trochoid_out};
pub use error::*;
pub use look::*;
pub use options::{trochoid_options, trochoid_options_init};
pub use picture::*;
pub use shader::*;
pub use status::{trochoid_illegal, trochoid_kind, trochoid_status};
pub use version::*;
