//! The one declaration of a node: a struct whose fields are its ports and knobs.
//!
//! `#[derive(Node)]` reads the struct's documentation and attributes, and makes the node's declaration, from which schema,
//! manual, widgets and checks follow, and the code that reads its fields from a document. What a field is follows from its type:
//!
//! | type | item | attribute |
//! |---|---|---|
//! | `One<Kind>`, `Optional<Kind>` | a port with one connection, or with one or none | |
//! | `Many<Kind>` | a port with several | `#[port(1..=64)]` |
//! | `f64`, `i64` | a number, a whole number | `#[knob(default = 1.0, range = 0.0..=9.0)]` |
//! | `bool` | a truth value | `#[knob(default = false)]` |
//! | `[f64; 3]` | a vector, a color | `#[knob(default = [0.0; 3])]`, `#[knob(color)]` |
//! | `String` | a text, a path | `#[knob]`, `#[knob(path)]` |
//! | `Vec<f64>`, `Vec<String>` | a list of numbers, of texts | `#[knob(len = 0..=4)]` |
//! | an enum with `#[derive(Choice)]` | one of its words, the first unless told otherwise | |
//! | `Vec<Record>` | records that derive `Items` | `#[list(1..=8)]` |
//! | a struct that derives `Items` | its fields in this place | `#[items]` |
//!
//! `Option<…>` around a knob's type lets the node see it as unset. `#[knob]` also takes `unit = "m"`, `required`, and the
//! properties `held`, `accuracy`, `scales` and `drawn`, which `trochoid_graph::Knob` explains.

mod choice;
mod docs;
mod field;
mod items;
mod node;
mod outputs;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Makes of a struct the declaration of a node, and what reads its fields.
///
/// The struct's documentation is the node's: what it does in one sentence, then the sections `# Formula`, `# Edge cases` and
/// `# Source`. `#[node(end = Back, revision = 1, outputs = Out)]` names its end, its revision and the enum of its outputs;
/// a node with one output may declare it there, `output(mask: Kind::MASK = "What it holds.")`.
/// `#[also_called("Lerp", "Dissolve")]` lists words of other programs for its job, `#[also_called("Crop" => "its \"fit\"")]`
/// with the way to do it.
#[proc_macro_derive(Node, attributes(node, also_called, port, knob, list, items))]
pub fn node(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    node::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Makes of a struct a group of ports and knobs: the records of a list, or what several nodes share.
#[proc_macro_derive(Items, attributes(port, knob, list, items))]
pub fn items(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    items::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Makes of an enum the words of a knob, in snake case; `#[word("…")]` says another one.
#[proc_macro_derive(Choice, attributes(word))]
pub fn choice(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    choice::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}

/// Makes of an enum the outputs of a node, each with its kind, `#[output(Kind::MASK)]`, and its documentation as help.
#[proc_macro_derive(Outputs, attributes(output))]
pub fn outputs(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    outputs::derive(&input).unwrap_or_else(syn::Error::into_compile_error).into()
}
