//! Tests of plans, rules and certificates, on a few node types of their own.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod filters;
mod inspect;
mod mutation;
mod nodes;
mod rules;
