//! Any bytes as a certificate of an existing small picture.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use std::path::PathBuf;
use std::sync::OnceLock;
use trochoid::certificate::{Choice, Request, verify};
use trochoid::{Buffers, Cache, OutputFile, Plan, Settings, Silent, write_output};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    trochoid_fuzz::mutate_json(data, size, max_size, seed)
});

const DOCUMENT: &str = r##"{ "trochoid": 1, "format": { "width": 16, "height": 9 },
    "nodes": { "across": { "type": "ScreenX" }, "mix": { "type": "Mix", "a": "#123", "b": "#fed", "weight": "across" } },
    "outputs": { "beauty": { "color": "mix" } } }"##;

/// Returns the picture that certificates are verified against.
fn image() -> &'static PathBuf {
    static IMAGE: OnceLock<PathBuf> = OnceLock::new();
    IMAGE.get_or_init(|| {
        let graph = trochoid::parse("a.json", DOCUMENT, trochoid_fuzz::folder(), &[]).expect("valid").graph;
        let plan = Plan::new(&graph, &[], 1, &[], &Settings::default()).expect("planned");
        let frame = plan.evaluate(&Buffers::new(), &mut Cache::new(), &Silent).expect("evaluated");
        let file = OutputFile { path: trochoid_fuzz::folder().join("a.png"), outputs: vec![0] };
        write_output(&graph, &frame, &file, &[]).expect("written");
        file.path
    })
}

fuzz_target!(|bytes: &[u8]| {
    let image = image();
    let certificate = trochoid_fuzz::file("a.certificate.json", bytes);
    let choice = Choice::Some(2);
    let request =
        Request { certificate: &certificate, image, choice, seed: 1, key: None, document: None, access: None };
    match verify(&request, &Silent) {
        Ok(_) => {}
        Err(error) => assert!(error.to_string().len() > 10, "an error without a text"),
    }
});
