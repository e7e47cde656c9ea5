//! `--memory`: sizes as they are written.

use bytesize::ByteSize;
use trochoid::in_bytes;

/// The least that is any use.
const LEAST: u64 = 64_000_000;

/// Reads a size such as 8GB, 500MB or 2GiB.
pub(crate) fn parse(text: &str) -> Result<u64, String> {
    let expected = "expected a number with its unit, such as 8GB, 500MB or 2GiB";
    let size = text.parse::<ByteSize>().map_err(|_| expected.to_string())?.as_u64();
    if size < LEAST {
        return Err(format!("found {}; {expected}, of {} or more", in_bytes(size), in_bytes(LEAST)));
    }
    Ok(size)
}

/// What to write for `--memory` where a frame is reckoned to take so many bytes: a tenth more, since reckoning is not all.
pub(crate) fn enough(bytes: u64) -> String {
    let bytes = bytes.saturating_add(bytes / 10).max(LEAST);
    if bytes > 10_000_000_000 {
        format!("{}GB", bytes.div_ceil(1_000_000_000))
    } else {
        format!("{}MB", bytes.div_ceil(100_000_000) * 100)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_do_can_be_asked_for() {
        for bytes in [1, 64_000_000, 999_999_999, 9_999_999_999, 10_000_000_000, 123_456_789_012] {
            assert!(parse(&enough(bytes)).unwrap() >= bytes + bytes / 10, "{bytes}");
        }
    }

    #[test]
    fn sizes_have_units() {
        for (text, bytes) in
            [("8GB", 8_000_000_000), ("500MB", 500_000_000), ("2GiB", 2 << 30), ("1.5 gb", 1_500_000_000)]
        {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for text in ["", "8", "1kB", "much", "-8GB", "8XB", "NaNGB"] {
            assert!(parse(text).unwrap_err().contains("8GB"), "{text}");
        }
    }
}
