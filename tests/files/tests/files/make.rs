//! Construction of small files, byte by byte or with the `exr` crate.

use std::io::{Cursor, Write};

use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer, Levels as ExrLevels, RipMaps};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{IntegerBounds, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::NamedTempFile;

use trochoid_io::{Error, Info, Levels, Limits, Picture, Selection};

pub(super) use exr::compression::Compression as Method;

/// All methods that the `exr` crate writes.
pub(super) const METHODS: [Method; 10] = [
    Method::Uncompressed,
    Method::RLE,
    Method::ZIP1,
    Method::ZIP16,
    Method::PIZ,
    Method::PXR24,
    Method::B44,
    Method::B44A,
    Method::DWAA(None),
    Method::DWAB(None),
];

pub(super) const SMALL: Limits = Limits { pixels: 1 << 20, bytes: 16 << 20 };

/// Returns a file with these bytes, which is there as long as the result.
pub(super) fn file(bytes: &[u8]) -> NamedTempFile {
    let mut file = NamedTempFile::new().unwrap();
    file.write_all(bytes).unwrap();
    file
}

pub(super) fn read(bytes: &[u8], selection: &Selection) -> Result<Picture, Error> {
    trochoid_io::read(file(bytes).path(), selection, &SMALL)
}

pub(super) fn describe(bytes: &[u8]) -> Result<Info, Error> {
    trochoid_io::info(file(bytes).path(), &SMALL)
}

pub(super) fn random() -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(0x0cea_2026)
}

/// Returns smooth values with some noise, which are partly compressible.
pub(super) fn values(count: usize, salt: u32) -> Vec<f32> {
    let mut random = Pcg64Mcg::seed_from_u64(u64::from(salt));
    (0..count).map(|i| (i as f32 * 0.01 + salt as f32).sin().abs() + random.random_range(0.0..0.01)).collect()
}

/// Part with half, float (Z) and integer (id) channels.
pub(super) struct Part {
    pub(super) name: Option<&'static str>,
    pub(super) prefix: &'static str,
    pub(super) size: (usize, usize),
    pub(super) position: (i32, i32),
    pub(super) method: Method,
    pub(super) blocks: Blocks,
    pub(super) order: LineOrder,
    pub(super) levels: Levels,
    pub(super) rounding: RoundingMode,
}

impl Part {
    pub(super) fn new(method: Method) -> Self {
        Self {
            name: None,
            prefix: "",
            size: (45, 37),
            position: (-7, 11),
            method,
            blocks: Blocks::ScanLines,
            order: LineOrder::Increasing,
            levels: Levels::One,
            rounding: RoundingMode::Down,
        }
    }

    pub(super) fn tiled(method: Method, tile: (usize, usize)) -> Self {
        Self { blocks: Blocks::Tiles(Vec2(tile.0, tile.1)), ..Self::new(method) }
    }

    pub(super) fn area(&self) -> usize {
        self.size.0 * self.size.1
    }

    pub(super) fn half(&self) -> Vec<f32> {
        values(self.area(), 1).into_iter().map(|v| half::f16::from_f32(v).to_f32()).collect()
    }

    pub(super) fn float(&self) -> Vec<f32> {
        values(self.area(), 2)
    }

    pub(super) fn uint(&self) -> Vec<u32> {
        (0..self.area() as u32).map(|i| i.wrapping_mul(i) % 65_521).collect()
    }

    fn attributes(&self) -> LayerAttributes {
        let attributes = match self.name {
            Some(name) => LayerAttributes::named(name),
            None => LayerAttributes::default(),
        };
        attributes.with_position(Vec2(self.position.0, self.position.1))
    }

    fn encoding(&self) -> Encoding {
        Encoding { compression: self.method, blocks: self.blocks, line_order: self.order }
    }

    fn text(&self, base: &str) -> Text {
        Text::from(format!("{}{base}", self.prefix).as_str())
    }

    fn layer(&self) -> Layer<AnyChannels<ExrLevels<FlatSamples>>> {
        let half = FlatSamples::F16(self.half().into_iter().map(half::f16::from_f32).collect());
        let mut list = vec![
            AnyChannel::new(self.text("A"), self.leveled(half, |n| FlatSamples::F16(vec![half::f16::ONE; n]))),
            AnyChannel::new(
                self.text("Z"),
                self.leveled(FlatSamples::F32(self.float()), |n| FlatSamples::F32(vec![9.0; n])),
            ),
        ];
        // The lossy cosine transform of the crate does not accept integers.
        if !matches!(self.method, Method::DWAA(_) | Method::DWAB(_)) {
            let integers = FlatSamples::U32(self.uint());
            list.push(AnyChannel::new(self.text("id"), self.leveled(integers, |n| FlatSamples::U32(vec![9; n]))));
        }
        Layer::new(self.size, self.attributes(), self.encoding(), AnyChannels::sort(list.into()))
    }

    /// Full resolution, and smaller levels with other values.
    fn leveled(&self, full: FlatSamples, other: impl Fn(usize) -> FlatSamples) -> ExrLevels<FlatSamples> {
        let sizes = |size: usize| -> Vec<usize> {
            let up = self.rounding == RoundingMode::Up;
            let halve = |&n: &usize| (n > 1).then(|| if up { n.div_ceil(2) } else { n / 2 });
            std::iter::successors(Some(size), halve).collect()
        };
        let (across, down) = (sizes(self.size.0), sizes(self.size.1));
        let rounding_mode = self.rounding;
        match self.levels {
            Levels::One => ExrLevels::Singular(full),
            Levels::Mip => {
                let at = |sizes: &[usize], level: usize| sizes.get(level).copied().unwrap_or(1);
                let smaller = (1..across.len().max(down.len())).map(|l| other(at(&across, l) * at(&down, l)));
                ExrLevels::Mip { rounding_mode, level_data: std::iter::once(full).chain(smaller).collect() }
            }
            Levels::Rip => {
                let all = down.iter().flat_map(|h| across.iter().map(move |w| w * h));
                let map_data = std::iter::once(full).chain(all.skip(1).map(other)).collect();
                let level_count = Vec2(across.len(), down.len());
                ExrLevels::Rip { rounding_mode, level_data: RipMaps { map_data, level_count } }
            }
        }
    }
}

/// Returns a file with these parts and the display window [0, 20) × [0, 10).
pub(super) fn exr(parts: &[Part]) -> Vec<u8> {
    let display = IntegerBounds::from_dimensions((20, 10));
    let layers: Vec<_> = parts.iter().map(Part::layer).collect();
    let mut bytes = Cursor::new(Vec::new());
    let image = Image::from_layers(ImageAttributes::new(display), layers);
    image.write().non_parallel().to_buffered(&mut bytes).expect("a writable image");
    bytes.into_inner()
}
