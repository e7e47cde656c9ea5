//! Attribute values: little-endian fields, and their readable text.

use trochoid_image::{Chromaticities, Window};

use crate::{Compression, Levels};

/// Reader of little-endian fields from an attribute's bytes; returns `None` at the end.
pub(super) struct Fields<'a>(pub(super) &'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, tail) = self.0.split_first_chunk()?;
        self.0 = tail;
        Some(*head)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.take().map(i32::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    fn f32(&mut self) -> Option<f32> {
        self.take().map(f32::from_le_bytes)
    }

    fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// Takes the bytes up to a zero, and the zero.
    pub(super) fn name(&mut self) -> Option<&'a [u8]> {
        let end = self.0.iter().position(|&byte| byte == 0)?;
        let name = &self.0[..end];
        self.0 = &self.0[end + 1..];
        Some(name)
    }

    fn array<const N: usize, T: Copy + Default>(&mut self, field: impl Fn(&mut Self) -> Option<T>) -> Option<[T; N]> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = field(self)?;
        }
        Some(values)
    }
}

/// Converts a `box2i`, whose corners are inclusive, to a half-open window.
pub(super) fn window(bytes: &[u8]) -> Option<Window> {
    let [x0, y0, x1, y1] = Fields(bytes).array(Fields::i32)?.map(i64::from);
    Some(Window::new(x0, y0, x1 + 1, y1 + 1))
}

pub(super) fn chromaticities(bytes: &[u8]) -> Option<Chromaticities> {
    let [rx, ry, gx, gy, bx, by, wx, wy] = Fields(bytes).array(Fields::f32)?;
    Some(Chromaticities { red: [rx, ry], green: [gx, gy], blue: [bx, by], white: [wx, wy] })
}

/// Returns width, height and levels of a `tiledesc`, and whether the sizes of levels are rounded up.
pub(super) fn tiles(bytes: &[u8]) -> Option<(u32, u32, Levels, bool)> {
    let mut fields = Fields(bytes);
    let (width, height, mode) = (fields.u32()?, fields.u32()?, fields.u8()?);
    let levels = match mode & 0xf {
        0 => Levels::One,
        1 => Levels::Mip,
        2 => Levels::Rip,
        _ => return None,
    };
    match mode >> 4 {
        0 => Some((width, height, levels, false)),
        1 => Some((width, height, levels, true)),
        _ => None,
    }
}

/// Returns a value as text; for types without one, the name of the type and the size.
pub(super) fn text(kind: &str, bytes: &[u8]) -> String {
    known(kind, bytes).unwrap_or_else(|| format!("({kind}, {} bytes)", bytes.len()))
}

fn known(kind: &str, bytes: &[u8]) -> Option<String> {
    let mut fields = Fields(bytes);
    let text = match kind {
        "string" => return Some(String::from_utf8_lossy(bytes).into_owned()),
        "stringvector" => return string_vector(bytes),
        "preview" => return Some(format!("{} × {} pixels", fields.u32()?, fields.u32()?)),
        "int" => fields.i32()?.to_string(),
        "float" => fields.f32()?.to_string(),
        "double" => fields.f64()?.to_string(),
        "v2i" => listed(&fields.array::<2, _>(Fields::i32)?),
        "v3i" => listed(&fields.array::<3, _>(Fields::i32)?),
        "v2f" => listed(&fields.array::<2, _>(Fields::f32)?),
        "v3f" => listed(&fields.array::<3, _>(Fields::f32)?),
        "v2d" => listed(&fields.array::<2, _>(Fields::f64)?),
        "v3d" => listed(&fields.array::<3, _>(Fields::f64)?),
        "box2f" => listed(&fields.array::<4, _>(Fields::f32)?),
        "chromaticities" => listed(&fields.array::<8, _>(Fields::f32)?),
        "m33f" => listed(&fields.array::<9, _>(Fields::f32)?),
        "m44f" => listed(&fields.array::<16, _>(Fields::f32)?),
        "m33d" => listed(&fields.array::<9, _>(Fields::f64)?),
        "m44d" => listed(&fields.array::<16, _>(Fields::f64)?),
        "keycode" => listed(&fields.array::<7, _>(Fields::i32)?),
        "rational" => format!("{}/{}", fields.i32()?, fields.u32()?),
        "timecode" => time_code(fields.u32()?),
        "box2i" => {
            let found = window(bytes)?;
            fields.0 = fields.0.get(16..)?;
            found.to_string()
        }
        "compression" => Compression::of_exr(fields.u8()?).to_string(),
        "lineOrder" => choice(fields.u8()?, &["increasing y", "decreasing y", "random y"])?,
        "envmap" => choice(fields.u8()?, &["latitude-longitude", "cube"])?,
        "deepImageState" => choice(fields.u8()?, &["messy", "sorted", "non-overlapping", "tidy"])?,
        "tiledesc" => {
            let (width, height, levels, up) = tiles(bytes)?;
            fields.0 = fields.0.get(9..)?;
            format!("{width} × {height}, {levels:?}, rounded {}", if up { "up" } else { "down" })
        }
        _ => return None,
    };
    // Bytes are left over, so the value does not have the stated type.
    fields.0.is_empty().then_some(text)
}

fn listed<T: ToString>(values: &[T]) -> String {
    values.iter().map(T::to_string).collect::<Vec<_>>().join(" ")
}

fn choice(number: u8, names: &[&str]) -> Option<String> {
    names.get(usize::from(number)).map(|name| (*name).into())
}

fn string_vector(mut bytes: &[u8]) -> Option<String> {
    let mut strings = Vec::new();
    while !bytes.is_empty() {
        let mut fields = Fields(bytes);
        let length = usize::try_from(fields.i32()?).ok()?;
        strings.push(String::from_utf8_lossy(fields.0.get(..length)?).into_owned());
        bytes = &fields.0[length..];
    }
    Some(strings.join(", "))
}

/// Formats an SMPTE time code, which consists of binary-coded decimals.
fn time_code(bits: u32) -> String {
    let decimal = |shift: u32, tens_mask: u32| ((bits >> (shift + 4)) & tens_mask) * 10 + ((bits >> shift) & 0xf);
    format!("{:02}:{:02}:{:02}:{:02}", decimal(24, 3), decimal(16, 7), decimal(8, 7), decimal(0, 3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_text() {
        assert_eq!(text("int", &7_i32.to_le_bytes()), "7");
        assert_eq!(text("rational", &[24, 0, 0, 0, 1, 0, 0, 0]), "24/1");
        assert_eq!(text("timecode", &0x0102_0304_u32.to_le_bytes()), "01:02:03:04");
        assert_eq!(text("stringvector", b"\x04\0\0\0left\x05\0\0\0right"), "left, right");
        assert_eq!(text("lineOrder", &[1]), "decreasing y");
        assert_eq!(text("box2i", &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]), "[0, 2) × [0, 3)");
    }

    #[test]
    fn damaged_and_unknown_values_are_named_with_their_size() {
        assert_eq!(text("int", &[1, 2]), "(int, 2 bytes)");
        assert_eq!(text("int", &[1, 2, 3, 4, 5]), "(int, 5 bytes)");
        assert_eq!(text("stringvector", b"\xff\xff\xff\x7fleft"), "(stringvector, 8 bytes)");
        assert_eq!(text("lineOrder", &[9]), "(lineOrder, 1 bytes)");
        assert_eq!(text("custom", &[0; 3]), "(custom, 3 bytes)");
        assert_eq!(text("tiledesc", &[0; 3]), "(tiledesc, 3 bytes)");
        assert_eq!(text("box2i", &[0; 17]), "(box2i, 17 bytes)");
    }
}
