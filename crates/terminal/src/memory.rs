//! The `--memory` option: limits the memory of the program, and ends the program if memory runs out.

use crate::FAILED;
use bytesize::ByteSize;
use std::sync::Mutex;
use trochoid::{Exhausted, Heap, discard_partial_files, exit_at_once, in_bytes, memory_share};

/// Minimum useful limit, in bytes.
const LEAST: u64 = 64_000_000;

const EXPECTED: &str = "expected a number with its unit, such as 8GB, 500MB or 2GiB";

/// Memory reserve, released when memory runs out so that the error can be reported; large enough for the system to
/// return it.
static RESERVE: Mutex<Vec<u8>> = Mutex::new(Vec::new());
const RESERVED: usize = 4 << 20;

/// Reads a size such as 8GB, 500MB or 2GiB.
///
/// # Errors
/// The text is no number with a unit, or the size is too small to be useful.
pub fn size(text: &str) -> Result<u64, SizeError> {
    // What the library says of it tells neither what is expected nor what to do.
    let size = text.parse::<ByteSize>().map_err(|_| SizeError::None)?.as_u64();
    if size < LEAST { Err(SizeError::Small { found: size }) } else { Ok(size) }
}

/// Error in a size of memory or of files.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum SizeError {
    /// Not a number with a unit.
    #[error("{EXPECTED}")]
    None,
    /// A size that is too small to be useful.
    #[error("found {}; {EXPECTED}, of {} or more", in_bytes(*found), in_bytes(LEAST))]
    Small {
        /// Bytes.
        found: u64,
    },
}

/// Returns the value for `--memory` suggested for a frame with this estimated number of bytes: ten percent more,
/// because the estimate is incomplete.
pub fn enough_memory(bytes: u64) -> String {
    let bytes = bytes.saturating_add(bytes / 10).max(LEAST);
    if bytes > 10_000_000_000 {
        format!("{}GB", bytes.div_ceil(1_000_000_000))
    } else {
        format!("{}MB", bytes.div_ceil(100_000_000) * 100)
    }
}

/// Memory limit of the process.
#[derive(Debug, clap::Args)]
pub struct MemoryArgs {
    /// Most memory to take, such as 8GB or 500MB: what needs more is refused before it begins [default: three quarters of the
    /// machine's]
    #[arg(long, global = true, value_name = "SIZE", value_parser = size)]
    memory: Option<u64>,
}

impl MemoryArgs {
    /// Limits the memory of the whole process, whose allocator is [`Heap`]. If the limit is exceeded, the process exits
    /// with code 1 and removes partially written files.
    pub fn bound(&self) {
        let bytes = self.memory.unwrap_or_else(memory_share);
        Heap::bound(usize::try_from(bytes).unwrap_or(usize::MAX));
        if let Ok(mut reserve) = RESERVE.try_lock() {
            *reserve = vec![1; RESERVED];
        }
        Heap::on_exhaustion(end);
    }

    /// Limits what is planned in this process until the result is dropped, if the option is given. The process does not end
    /// when memory runs out.
    #[must_use]
    pub fn limit_for_now(&self) -> Limited {
        let before = Heap::allowed();
        if let Some(bytes) = self.memory {
            Heap::bound(usize::try_from(bytes).unwrap_or(usize::MAX));
        }
        Limited { before }
    }
}

/// A limit that ends when this is dropped.
#[derive(Debug)]
pub struct Limited {
    before: usize,
}

impl Drop for Limited {
    fn drop(&mut self) {
        Heap::bound(self.before);
    }
}

fn end(exhausted: Exhausted) -> ! {
    if let Ok(mut reserve) = RESERVE.try_lock() {
        *reserve = Vec::new();
    }
    discard_partial_files();
    let (asked, taken) = (in_bytes(exhausted.asked as u64), in_bytes(exhausted.taken as u64));
    let (allowed, remedy) = match exhausted.bound {
        Some(bound) => (format!(", of {} allowed", in_bytes(bound as u64)), "allow more by --memory, "),
        None => (", more than the machine has left".into(), "end other programs, "),
    };
    crate::tell(&[format!(
        "error: out of memory: found {taken} taken and {asked} asked for{allowed}\n  remedy: {remedy}use fewer --threads, or \
         lower the format's \"width\" and \"height\""
    )]);
    exit_at_once(FAILED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_do_can_be_asked_for() {
        for bytes in [1, 64_000_000, 999_999_999, 9_999_999_999, 10_000_000_000, 123_456_789_012] {
            assert!(size(&enough_memory(bytes)).unwrap() >= bytes + bytes / 10, "{bytes}");
        }
    }

    #[test]
    fn sizes_have_units() {
        for (text, bytes) in
            [("8GB", 8_000_000_000), ("500MB", 500_000_000), ("2GiB", 2 << 30), ("1.5 gb", 1_500_000_000)]
        {
            assert_eq!(size(text), Ok(bytes), "{text}");
        }
        for text in ["", "8", "1kB", "much", "-8GB", "8XB", "NaNGB"] {
            assert!(size(text).unwrap_err().to_string().contains("8GB"), "{text}");
        }
    }
}
