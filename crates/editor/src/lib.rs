//! The graph editor: one document, in a window.
//!
//! Data walks one way here too:
//!
//! ```text
//! text ─► Session ─► Sheet ─► panels ─► Actions ─► Session
//!             └────► Worker ─► Seen ─┘
//! ```
//!
//! The document's *text* is the document ([`document::Session`]). Everything that is drawn is read from it, every change is an
//! [`Edit`](document::Edit) of it that undo takes back byte by byte. Pictures are made by a worker ([`evaluate`]), the newest
//! wish first. Panels draw a [`state::State`] and ask by [`actions::Action`]s; none knows another. The editor
//! ([`editor::Editor`]) does what was asked for.

#![cfg_attr(test, allow(clippy::unwrap_used, reason = "a test may panic"))]

pub mod actions;
mod app;
pub mod canvas;
mod choice;
pub mod commands;
pub mod document;
pub mod editor;
pub mod evaluate;
mod field;
mod format;
pub mod layout;
mod notices;
mod plots;
mod prompts;
mod properties;
mod prose;
pub mod reach;
mod recent;
mod refusal;
mod render;
mod report;
pub mod state;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod text_panel;
mod theme;
mod timeline;
mod turns;
mod viewer;
mod watch;
mod waves;
mod window;

pub use app::{OpenError, open};
