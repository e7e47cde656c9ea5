//! Rows read on demand equal those of the decoded picture, bit for bit, and so do their errors.

use super::knobs::FitBy;
use super::read::Read;
use super::{Fit, Layer, Reading, Rows, Stream, controls, walked};
use crate::testing::graph;
use exr::compression::Compression as Method;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer as ExrLayer};
use exr::math::Vec2;
use exr::meta::attribute::{IntegerBounds, LineOrder};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use rayon::prelude::*;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use trochoid_graph::{Block, Choice, FrameContext, NodeError, Pool, Prepare};
use trochoid_image::{Format, Rgb, Window};

type Channels<'c> = [(&'c str, Vec<f32>)];

fn write(path: &Path, data: Window, display: (usize, usize), way: (Method, Blocks), channels: &Channels<'_>) {
    let channels: Vec<_> =
        channels.iter().map(|(name, samples)| AnyChannel::new(*name, FlatSamples::F32(samples.clone()))).collect();
    let layer = ExrLayer::new(
        (data.width(), data.height()),
        LayerAttributes::default().with_position(Vec2(data.x0 as i32, data.y0 as i32)),
        Encoding { compression: way.0, blocks: way.1, line_order: LineOrder::Increasing },
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let image = Image { attributes: ImageAttributes::new(IntegerBounds::new((0, 0), display)), layer_data: layer };
    image.write().to_file(path).unwrap();
}

/// Input of a Read with given knobs.
struct Case {
    node: Read,
    context: FrameContext,
    kind: trochoid_graph::Kind,
    outside: Option<Rgb>,
}

impl Case {
    fn new(folder: &Path, format: (u32, u32), key: &str, knobs: &str) -> Self {
        let node = format!(r#""out": {{ "type": "Read", "file": "a.exr", {knobs} }}"#);
        let graph = graph(key, &node, folder).unwrap();
        let mut context = graph.frame_context(1, 1 << 30);
        context.format = Format::new(format.0, format.1, 1).unwrap();
        context.document_format = context.format;
        let settled = graph.settle(graph.find("out").unwrap(), 1);
        let kind = settled.kinds()[0];
        let node = settled.get::<Read>().unwrap().clone();
        let outside = node.outside.map(|color| color.map(|v| v as f32));
        Self { node, context, kind, outside }
    }

    fn reading<T>(&self, f: impl FnOnce(Reading<'_>) -> T) -> T {
        let path = self.context.path("a.exr");
        f(self.node.reading(&self.context, &path))
    }

    fn stream(&self, pool: &Pool) -> Stream {
        let wanted = vec![true; self.kind.channels()];
        let wanted = [wanted];
        let prepare = Prepare::new(&self.context, &[], &wanted, &|_| None, &|| false, pool);
        let found = self.reading(|reading| reading.on_demand(&prepare, self.kind, &wanted[0], 0));
        found.unwrap().expect("it can be streamed").0
    }

    /// Decodes the picture, and returns its layers and the number of repaired values.
    fn layers(&self) -> Result<(Vec<Layer>, u64), NodeError> {
        let mut fit = None;
        let planes = self.reading(|reading| {
            reading.planes(self.kind, &vec![true; self.kind.channels()], &mut |picture| {
                fit = Some(Fit::new(
                    self.node.fit,
                    FitBy::WORDS,
                    picture.display,
                    [self.context.format; 2],
                    Path::new("a.exr"),
                )?);
                Ok(())
            })
        })?;
        let repaired = planes.repaired;
        let layers = planes.channels().enumerate().map(|(channel, plane)| {
            let (plane, exact) = plane.unwrap();
            Layer::new(plane, fit.unwrap(), self.outside.map(|color| color[channel])).with_exact(exact)
        });
        Ok((layers.collect(), repaired))
    }
}

fn fill(stream: &Stream, block: &Block<'_>, unwanted: Option<usize>) -> Result<Vec<Vec<f32>>, NodeError> {
    let mut planes = vec![vec![f32::NAN; block.window.area()]; stream.outputs];
    let mut outs: Vec<Option<&mut [f32]>> = planes
        .iter_mut()
        .enumerate()
        .map(|(index, plane)| (unwanted != Some(index)).then_some(&mut plane[..]))
        .collect();
    stream.fill(block, &mut outs)?;
    Ok(planes)
}

fn bits(samples: &[f32]) -> Vec<u32> {
    samples.iter().map(|v| v.to_bits()).collect()
}

/// Compares a stream with the decoded picture, over windows of all sizes, on several threads.
fn same(case: &Case, what: &str) {
    let (layers, repaired) = case.layers().unwrap();
    let stream = case.stream(&Pool::new());
    let mut blocks = Vec::new();
    for (width, height) in [(1, 1), (3, 2), (7, 40), (60, 16), (90, 90)] {
        for (x, y) in [(0, 0), (-20, -9), (5, 17), (33, 30), (70, 80)] {
            for offset in [[0.5, 0.5], [0.125, 0.875]] {
                blocks.push(Block::of(Window::new(x, y, x + width, y + height), offset));
            }
        }
    }
    blocks.par_iter().enumerate().for_each(|(index, block)| {
        let unwanted = Some(index % 4);
        for (channel, plane) in fill(&stream, block, unwanted).unwrap().iter().enumerate() {
            if unwanted != Some(channel) {
                let mut expected = vec![f32::NAN; plane.len()];
                layers[channel].fill(block, &mut expected);
                assert_eq!(bits(plane), bits(&expected), "{what}: channel {channel} of {block:?}");
            }
        }
        let at = [block.window.x0 as f64 + block.offset[0], block.window.y0 as f64 + block.offset[1]];
        let truth: Vec<f64> = layers.iter().map(|layer| layer.reference(at)).collect();
        assert_eq!(stream.reference(at).unwrap(), truth, "{what}: at {at:?}");
    });
    // The windows need not have included every row.
    stream.each_row(0..stream.stored.data.height(), |_| Ok(())).unwrap();
    assert_eq!(stream.repaired(), repaired, "{what}");
    if case.kind == trochoid_graph::Kind::Color {
        let [r, g, b] = [0, 1, 2].map(|channel| layers[channel].samples());
        assert_eq!(walked(&stream, &|| false).unwrap(), controls([r, g, b]), "{what}");
    }
}

fn noise(count: usize, salt: u32) -> Vec<f32> {
    let mut state = salt;
    let mut draw = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| draw()).collect()
}

#[test]
fn a_stream_is_the_decoded_picture() {
    let folder = tempfile::tempdir().unwrap();
    let scan = Blocks::ScanLines;
    let ways = [
        (Method::ZIP16, scan),
        (Method::ZIP1, scan),
        (Method::PIZ, scan),
        (Method::Uncompressed, scan),
        (Method::ZIP16, Blocks::Tiles(Vec2(16, 16))),
        (Method::ZIP1, Blocks::Tiles(Vec2(13, 70))),
    ];
    let windows = [Window::new(0, 0, 60, 75), Window::new(11, 7, 40, 60), Window::new(-5, -9, 71, 83)];
    for (number, (way, data)) in ways.iter().flat_map(|way| windows.map(|data| (way, data))).enumerate() {
        let area = data.area();
        let mut channels = vec![("R", noise(area, 1)), ("G", noise(area, 2)), ("B", noise(area, 3))];
        // Illegal values for weights and colors, and a negative zero.
        (channels[1].1[area / 2], channels[1].1[3], channels[2].1[area - 1]) = (-0.5, -0.0, f32::INFINITY);
        channels.push(("one", vec![1.0; area]));
        channels.push(("rest", channels[0].1.iter().map(|v| 1.0 - v).collect()));
        write(&folder.path().join("a.exr"), data, (60, 75), *way, &channels);
        for (format, fit) in [((60, 75), ""), ((50, 80), "crop"), ((31, 90), "nearest"), ((97, 33), "bilinear")] {
            if number > 2 && !matches!(fit, "" | "bilinear") {
                continue;
            }
            let fit = if fit.is_empty() { String::new() } else { format!(r#", "fit": "{fit}""#) };
            for (key, knobs) in [
                ("field", r#""as": "field", "channels": ["B", "G"]"#),
                ("weights", r#""as": "weights", "channels": ["G"], "repair": true"#),
                ("weights", r#""as": "weights", "channels": ["R", "rest"]"#),
                ("weights", r#""as": "weights", "channels": ["R", "G", "rest", "B"], "repair": true"#),
                ("color", r#""as": "color", "repair": true"#),
                ("color", r#""as": "color", "channels": ["R"], "encoding": "srgb", "outside": [1, 2, 3]"#),
                ("color", r#""as": "color", "repair": true, "outside": [1, 2, 3], "encoding": "srgb""#),
            ] {
                let case = Case::new(folder.path(), format, key, &format!("{knobs}{fit}"));
                same(&case, &format!("{way:?}, {data}, {knobs}{fit}"));
            }
        }
    }
}

#[test]
fn many_colors_are_walked_to_the_same_hull() {
    let folder = tempfile::tempdir().unwrap();
    let data = Window::sized(300, 240);
    let channels = [1, 2, 3].map(|salt| noise(data.area(), salt));
    let [r, g, b] = channels;
    write(
        &folder.path().join("a.exr"),
        data,
        (300, 240),
        (Method::ZIP16, Blocks::ScanLines),
        &[("R", r), ("G", g), ("B", b)],
    );
    let case = Case::new(folder.path(), (300, 240), "color", r#""as": "color""#);
    same(&case, "many colors");
}

#[test]
fn reads_of_one_file_decode_it_once() {
    let folder = tempfile::tempdir().unwrap();
    let data = Window::sized(40, 640);
    let channels: Vec<(String, Vec<f32>)> =
        (0..5).map(|index| (format!("sea.c{index}.V"), noise(data.area(), index))).collect();
    let named: Vec<(&str, Vec<f32>)> = channels.iter().map(|(name, plane)| (&**name, plane.clone())).collect();
    write(&folder.path().join("a.exr"), data, (40, 640), (Method::ZIP16, Blocks::ScanLines), &named);
    let pool = Pool::new();
    let streams: Vec<Stream> = (0..5)
        .map(|index| {
            let knobs = format!(r#""as": "field", "layer": "sea.c{index}""#);
            Case::new(folder.path(), (40, 640), "field", &knobs).stream(&pool)
        })
        .collect();
    let tiles: Vec<Window> = data.tiles(40, 16).collect();
    for offset in [0.25, 0.75] {
        tiles.par_iter().for_each(|tile| {
            for (stream, (_, plane)) in streams.iter().zip(&channels) {
                let found = fill(stream, &Block::of(*tile, [offset; 2]), None).unwrap();
                let start = tile.y0 as usize * 40;
                assert_eq!(found[0], plane[start..start + tile.area()]);
            }
        });
    }
    let Rows::File(file, _) = &streams[0].rows else { panic!("a file") };
    assert_eq!(Arc::strong_count(file), 5);
    assert_eq!(file.decoded.load(Ordering::Relaxed), 40, "each of 40 blocks once");
    assert_eq!(streams[0].rows_per_band(), Some(16));
    assert!(streams.iter().map(Stream::bytes).sum::<usize>() >= 5 * 4 * data.area() / 2);
}

#[test]
fn the_first_fault_is_reported_whoever_asks() {
    let folder = tempfile::tempdir().unwrap();
    let data = Window::sized(3, 6000);
    let mut plane = noise(data.area(), 1);
    plane[3 * 5000 + 1] = f32::NAN;
    plane[3 * 5500] = f32::NAN;
    let mut other = noise(data.area(), 2);
    other[7] = f32::NAN;
    let path = folder.path().join("a.exr");
    write(&path, data, (3, 6000), (Method::ZIP16, Blocks::ScanLines), &[("u", plane), ("v", other)]);
    let case = Case::new(folder.path(), (3, 6000), "field", r#""as": "field", "channels": ["u", "v"]"#);
    let decoded = case.layers().err().unwrap().to_string();
    assert!(decoded.contains("channel \"u\", pixel (1, 5000): found NaN"), "{decoded}");
    for rows in [5496..5512, 0..16, 4999..5001] {
        let window = Window::new(2, rows.start, 3, rows.end);
        let stream = case.stream(&Pool::new());
        let block = Block::of(window, [0.5; 2]);
        assert_eq!(fill(&stream, &block, None).unwrap_err().to_string(), decoded);
        assert_eq!(stream.reference([2.5, rows.start as f64 + 4.5]).is_err(), rows.start == 5496);
    }
    let fine = Block::of(Window::sized(3, 2), [0.5; 2]);
    fill(&case.stream(&Pool::new()), &fine, None).unwrap();
}

#[test]
fn a_truncated_file_is_refused_where_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let data = Window::sized(64, 200);
    let path = folder.path().join("a.exr");
    let channels = [("u", noise(data.area(), 1))];
    for way in [(Method::ZIP16, Blocks::ScanLines), (Method::PIZ, Blocks::Tiles(Vec2(32, 32)))] {
        write(&path, data, (64, 200), way, &channels);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let case = Case::new(folder.path(), (64, 200), "field", r#""as": "field""#);
        let stream = case.stream(&Pool::new());
        let part = |y0: i64| Block::of(Window::new(0, y0, 64, y0 + 10), [0.5; 2]);
        fill(&stream, &part(0), None).unwrap();
        let first = fill(&stream, &part(190), None).unwrap_err().to_string();
        assert!(first.contains("the end of the file") || first.contains("an offset from"), "{first}");
        assert_eq!(fill(&stream, &part(150), None).unwrap_err().to_string(), first);
    }
}
