//! Tests of colors of files in the working space.

use crate::testing::{graph, prepare, sole_reference};
use trochoid_graph::{Block, Inputs, Outputs, Pool};
use trochoid_image::{Window, WorkingSpace, srgb_decode, srgb_encode};
use trochoid_io::{PngImage, Samples, write_png8};
use trochoid_nodes::inside::Holding;

/// Every byte, many times, so that a part of the picture can be held.
const WIDTH: usize = 2560;

#[test]
fn bytes_are_converted_by_the_formula() {
    let folder = tempfile::tempdir().unwrap();
    let pixels: Vec<[f32; 3]> = (0..2 * WIDTH).map(|at| [(at % 256) as f32 / 255.0; 3]).collect();
    let image = PngImage::new(WIDTH as u32, 2, Samples::rgb(&pixels));
    write_png8(folder.path().join("a.png"), &image).unwrap();
    let same = |v: f64| v;
    for (space, encoding, formula) in [
        (WorkingSpace::LinearSrgb, "auto", srgb_decode as fn(f64) -> f64),
        (WorkingSpace::LinearSrgb, "linear", same),
        (WorkingSpace::Srgb, "linear", srgb_encode),
        (WorkingSpace::Srgb, "auto", same),
        (WorkingSpace::AcesCg, "auto", srgb_decode),
    ] {
        let node = format!(
            r#""out": {{ "type": "Read", "file": "a.png", "as": "color", "encoding": "{encoding}", "fit": "crop" }}"#
        );
        let graph = graph("color", &node, folder.path()).unwrap();
        let mut context = graph.frame_context(1, 1 << 30);
        context.space = space;
        for whole in [u64::MAX, 0] {
            let holding = Holding { on_demand: None, whole };
            let read = prepare(&graph, "out", &context, Some(holding), &Pool::new()).unwrap();
            assert_eq!(read.bytes() < 2 * WIDTH * 3 * size_of::<f32>(), whole == 0, "{}", read.bytes());
            let mut planes = [(); 3].map(|()| vec![f32::NAN; 256]);
            let block = Block::of(Window::sized(256, 1), [0.5; 2]);
            let outs = planes.each_mut().map(|plane| Some(&mut plane[..]));
            read.fill(&block, &Inputs::new(&[]), &mut Outputs::new([outs])).unwrap();
            for byte in 0..256 {
                let found = planes.each_ref().map(|plane| plane[byte]);
                let light = [formula(byte as f64 / 255.0); 3];
                if space == WorkingSpace::AcesCg {
                    let expected = space.from_linear_srgb(light);
                    assert!((0..3).all(|c| (f64::from(found[c]) - expected[c]).abs() < 1e-6), "{byte}: {found:?}");
                } else {
                    let expected = light.map(|v| v as f32);
                    assert_eq!(found.map(f32::to_bits), expected.map(f32::to_bits), "{space} {encoding}, {byte}");
                }
                let truth = sole_reference(&*read, &context, [byte as f64 + 0.5, 0.5]).unwrap();
                assert!((0..3).all(|c| (f64::from(found[c]) - truth[c]).abs() < 1e-6), "{byte}: {truth:?}");
            }
        }
    }
}
