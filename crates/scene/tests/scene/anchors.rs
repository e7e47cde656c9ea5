//! Tests of points given by texture coordinates, against the points that rays meet.

use std::sync::Arc;

use crate::random::Draw;
use trochoid_image::Format;
use trochoid_scene::bezier::{PatchModel, Placement, Rails, Tessellation};
use trochoid_scene::{
    Camera, DVec3, GridSurface, Pose, Projection, Projector, RigidBodies, SeaSurface, Surface, TriangleModel, Triangles,
};
use trochoid_sea::{GerstnerSpectrum, Sea};

fn projector() -> Projector {
    let camera = Camera {
        position: DVec3::new(1.0, 9.0, 7.0),
        target: DVec3::ZERO,
        roll: 0.3,
        projection: Projection::Orthographic { height: 5.0 },
    };
    camera.projector(Format::new(4000, 4000, 1).expect("valid"))
}

/// Checks that the texture coordinates of points on random rays lead back to those points, and that neighbors of
/// these lie in the direction of the tangents.
fn leads_back(what: &str, surface: &dyn Surface) {
    let (mut draw, mut met, projector) = (Draw(7), 0, projector());
    for _ in 0..300 {
        let ray = projector.ray(4000.0 * draw.next(), 4000.0 * draw.next());
        let Ok(Some(hit)) = surface.trace(&projector, &ray, f64::INFINITY) else { continue };
        let nearest = |uv: [f64; 2], point: DVec3| {
            let anchors = surface.anchors(uv).into_iter();
            anchors.min_by(|a, b| a.point.distance(point).total_cmp(&b.point.distance(point)))
        };
        let Some(anchor) = nearest(hit.uv, hit.position) else { panic!("{what}: no point at {:?}", hit.uv) };
        assert!(anchor.point.distance(hit.position) < 2e-3, "{what}: {anchor:?}, the ray met {hit:?}");
        for (axis, along) in [anchor.along_u, anchor.along_v].into_iter().enumerate() {
            let step = 1e-6;
            let mut uv = hit.uv;
            uv[axis] += step;
            let Some(beside) = nearest(uv, anchor.point) else { continue };
            let way = beside.point - anchor.point;
            // Beyond an edge another triangle begins.
            if way.length() > 10.0 * step * along.length() {
                continue;
            }
            assert!(way.normalize().dot(along.normalize()) > 1.0 - 1e-3, "{what}, {axis}: {way}, expected {along}");
        }
        met += 1;
    }
    assert!(met > 60, "{what}: {met}");
}

fn sheet() -> PatchModel {
    let point = |i: i32, j: i32| DVec3::new(f64::from(i) - 2.5, f64::from((i * j) % 3) * 0.3, f64::from(j) - 1.5);
    let rail = |j: i32| (0..6).map(|i| point(i, j)).collect();
    let rails = Rails { rails: (0..4).map(rail).collect(), closed_u: false, closed_v: false };
    let placement = Placement { rotate: DVec3::new(0.1, 0.4, -0.2), ..Placement::default() };
    PatchModel::new(&rails.patches().expect("rails"), placement, false, Tessellation::Uniform { segments: 8 })
}

fn mesh() -> TriangleModel {
    let mesh = Triangles {
        positions: vec![
            DVec3::new(-2.0, 0.0, -2.0),
            DVec3::new(2.0, 1.0, -2.0),
            DVec3::new(-2.0, 0.5, 2.0),
            DVec3::new(2.0, 0.0, 2.0),
        ],
        normals: Vec::new(),
        uvs: vec![[0.0, 0.0], [1.0, 0.2], [0.1, 1.0], [0.9, 0.8]],
        triangles: vec![[0, 2, 1], [1, 2, 3]],
    };
    TriangleModel::new(mesh, Placement::default(), false).expect("a mesh")
}

#[test]
fn texture_coordinates_lead_back_to_what_rays_meet() {
    leads_back("patches", &sheet());
    leads_back("triangles", &mesh());
    let heights = (0..900).map(|cell| (0.2 * f64::from(cell % 30)).sin() as f32 * 0.4).collect();
    leads_back("grid", &GridSurface::new(heights, 30, 0.25, [-3.5, -3.5], 0.5));
    let spectrum = GerstnerSpectrum { count: 12, wavelength: 4.0, height: 0.3, ..GerstnerSpectrum::default() };
    leads_back("sea", &SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 2.0, -0.5));
    let pose = Pose { axes: [DVec3::Z, DVec3::Y, DVec3::NEG_X], origin: DVec3::new(0.5, 0.25, -0.5) };
    leads_back("bodies", &RigidBodies::new(Arc::new(sheet()), vec![pose]));
}

#[test]
fn edges_between_patches_are_one_place_and_nothing_lies_beyond() {
    let sheet = sheet();
    for i in 0..=5 {
        for j in 0..=3 {
            let uv = [f64::from(i) / 5.0, f64::from(j) / 3.0];
            assert_eq!(sheet.anchors(uv).len(), 1, "{uv:?}");
        }
    }
    for uv in [[-0.01, 0.5], [1.01, 0.5], [0.5, f64::NAN], [0.5, 1.5]] {
        assert!(sheet.anchors(uv).is_empty() && mesh().anchors(uv).is_empty(), "{uv:?}");
    }
}
