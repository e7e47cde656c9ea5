//! Tests of WaterlineFoam.

use crate::testing::{Frame, frame, graph, refused, view};
use std::path::Path;
use trochoid_graph::{Channel, Reference};

#[test]
fn one_camera_sees_both_views() {
    let nodes = |other: &str| {
        format!(
            r#""a": {{ "type": "Camera", "fov": 40 }},
            "b": {{ "type": "Camera", "fov": {{ "keys": [[1, {other}]] }} }},
            "s": {{ "type": "GerstnerSea", "count": 0 }},
            "v": {{ "type": "Render", "camera": "a", "surfaces": ["s"] }},
            "w": {{ "type": "Render", "camera": "b", "surfaces": ["s"] }},
            "out": {{ "type": "WaterlineFoam", "view": "v", "behind": "w" }}"#
        )
    };
    let faults = refused("weights", &nodes("41"));
    assert!(faults.contains("views by different cameras") && faults.contains("connect the camera of"), "{faults}");
    assert!(graph("weights", &nodes("40"), Path::new(".")).is_ok(), "two nodes that are the same camera");
}

#[test]
fn water_before_itself_is_refused() {
    let nodes = r#""c": { "type": "Camera" }, "s": { "type": "GerstnerSea", "count": 0 },
        "v": { "type": "Render", "camera": "c", "surfaces": ["s"] },
        "out": { "type": "WaterlineFoam", "view": "v", "behind": "v" }"#;
    let faults = refused("weights", nodes);
    assert!(faults.contains("foam would cover everything") && faults.contains("but the water"), "{faults}");
}

/// Foam before a second view of a deeper sea, and with an edge.
struct Foam(Frame);

impl Foam {
    fn new(distance: f64, solid: f64, measure: &str) -> Self {
        let nodes = format!(
            r#""c": {{ "type": "Camera" }}, "s": {{ "type": "GerstnerSea", "count": 0 }},
            "t": {{ "type": "GerstnerSea", "count": 0, "level": -1 }},
            "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }},
            "w": {{ "type": "Render", "camera": "c", "surfaces": ["t"] }},
            "edge": {{ "type": "FieldMath", "expression": "0" }},
            "out": {{ "type": "WaterlineFoam", "view": "v", "behind": "w", "edge": "edge", "measure": "{measure}",
                "distance": {distance:?}, "solid": {solid} }}"#
        );
        Self(frame("weights", &nodes))
    }

    /// Returns the mask for depths and heights of the water and of what is behind it.
    fn mask(&self, depths: [f64; 2], heights: [f64; 2], edge: f64) -> f64 {
        self.0.mask_of(&|name| {
            let which = usize::from(name == "w");
            match name {
                "edge" => Reference::Field(vec![edge]),
                _ => view(&[(Channel::Depth, depths[which]), (Channel::PositionY, heights[which])]),
            }
        })
    }
}

#[test]
fn the_source_line_is_a_share_of_everything() {
    let line = Foam::new(0.7, 1.0, "depth");
    for (behind, expected) in [(10.0, 1.0), (10.69, 1.0), (10.71, 0.0), (11.0, 0.0)] {
        assert_eq!(line.mask([10.0, behind], [0.0; 2], 0.0), expected, "{behind}");
    }
    let [soft, soft_by_height] = ["depth", "height"].map(|measure| Foam::new(2.0, 0.5, measure));
    for (apart, expected) in [(0.0, 1.0), (1.0, 1.0), (1.5, 0.5), (1.75, 0.25), (2.0, 0.0), (9.0, 0.0)] {
        assert_eq!(soft.mask([5.0, 5.0 + apart], [0.0; 2], 0.0), expected, "{apart}");
        let half = soft_by_height.mask([5.0, 6.0], [apart / 2.0, 0.0], -0.5);
        assert_eq!(half, expected, "half the width, {apart}");
    }
}

#[test]
fn hostile_depths_make_masks() {
    let (never, values) = (f64::INFINITY, [0.0, -0.0, 1e-300, -1e30, 1e30, 3.0, f64::INFINITY, f64::NEG_INFINITY]);
    for solid in [0.0, 0.3, 1.0] {
        for distance in [1e-9, 1.0, 1e9] {
            let foam = Foam::new(distance, solid, "depth");
            for water in values {
                for behind in values {
                    for edge in [0.0, -1.0, -5.0, 1e30, never, -never] {
                        let mask = foam.mask([water, behind], [0.0; 2], edge);
                        assert!((0.0..=1.0).contains(&mask), "{water} {behind} {edge}: {mask}");
                        if water == never || behind == never || behind < water || edge <= -1.0 {
                            assert_eq!(mask, 0.0, "{water} {behind} {edge}");
                        }
                    }
                }
            }
            assert_eq!(foam.mask([4.0, 4.0], [0.0; 2], 0.0), 1.0, "where they meet");
            assert_eq!(foam.mask([4.0, 5.0], [0.0; 2], never), 1.0, "an endless edge reaches everything");
        }
    }
}
