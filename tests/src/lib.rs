//! Holds the tests across crates; see `tests/main.rs`.
