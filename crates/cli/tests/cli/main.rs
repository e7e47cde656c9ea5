//! The binary from a user's point of view: exit codes, stdout and stderr, and the files that appear.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod access;
mod bad_images;
mod cache;
mod certify;
mod commands;
#[cfg(unix)]
mod edit;
mod examine;
mod explain;
mod export;
mod files;
mod fit;
mod hosted;
#[cfg(target_os = "linux")]
mod hostile;
mod job;
mod kills;
#[cfg(unix)]
mod memory;
mod overwrite;
mod page;
mod painting;
mod palette;
mod plan;
mod preview;
mod recipes;
mod recolor;
mod refusals;
#[cfg(unix)]
mod remedies;
mod render;
mod resume;
mod scene;
mod share;
mod sheet;
mod stability;
#[path = "../../../../tests/tests/support/stored.rs"]
mod stored;
mod streams;
mod tiles;
mod told;
mod view;
mod warnings;
