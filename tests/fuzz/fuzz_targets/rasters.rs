//! Any bytes as a PNG, JPEG or TIFF file: header, metadata, and pixels as a Read takes them.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| trochoid_fuzz::read(&trochoid_fuzz::file("a.png", bytes)));
