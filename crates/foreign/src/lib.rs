//! Shades samples in memory of other languages: pointers with strides in bytes, as C and Python have them.
//!
//! The C interface stands on it. It decides where a sample is, and nothing else; what is computed is
//! [`trochoid::Shader`]'s.

mod pointers;
mod shader;

pub use pointers::{Input, Output};
pub use shader::ForeignShader;
