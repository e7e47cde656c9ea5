//! BezierModel: a surface of Bézier patches.

use super::{PlacementKnobs, PreparedSurface, check_ending, memory, read_model};
use crate::view::named;
use std::path::PathBuf;
use trochoid_graph::*;
use trochoid_scene::DVec3;
use trochoid_scene::bezier::{MAX_PATCHES, MAX_SEGMENTS, Patch, PatchModel, Rails, Tessellation, continuity};

/// A surface of bilinear and bicubic Bézier patches, from a model file, from control points, or from rails that it
/// passes through.
///
/// # Formula
/// P(u, v) = Σ Bᵢ(u)Bⱼ(v)Pᵢⱼ. N = ∂P/∂u × ∂P/∂v. Rails: Catmull-Rom through the points, as exact bicubic patches.
/// World = translate + Rz·Ry·Rx·(scale · (x, stretch·y, z)).
///
/// # Edge cases
/// Where tangents vanish, the normal is its limit from inside the patch; a patch without area has (0, 1, 0). At the
/// open end of a rail, the tangent is that of the parabola through its last three points. Open surfaces are visible
/// from both sides. Neighbors that share an edge's control points never crack, because the edge's subdivision depends
/// only on the edge.
///
/// # Source
/// CSE 167, Toon Shading and Surface Patches; Farin, Curves and Surfaces for CAGD, 2002; Catmull and Rom, 1974.
#[derive(Clone, Node)]
#[node(
    stage,
    end = Front,
    revision = 1,
    example = r#""model": "patches.json""#,
    reads("a model of Bézier patches": "json"),
    output(surface: Kind::Surface = "The surface.")
)]
#[also_called("Sphere", "Primitive", "Cube", "Card")]
pub(crate) struct BezierModel {
    /// Model file with points, patches of 4 or 16 points, and sheets of rails.
    #[knob(path)]
    model: Option<String>,
    /// Patches, given by their control points.
    #[list(0..=1024)]
    patches: Vec<PatchPoints>,
    /// Rails: rows of points that the surface passes through, u along each rail and v from rail to rail. It is smooth
    /// everywhere: for a sharp edge, use two models.
    #[list(0..=256)]
    rails: Vec<RailPoints>,
    /// Connects the last point of each rail to its first.
    #[knob(default = false)]
    closed_u: bool,
    /// Connects the last rail to the first.
    #[knob(default = false)]
    closed_v: bool,
    /// Factor of the model's heights. The published teapot is squashed by Blinn's 0.75; 1.3333 restores Newell's
    /// height.
    #[knob(default = 1.0, range = 1e-3..=1e3)]
    stretch: f64,
    #[items]
    placement: PlacementKnobs,
    /// Tessellation: "adaptive" is as fine as the picture needs, "uniform" is the same everywhere.
    tessellation: Pieces,
    /// Maximum distance of facets from the surface, for "adaptive".
    #[knob(default = 0.1, range = 1e-3..=100.0, unit = "pixels")]
    tolerance: f64,
    /// Number of segments along each patch edge, for "uniform".
    #[knob(default = 16, range = 1..=MAX_SEGMENTS as i64)]
    segments: i64,
}

#[derive(Clone, Items)]
struct PatchPoints {
    /// Control points: 4 (bilinear) or 16 (bicubic), row by row, u varying fastest.
    #[list(4..=16)]
    points: Vec<Point>,
}

#[derive(Clone, Items)]
struct RailPoints {
    /// Points along the rail; all rails have the same number.
    #[list(2..=1024)]
    points: Vec<Point>,
}

#[derive(Clone, Items)]
struct Point {
    /// Position of the point; can be keyed.
    #[knob(unit = "m", required)]
    at: [f64; 3],
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Pieces {
    Adaptive,
    Uniform,
}

/// Error for points that do not form patches.
#[derive(Debug)]
struct Misfit {
    item: ItemName,
    found: String,
    expected: &'static str,
}

fn places(points: &[Point]) -> Vec<DVec3> {
    points.iter().map(|point| point.at.into()).collect()
}

impl BezierModel {
    /// Returns the patches that the knobs describe, without those of the model file.
    fn inline(&self) -> Result<Vec<Patch>, Misfit> {
        let mut patches = Vec::new();
        for (index, PatchPoints { points }) in self.patches.iter().enumerate() {
            let misfit = |found| Misfit {
                item: Self::PATCHES,
                found: format!("{found} points of patches[{index}]"),
                expected: "4 or 16 points",
            };
            patches.push(Patch::of(&places(points)).map_err(misfit)?);
        }
        let rails: Vec<_> = self.rails.iter().map(|rail| places(&rail.points)).collect();
        if !rails.is_empty() {
            let rails = Rails { rails, closed_u: self.closed_u, closed_v: self.closed_v };
            patches.extend(rails.patches().map_err(|error| Misfit {
                item: Self::RAILS,
                found: error.to_string(),
                expected: "2 or more rails with the same number of points",
            })?);
        }
        Ok(patches)
    }
}

/// Says how the patches of a model join.
fn joints(patches: &[Patch]) -> Vec<String> {
    let shapes: Vec<_> = patches.iter().map(|patch| &patch.shape).collect();
    if shapes.is_empty() { Vec::new() } else { vec![continuity(shapes).to_string()] }
}

impl Node for BezierModel {
    fn check(&self, check: &mut Check<'_>) {
        self.placement.check(check);
        check_ending(self.model.as_deref().unwrap_or_default(), Self::DECLARATION, Self::MODEL, check);
        match self.inline() {
            Err(Misfit { item, found, expected }) => check.error(item, found, expected, "add or remove points"),
            Ok(patches) if patches.is_empty() && self.model.is_none() => {
                let expected = "a model file, patches or rails";
                check.error(Self::MODEL, "no patches", expected, "set \"model\" to a file");
            }
            Ok(patches) if patches.len() > MAX_PATCHES => {
                let found = format!("{} patches", patches.len());
                check.error(Self::RAILS, found, format!("at most {MAX_PATCHES}"), "use fewer points");
            }
            Ok(_) => {}
        }
    }

    fn notes(&self, _times: FrameTimes) -> Vec<String> {
        // Those of a file are in `file_notes`.
        match self.inline() {
            Ok(patches) if self.model.is_none() => joints(&patches),
            _ => Vec::new(),
        }
    }
}

/// Approximate number of file bytes per vertex: patches are tessellated as finely as their pixels require.
const BYTES_OF_VERTEX: u64 = 2;

impl Stage for BezierModel {
    fn depends_on_format(&self) -> bool {
        false
    }

    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        self.model.iter().map(|model| frame.path(model)).collect()
    }

    fn check_headers(&self, frame: &FrameContext, _wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        let Some(model) = &self.model else { return Ok(()) };
        read_model(&named(frame, model)?)?;
        Ok(())
    }

    fn file_notes(&self, prepare: &Prepare<'_>) -> Vec<String> {
        let Some(model) = &self.model else { return Vec::new() };
        // What is wrong with the file is reported as its error.
        let read = named(prepare.frame, model).and_then(|path| read_model(&path));
        let (Ok(read), Ok(mut patches)) = (read, self.inline()) else { return Vec::new() };
        patches.extend(read);
        joints(&patches)
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        let model = self.model.as_ref();
        let model = model.map(|model| memory::of_model(&context.frame.path(model), BYTES_OF_VERTEX));
        let own = match self.tessellation {
            Pieces::Adaptive => memory::of_curved(self.tolerance, context),
            Pieces::Uniform => memory::of_patches(self.patches.len() as u64, self.segments as u64 + 1),
        };
        model.map_or(own, |model| model.per_view(model.per_view.max(own.per_view)))
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let misfit = |Misfit { item, found, expected }| BadData::new(found, expected, "").of_item(item);
        let mut patches = self.inline().map_err(misfit)?;
        if let Some(model) = &self.model {
            patches.extend(read_model(&named(prepare.frame, model)?)?);
        }
        let mut placement = self.placement.placement();
        placement.scale.y *= self.stretch;
        let tessellation = match self.tessellation {
            Pieces::Adaptive => Tessellation::Adaptive { tolerance: self.tolerance },
            Pieces::Uniform => Tessellation::Uniform { segments: self.segments as u32 },
        };
        Ok(Box::new(PreparedSurface::new(PatchModel::new(&patches, placement, self.placement.flip, tessellation))))
    }
}
