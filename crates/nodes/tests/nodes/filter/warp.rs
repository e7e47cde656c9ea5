//! Tests of Warp.

use crate::testing::{Frame, draws, graph};
use std::path::Path;
use trochoid_graph::{Block, Connection, Inputs, Outputs, Reference};
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;

const WINDOW: Window = Window { x0: 0, y0: 0, x1: 37, y1: 5 };
/// A window that is neither around nor within the other.
const IMAGE: Window = Window { x0: 3, y0: -2, x1: 44, y1: 4 };

/// Returns the sample of a plane that is nearest to a place.
fn nearest(plane: &[f32], window: Window, [x, y]: [f64; 2]) -> f64 {
    let column = (x.floor() as i64).clamp(window.x0, window.x1 - 1) - window.x0;
    let row = (y.floor() as i64).clamp(window.y0, window.y1 - 1) - window.y0;
    f64::from(plane[row as usize * window.width() + column as usize])
}

/// Warps an image, and compares all samples with their references.
fn agrees(image: &[f32], displacements: [&[f32]; 2]) {
    let nodes = r#""image": { "type": "Noise" }, "dx": { "type": "ScreenX" }, "dy": { "type": "ScreenY" },
        "out": { "type": "Warp", "image": "image", "dx": "dx", "dy": "dy", "reach": 8 }"#;
    let frame = Frame::new(graph("field", nodes, Path::new(".")).unwrap().with_format(Format::new(37, 5, 1).unwrap()));
    let frame = frame.unwrap();
    let port = |plane, window| -> Scratch<Connection<'_>> {
        [Connection { planes: [Some(plane)].into_iter().collect(), window, extent: window }].into_iter().collect()
    };
    let ports = [port(image, IMAGE), port(displacements[0], WINDOW), port(displacements[1], WINDOW)];
    let mut found = vec![f32::NAN; WINDOW.area()];
    let block = Block::of(WINDOW, [0.5, 0.5]);
    frame.node("out").fill(&block, &Inputs::new(&ports), &mut Outputs::new([[Some(&mut found[..])]])).unwrap();
    for (found, at) in found.iter().zip(block.places()) {
        let given = |name: &str, at: [f64; 2]| {
            Reference::Field(vec![match name {
                "image" => nearest(image, IMAGE, at),
                "dx" => nearest(displacements[0], WINDOW, at),
                _ => nearest(displacements[1], WINDOW, at),
            }])
        };
        let truth = match &frame.given(at, &given)[..] {
            [Reference::Field(truth)] => truth[0],
            _ => panic!("no field"),
        };
        let found = f64::from(*found);
        assert!(found == truth || (found - truth).abs() < 1e-5, "{at:?}: {found}, expected {truth}");
    }
}

#[test]
fn samples_are_those_of_the_reference_for_any_displacement() {
    let mut image = draws(IMAGE.area(), 1);
    let [mut dx, mut dy] = [2, 3].map(|salt| draws(WINDOW.area(), salt));
    dx.iter_mut().chain(&mut dy).for_each(|by| *by *= 12.0);
    agrees(&image, [&dx, &dy]);
    let hostile = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 0.0, 1e30, -1e-40, 8.0, -8.0, 3.0, -0.5];
    dx.iter_mut().zip(hostile.iter().cycle()).step_by(3).for_each(|(by, hostile)| *by = *hostile);
    dy.iter_mut().zip(hostile.iter().cycle()).step_by(5).for_each(|(by, hostile)| *by = *hostile);
    agrees(&image, [&dx, &dy]);
    // Quarters, whose weights are exact: none of them is rounded to 0, whatever the values.
    dx.iter_mut().chain(&mut dy).for_each(|by| *by = (*by * 4.0).round() / 4.0);
    let infinite = [f32::INFINITY, f32::NEG_INFINITY, -0.0];
    image.iter_mut().zip(infinite.iter().cycle()).step_by(7).for_each(|(value, infinite)| *value = *infinite);
    agrees(&image, [&dx, &dy]);
}

#[test]
fn samples_that_stay_keep_their_bits() {
    let nodes = r#""image": { "type": "Noise" }, "out": { "type": "Warp", "image": "image" }"#;
    let frame = Frame::new(graph("field", nodes, Path::new(".")).unwrap()).unwrap();
    let image = [-0.0, 1.5, f32::NEG_INFINITY, 1e-40];
    let window = Window::sized(4, 1);
    let planes = [Some(&image[..])].into_iter().collect();
    let image_port = [Connection { planes, window, extent: window }].into_iter().collect();
    let ports: [Scratch<Connection<'_>>; 3] = [image_port, Scratch::new(), Scratch::new()];
    let mut found = [f32::NAN; 4];
    let outputs = Outputs::new([[Some(&mut found[..])]]);
    frame.node("out").fill(&Block::of(window, [0.5, 0.5]), &Inputs::new(&ports), &mut { outputs }).unwrap();
    assert_eq!(found.map(f32::to_bits), image.map(f32::to_bits));
}
