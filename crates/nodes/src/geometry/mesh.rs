//! Mesh: a model of triangles.

use super::{PlacementKnobs, PreparedSurface, Up, check_ending, check_mesh, memory, read_mesh};
use crate::view::named;
use std::path::PathBuf;
use trochoid_graph::*;
use trochoid_scene::{DVec3, MAX_TRIANGLES, TriangleModel, Triangles};

/// A model of triangles from a file: Wavefront OBJ or glTF 2.0.
///
/// # Formula
/// Weights w of a triangle's corners give position, normal and texture coordinates: Σ wᵢPᵢ, Σ wᵢNᵢ/|Σ wᵢNᵢ|, Σ wᵢUVᵢ.
/// World = translate + Rz·Ry·Rx·(scale · P); normals are transformed by the inverse transpose.
///
/// # Edge cases
/// Polygons are split into fans, so they must be convex. Smooth normals are the area-weighted mean of the triangles
/// around a point; "file" uses them where the file has no normals. Triangles are visible from both sides; from behind,
/// the normal is reversed. Texture coordinates rise from the lower left; if there are none, they are the rest point's
/// x and z. Materials, points, lines, skins and animations are ignored. A glTF must contain its own buffers: .glb, or
/// .gltf with embedded buffers. The file type is detected from the file's first bytes.
///
/// # Source
/// Wavefront, Advanced Visualizer, Appendix B1 (OBJ); Khronos, glTF 2.0 Specification.
#[derive(Clone, Node)]
#[node(
    stage,
    end = Front,
    revision = 1,
    reads("a mesh of triangles": "obj", "glb", "gltf"),
    output(surface: Kind::Surface = "The surface.")
)]
#[also_called("Model", "ReadGeo", "Geometry", "OBJ", "Object", "GLTF", "FBX")]
pub(crate) struct Mesh {
    /// Model file: .obj, .glb or .gltf. #### or %04d stands for the frame number; write \# and \% for literal signs.
    #[knob(path)]
    file: String,
    /// Axis that points up in the file.
    up: Up,
    /// Normals: those of the "file", "smooth" across triangles, or "flat" for each triangle.
    normals: Normals,
    #[items]
    placement: PlacementKnobs,
}

#[derive(Clone, Copy, Debug, PartialEq, Choice)]
enum Normals {
    File,
    Smooth,
    Flat,
}

impl Node for Mesh {
    fn check(&self, check: &mut Check<'_>) {
        self.placement.check(check);
        check_ending(&self.file, Self::DECLARATION, Self::FILE, check);
    }
}

impl Mesh {
    /// Returns the file's triangles with the knobs applied, before placement.
    fn triangles(&self, frame: &FrameContext) -> Result<Triangles, NodeError> {
        let path = named(frame, &self.file)?;
        let mut mesh = read_mesh(&path, frame.memory_limit)?;
        for vector in mesh.positions.iter_mut().chain(&mut mesh.normals) {
            *vector = DVec3::from(self.up.to_y_up(vector.to_array()));
        }
        match self.normals {
            Normals::File => {}
            Normals::Smooth => mesh.normals = Vec::new(),
            Normals::Flat if 3 * mesh.triangles.len() > MAX_TRIANGLES => {
                let found = format_args!("{} triangles", mesh.triangles.len());
                let expected = format!("at most {} with flat normals", MAX_TRIANGLES / 3);
                return Err(BadData::new(found, expected, "reduce the mesh, or use smooth normals")
                    .in_file(path)
                    .into());
            }
            Normals::Flat => mesh = mesh.faceted(),
        }
        Ok(mesh)
    }
}

/// Approximate number of file bytes per vertex.
const BYTES_OF_VERTEX: u64 = 40;

impl Stage for Mesh {
    fn depends_on_format(&self) -> bool {
        false
    }

    fn check_headers(&self, frame: &FrameContext, _wanted: &[Vec<bool>]) -> Result<(), NodeError> {
        check_mesh(&named(frame, &self.file)?)
    }

    fn files(&self, frame: &FrameContext) -> Vec<PathBuf> {
        vec![frame.path(&self.file)]
    }

    fn memory(&self, context: &MemoryContext<'_>) -> MemoryUse {
        memory::of_model(&context.frame.path(&self.file), BYTES_OF_VERTEX)
    }

    fn prepare(&self, prepare: &Prepare<'_>) -> Result<Box<dyn Prepared>, NodeError> {
        let mesh = self.triangles(prepare.frame)?;
        let model = TriangleModel::new(mesh, self.placement.placement(), self.placement.flip)?;
        Ok(Box::new(PreparedSurface::new(model)))
    }
}
