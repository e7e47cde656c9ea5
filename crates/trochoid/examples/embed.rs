//! Use of Trochoid in another renderer, which shades points in batches, or hands over whole passes.
//!
//! Run it with `cargo run --release -p trochoid --example embed`.

use trochoid::{Cache, Format, LookBuilder, Samples, SamplesMut, Silent};

/// The look: a palette and two passes. Until the renderer supplies them, gradients stand in for `light` and `rim`.
const LOOK: &str = r##"{
  "trochoid": 1,
  "working_space": "srgb",
  "palette": { "deep": "#274e53", "crest": "#839191", "foam": "#ece6c2", "mist": "#8b9aa1" },
  "nodes": {
    "light": { "type": "ScreenX" },
    "rim": { "type": "ScreenY" },
    "water": {
      "type": "Ramp", "weight": "light",
      "stops": [
        { "at": 0, "color": "palette.deep" }, { "at": 0.6, "color": "palette.crest" }, { "at": 1, "color": "palette.foam" }
      ]
    },
    "beauty": { "type": "Mix", "a": "water", "b": "palette.mist", "weight": "rim" }
  },
  "outputs": { "beauty": { "color": "beauty" } }
}"##;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Planned once. The mist is an input too: it changes from frame to frame.
    let look = LookBuilder::new(LOOK).bind("light").bind("rim").bind("palette.mist").build()?;

    // Samples: one shader for each thread. The light lies in the renderer's own structures, three floats apart.
    let mut shader = look.shader()?;
    let points = [0.0, 7.0, 7.0, 0.3, 7.0, 7.0, 1.0, 7.0, 7.0];
    let (rim, mist) = ([0.0, 0.0, 1.0], [0.25, 0.35, 0.4]);
    let mut rgb = [[0.0; 3]; 3];
    let mut inputs = vec![Samples::strided(&points, 3), Samples::new(&rim)];
    inputs.extend(mist.iter().map(Samples::uniform));
    shader.shade(3, &inputs, &mut rgb.each_mut().map(|channel| SamplesMut::new(channel)))?;
    let [r, g, b] = rgb;
    for i in 0..3 {
        println!("sample: light {} rim {} -> {:.4} {:.4} {:.4}", points[3 * i], rim[i], r[i], g[i], b[i]);
    }

    // Images: the passes of a whole picture.
    let light: Vec<f32> = (0..64 * 32).map(|i| (i % 64) as f32 / 63.0).collect();
    let rim: Vec<f32> = (0..64 * 32).map(|i| ((i / 64) as f32 / 31.0).powi(4)).collect();
    let mut passes = vec![Samples::new(&light), Samples::new(&rim)];
    passes.extend(mist.iter().map(Samples::uniform));
    let frame = look.picture(Format::new(64, 32, 1)?, &passes, &mut Cache::new(), &Silent)?;
    let picture = &frame.pictures[0];
    println!("image: {} pixels, {} values that are no number", picture.audit.pixels, picture.audit.nan_count);
    for node in &frame.nodes {
        println!("  {} ({}): {} {:.6} s", node.name, node.ty, node.state.name(), node.seconds);
    }
    Ok(())
}
