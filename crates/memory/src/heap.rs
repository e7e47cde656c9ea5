//! The memory of a whole program: counted, bounded, and, when exhausted, reported instead of causing an abort.

#[cfg(all(target_os = "linux", target_env = "gnu"))]
use super::pages::{LARGE_PAGE, large_pages};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Size from which on blocks are counted, in bytes. Smaller blocks are too frequent: all threads share one counter.
const COUNTED: usize = 16 << 10;

/// A program's memory, for `#[global_allocator]`.
///
/// Blocks of 16 KiB and more are counted and compared with a bound ([`Heap::bound`]). If the bound or the system
/// refuses memory, the standard library aborts; a program with [`Heap::on_exhaustion`] ends in an orderly way
/// instead. Code that can do without the memory requests it within [`fallible`], and gets an error.
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

/// A request for memory that was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exhausted {
    /// Bytes requested.
    pub asked: usize,
    /// Bytes in counted blocks at that time.
    pub taken: usize,
    /// The bound, if it caused the refusal; `None` if the system did.
    pub bound: Option<usize>,
}

static TAKEN: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);
static BOUND: AtomicUsize = AtomicUsize::new(usize::MAX);
/// Whether the heap never shrinks.
static KEEPS_FREED: AtomicBool = AtomicBool::new(false);
/// End of the heap's memory that has been asked to be on large pages; 0 if none is asked to be.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
static ON_LARGE_PAGES: AtomicUsize = AtomicUsize::new(0);
static ON_EXHAUSTION: OnceLock<fn(Exhausted) -> !> = OnceLock::new();
/// Whether some thread is already ending the program.
static ENDING: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Whether the thread can do without the memory that it requests.
    static FALLIBLE: Cell<bool> = const { Cell::new(false) };
    /// Whether this thread is ending the program.
    static ENDS: Cell<bool> = const { Cell::new(false) };
}

/// Runs code that can do without the memory that it requests, for example by `try_reserve`: a refused request returns
/// an error instead of ending the program.
pub fn fallible<R>(ask: impl FnOnce() -> R) -> R {
    /// Restores the state, also if `ask` panics.
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
    /// Bounds the memory that may be taken, in bytes. Blocks that are already taken stay.
    pub fn bound(bytes: usize) {
        BOUND.store(bytes, Ordering::Relaxed);
    }

    /// Returns the bound that [`Heap::bound`] set last, in bytes; `usize::MAX` if it was never set.
    pub fn allowed() -> usize {
        BOUND.load(Ordering::Relaxed)
    }

    /// Returns the bytes in counted blocks; 0 if the program has another allocator.
    pub fn taken() -> usize {
        TAKEN.load(Ordering::Relaxed)
    }

    /// Returns the largest number of bytes in counted blocks since the start, or since [`Heap::forget_peak`].
    pub fn peak() -> usize {
        PEAK.load(Ordering::Relaxed)
    }

    /// Restarts the measurement of the peak.
    pub fn forget_peak() {
        PEAK.store(Self::taken(), Ordering::Relaxed);
    }

    /// Hands blocks of 1 MiB and more back to the system as soon as they are freed, instead of keeping them for later
    /// requests: for programs that hold pictures of many sizes for a long time, and whose freed blocks would lie between
    /// used ones. Each large block then costs its page faults anew. Does nothing where the system does so by itself.
    pub fn return_large() {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        #[allow(unsafe_code)]
        // SAFETY: `mallopt` takes any parameter and value, and returns 0 for those that it does not know; it takes the
        // allocator's lock, so other threads may allocate meanwhile. Blocks keep their kind until they are freed.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, 1 << 20);
        }
    }

    /// Keeps freed blocks of any size for later requests, instead of handing them back to the system: for programs that make
    /// one picture after another, whose memory would cost its page faults anew for each. All threads take
    /// turns in asking for memory. Does nothing on systems other than Linux with glibc.
    pub fn keep_freed() {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        #[allow(unsafe_code)]
        // SAFETY: as in `return_large`: `mallopt` takes any parameter and value, and the allocator's lock.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, i32::MAX);
            libc::mallopt(libc::M_TRIM_THRESHOLD, i32::MAX);
            // Otherwise threads ask for memory of their own, and get no large blocks from it.
            libc::mallopt(libc::M_ARENA_MAX, 1);
        }
        KEEPS_FREED.store(true, Ordering::Relaxed);
    }

    /// Asks for large pages for all memory that the heap grows by from now on, if it keeps what is freed
    /// ([`Heap::keep_freed`]): for programs that use the same memory for long. Large pages are missed less often in the
    /// processor's table of pages, but the system may need more time to hand them out. Does nothing on systems other than
    /// Linux with glibc.
    pub fn use_large_pages() {
        #[cfg(all(target_os = "linux", target_env = "gnu"))]
        if KEEPS_FREED.load(Ordering::Relaxed) {
            #[allow(unsafe_code)]
            // SAFETY: as in `return_large`; and `sbrk` without a change only returns the end of the heap.
            let end = unsafe {
                // The heap grows by many large pages at once: one that is mapped in part cannot be large.
                libc::mallopt(libc::M_TOP_PAD, 32 * LARGE_PAGE as i32);
                libc::sbrk(0) as usize
            };
            ON_LARGE_PAGES.fetch_max(end, Ordering::Relaxed);
        }
    }

    /// Sets the function that ends the program when memory is exhausted. Only the first call counts.
    ///
    /// The function may allocate: if even that fails, the process reports it on stderr and exits at once with code 1.
    pub fn on_exhaustion(end: fn(Exhausted) -> !) {
        let _ = ON_EXHAUSTION.set(end);
    }
}

/// Returns the counted bytes of a block.
fn counted(bytes: usize) -> usize {
    if bytes < COUNTED { 0 } else { bytes }
}

/// Counts some bytes; returns `false`, and counts nothing, if that would exceed the bound.
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
    // A new peak is rare, so a read comes first, which is cheaper than `fetch_max`.
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

/// Returns a block of some bytes, `more` of which are newly counted, unless the bound or the system refuses it.
fn granted(bytes: usize, more: usize, ask: impl FnOnce() -> *mut u8) -> *mut u8 {
    if !take(more) {
        return refuse(bytes, true);
    }
    let block = ask();
    if block.is_null() {
        give_back(more);
        return refuse(bytes, false);
    }
    if counted(bytes) > 0 {
        ask_for_large_pages(block as usize + bytes);
    }
    block
}

/// Asks for large pages for what the heap has grown by, if a block ends beyond what has been asked for.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code)]
fn ask_for_large_pages(block_end: usize) {
    let asked = ON_LARGE_PAGES.load(Ordering::Relaxed);
    if asked == 0 || block_end <= asked {
        return;
    }
    // SAFETY: `sbrk` without a change only returns the end of the heap.
    let end = unsafe { libc::sbrk(0) } as usize;
    // Where the heap cannot grow, blocks come from elsewhere.
    if block_end <= end {
        // SAFETY: this is memory of the heap, which `keep_freed` told never to shrink.
        unsafe { large_pages(asked, end) };
        ON_LARGE_PAGES.fetch_max(end, Ordering::Relaxed);
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn ask_for_large_pages(_block_end: usize) {}

/// Handles a refused block: returns null to code that can do without it, otherwise ends the program.
#[cold]
fn refuse(asked: usize, by_bound: bool) -> *mut u8 {
    if FALLIBLE.get() {
        return std::ptr::null_mut();
    }
    let Some(end) = ON_EXHAUSTION.get() else { return std::ptr::null_mut() };
    if ENDS.get() {
        tell("error: out of memory, even for the error message\n  remedy: allow more memory, or lower the format\n");
        exit_at_once(1);
    }
    if ENDING.swap(true, Ordering::Relaxed) {
        // Another thread is ending the program, and must not be disturbed.
        loop {
            std::thread::sleep(std::time::Duration::MAX);
        }
    }
    ENDS.set(true);
    end(Exhausted { asked, taken: Heap::taken(), bound: by_bound.then(|| BOUND.load(Ordering::Relaxed)) })
}

/// Writes a text to stderr without allocating and without locks.
#[cfg(unix)]
#[allow(unsafe_code)]
fn tell(text: &str) {
    // SAFETY: the pointer is to `text.len()` bytes, which live through the call. A text that cannot be written is lost.
    unsafe { libc::write(libc::STDERR_FILENO, text.as_ptr().cast(), text.len()) };
}

/// Writes a text to stderr, which has no buffer of its own.
#[cfg(not(unix))]
fn tell(text: &str) {
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
}

/// Ends the process at once, without the exit handlers of libraries, which could request memory, or locks that
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

// SAFETY: every block comes from `System` and returns to it with its original layout. Counting changes only atomics,
// and thread-locals with constant initializers and without destructors, so it neither allocates nor unwinds. `refuse`
// returns null, which means "no memory" to all callers, or does not return.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Heap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's guarantee for `layout` is the one that `System` requires.
        granted(layout.size(), counted(layout.size()), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's guarantee for `layout` is the one that `System` requires.
        granted(layout.size(), counted(layout.size()), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: `block` came from `System` with this layout, by the caller's guarantee.
        unsafe { System.dealloc(block, layout) };
        give_back(counted(layout.size()));
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let (old, new) = (counted(layout.size()), counted(size));
        // The system moves the pages of large blocks, so the old and the new block do not exist at the same time.
        // SAFETY: `block` came from `System` with this layout, and `size` is not 0 and does not overflow, by the
        // caller's guarantee.
        let moved = granted(size, new.saturating_sub(old), || unsafe { System.realloc(block, layout, size) });
        if !moved.is_null() {
            give_back(old.saturating_sub(new));
        }
        moved
    }
}
