//! Use of Trochoid in another renderer, which binds its own passes as images, or shades points in batches.
//!
//! Run it with `cargo run --release -p trochoid --example embed`.

use std::path::Path;
use trochoid::{Buffers, Cache, Plan, Settings, ShadingPlan, Silent, parse};

/// The look: a palette and two passes. Until the renderer supplies them, gradients stand in for `light` and `rim`.
const LOOK: &str = r##"{
  "trochoid": 1,
  "format": { "width": 64, "height": 32 },
  "working_space": "srgb",
  "nodes": {
    "light": { "type": "ScreenX" },
    "rim": { "type": "ScreenY" },
    "water": {
      "type": "Ramp", "weight": "light",
      "stops": [{ "at": 0, "color": "#274e53" }, { "at": 0.6, "color": "#839191" }, { "at": 1, "color": "#ece6c2" }]
    },
    "beauty": { "type": "Mix", "a": "water", "b": "#8b9aa1", "weight": "rim" }
  },
  "outputs": { "beauty": { "color": "beauty" } }
}"##;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let graph = parse("look", LOOK, Path::new("."), &[])?.graph;
    let settings = Settings::default();

    // Images: the renderer's own passes replace two nodes; nodes that only these needed are left out.
    let light: Vec<f32> = (0..64 * 32).map(|i| (i % 64) as f32 / 63.0).collect();
    let rim: Vec<f32> = (0..64 * 32).map(|i| ((i / 64) as f32 / 31.0).powi(4)).collect();
    let plan = Plan::new(&graph, &["beauty"], 1, &["light", "rim"], &settings)?;
    let buffers = Buffers::new().with("light", &[&light]).with("rim", &[&rim]);
    let frame = plan.evaluate(&buffers, &mut Cache::new(), &Silent)?;
    let picture = &frame.pictures[0];
    println!(
        "image: {} pixels, {} control colors, {} outside their hull",
        picture.audit.pixels, picture.control_count, picture.audit.hull_exits
    );
    for node in &frame.nodes {
        println!("  {} ({}): {} {:.6} s", node.name, node.ty, node.state.name(), node.seconds);
    }

    // Shading samples: structures of arrays in and out, on any thread, without a picture.
    let shading = ShadingPlan::new(&graph, "beauty", 1, &["light", "rim"], &settings)?;
    let (light, rim) = ([0.0, 0.3, 1.0], [0.0, 0.0, 1.0]);
    let (mut r, mut g, mut b) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    let buffers = Buffers::new().with("light", &[&light]).with("rim", &[&rim]);
    shading.evaluate(&buffers, 3, &mut [&mut r, &mut g, &mut b])?;
    for i in 0..3 {
        println!("sample: light {} rim {} -> {:.4} {:.4} {:.4}", light[i], rim[i], r[i], g[i], b[i]);
    }
    Ok(())
}
