//! How much the program may take, and its end where that, or the machine, does not suffice.

use crate::failure::FAILED;
use crate::shell;
use std::sync::Mutex;
use trochoid::{Exhausted, Heap, discard_partial_files, exit_at_once, in_bytes, memory_share};

/// Given back at the end, so that there is memory to say why; large enough for the system to take it from the process.
static RESERVE: Mutex<Vec<u8>> = Mutex::new(Vec::new());
const RESERVED: usize = 4 << 20;

/// Bounds the memory of the whole process. Where it does not suffice, the process ends with code 1 and leaves nothing half
/// written.
pub(crate) fn bound(asked: Option<u64>) {
    let bytes = asked.unwrap_or_else(memory_share);
    Heap::bound(usize::try_from(bytes).unwrap_or(usize::MAX));
    if let Ok(mut reserve) = RESERVE.try_lock() {
        *reserve = vec![1; RESERVED];
    }
    Heap::on_exhaustion(end);
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
    shell::tell(&[format!(
        "error: out of memory: found {taken} taken and {asked} asked for{allowed}\n  remedy: {remedy}use fewer --threads, or \
         lower the format's \"width\" and \"height\""
    )]);
    exit_at_once(FAILED)
}
