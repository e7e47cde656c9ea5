//! Rows read on demand equal those of the decoded picture, bit for bit, and so do their errors.

use crate::testing::{graph, prepare, sole_reference};
use exr::compression::Compression as Method;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{IntegerBounds, LineOrder};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use rayon::prelude::*;
use std::path::Path;
use trochoid_graph::{Block, CheckedGraph, FrameContext, Inputs, Kind, NodeError, Outputs, Pool, Prepared};
use trochoid_image::{Format, Window};
use trochoid_nodes::inside::Holding;

type Channels<'c> = [(&'c str, Vec<f32>)];

fn write(path: &Path, data: Window, display: (usize, usize), way: (Method, Blocks), channels: &Channels<'_>) {
    let channels: Vec<_> =
        channels.iter().map(|(name, samples)| AnyChannel::new(*name, FlatSamples::F32(samples.clone()))).collect();
    let layer = Layer::new(
        (data.width(), data.height()),
        LayerAttributes::default().with_position(Vec2(data.x0 as i32, data.y0 as i32)),
        Encoding { compression: way.0, blocks: way.1, line_order: LineOrder::Increasing },
        AnyChannels::sort(channels.into_iter().collect()),
    );
    let image = Image { attributes: ImageAttributes::new(IntegerBounds::new((0, 0), display)), layer_data: layer };
    image.write().to_file(path).unwrap();
}

/// A Read with given knobs.
struct Case {
    graph: CheckedGraph,
    context: FrameContext,
    kind: Kind,
}

impl Case {
    fn new(folder: &Path, format: (u32, u32), key: &str, knobs: &str) -> Self {
        let node = format!(r#""out": {{ "type": "Read", "file": "a.exr", {knobs} }}"#);
        let graph = graph(key, &node, folder).unwrap();
        let mut context = graph.frame_context(1, 1 << 30);
        context.format = Format::new(format.0, format.1, 1).unwrap();
        context.document_format = context.format;
        let kind = graph.node(graph.find("out").unwrap()).kinds[0];
        Self { graph, context, kind }
    }

    /// Prepares the picture to be read on demand.
    fn stream(&self, pool: &Pool) -> Box<dyn Prepared> {
        let holding = Holding { on_demand: Some(0), whole: u64::MAX };
        prepare(&self.graph, "out", &self.context, Some(holding), pool).unwrap()
    }

    /// Decodes the picture.
    fn decoded(&self) -> Result<Box<dyn Prepared>, NodeError> {
        let holding = Holding { on_demand: None, whole: u64::MAX };
        prepare(&self.graph, "out", &self.context, Some(holding), &Pool::new())
    }

    fn fill(
        &self,
        picture: &dyn Prepared,
        block: &Block<'_>,
        unwanted: Option<usize>,
    ) -> Result<Vec<Vec<f32>>, NodeError> {
        let mut planes = vec![vec![f32::NAN; block.window.area()]; self.kind.channels()];
        let outs =
            planes.iter_mut().enumerate().map(|(index, plane)| (unwanted != Some(index)).then_some(&mut plane[..]));
        picture.fill(block, &Inputs::new(&[]), &mut Outputs::new([outs]))?;
        Ok(planes)
    }

    fn reference(&self, picture: &dyn Prepared, at: [f64; 2]) -> Result<Vec<f64>, NodeError> {
        sole_reference(picture, &self.context, at)
    }
}

fn bits(planes: &[Vec<f32>]) -> Vec<u32> {
    planes.iter().flatten().map(|v| v.to_bits()).collect()
}

/// Compares a stream with the decoded picture, over windows of all sizes, on several threads.
fn same(case: &Case, what: &str) {
    let (decoded, stream) = (case.decoded().unwrap(), case.stream(&Pool::new()));
    let mut blocks = Vec::new();
    for (width, height) in [(1, 1), (3, 2), (7, 40), (60, 16), (90, 90)] {
        for (x, y) in [(0, 0), (-20, -9), (5, 17), (33, 30), (70, 80)] {
            for offset in [[0.5, 0.5], [0.125, 0.875]] {
                blocks.push(Block::of(Window::new(x, y, x + width, y + height), offset));
            }
        }
    }
    blocks.par_iter().enumerate().for_each(|(index, block)| {
        let fill = |picture: &dyn Prepared| bits(&case.fill(picture, block, Some(index % 4)).unwrap());
        assert_eq!(fill(&*stream), fill(&*decoded), "{what}: {block:?}");
        let at = [block.window.x0 as f64 + block.offset[0], block.window.y0 as f64 + block.offset[1]];
        let reference = |picture: &dyn Prepared| case.reference(picture, at).unwrap();
        assert_eq!(reference(&*stream), reference(&*decoded), "{what}: at {at:?}");
    });
    // The blocks need not have included every row, of which there are three per sample at most.
    if matches!(case.kind, Kind::Weights(_)) {
        let nowhere = Window::sized(0, 0);
        let all = stream.data_window(nowhere, &|_| nowhere);
        for part in 0..4 {
            let column = Window::new(all.x0, all.y0, all.x0 + 1, all.y1);
            case.fill(&*stream, &Block::of(column, [0.5, f64::from(part) / 4.0]), None).unwrap();
        }
    }
    assert_eq!(stream.repaired(), decoded.repaired(), "{what}");
    assert_eq!(stream.controls(), decoded.controls(), "{what}");
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
    assert!(case.stream(&Pool::new()).rows_per_band().is_some() && case.decoded().unwrap().rows_per_band().is_none());
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
    let cases: Vec<Case> = (0..5)
        .map(|index| {
            let knobs = format!(r#""as": "field", "layer": "sea.c{index}""#);
            Case::new(folder.path(), (40, 640), "field", &knobs)
        })
        .collect();
    let streams: Vec<Box<dyn Prepared>> = cases.iter().map(|case| case.stream(&pool)).collect();
    let tiles: Vec<Window> = data.tiles(40, 16).collect();
    let check = |picked: std::ops::Range<usize>, offset: f64| {
        tiles.par_iter().for_each(|tile| {
            for index in picked.clone() {
                let found = cases[index].fill(&*streams[index], &Block::of(*tile, [offset; 2]), None).unwrap();
                let start = tile.y0 as usize * 40;
                assert_eq!(found[0], channels[index].1[start..start + tile.area()]);
            }
        });
    };
    check(0..1, 0.25);
    assert!(streams.iter().map(|stream| stream.bytes()).sum::<usize>() >= 5 * 4 * data.area() / 2);
    assert_eq!(streams[0].rows_per_band(), Some(16));
    // What one of them has decoded, no other reads again.
    std::fs::OpenOptions::new().write(true).open(folder.path().join("a.exr")).unwrap().set_len(0).unwrap();
    check(0..5, 0.25);
    check(0..5, 0.75);
    let alone = &cases[0];
    assert!(prepare(&alone.graph, "out", &alone.context, None, &Pool::new()).is_err(), "the file is gone");
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
    let decoded = case.decoded().err().unwrap().to_string();
    assert!(decoded.contains("channel \"u\", pixel (1, 5000): found NaN"), "{decoded}");
    for rows in [5496..5512, 0..16, 4999..5001] {
        let window = Window::new(2, rows.start, 3, rows.end);
        let stream = case.stream(&Pool::new());
        let block = Block::of(window, [0.5; 2]);
        assert_eq!(case.fill(&*stream, &block, None).unwrap_err().to_string(), decoded);
        assert_eq!(case.reference(&*stream, [2.5, rows.start as f64 + 4.5]).is_err(), rows.start == 5496);
    }
    let fine = Block::of(Window::sized(3, 2), [0.5; 2]);
    case.fill(&*case.stream(&Pool::new()), &fine, None).unwrap();
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
        case.fill(&*stream, &part(0), None).unwrap();
        let first = case.fill(&*stream, &part(190), None).unwrap_err().to_string();
        assert!(first.contains("the end of the file") || first.contains("an offset from"), "{first}");
        assert_eq!(case.fill(&*stream, &part(150), None).unwrap_err().to_string(), first);
    }
}
