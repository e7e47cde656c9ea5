//! From stored values to colors of the working space.

use super::covered;
use super::legal::{Rule, place};
use std::path::Path;
use trochoid_graph::NodeError;
use trochoid_image::{Chromaticities, Plane, WorkingSpace, srgb_decode, srgb_encode};
use trochoid_io::{Encoding, Picture, SampleType};

/// Alpha that colors are to be divided by, and the color where nothing is covered.
pub(crate) struct Premultiplied {
    pub(crate) alpha: Plane,
    pub(crate) uncovered: Option<[f32; 3]>,
}

/// Converts colors in place: divided by alpha, decoded, brought to the working space, in f64 and rounded once.
///
/// `planes` hold legal stored values of the channels of sample type `stored`. Returns how many values were set to the
/// nearest legal one, as `repair` allows.
///
/// # Errors
/// Unknown primaries, a color outside the working space, or no covered pixel.
pub(crate) fn convert(
    path: &Path,
    picture: &Picture,
    stored: SampleType,
    planes: &mut [Plane; 3],
    (encoding, space): (&str, WorkingSpace),
    premultiplied: Option<&Premultiplied>,
    repair: bool,
) -> Result<u64, NodeError> {
    let mut conversion = Conversion::new(path, picture, encoding, space)?;
    if conversion.identity && premultiplied.is_none() {
        // −0 is legal, but no color.
        planes.iter_mut().flat_map(|plane| plane.samples_mut()).for_each(|sample| *sample += 0.0);
        return Ok(0);
    }
    let window = planes[0].window();
    let [r, g, b] = planes.each_mut().map(|plane| plane.samples_mut());
    let mut repaired = 0;
    for (index, ((r, g), b)) in r.iter_mut().zip(g).zip(b).enumerate() {
        let alpha = premultiplied.map_or(1.0, |p| f64::from(p.alpha.samples()[index]));
        if alpha == 0.0 {
            continue;
        }
        let straight = [*r, *g, *b].map(|v| exact(stored, v) / alpha);
        let color = conversion.color(straight).map(|v| v as f32 + 0.0);
        let legal = color.map(|v| Rule::Color.nearest(v));
        if color != legal {
            if !repair {
                let (x, y) = place(window, index);
                return Err(NodeError::new(format!(
                    "{}: part {}, pixel ({x}, {y}): the color ({}, {}, {}) of the file is ({}, {}, {}) in {space}, \
                     expected finite numbers, at least 0; choose a wider \"working_space\" (acescg), or set \
                     \"repair\": true to take the nearest legal value",
                    path.display(),
                    picture.part,
                    *r,
                    *g,
                    *b,
                    color[0],
                    color[1],
                    color[2]
                )));
            }
            repaired += color.iter().zip(&legal).filter(|(found, legal)| found != legal).count() as u64;
        }
        [*r, *g, *b] = legal;
    }
    if let Some(Premultiplied { alpha, uncovered }) = premultiplied
        && !covered::spread(planes, alpha)
    {
        let Some(color) = uncovered else {
            return Err(NodeError::new(format!(
                "{}: part {}: alpha is 0 everywhere, expected at least one covered pixel to take colors from; \
                 set \"outside\" to the color that is meant",
                path.display(),
                picture.part
            )));
        };
        planes.iter_mut().zip(color).for_each(|(plane, value)| plane.samples_mut().fill(*value));
    }
    Ok(repaired)
}

/// The value that a sample stands for: of integers the exact fraction, which f32 rounds.
fn exact(stored: SampleType, value: f32) -> f64 {
    let value = f64::from(value);
    match stored {
        SampleType::U8 => (value * 255.0).round() / 255.0,
        SampleType::U16 => (value * 65535.0).round() / 65535.0,
        SampleType::Half | SampleType::Float | SampleType::Uint => value,
    }
}

/// From stored values to a working space.
struct Conversion {
    identity: bool,
    decode: Option<Memo>,
    /// Linear primaries of the file to those of the space; `None` where they are the same.
    matrix: Option<[[f64; 3]; 3]>,
    encode: Option<Memo>,
}

impl Conversion {
    fn new(path: &Path, picture: &Picture, encoding: &str, space: WorkingSpace) -> Result<Self, NodeError> {
        let encoded = match encoding {
            "linear" => false,
            "srgb" => true,
            _ => picture.encoding == Encoding::Srgb,
        };
        let from = primaries(path, picture)?;
        // Display encoding in and out cancel, if nothing happens to the light between.
        let wide = space == WorkingSpace::AcesCg;
        let same = (from == WorkingSpace::AcesCg) == wide;
        let encode = space == WorkingSpace::Srgb;
        let identity = same && encoded == encode;
        let matrix = (!same).then(|| {
            let to = if wide { WorkingSpace::AcesCg } else { WorkingSpace::LinearSrgb };
            let column = |c: usize| {
                let mut basis = [0.0; 3];
                basis[c] = 1.0;
                to.from_linear_srgb(from.to_linear_srgb(basis))
            };
            let columns = [column(0), column(1), column(2)];
            [0, 1, 2].map(|i| [columns[0][i], columns[1][i], columns[2][i]])
        });
        Ok(Self {
            identity,
            decode: (encoded && !identity).then(|| Memo::new(srgb_decode)),
            matrix,
            encode: (encode && !identity).then(|| Memo::new(srgb_encode)),
        })
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

/// The linear space whose primaries the file states; Rec. 709, as the EXR specification says, where it states none.
fn primaries(path: &Path, picture: &Picture) -> Result<WorkingSpace, NodeError> {
    let Some(found) = picture.chromaticities else { return Ok(WorkingSpace::LinearSrgb) };
    let listed = |c: Chromaticities| [c.red, c.green, c.blue, c.white];
    // Files state three decimals.
    let near = |space: &WorkingSpace| {
        let pairs = listed(found).into_iter().zip(listed(space.chromaticities()));
        pairs.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).all(|difference| difference.abs() < 1.5e-3)
    };
    [WorkingSpace::LinearSrgb, WorkingSpace::AcesCg].into_iter().find(near).ok_or_else(|| {
        NodeError::new(format!(
            "{}: part {}: found the primaries red {:?}, green {:?}, blue {:?}, white {:?}, expected those of Rec. 709 \
             or ACEScg (AP1); convert the picture to one of them",
            path.display(),
            picture.part,
            found.red,
            found.green,
            found.blue,
            found.white
        ))
    })
}

/// A function that remembers its latest values: pictures hold few different ones, and powers are dear.
struct Memo {
    function: fn(f64) -> f64,
    known: Vec<(u64, f64)>,
}

/// Values remembered; a power of 2.
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
