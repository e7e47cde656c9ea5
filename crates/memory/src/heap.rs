//! The memory of a whole program: counted, bounded, and never the cause of an abort.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Blocks of so many bytes and more are counted. Smaller ones are many, and all threads count in one place.
const COUNTED: usize = 16 << 10;

/// A program's memory, for `#[global_allocator]`.
///
/// Blocks of 16 KiB and more are counted and held against a bound ([`Heap::bound`]). Where memory cannot be had, for the bound or
/// for the system, the standard library aborts; a program with [`Heap::on_exhaustion`] ends in order instead. Whoever can do
/// without the memory asks for it within [`fallible`], and is refused.
///
/// ```
/// use trochoid_memory::{Heap, fallible};
///
/// #[global_allocator]
/// static HEAP: Heap = Heap;
///
/// let before = Heap::taken();
/// let block = vec![1_u8; 1 << 20];
/// assert!(Heap::taken() >= before + block.len());
///
/// Heap::bound(Heap::taken() + (1 << 20));
/// assert!(fallible(|| Vec::<u8>::new().try_reserve(64 << 20)).is_err());
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Heap;

/// Memory that could not be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exhausted {
    /// Bytes asked for.
    pub asked: usize,
    /// Bytes taken, as far as they are counted.
    pub taken: usize,
    /// The bound, where that is what refused them, and not the system.
    pub bound: Option<usize>,
}

static TAKEN: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static BOUND: AtomicUsize = AtomicUsize::new(usize::MAX);
static ON_EXHAUSTION: OnceLock<fn(Exhausted) -> !> = OnceLock::new();
/// Whether a thread ends the program already.
static ENDING: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Whether the thread can do without what it asks for.
    static FALLIBLE: Cell<bool> = const { Cell::new(false) };
    /// Whether it is this thread that ends the program.
    static ENDS: Cell<bool> = const { Cell::new(false) };
}

/// Runs what can do without memory that it asks for, such as `try_reserve`: it is refused the memory, and goes on.
pub fn fallible<R>(ask: impl FnOnce() -> R) -> R {
    /// Also where `ask` panics.
    struct Before(bool);
    impl Drop for Before {
        fn drop(&mut self) {
            FALLIBLE.set(self.0);
        }
    }
    let _before = Before(FALLIBLE.replace(true));
    ask()
}

impl Heap {
    /// Bounds what is taken from now on, bytes; what is taken already stays.
    pub fn bound(bytes: usize) {
        BOUND.store(bytes, Ordering::Relaxed);
    }

    /// What [`Heap::bound`] said last, bytes; without end where it said nothing.
    pub fn allowed() -> usize {
        BOUND.load(Ordering::Relaxed)
    }

    /// Bytes taken in counted blocks. 0 where the program has another allocator.
    pub fn taken() -> usize {
        TAKEN.load(Ordering::Relaxed)
    }

    /// The most bytes that were taken at once since the start, or since [`Heap::forget_peak`].
    pub fn peak() -> usize {
        PEAK.load(Ordering::Relaxed)
    }

    /// Measures the peak anew.
    pub fn forget_peak() {
        PEAK.store(Self::taken(), Ordering::Relaxed);
    }

    /// What ends the program where memory cannot be had. The first call counts.
    ///
    /// It may allocate: where even that fails, the process says so on stderr and exits at once with code 1.
    pub fn on_exhaustion(end: fn(Exhausted) -> !) {
        let _ = ON_EXHAUSTION.set(end);
    }
}

/// What counts of a block.
fn counted(bytes: usize) -> usize {
    if bytes < COUNTED { 0 } else { bytes }
}

/// Counts so many bytes, unless that goes beyond the bound.
fn take(bytes: usize) -> bool {
    if bytes == 0 {
        return true;
    }
    let before = TAKEN.fetch_add(bytes, Ordering::Relaxed);
    let now = before.saturating_add(bytes);
    if now > BOUND.load(Ordering::Relaxed) && !ENDS.get() {
        TAKEN.fetch_sub(bytes, Ordering::Relaxed);
        return false;
    }
    // Nearly always it is no peak, which reading alone tells.
    if now > PEAK.load(Ordering::Relaxed) {
        PEAK.fetch_max(now, Ordering::Relaxed);
    }
    true
}

fn give_back(bytes: usize) {
    if bytes > 0 {
        TAKEN.fetch_sub(bytes, Ordering::Relaxed);
    }
}

/// A block of so many bytes, of which `more` come to those that are counted, unless the bound or the system refuses it.
fn granted(bytes: usize, more: usize, ask: impl FnOnce() -> *mut u8) -> *mut u8 {
    if !take(more) {
        return refuse(bytes, true);
    }
    let block = ask();
    if block.is_null() {
        give_back(more);
        return refuse(bytes, false);
    }
    block
}

/// What becomes of a block that cannot be had: null for whoever can do without, else the end of the program.
#[cold]
fn refuse(asked: usize, by_bound: bool) -> *mut u8 {
    if FALLIBLE.get() {
        return std::ptr::null_mut();
    }
    let Some(end) = ON_EXHAUSTION.get() else { return std::ptr::null_mut() };
    if ENDS.get() {
        tell(
            "error: out of memory, even of what it takes to say so\n  remedy: allow more memory, or lower the format\n",
        );
        exit_at_once(1);
    }
    if ENDING.swap(true, Ordering::Relaxed) {
        // Another thread ends the program, and is not to be kept from it.
        loop {
            std::thread::sleep(std::time::Duration::MAX);
        }
    }
    ENDS.set(true);
    end(Exhausted { asked, taken: Heap::taken(), bound: by_bound.then(|| BOUND.load(Ordering::Relaxed)) })
}

/// Says something on stderr, without memory and without locks.
#[cfg(unix)]
#[allow(unsafe_code)]
fn tell(text: &str) {
    // SAFETY: the pointer is to as many bytes as are named, which live through the call. What cannot be written is lost.
    unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
}

/// Says something on stderr, which has no buffer of its own.
#[cfg(not(unix))]
fn tell(text: &str) {
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
}

/// Ends the process at once, without anything that libraries do at an end: that could ask for memory, or for locks that
/// another thread holds.
#[cfg(unix)]
#[allow(unsafe_code)]
pub fn exit_at_once(code: u8) -> ! {
    // SAFETY: `_exit` takes any code and does not return.
    unsafe { libc::_exit(i32::from(code)) }
}

/// Ends the process.
#[cfg(not(unix))]
pub fn exit_at_once(code: u8) -> ! {
    std::process::exit(i32::from(code))
}

// SAFETY: every block comes from `System` and goes back to it with the layout that it came with. Counting changes atomics and
// thread-locals that are constant at the start and have no destructor, so it neither allocates nor unwinds. `refuse` returns
// null, which means "no memory" to all callers, or does not return.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Heap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise for `layout` is what `System` asks for.
        granted(layout.size(), counted(layout.size()), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise for `layout` is what `System` asks for.
        granted(layout.size(), counted(layout.size()), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: `block` came from `System` with this layout, by the caller's promise.
        unsafe { System.dealloc(block, layout) };
        give_back(counted(layout.size()));
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let (old, new) = (counted(layout.size()), counted(size));
        // The system moves pages of large blocks, so the old block and the new one are not there at once.
        // SAFETY: `block` came from `System` with this layout, and `size` is not 0 and does not overflow, by the caller's
        // promise.
        let moved = granted(size, new.saturating_sub(old), || unsafe { System.realloc(block, layout, size) });
        if !moved.is_null() {
            give_back(old.saturating_sub(new));
        }
        moved
    }
}
