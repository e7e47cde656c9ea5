//! A program with a node of its own: `cargo run --release -p trochoid-own-node`.
//!
//! A node is a struct that derives its declaration from its fields, and says what it computes. Documents use it by its
//! name, with the same checks, messages and guarantees as any other node.

mod duotone;

use duotone::Duotone;
use std::sync::OnceLock;
use trochoid::{LookBuilder, Registry, Samples};
use trochoid_graph::NodeType;

static DUOTONE: NodeType = NodeType::of::<Duotone>();

/// All node types of Trochoid, and our own.
fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| trochoid::registry().with(&DUOTONE))
}

const LOOK: &str = r##"{
  "trochoid": 1,
  "working_space": "srgb",
  "nodes": {
    "light": { "type": "ScreenX" },
    "print": { "type": "Duotone", "a": "#1b2a49", "b": "#f3e3c3", "weight": "light", "hardness": 4 }
  },
  "outputs": { "beauty": { "color": "print" } }
}"##;

fn look(text: &str) -> Result<trochoid::Look, trochoid::LookError> {
    LookBuilder::new(text).with_registry(registry()).bind("light").build()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let light = [0.0, 0.4, 0.5, 0.6, 1.0];
    let mut rgb = [0.0; 15];
    look(LOOK)?.shader()?.shade_pixels(light.len(), &[Samples::new(&light)], &mut rgb, 3)?;
    for (light, color) in light.iter().zip(rgb.chunks(3)) {
        println!("light {light}: {color:.3?}");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::ReferenceFrame;

    #[test]
    fn it_is_checked_like_any_other_node() -> Result<(), Box<dyn std::error::Error>> {
        let wrong = LOOK.replace("\"hardness\": 4", "\"hardnes\": 4");
        let told = look(&wrong).map(|_| ()).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(told.contains("did you mean \"hardness\"?"), "{told}");
        assert!(trochoid::registry().get("Duotone").is_none(), "the registry of Trochoid stays as it is");
        Ok(())
    }

    #[test]
    fn it_agrees_with_its_reference() -> Result<(), Box<dyn std::error::Error>> {
        let text = LOOK.replace("\"nodes\"", "\"format\": { \"width\": 65, \"height\": 1 }, \"nodes\"");
        let graph = LookBuilder::new(text.clone()).with_registry(registry()).load()?.graph;
        let reference = ReferenceFrame::new(&graph, "beauty", 1)?;
        let light: Vec<f32> = (0..65).map(|x| x as f32 / 64.0).collect();
        let mut rgb = [0.0; 3 * 65];
        look(&text)?.shader()?.shade_pixels(65, &[Samples::new(&light)], &mut rgb, 3)?;
        for (x, color) in rgb.chunks(3).enumerate() {
            for (found, truth) in color.iter().zip(reference.pixel(x as i64, 0)?) {
                assert!((f64::from(*found) - truth).abs() < 1e-6, "at {x}: {found}, not {truth}");
            }
        }
        Ok(())
    }
}
