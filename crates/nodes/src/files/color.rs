//! Conversion of stored values to colors of the working space.

use super::knobs::Encoded;
use super::legal::{Rule, place};
use std::path::PathBuf;
use trochoid_graph::{BadData, NodeError};
use trochoid_image::{Chromaticities, Plane, WorkingSpace, spread, srgb_decode, srgb_encode};
use trochoid_io::{Encoding, SampleType};

/// Alpha by which colors are divided, and the color used if no pixel is covered.
pub(crate) struct Premultiplied {
    pub(crate) alpha: Plane,
    pub(crate) uncovered: Option<[f32; 3]>,
}

/// Interpretation of a file's colors, and the treatment of colors outside the working space.
#[derive(Clone)]
pub(crate) struct ColorSource {
    pub(crate) path: PathBuf,
    pub(crate) part: usize,
    /// Encoding stated by the file.
    pub(crate) encoding: Encoding,
    pub(crate) chromaticities: Option<Chromaticities>,
    pub(crate) stored: SampleType,
    pub(crate) space: WorkingSpace,
    pub(crate) repair: bool,
}

/// Converts colors in place: divides them by alpha, decodes them and converts them to the working space, in f64,
/// rounding once.
///
/// `planes` hold legal stored values. Returns the number of values set to the nearest legal one, if `repair` allows
/// that.
///
/// # Errors
/// A color is outside the working space, or no pixel is covered.
pub(crate) fn convert(
    conversion: &mut Conversion,
    planes: &mut [Plane; 3],
    premultiplied: Option<&Premultiplied>,
) -> Result<u64, NodeError> {
    if conversion.identity && premultiplied.is_none() {
        // −0 is a legal stored value, but not a color.
        planes.iter_mut().flat_map(|plane| plane.samples_mut()).for_each(|sample| *sample += 0.0);
        return Ok(0);
    }
    let window = planes[0].window();
    let [r, g, b] = planes.each_mut().map(|plane| plane.samples_mut());
    if let (Some(table), None) = (&conversion.table, premultiplied) {
        [r, g, b].into_iter().for_each(|samples| table.apply(samples));
        return Ok(0);
    }
    let mut repaired = 0;
    for (index, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
        let alpha = premultiplied.map_or(1.0, |p| f64::from(p.alpha.samples()[index]));
        if alpha != 0.0 {
            repaired += conversion.pixel([r, g, b], alpha, || place(window, index))?;
        }
    }
    if let Some(Premultiplied { alpha, uncovered }) = premultiplied
        && !spread(planes, alpha)
    {
        let Some(color) = uncovered else {
            let expected = "at least one covered pixel to take colors from";
            let bad = BadData::new("alpha 0 everywhere", expected, "set \"outside\" to the color to use");
            return Err(bad.in_file(&conversion.source.path).in_part(conversion.source.part).into());
        };
        planes.iter_mut().zip(color).for_each(|(plane, value)| plane.samples_mut().fill(*value));
    }
    Ok(repaired)
}

/// Returns the exact value of a sample: for integers the exact fraction, which f32 rounds.
fn exact(stored: SampleType, value: f32) -> f64 {
    let value = f64::from(value);
    match stored {
        SampleType::U8 => (value * 255.0).round() / 255.0,
        SampleType::U16 => (value * 65535.0).round() / 65535.0,
        SampleType::Half | SampleType::Float | SampleType::Uint => value,
    }
}

/// A conversion from stored values to a working space.
#[derive(Clone)]
pub(crate) struct Conversion {
    source: ColorSource,
    pub(crate) identity: bool,
    decode: Option<Memo>,
    /// Matrix from the file's linear primaries to those of the space; `None` if they are the same.
    matrix: Option<[[f64; 3]; 3]>,
    encode: Option<Memo>,
    /// The whole conversion as a table, if each channel has few values and does not depend on the others.
    table: Option<Table>,
}

impl Conversion {
    /// Returns the conversion for a file and the knob `encoding`.
    ///
    /// # Errors
    /// The primaries span no colors.
    pub(crate) fn new(source: ColorSource, encoding: Encoded) -> Result<Self, NodeError> {
        let encoded = match encoding {
            Encoded::Linear => false,
            Encoded::Srgb => true,
            Encoded::Auto => source.encoding == Encoding::Srgb,
        };
        let space = source.space;
        let wide = space == WorkingSpace::AcesCg;
        let to = if wide { WorkingSpace::AcesCg } else { WorkingSpace::LinearSrgb };
        let matrix = match known(&source) {
            Some(from) if from == to => None,
            Some(from) => {
                let column = |c: usize| {
                    let mut basis = [0.0; 3];
                    basis[c] = 1.0;
                    to.from_linear_srgb(from.to_linear_srgb(basis))
                };
                let columns = [column(0), column(1), column(2)];
                Some([0, 1, 2].map(|i| [columns[0][i], columns[1][i], columns[2][i]]))
            }
            None => Some(other(&source, &to.chromaticities())?),
        };
        // Decoding and encoding for display cancel if nothing changes the light between them.
        let encode = space == WorkingSpace::Srgb;
        let identity = matrix.is_none() && encoded == encode;
        let mut conversion = Self {
            source,
            identity,
            decode: (encoded && !identity).then(|| Memo::new(srgb_decode)),
            matrix,
            encode: (encode && !identity).then(|| Memo::new(srgb_encode)),
            table: None,
        };
        if conversion.source.stored == SampleType::U8 && conversion.matrix.is_none() && !identity {
            // No byte value is outside 0 to 1, so none is illegal.
            let value = |byte: usize| conversion.color([byte as f64 / 255.0; 3])[0] as f32 + 0.0;
            conversion.table = Some(Table(Box::new(std::array::from_fn(value))));
        }
        Ok(conversion)
    }

    /// Converts the pixels from `at` on in place, as in [`convert`].
    pub(crate) fn row(&mut self, [x, y]: [i64; 2], [r, g, b]: [&mut [f32]; 3]) -> Result<u64, NodeError> {
        if let Some(table) = &self.table {
            [r, g, b].into_iter().for_each(|samples| table.apply(samples));
            return Ok(0);
        }
        let mut repaired = 0;
        if !self.identity {
            for (index, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
                repaired += self.pixel([r, g, b], 1.0, || (x + index as i64, y))?;
            }
        }
        Ok(repaired)
    }

    fn pixel(
        &mut self,
        [r, g, b]: [&mut f32; 3],
        alpha: f64,
        place: impl FnOnce() -> (i64, i64),
    ) -> Result<u64, NodeError> {
        let straight = [*r, *g, *b].map(|v| exact(self.source.stored, v) / alpha);
        let color = self.color(straight).map(|v| v as f32 + 0.0);
        let legal = color.map(|v| Rule::Color.nearest(v));
        let wrong = color.iter().zip(&legal).filter(|(found, legal)| found != legal).count();
        let ColorSource { path, part, space, repair, .. } = &self.source;
        if wrong > 0 && !repair {
            let [red, green, blue] = color;
            let found = format_args!("the color ({r}, {g}, {b}), which is ({red}, {green}, {blue}) in {space}");
            let remedy =
                "choose a wider \"working_space\" (acescg), or set \"repair\": true to take the nearest legal value";
            let bad = BadData::new(found, "finite numbers, at least 0", remedy);
            return Err(bad.in_file(path).in_part(*part).at_pixel(place()).into());
        }
        [*r, *g, *b] = legal;
        Ok(wrong as u64)
    }

    fn color(&mut self, stored: [f64; 3]) -> [f64; 3] {
        let mut color = stored;
        if let Some(decode) = &mut self.decode {
            color = color.map(|v| decode.of(v));
        }
        if let Some(m) = &self.matrix {
            color = [0, 1, 2].map(|i| m[i][0] * color[0] + m[i][1] * color[1] + m[i][2] * color[2]);
        }
        if let Some(encode) = &mut self.encode {
            color = color.map(|v| encode.of(v));
        }
        color
    }
}

/// Table of the converted value for each byte value.
#[derive(Clone)]
struct Table(Box<[f32; 256]>);

impl Table {
    fn apply(&self, samples: &mut [f32]) {
        // Find the byte: a sample is a rounded fraction of 255.
        samples.iter_mut().for_each(|sample| *sample = self.0[usize::from((*sample * 255.0 + 0.5) as u8)]);
    }
}

/// Returns the known linear space with the primaries stated by the file; Rec. 709, as the EXR specification says, if
/// the file states none.
fn known(source: &ColorSource) -> Option<WorkingSpace> {
    let Some(found) = source.chromaticities else { return Some(WorkingSpace::LinearSrgb) };
    let listed = |c: Chromaticities| [c.red, c.green, c.blue, c.white];
    // Files state three decimals.
    let near = |space: &WorkingSpace| {
        let pairs = listed(found).into_iter().zip(listed(space.chromaticities()));
        pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).all(|difference| difference.abs() < 1.5e-3)
    };
    [WorkingSpace::LinearSrgb, WorkingSpace::AcesCg].into_iter().find(near)
}

/// Returns the matrix from any other primaries.
fn other(source: &ColorSource, to: &Chromaticities) -> Result<[[f64; 3]; 3], NodeError> {
    let found = source.chromaticities.unwrap_or(*to);
    found.matrix_to(to).ok_or_else(|| {
        let Chromaticities { red, green, blue, white } = found;
        BadData::new(
            format_args!("the primaries red {red:?}, green {green:?}, blue {blue:?}, white {white:?}"),
            "three primaries that span colors, with the white point inside them",
            "correct the attribute \"chromaticities\", or remove it if they are those of Rec. 709",
        )
        .in_file(&source.path)
        .in_part(source.part)
        .into()
    })
}

/// A function that caches its latest values: pictures contain few distinct values, and powers are expensive.
#[derive(Clone)]
struct Memo {
    function: fn(f64) -> f64,
    known: Vec<(u64, f64)>,
}

/// Number of cached values; a power of 2.
const REMEMBERED: usize = 1 << 16;

impl Memo {
    fn new(function: fn(f64) -> f64) -> Self {
        Self { function, known: vec![(0.0_f64.to_bits(), function(0.0)); REMEMBERED] }
    }

    fn of(&mut self, value: f64) -> f64 {
        let bits = value.to_bits();
        let slot = (bits.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - REMEMBERED.trailing_zeros())) as usize;
        let known = &mut self.known[slot];
        if known.0 != bits {
            *known = (bits, (self.function)(value));
        }
        known.1
    }
}
