//! Ends of ranges and hostile data: whatever a document says, it is refused with a reason, or its pictures are right.

mod ends;
mod graphs;

#[test]
fn a_step_that_no_number_counts_is_no_step_too_many() {
    let text = r#"{ "trochoid": 1, "format": { "width": 8, "height": 4 }, "frames": { "fps": 1e-300, "last": 10 }, "nodes": {
        "camera": { "type": "Camera", "position": [0, 23, 0], "target": [0, 2, 0] },
        "sea": { "type": "ToonSea", "columns": 20, "rows": 12, "rift": "sum",
                 "bursts": [{ "path": [8, 7, 8, 3, 8, 3, 8, 3], "height": 0.1, "end": 0 }] },
        "seen": { "type": "Render", "camera": "camera", "surfaces": ["sea"] },
        "height": { "type": "Height", "view": "seen" } }, "outputs": { "height": { "field": "height" } } }"#;
    trochoid::parse("a.json", text, std::path::Path::new("."), &[]).unwrap();
}
