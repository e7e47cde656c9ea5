//! BezierModel: a surface of Bézier patches.

use crate::scene_support::{
    FLIP, ROTATE, SCALE, Standing, TRANSLATE, check_ending, check_scale, memory, named, patch, placement, read_model,
    vector,
};
use std::path::PathBuf;
use trochoid_graph::*;
use trochoid_scene::bezier::{MAX_PATCHES, MAX_SEGMENTS, Patch, PatchModel, Rails, Tessellation, continuity};

pub(crate) static NODE: &dyn NodeType = &BezierModel;

struct BezierModel;

static DECLARATION: Declaration = Declaration {
    name: "BezierModel",
    end: End::Front,
    summary: "A surface of bilinear and bicubic Bézier patches, from a model file, control points, or rails that it \
              passes through.",
    formula: "P(u, v) = Σ Bᵢ(u)Bⱼ(v)Pᵢⱼ. N = ∂P/∂u × ∂P/∂v. Rails: Catmull-Rom through the points, as exact bicubic \
              patches. World = translate + Rz·Ry·Rx·(scale · (x, stretch·y, z)).",
    edge_cases: "Where tangents vanish the normal is its limit from inside the patch; a patch without area has (0, 1, \
                 0). At the open end of a rail the tangent is that of the parabola through its last three points. \
                 Open surfaces are seen from both sides. Neighbors that share an edge's control points never \
                 crack: its pieces follow from the edge alone.",
    source: "CSE 167, Toon Shading and Surface Patches; Farin, Curves and Surfaces for CAGD, 2002; \
             Catmull and Rom, 1974.",
    items: &[
        Knob::path("model", "A model file: points, patches of 4 or 16 of them, sheets of rails.").optional().item(),
        List::of("patches", PATCH, 0, 1024, "Patches by their control points."),
        List::of("rails", RAIL, 0, 256, "Rows of points that the surface passes through."),
        Knob::bool("closed_u", false, "Joins the last point of each rail to its first.").item(),
        Knob::bool("closed_v", false, "Joins the last rail to the first.").item(),
        Knob::number(
            "stretch",
            1.0,
            1e-3,
            1e3,
            "Factor of the model's heights. The teapot as published stands squat by Blinn's 0.75: 1.3333 gives it \
             Newell's height back.",
        )
        .item(),
        SCALE,
        ROTATE,
        TRANSLATE,
        FLIP,
        Knob::choice("tessellation", &["adaptive", "uniform"], "As fine as the picture needs, or alike everywhere.")
            .item(),
        Knob::number("tolerance", 0.1, 1e-3, 100.0, "How far facets may stand off the surface; adaptive.")
            .unit("pixels")
            .item(),
        Knob::integer("segments", 16, 1, MAX_SEGMENTS as i64, "Pieces of each patch's edge; uniform.").item(),
    ],
    outputs: &[Output::new("surface", Kind::Surface, "The surface.")],
    revision: 1,
};

static PATCH: &[Item] =
    &[List::of("points", POINT, 4, 16, "4 points (bilinear) or 16 (bicubic), row by row, u fastest.")];

static RAIL: &[Item] = &[List::of("points", POINT, 2, 1024, "Points along the rail, as many on every rail.")];

static POINT: &[Item] = &[Knob::vector("at", &[0.0, 0.0, 0.0], "The point; may be keyed.").required().unit("m").item()];

/// The patches that the knobs describe, but for the model file; or the knob at fault, what was found and expected.
fn inline(node: &Settled) -> Result<Vec<Patch>, (&'static str, String, &'static str)> {
    let points = |record: &Settled| record.list("points").iter().map(|point| vector(point, "at")).collect::<Vec<_>>();
    let mut patches = Vec::new();
    for (index, record) in node.list("patches").iter().enumerate() {
        let fault = |found| ("patches", format!("{found} points of patches[{index}]"), "4 points, or 16");
        patches.push(patch(&points(record)).map_err(fault)?);
    }
    let rails: Vec<_> = node.list("rails").iter().map(points).collect();
    if !rails.is_empty() {
        let rails = Rails { rails, closed_u: node.bool("closed_u"), closed_v: node.bool("closed_v") };
        let fault =
            |error: trochoid_scene::bezier::RailsError| ("rails", error.to_string(), "2 rails or more of equal length");
        patches.extend(rails.patches().map_err(fault)?);
    }
    Ok(patches)
}

impl NodeType for BezierModel {
    fn declaration(&self) -> &'static Declaration {
        &DECLARATION
    }

    fn check(&self, node: &Settled, check: &mut Check<'_>) {
        check_scale(node, check);
        check_ending(node, check, "model", &["json"]);
        match inline(node) {
            Err((knob, found, expected)) => check.error(knob, found, expected, "add or remove points"),
            Ok(patches) if patches.is_empty() && !node.is_set("model") => {
                check.error("model", "no patches", "a model file, patches or rails", "set \"model\" to a file");
            }
            Ok(patches) if patches.len() > MAX_PATCHES => {
                let expected = format!("at most {MAX_PATCHES}");
                check.error("rails", format!("{} patches", patches.len()), expected, "use fewer points");
            }
            Ok(_) => {}
        }
    }

    fn notes(&self, node: &Settled) -> Vec<String> {
        // Model files are not opened to check a document.
        match inline(node) {
            Ok(patches) if !patches.is_empty() => {
                let shapes: Vec<_> = patches.iter().map(|patch| &patch.shape).collect();
                vec![continuity(shapes).to_string()]
            }
            _ => Vec::new(),
        }
    }

    fn body(&self) -> Body<'_> {
        Body::Stage(self)
    }
}

impl Stage for BezierModel {
    fn formatted(&self) -> bool {
        false
    }

    fn files(&self, node: &Settled, frame: &FrameContext) -> Vec<PathBuf> {
        if node.is_set("model") { vec![frame.path(node.text("model"))] } else { Vec::new() }
    }

    fn examine(&self, node: &Settled, frame: &FrameContext, _wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        if !node.is_set("model") {
            return Ok(());
        }
        trochoid_io::open_file(named(frame, node.text("model"))?).map(drop).map_err(NodeError::new)
    }

    fn memory(&self, node: &Settled, reckoning: &Reckoning<'_>) -> MemoryUse {
        if node.is_set("model") {
            // Patches are cut as finely as their pixels ask for, some vertices for each byte of a file.
            return memory::of_model(&reckoning.frame.path(node.text("model")), 2);
        }
        let side = match node.text("tessellation") {
            "uniform" => node.integer("segments") as u64 + 1,
            _ => 1,
        };
        memory::of_patches(node.list("patches").len() as u64, side)
    }

    fn prepare(&self, node: &Settled, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let mut patches =
            inline(node).map_err(|(_, found, expected)| NodeError::new(format!("{found}: {expected}")))?;
        if node.is_set("model") {
            patches.extend(read_model(&named(prepare.frame, node.text("model"))?)?);
        }
        let mut placement = placement(node);
        placement.scale.y *= node.number("stretch");
        let tessellation = match node.text("tessellation") {
            "uniform" => Tessellation::Uniform { segments: node.integer("segments") as u32 },
            _ => Tessellation::Adaptive { tolerance: node.number("tolerance") },
        };
        Ok(Box::new(Standing::new(PatchModel::new(&patches, placement, node.bool("flip"), tessellation))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{graph, refused};
    use std::path::Path;

    fn nodes(knobs: &str) -> String {
        format!(
            r#""c": {{ "type": "Camera" }}, "s": {{ "type": "BezierModel", {knobs} }},
            "v": {{ "type": "Render", "camera": "c", "surfaces": ["s"] }}, "out": {{ "type": "Depth", "view": "v" }}"#
        )
    }

    const FIVE: &str = r#""patches": [{ "points": [{ "at": [0, 0, 0] }, { "at": [0, 0, 0] }, { "at": [0, 0, 0] },
        { "at": [0, 0, 0] }, { "at": [1, 0, 0] }] }]"#;
    const RAILS: &str = r#"{ "points": [{ "at": [0, 0, 0] }, { "at": [1, 0, 0] }, { "at": [2, 1, 0] }] },
        { "points": [{ "at": [0, 0, 1] }, { "at": { "keys": [[1, [1, 0, 1]], [9, [1, 4, 1]]] } },
            { "at": [2, 0, 1] }] }"#;

    #[test]
    fn what_makes_no_surface_is_refused() {
        for (knobs, part) in [
            (r#""stretch": 1"#, "no patches"),
            (r#""model": "a.json", "scale": [1, 0, 1]"#, "factors other than 0"),
            (FIVE, "5 points of patches[0]"),
            (r#""rails": [{ "points": [{ "at": [0,0,0] }, { "at": [1,0,0] }] }]"#, "1 rails"),
        ] {
            let faults = refused("field", &nodes(knobs));
            assert!(faults.contains(part), "{knobs}: {faults}");
        }
    }

    #[test]
    fn keyed_points_move_and_the_notes_report_joints() {
        let graph = graph("field", &nodes(&format!(r#""rails": [{RAILS}]"#)), Path::new(".")).unwrap();
        let id = graph.find("s").unwrap();
        let corner = |frame: i64| inline(&graph.settle(id, frame)).unwrap()[0].shape.points[15].y;
        assert_eq!((corner(1), corner(5), corner(9)), (0.0, 2.0, 4.0));
        let notes = BezierModel.notes(&graph.settle(id, 1));
        assert!(notes[0].starts_with("2 patches, 1 joint: no gaps"), "{notes:?}");
    }
}
