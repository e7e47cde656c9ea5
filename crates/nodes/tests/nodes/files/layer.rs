//! Tests of how a picture is laid over the document's.

use crate::testing::{graph, prepare, sole_reference};
use trochoid_graph::{Block, FrameContext, Inputs, NodeError, Outputs, Pool, Prepared};
use trochoid_image::{Format, Window};
use trochoid_io::{ExrChannel, ExrImage, Samples, write_exr};
use trochoid_nodes::inside::Holding;

/// A decoded picture.
struct Layer {
    context: FrameContext,
    prepared: Box<dyn Prepared>,
}

/// Reads a picture with these windows for formats, the one being rendered and the whole one.
fn laid(
    fit: Option<&str>,
    [display, data]: [Window; 2],
    [format, whole]: [[u32; 2]; 2],
    samples: &[f32],
    outside: Option<f32>,
) -> Result<Layer, NodeError> {
    let folder = tempfile::tempdir().unwrap();
    let channels = vec![ExrChannel::float("Y", Samples::contiguous(samples))];
    write_exr(folder.path().join("a.exr"), &ExrImage { channels, display, ..ExrImage::new(data) }).unwrap();
    let fit = fit.map_or(String::new(), |fit| format!(r#", "fit": "{fit}""#));
    let outside = outside.map_or(String::new(), |value| format!(r#", "outside": [{value}, {value}, {value}]"#));
    let node = format!(r#""out": {{ "type": "Read", "file": "a.exr", "as": "color"{fit}{outside} }}"#);
    let graph = graph("color", &node, folder.path()).unwrap();
    let mut context = graph.frame_context(1, 1 << 30);
    [context.format, context.document_format] =
        [format, whole].map(|[width, height]| Format::new(width, height, 1).unwrap());
    let holding = Holding { on_demand: None, whole: u64::MAX };
    let prepared = prepare(&graph, "out", &context, Some(holding), &Pool::new())?;
    Ok(Layer { context, prepared })
}

/// Reads a picture of 2 × 2 pixels.
fn layer(fit: Option<&str>, format: [u32; 2], outside: Option<f32>) -> Layer {
    laid(fit, [Window::new(-1, 0, 1, 2); 2], [format; 2], &[0.0, 1.0, 2.0, 3.0], outside).unwrap()
}

impl Layer {
    /// Returns the window of the picture in the document's pixels.
    fn window(&self) -> Window {
        self.prepared.data_window(Window::sized(0, 0), &|_| Window::sized(0, 0))
    }

    /// Returns the samples in a window, which are those of the reference.
    fn filled(&self, window: Window) -> Vec<f32> {
        let mut planes = [(); 3].map(|()| vec![f32::NAN; window.area()]);
        let block = Block::of(window, [0.5, 0.5]);
        let outs = planes.each_mut().map(|plane| Some(&mut plane[..]));
        self.prepared.fill(&block, &Inputs::new(&[]), &mut Outputs::new([outs])).unwrap();
        let [out, ..] = planes;
        for (value, at) in out.iter().zip(block.places()) {
            let truth = sole_reference(&*self.prepared, &self.context, at).unwrap()[0];
            assert!((f64::from(*value) - truth).abs() < 1e-6, "{at:?}: {value} and {truth}");
        }
        out
    }
}

#[test]
fn equal_sizes_lie_pixel_on_pixel() {
    assert_eq!(layer(None, [2, 2], None).filled(Window::sized(2, 2)), [0.0, 1.0, 2.0, 3.0]);
}

#[test]
fn a_smaller_drawing_takes_the_same_part_and_errors_name_the_document() {
    let fit = |fit: Option<&str>, display: Window| {
        laid(fit, [display; 2], [[4, 2], [8, 4]], &vec![0.5; display.area()], None)
    };
    assert_eq!(fit(None, Window::sized(8, 4)).unwrap().window(), Window::sized(4, 2));
    let large = Window::sized(12, 8);
    assert_eq!(fit(Some("crop"), large).unwrap().window(), Window::sized(6, 4));
    assert_eq!(fit(Some("nearest"), large).unwrap().window(), Window::sized(4, 2));
    // The rendered size equals the picture's, but the document's does not.
    let error = fit(None, Window::sized(4, 2)).err().unwrap().to_string();
    assert!(error.contains("4 × 2 pixels, expected 8 × 4"), "{error}");
}

#[test]
fn the_window_is_that_of_the_document() {
    let of = |fit: Option<&str>, format: [u32; 2]| layer(fit, format, None).window();
    assert_eq!(of(None, [2, 2]), Window::sized(2, 2));
    assert_eq!(of(Some("crop"), [9, 1]), Window::sized(2, 2));
    assert_eq!(of(Some("bilinear"), [4, 1]), Window::sized(4, 1));
    // The data window extends one pixel beyond the display window, to the right and below.
    let windows = [Window::new(-1, 0, 1, 2), Window::new(-1, 0, 2, 3)];
    let window = |fit: Option<&str>, width: u32| laid(fit, windows, [[width, 2]; 2], &[0.0; 9], None).unwrap().window();
    assert_eq!(window(None, 2), Window::sized(3, 3));
    assert_eq!(window(Some("nearest"), 5), Window::sized(8, 3));
}

#[test]
fn other_sizes_need_a_fit() {
    let error = laid(None, [Window::sized(2, 2); 2], [[4, 2]; 2], &[0.0; 4], None).err().unwrap();
    assert!(error.to_string().contains("2 × 2") && error.to_string().contains("\"fit\""), "{error}");
}

#[test]
fn crop_repeats_the_edge_or_takes_the_outside() {
    let window = Window::sized(3, 1);
    assert_eq!(layer(Some("crop"), [3, 3], None).filled(window), [0.0, 1.0, 1.0]);
    assert_eq!(layer(Some("crop"), [3, 3], Some(9.0)).filled(window), [0.0, 1.0, 9.0]);
}

#[test]
fn rows_are_copied_from_any_place() {
    for outside in [None, Some(9.0)] {
        let layer = layer(Some("crop"), [3, 3], outside);
        for (x0, x1) in [(-9, -5), (-3, 1), (-2, 5), (0, 2), (1, 2), (2, 7), (8, 9)] {
            for y0 in -3..4 {
                layer.filled(Window::new(x0, y0, x1, y0 + 2));
            }
        }
    }
}

#[test]
fn scaling_up_repeats_or_blends() {
    let window = Window::sized(4, 1);
    assert_eq!(layer(Some("nearest"), [4, 4], None).filled(window), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(layer(Some("bilinear"), [4, 2], None).filled(window), [0.0, 0.25, 0.75, 1.0]);
    assert_eq!(layer(Some("bilinear"), [1, 1], None).filled(Window::sized(1, 1)), [1.5]);
}
