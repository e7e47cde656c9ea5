//! Certified bounds of single pixels, held against those of whole pictures.

use super::settings;
use trochoid::{Buffers, Cache, Certified, Certifier, CheckedGraph, Frame, ReferenceFrame, Silent};

/// Checks that single pixels are certified like the whole picture, bit for bit, with the picture's own values, and that
/// the references of all outputs together are those of each.
pub(crate) fn pixels_are_as_the_whole(
    graph: &CheckedGraph,
    number: i64,
    frame: &Frame,
    whole: &[Certified],
    what: &str,
) {
    let window = whole[0].window;
    let index = |[x, y]: [i64; 2]| (y - window.y0) as usize * window.width() + (x - window.x0) as usize;
    // From the end to the start, few enough that most are certified in windows of their own.
    let pixels: Vec<[i64; 2]> = (0..window.area())
        .rev()
        .step_by((window.area() / 5).max(1))
        .map(|at| [window.x0 + (at % window.width()) as i64, window.y0 + (at / window.width()) as i64])
        .collect();
    let certifier = Certifier::new(graph, &[], number, &[], &settings(|_| ())).unwrap();
    let found = certifier.certify_pixels(&pixels, &Buffers::new(), &mut Cache::new(), &Silent).unwrap();
    let names: Vec<&str> = graph.outputs().iter().map(|output| output.name.as_str()).collect();
    let together = ReferenceFrame::prepared(graph, &names, number, &mut Cache::new(), &Silent).unwrap();
    let together = together.pixels(&pixels, &Silent).unwrap();
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    for (output, (found, whole)) in found.iter().zip(whole).enumerate() {
        let name = names[output];
        assert_eq!((found.output, &found.palette), (whole.output, &whole.palette), "{what}: {name}");
        assert_eq!((found.margin, &found.unbounded), (whole.margin, &whole.unbounded), "{what}: {name}");
        let picture = &frame.pictures[output];
        let alone = ReferenceFrame::new(graph, name, number).unwrap();
        for (at, pixel) in pixels.iter().enumerate() {
            let place = index(*pixel);
            let [of_pixel, of_whole] = [(&found.errors, at), (&whole.errors, place)]
                .map(|(errors, at)| errors.iter().map(|channel| channel[at]).collect::<Vec<f32>>());
            assert_eq!(bits(&of_pixel), bits(&of_whole), "{what}: bound of {name} at {pixel:?}");
            assert_eq!(found.doubt[at], whole.doubt[place], "{what}: doubt of {name} at {pixel:?}");
            for (channel, infinite) in found.infinite.iter().enumerate() {
                assert_eq!(infinite[at], whole.infinite[channel][place], "{what}: {name} at {pixel:?}");
            }
            for (channel, values) in found.values.iter().enumerate() {
                let drawn = picture.planes[channel].samples()[place];
                assert_eq!(values[at].to_bits(), drawn.to_bits(), "{what}: value of {name} at {pixel:?}");
            }
            let reference = alone.pixel(pixel[0], pixel[1]).unwrap();
            let same = reference.iter().zip(&together[at][output].value).all(|(a, b)| a.to_bits() == b.to_bits());
            assert!(same, "{what}: reference of {name} at {pixel:?}: {reference:?}, {:?}", together[at][output].value);
        }
    }
}
