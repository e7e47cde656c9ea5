//! Documents that check accepts, evaluated at 8 × 8: no panic, and no color outside its palette.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    trochoid_fuzz::mutate_json(data, size, max_size, seed)
});

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Ok(loaded) = trochoid::parse("a.json", text, trochoid_fuzz::folder(), &[]) {
        trochoid_fuzz::evaluate(&loaded.graph);
    }
});
