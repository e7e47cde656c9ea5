//! Derive macros that declare a node as a struct whose fields are its ports and knobs.
//!
//! `#[derive(Node)]` reads the struct's documentation and attributes. It makes the node's declaration, from which
//! schema, manual, widgets and checks follow, and the code that reads the fields from a document. The type of a field
//! decides what it is:
//!
//! | type | item | attribute |
//! |---|---|---|
//! | `One<Kind>`, `Optional<Kind>` | a port with one connection, or with at most one | |
//! | `Many<Kind>` | a port with several connections | `#[port(1..=64)]` |
//! | `f64`, `i64` | a number, a whole number | `#[knob(default = 1.0, range = 0.0..=9.0)]` |
//! | `bool` | a Boolean value | `#[knob(default = false)]` |
//! | `[f64; 3]` | a vector, a color | `#[knob(default = [0.0; 3])]`, `#[knob(color)]` |
//! | `String` | a string, a path | `#[knob]`, `#[knob(path)]` |
//! | `Vec<f64>`, `Vec<String>` | a list of numbers, of strings | `#[knob(len = 0..=4)]` |
//! | an enum with `#[derive(Choice)]` | one of its words, by default the first | |
//! | `Vec<Record>` | records that derive `Items` | `#[list(1..=8)]` |
//! | a struct that derives `Items` | its fields, inserted here | `#[items]` |
//!
//! With `Option<…>` around its type, a knob may be unset. `#[knob]` also takes `unit = "m"`, `required`, `places = X` (what
//! it sets in the world, a `trochoid_graph::Placing`), and the properties `hold_keys`, `accuracy`, `affects_cost`,
//! `in_pixels` and `picture_height`, which `trochoid_graph::Knob` explains.

mod choice;
mod docs;
mod field;
mod items;
mod node;
mod outputs;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Derives the declaration of a node, and the code that reads its fields, from a struct.
///
/// The documentation of the struct becomes that of the node: one sentence, then the sections `# Formula`,
/// `# Edge cases` and `# Source`. `#[node(pointwise, end = Back, revision = 1, outputs = Out)]` sets its body
/// (`pointwise` or `stage`), its end, its revision and the enum of its outputs; a node with one output may declare it
/// there: `output(mask: Kind::MASK = "Help.")`.
///
/// A node that is not valid with what its items require alone has an `example`: more entries of it, as JSON, for the manual.
/// Other nodes are called "sea", "camera", "view", "light", "weights", "direction", "uv", "boat" and "shore" there.
#[proc_macro_derive(Node, attributes(node, also_called, port, knob, list, items))]
pub fn node(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    node::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Derives a group of ports and knobs from a struct: the records of a list, or items that several nodes share.
#[proc_macro_derive(Items, attributes(port, knob, list, items))]
pub fn items(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    items::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Derives the words of a knob from an enum, in snake case; `#[word("…")]` sets another word.
#[proc_macro_derive(Choice, attributes(word))]
pub fn choice(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    choice::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Derives the outputs of a node from an enum; each has its kind, `#[output(Kind::MASK)]`, and its documentation as
/// help.
#[proc_macro_derive(Outputs, attributes(output))]
pub fn outputs(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    outputs::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}
