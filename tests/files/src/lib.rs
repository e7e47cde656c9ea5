//! Holds the tests of image files; see `tests/files/main.rs`.
