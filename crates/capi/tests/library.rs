//! The shared library that a plain build makes.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[test]
fn programs_find_the_shared_library_by_its_name() {
    let name = "libtrochoid_capi.so";
    let test = std::env::current_exe().unwrap();
    let library = std::fs::read(test.with_file_name(name)).unwrap();
    // Nothing but the SONAME has the file's name in the library.
    let text = format!("\0{name}\0");
    assert!(library.windows(text.len()).any(|bytes| bytes == text.as_bytes()), "the library has no SONAME");
}
