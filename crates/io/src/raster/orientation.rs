//! How a stored picture is to be turned, as Exif tells.

/// What makes a stored picture upright; turned clockwise first, then flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Orientation {
    NoTransforms,
    FlipHorizontal,
    Rotate180,
    FlipVertical,
    Rotate90FlipH,
    Rotate90,
    Rotate270FlipH,
    Rotate270,
}

/// Exif's tag, whose value is one SHORT.
const TAG: u16 = 0x112;
const SHORT: u16 = 3;

impl Orientation {
    /// What an Exif block says, if it is one: a TIFF header, and a table of tags somewhere behind it.
    pub(crate) fn from_block(block: &[u8]) -> Option<Self> {
        let little = match block.get(..4)? {
            [b'I', b'I', 42, 0] => true,
            [b'M', b'M', 0, 42] => false,
            _ => return None,
        };
        let short = |at: usize| {
            let bytes = block.get(at..at.checked_add(2)?)?.try_into().ok()?;
            Some(if little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) })
        };
        let long = |at: usize| {
            let (first, second) = (u32::from(short(at)?), u32::from(short(at.checked_add(2)?)?));
            Some(if little { second << 16 | first } else { first << 16 | second })
        };
        let table = usize::try_from(long(4)?).ok()?;
        for entry in 0..usize::from(short(table)?) {
            let at = table.checked_add(2 + 12 * entry)?;
            let (tag, kind, count, value) = (short(at)?, short(at + 2)?, long(at + 4)?, short(at + 8)?);
            // A table that ends within an entry tells nothing, though that is behind the value.
            short(at + 10)?;
            if (tag, kind, count) == (TAG, SHORT, 1) {
                return Self::from_number(value);
            }
        }
        None
    }

    /// What the number says that Exif and TIFF have for it.
    pub(crate) fn from_number(value: u16) -> Option<Self> {
        Some(match value {
            1 => Self::NoTransforms,
            2 => Self::FlipHorizontal,
            3 => Self::Rotate180,
            4 => Self::FlipVertical,
            5 => Self::Rotate90FlipH,
            6 => Self::Rotate90,
            7 => Self::Rotate270FlipH,
            8 => Self::Rotate270,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block of one entry after another tag, in either order of bytes.
    fn block(little: bool, tag: u16, kind: u16, count: u32, value: u16) -> Vec<u8> {
        let short = |v: u16| if little { v.to_le_bytes() } else { v.to_be_bytes() };
        let long = |v: u32| if little { v.to_le_bytes() } else { v.to_be_bytes() };
        let mut bytes = if little { b"II".to_vec() } else { b"MM".to_vec() };
        bytes.extend([short(42).as_slice(), &long(10), &[0, 0], &short(2)].concat());
        bytes.extend([short(0x10f).as_slice(), &short(2), &long(1), &[b'a', 0, 0, 0]].concat());
        bytes.extend([short(tag).as_slice(), &short(kind), &long(count), &short(value), &[0, 0]].concat());
        bytes
    }

    #[test]
    fn every_block_says_what_it_says_to_the_image_crate() {
        use image::metadata::Orientation as Theirs;
        let mut seen = 0;
        for little in [true, false] {
            for (tag, kind, count) in [(TAG, SHORT, 1), (TAG, SHORT, 2), (TAG, 4, 1), (0x113, SHORT, 1)] {
                for value in [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 256, 257, 65535] {
                    let whole = block(little, tag, kind, count, value);
                    // Cut off anywhere, and with the table beyond the end or at the greatest place.
                    let cut = (0..=whole.len()).map(|length| whole[..length].to_vec());
                    let beyond = [0x7f, 0xff].map(|byte| [&whole[..4], &[byte; 4], &whole[8..]].concat());
                    for bytes in cut.chain(beyond) {
                        let (ours, theirs) = (Orientation::from_block(&bytes), Theirs::from_exif_chunk(&bytes));
                        assert_eq!(format!("{ours:?}"), format!("{theirs:?}"), "{bytes:?}");
                        seen += usize::from(ours.is_some());
                    }
                }
            }
        }
        assert_eq!(seen, 16);
    }
}
