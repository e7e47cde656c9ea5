//! The graph editor: one document, in a window.
//!
//! Data flows in one direction:
//!
//! ```text
//! text ─► Session ─► Sheet ─► panels ─► Actions ─► Session
//!             └────► Worker ─► Seen ─┘
//! ```
//!
//! The *text* is the document ([`document::Session`]). Everything drawn is derived from it; every change is an
//! [`Edit`](document::Edit) of the text, which undo reverts byte for byte. A worker ([`evaluate`]) evaluates pictures,
//! newest request first. Panels draw a [`state::State`] and request [`actions::Action`]s; no panel depends on another.
//! The editor ([`editor::Editor`]) performs the actions.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

pub mod actions;
mod app;
pub mod canvas;
mod choice;
pub mod commands;
mod curves;
mod dialogs;
pub mod document;
pub mod editor;
pub mod evaluate;
mod faults;
mod field;
mod follow;
mod fonts;
mod format;
mod help;
pub mod layout;
mod layouts;
mod notices;
mod palette;
mod picker;
mod plots;
mod presets;
mod prompts;
mod properties;
mod prose;
pub mod reach;
mod recent;
mod refusal;
mod render;
mod report;
mod shipped;
pub mod state;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod text_panel;
mod theme;
mod timeline;
pub mod transform;
mod turns;
mod viewer;
mod watch;
mod waves;
mod welcome;
mod window;

pub use app::{OpenError, open};
