//! Any bytes as an EXR file: header, metadata, and pixels as a Read takes them.
#![no_main]

use libfuzzer_sys::fuzz_target;

/// First bytes of every EXR, which the fuzzer need not find by itself.
const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

fuzz_target!(|bytes: &[u8]| {
    let mut whole = MAGIC.to_vec();
    whole.extend(bytes.strip_prefix(&MAGIC).unwrap_or(bytes));
    trochoid_fuzz::read(&trochoid_fuzz::file("a.exr", &whole));
});
