//! Writing of evaluated frames to files.

use crate::Form;
use crate::exr_layer::convert;
use crate::files::{folder_of_file, target};
use crate::join::{REGION, region_text};
use crate::marks::with_mark;
use crate::output_file::{OutputError, OutputFile};
use crate::stream::write_layers;
use trochoid_engine::{Frame, Picture};
use trochoid_graph::{CheckedGraph, Kind, OutputSpec, Precision};
use trochoid_image::{Plane, Window, WorkingSpace};
use trochoid_io::{PngImage, Samples, write_png8, write_png16};

/// Writes one file of an evaluated frame, which appears whole or not at all, and creates missing folders.
///
/// EXR stores linear light in the primaries of the working space (a display-encoded `srgb` is decoded), so that any
/// reader shows it correctly. PNG is encoded as sRGB. The metadata of both name Trochoid. Foreign files are replaced
/// only if the graph's [access rights](trochoid_graph::Access::overwrites) allow it.
///
/// # Errors
/// A value does not fit in the file's precision, the file cannot be written, or a foreign file is there.
pub fn write_output(
    graph: &CheckedGraph,
    frame: &Frame,
    file: &OutputFile,
    metadata: &[(String, String)],
) -> Result<(), OutputError> {
    folder_of_file(&file.path)?;
    let is_png = file.path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    let metadata = &with_mark(metadata);
    if is_png { write_png(graph, frame, file, metadata) } else { write_layers(graph, frame, file, metadata) }
}

fn pictures<'f>(graph: &'f CheckedGraph, frame: &'f Frame, file: &OutputFile) -> Vec<(&'f OutputSpec, &'f Picture)> {
    let chosen = frame.pictures.iter().filter(|picture| file.outputs.contains(&picture.output));
    chosen.map(|picture| (&graph.outputs()[picture.output], picture)).collect()
}

fn write_png(
    graph: &CheckedGraph,
    frame: &Frame,
    file: &OutputFile,
    metadata: &[(String, String)],
) -> Result<(), OutputError> {
    let Some((spec, picture)) = pictures(graph, frame, file).into_iter().next() else { return Ok(()) };
    let space = graph.space();
    let linear = picture.kind == Kind::Color && space != WorkingSpace::Srgb;
    let rgb = color_rows(&picture.planes).filter(|_| linear);
    let encoded = rgb.map(|rgb| convert(rgb, |color| space.to_display(color)));
    let window: Window = frame.window;
    let channels = samples_of(&picture.planes, encoded.as_ref());
    let mut image = PngImage::new(window.width() as u32, window.height() as u32, channels);
    image.metadata = metadata.to_vec();
    let whole = graph.format().window();
    if window != whole {
        image.metadata.push((REGION.into(), region_text(window, whole)));
    }
    let target = target(&file.path, Form::Png, graph.access().overwrites());
    match spec.precision {
        Some(Precision::Uint16) => write_png16(target, &image)?,
        _ => write_png8(target, &image)?,
    }
    Ok(())
}

/// Returns the channels of a color.
fn color_rows(planes: &[Plane]) -> Option<[&[f32]; 3]> {
    match planes {
        [r, g, b] => Some([r.samples(), g.samples(), b.samples()]),
        _ => None,
    }
}

/// Returns the samples to write: those of the planes, or the converted ones.
fn samples_of<'s>(planes: &'s [Plane], converted: Option<&'s [Vec<f32>; 3]>) -> Vec<Samples<'s>> {
    match converted {
        Some(color) => color.iter().map(|channel| Samples::contiguous(channel)).collect(),
        None => planes.iter().map(Samples::plane).collect(),
    }
}
