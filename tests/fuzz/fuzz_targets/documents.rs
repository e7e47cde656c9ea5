//! Any bytes as a document: checked, hashed and planned, without a panic.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    trochoid_fuzz::mutate_json(data, size, max_size, seed)
});

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match trochoid::parse("a.json", text, trochoid_fuzz::folder(), &[]) {
        Ok(loaded) => {
            let graph = &loaded.graph;
            let hash = graph.document_hash();
            assert_eq!(hash.len(), 64);
            let frame = graph.frames().0;
            let _ = trochoid::Plan::new(graph, &[], frame, &[], &trochoid::Settings::default())
                .map(|plan| plan.memory(trochoid::Pictures::Whole).total());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
