//! Reading and writing of EXR: one band, and a whole HD picture.

use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use trochoid_image::{Plane, Window};
use trochoid_io::{
    BandBuffer, EncodeScratch, ExrChannel, ExrHeader, ExrImage, ExrReader, ExrWriter, Limits, SampleType, Samples,
    Selection, read, write_exr,
};

const HD: Window = Window::sized(1920, 1080);
const TYPES: [SampleType; 2] = [SampleType::Half, SampleType::Float];

fn main() {
    divan::main();
}

/// Returns three planes of a smooth picture with noise in its low bits, like the pictures of renderers.
fn planes() -> Vec<Plane> {
    let mut seed = 1_u32;
    let mut noise = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 16) as f32 / 65536.0
    };
    let mut value = |x: usize, y: usize, c: usize| ((x + 3 * y) as f32 * 0.002 + c as f32).sin().abs() + 0.01 * noise();
    let samples = |c: usize| (0..HD.area()).map(|i| value(i % HD.width(), i / HD.width(), c)).collect();
    [0, 1, 2].map(samples).map(|samples| Plane::new(HD, samples).expect("as many samples as pixels")).into()
}

fn image(planes: &[Plane], sample_type: SampleType) -> ExrImage<'_> {
    let channel = |(name, plane): (&str, _)| match sample_type {
        SampleType::Half => ExrChannel::half(name, Samples::plane(plane)),
        _ => ExrChannel::float(name, Samples::plane(plane)),
    };
    ExrImage { channels: ["R", "G", "B"].into_iter().zip(planes).map(channel).collect(), ..ExrImage::new(HD) }
}

fn bytes(pixels: usize, sample_type: SampleType) -> BytesCount {
    BytesCount::new(pixels * 3 * sample_type.bytes())
}

#[divan::bench(args = TYPES, sample_count = 20)]
fn encode_band(bencher: Bencher<'_, '_>, sample_type: SampleType) {
    let folder = tempfile::tempdir().expect("a folder");
    let channels = ["R", "G", "B"].map(|name| (name.into(), sample_type)).into();
    let header = ExrHeader { channels, ..ExrHeader::new(HD) };
    let writer = ExrWriter::create(folder.path().join("a.exr"), &header).expect("a file");
    let (planes, area) = (planes(), writer.band_window(0).area());
    let rows: Vec<&[f32]> = planes.iter().map(|plane| &plane.samples()[..area]).collect();
    let mut scratch = EncodeScratch::new();
    bencher.counter(bytes(area, sample_type)).bench_local(|| writer.encode(0, &rows, &mut scratch));
}

#[divan::bench(args = TYPES, sample_count = 20)]
fn decode_band(bencher: Bencher<'_, '_>, sample_type: SampleType) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    write_exr(&path, &image(&planes(), sample_type)).expect("a file");
    let reader = ExrReader::open(&path, &Selection::default(), &Limits::default()).expect("the same file");
    let mut buffer = BandBuffer::new();
    let area = reader.band_window(0).area();
    bencher.counter(bytes(area, sample_type)).bench_local(|| reader.decode(black_box(0), &mut buffer));
}

#[divan::bench(args = TYPES, sample_count = 10)]
fn write_hd(bencher: Bencher<'_, '_>, sample_type: SampleType) {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, planes) = (folder.path().join("a.exr"), planes());
    bencher.counter(bytes(HD.area(), sample_type)).bench_local(|| write_exr(&path, &image(&planes, sample_type)));
}

#[divan::bench(args = TYPES, sample_count = 10)]
fn read_hd(bencher: Bencher<'_, '_>, sample_type: SampleType) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.exr");
    write_exr(&path, &image(&planes(), sample_type)).expect("a file");
    let limits = Limits::default();
    bencher.counter(bytes(HD.area(), sample_type)).bench_local(|| read(&path, &Selection::default(), &limits));
}
