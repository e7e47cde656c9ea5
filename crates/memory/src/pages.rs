//! Large pages: fewer page faults, and fewer misses in the processor's table of pages.

/// Size of a large page in bytes, from which on memory asks for them.
pub(crate) const LARGE_PAGE: usize = 2 << 20;

/// Asks the system for large pages for the whole pages among some addresses: a hint that changes no content.
///
/// # Safety
/// The addresses are mapped memory of this process, or memory that nothing uses.
#[cfg(target_os = "linux")]
#[allow(unsafe_code)]
pub(crate) unsafe fn large_pages(from: usize, to: usize) {
    // SAFETY: `sysconf` only reads a constant of the system.
    let page = usize::try_from(unsafe { libc::sysconf(libc::_SC_PAGESIZE) }).unwrap_or(0);
    if !page.is_power_of_two() {
        return;
    }
    // `madvise` takes only whole pages.
    let (first, last) = (from.next_multiple_of(page), to & !(page - 1));
    if first < last {
        // SAFETY: the caller's guarantee. MADV_HUGEPAGE changes neither contents nor protection, and its failure changes
        // nothing.
        unsafe { libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE) };
    }
}

/// Does nothing: this system has no such hint.
#[cfg(not(target_os = "linux"))]
#[allow(unsafe_code)]
pub(crate) unsafe fn large_pages(_from: usize, _to: usize) {}
