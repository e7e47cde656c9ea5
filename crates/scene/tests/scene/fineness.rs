//! Tests that finer meshes lie nearer to their surfaces, and that points followed to the surfaces lie on them.

use crate::random::Draw;
use trochoid_image::Format;
use trochoid_scene::bezier::{Bicubic, Patch, PatchModel, Placement, Tessellation};
use trochoid_scene::{
    Camera, Channel, ChannelSet, DVec3, GridSurface, Projection, Samples, SeaSurface, Sums, Surface, Visible, reference,
};
use trochoid_sea::{GerstnerSpectrum, Sea};

const SIZE: [u32; 2] = [160, 90];

/// Returns the median distance of mesh depths from those of the surface near them, where both are visible.
fn off(surface: &dyn Surface, fineness: f64) -> f64 {
    let camera = Camera {
        position: DVec3::new(0.0, 14.0, 22.0),
        target: DVec3::new(0.0, 1.0, 0.0),
        roll: 0.1,
        projection: Projection::Perspective { fov: 0.8 },
    };
    let format = Format::new(SIZE[0], SIZE[1], 1).expect("valid");
    let wanted = ChannelSet::REST.union(ChannelSet::DEPTH);
    let visible =
        Visible::prepare_unless(&camera, &[surface], format, fineness, wanted, &|| false).expect("it goes on");
    let mut samples = Samples::new();
    visible.fill(format.window(), [0.5; 2], ChannelSet::DEPTH, &mut samples);
    let pixels: Vec<[i64; 2]> =
        (0..i64::from(SIZE[1])).flat_map(|y| (0..i64::from(SIZE[0])).map(move |x| [x, y])).collect();
    let points = visible.points(&[surface], &pixels, [0.5; 2], Sums::Double);
    let mut rough = Vec::new();
    let quick = visible.points(&[surface], &pixels, [0.5; 2], Sums::Single);
    assert_eq!(quick[700..733], visible.points(&[surface], &pixels[700..733], [0.5; 2], Sums::Single)[..]);
    let mut errors = Vec::new();
    for (quick, point) in quick.iter().zip(&points) {
        let (Some(quick), Some(point)) = (quick, point) else { continue };
        let apart = (quick.position - point.position).length() / point.distance;
        let turned = (quick.normal - point.normal).length();
        assert!(apart < 1e-4 && turned < 2e-3, "{quick:?} should be {point:?}");
        rough.push(turned);
    }
    rough.sort_by(f64::total_cmp);
    assert!(rough[rough.len() / 2] < 1e-5, "{:e}", rough[rough.len() / 2]);
    for (index, ([x, y], point)) in pixels.iter().zip(&points).enumerate() {
        let Some(point) = point else { continue };
        errors.push((f64::from(samples.channel(Channel::Depth)[index]) - point.depth).abs());
        if index % 97 == 0 {
            let truth =
                reference::trace(&camera, &[surface], format, *x as f64 + 0.5, *y as f64 + 0.5).expect("a first point");
            let same = truth.is_some_and(|truth| (truth.position - point.position).length() < 1e-7);
            // Where a crest hides another one by less than the error of the mesh, the other one may be found.
            assert!(same || errors[errors.len() - 1] > 1e-3, "({x}, {y}): {point:?} should be {truth:?}");
        }
    }
    assert!(errors.len() > 4000);
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

/// Checks that errors fall with the square of the spacing of vertices, or faster.
fn falls(surface: &dyn Surface) {
    let [coarse, plain, fine] = [0.5, 1.0, 2.0].map(|fineness| off(surface, fineness));
    assert!(coarse > 2.5 * plain && plain > 2.5 * fine, "{coarse:e}, {plain:e}, {fine:e}");
}

#[test]
fn of_seas() {
    let spectrum =
        GerstnerSpectrum { count: 30, wavelength: 9.0, height: 1.0, sharpness: 0.4, ..GerstnerSpectrum::default() };
    falls(&SeaSurface::new(&Sea::new(spectrum.waves().expect("valid")), 2.0, 0.0));
}

#[test]
fn of_height_grids() {
    // Cells so large that even the coarse mesh cuts them.
    let heights = (0..14 * 14).map(|cell| {
        let (x, z) = (f64::from(cell % 14), f64::from(cell / 14));
        (2.0 * (0.9 * x).sin() * (0.8 * z).cos()) as f32
    });
    // Views meet these themselves, whatever the triangles.
    let grid = GridSurface::new(heights.collect(), 14, 3.0, [-20.0, -20.0], 0.0);
    for fineness in [0.5, 1.0, 2.0] {
        assert!(off(&grid, fineness) < 2e-6);
    }
}

#[test]
fn of_patches() {
    let mut draw = Draw(5);
    let points = std::array::from_fn(|at| {
        let (u, v) = ((at % 4) as f64, (at / 4) as f64);
        DVec3::new(8.0 * u - 12.0, 3.0 * draw.next(), 8.0 * v - 12.0)
    });
    let placement = Placement { scale: DVec3::ONE, rotate: DVec3::ZERO, translate: DVec3::ZERO };
    let tessellation = Tessellation::Adaptive { tolerance: 0.05 };
    falls(&PatchModel::new(&[Patch::new(Bicubic { points })], placement, false, tessellation));
}
