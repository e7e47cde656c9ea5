//! Tests of FlowField.

use crate::testing::{Frame, draws, frame, graph, refused};
use std::path::Path;
use trochoid_graph::{Block, Channel, Connection, Inputs, Outputs, Reference};
use trochoid_image::{Format, Window};
use trochoid_memory::Scratch;
use trochoid_nodes::inside::{doubled, halved, projected};
use trochoid_scene::DVec3;

#[test]
fn halving_undoes_doubling() {
    for degrees in -89..=90 {
        let (sin, cos) = libm::sincos(f64::from(degrees).to_radians());
        let ([x, y], length) = halved(doubled([cos, sin]));
        assert!((length - 1.0).abs() < 1e-12);
        assert!((x - cos).abs() < 1e-7 && (y - sin).abs() < 1e-7, "{degrees}: {x}, {y}");
        let (other, _) = halved(doubled([-cos, -sin]));
        assert_eq!(other, [x, y], "a line has two directions");
    }
    assert_eq!(halved([0.0; 2]), ([0.0; 2], 0.0));
}

#[test]
fn projection_is_the_slope_of_places_in_the_picture() {
    let camera = trochoid_scene::Camera {
        position: DVec3::new(1.0, 4.0, 9.0),
        target: DVec3::new(0.0, 1.0, 0.0),
        roll: 0.3,
        projection: trochoid_scene::Projection::Perspective { fov: 0.9 },
    };
    let eye = camera.projector(trochoid_image::Format::new(64, 48, 1).unwrap());
    for index in 0..200 {
        let t = f64::from(index);
        let point = DVec3::new(3.0 * libm::sin(t), libm::sin(2.7 * t), -4.0 + 3.0 * libm::cos(1.3 * t));
        let way = DVec3::new(libm::cos(5.1 * t), libm::sin(3.3 * t), libm::cos(t));
        let place = |by: f64| eye.project(point + way * by).unwrap().0;
        let (before, after) = (place(-1e-5), place(1e-5));
        let [x, y] = [after[0] - before[0], after[1] - before[1]];
        let expected = [x, y].map(|along| along / x.hypot(y));
        let found = projected(&eye, point, way).unwrap();
        assert!((0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-5), "{found:?}, {expected:?}");
    }
}

#[test]
fn directions_by_hand_are_the_same_everywhere() {
    let frame = frame("field", r#""out": { "type": "FlowField", "along": "constant", "turn": 30 }"#);
    let truth = frame.truth([1.5, 1.5]);
    assert!((truth[0] - 0.75f64.sqrt()).abs() < 1e-9 && (truth[1] - 0.5).abs() < 1e-9, "{truth:?}");
    let id = frame.graph.find("out").unwrap();
    assert!((frame.filled(id, 0, 1, [1.5, 1.5]) - 0.5).abs() < 1e-6);
}

#[test]
fn needs_what_it_follows() {
    assert!(refused("field", r#""out": { "type": "FlowField" }"#).contains("slope without a view"));
    let contour = r#""out": { "type": "FlowField", "along": "contour" }"#;
    assert!(refused("field", contour).contains("contour without a field"));
}

/// Fills a picture from planes of the view or a field, and compares all directions with their references.
fn agrees(knobs: &str, planes: &[Vec<f32>]) {
    let window = Window::sized(29, 4);
    let nodes = format!(
        r#""camera": {{ "type": "Camera", "position": [0, 3, 8] }}, "field": {{ "type": "ScreenX" }},
            "sea": {{ "type": "GerstnerSea", "count": 0 }},
            "view": {{ "type": "Render", "camera": "camera", "surfaces": ["sea"] }},
            "out": {{ "type": "FlowField", {knobs} }}"#
    );
    let graph = graph("field", &nodes, Path::new(".")).unwrap().with_format(Format::new(29, 4, 1).unwrap());
    let frame = Frame::new(graph).unwrap();
    let planes_of = || planes.iter().map(|plane| Some(&plane[..])).collect();
    let ports = [knobs.contains("view"), knobs.contains("\"field\"")].map(|is_given| -> Scratch<Connection<'_>> {
        is_given.then(|| Connection { planes: planes_of(), window, extent: window }).into_iter().collect()
    });
    let mut found = [(); 3].map(|()| vec![f32::NAN; window.area()]);
    let [x, y, length] = found.each_mut().map(|plane| Some(&mut plane[..]));
    let block = Block::of(window, [0.5, 0.5]);
    let outputs = Outputs::new([vec![x, y], vec![length]]);
    frame.node("out").fill(&block, &Inputs::new(&ports), &mut { outputs }).unwrap();
    for (index, at) in block.places().enumerate() {
        let given = |name: &str, [x, y]: [f64; 2]| {
            let [x, y] = [x.floor().clamp(0.0, 28.0), y.floor().clamp(0.0, 3.0)];
            let values = planes.iter().map(|plane| f64::from(plane[y as usize * 29 + x as usize])).collect();
            if name == "view" { Reference::View(values) } else { Reference::Field(values) }
        };
        let truth = match &frame.given(at, &given)[..] {
            [Reference::Field(way), Reference::Mask(length)] => [doubled([way[0], way[1]]), [*length, 0.0]].concat(),
            _ => panic!("neither a direction nor its length"),
        };
        let [x, y, length] = [0, 1, 2].map(|plane| f64::from(found[plane][index]));
        // A direction along the vertical has two signs, and half of its digits.
        for (found, truth) in doubled([x, y]).into_iter().chain([length]).zip(truth) {
            assert!((found - truth).abs() < 1e-3, "{knobs} at {at:?}: {found}, expected {truth}");
        }
    }
}

#[test]
#[allow(clippy::needless_range_loop, reason = "a loop over pixels of several planes")]
fn directions_on_surfaces_are_those_of_the_reference() {
    let mut planes: Vec<Vec<f32>> = (0..).zip(Channel::ALL).map(|(salt, _)| draws(29 * 4, salt)).collect();
    // Nothing is seen at some pixels; at others, normals point straight up or are no directions, and points lie in the eye
    // or anywhere.
    for index in 0..29 * 4 {
        let coverage = &mut planes[Channel::Coverage as usize][index];
        *coverage = if index % 4 == 0 { 0.0 } else { coverage.abs().max(0.1) };
        let mut set = |channels: [Channel; 3], values: [f32; 3]| {
            channels.into_iter().zip(values).for_each(|(channel, value)| planes[channel as usize][index] = value);
        };
        let normal = [Channel::NormalX, Channel::NormalY, Channel::NormalZ];
        let position = [Channel::PositionX, Channel::PositionY, Channel::PositionZ];
        match index % 13 {
            3 => set(normal, [0.0, 1.0, 0.0]),
            5 => set(normal, [0.0; 3]),
            7 => set(position, [0.0, 3.0, 8.0]),
            9 => set(position, [f32::INFINITY, 1e38, -1e38]),
            11 => set(position, [1e-40, -0.0, 40.0]),
            _ => {}
        }
    }
    for along in ["slope", "crest"] {
        for more in ["", r#", "turn": 30, "still": 70"#, r#", "flat": 0.2, "steep": 0.9"#, r#", "waver": 40"#] {
            agrees(&format!(r#""view": "view", "along": "{along}"{more}"#), &planes);
        }
    }
}

#[test]
fn directions_of_fields_are_those_of_the_reference() {
    let mut field = draws(29 * 4, 1);
    for (index, value) in [0.0, f32::INFINITY, f32::NEG_INFINITY, 1e38, -1e38, 1e-40, -0.0].into_iter().enumerate() {
        field[9 * index] = value;
        // A level place.
        field[60 + index] = 0.5;
    }
    for along in ["gradient", "contour"] {
        for more in ["", r#", "turn": -50, "still": 20"#, r#", "waver": 10"#] {
            agrees(&format!(r#""field": "field", "along": "{along}"{more}"#), &[field.clone()]);
        }
    }
}
