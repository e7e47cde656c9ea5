//! Texts from C.

use std::ffi::{CStr, c_char};

/// Returns a text; `None` if the pointer is null or the bytes are not UTF-8.
///
/// # Safety
/// The pointer is null, or leads to bytes that end with a 0 and stay while the text is used.
pub(crate) unsafe fn text<'t>(pointer: *const c_char) -> Option<&'t str> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: not null, and the rest is the caller's promise.
    unsafe { CStr::from_ptr(pointer) }.to_str().ok()
}

/// Returns the texts of a list; the index of the first that is null or not UTF-8 if there is one.
///
/// # Safety
/// The pointer leads to `count` pointers, each as for [`text`]; it may be null if the count is 0.
pub(crate) unsafe fn texts<'t>(pointer: *const *const c_char, count: usize) -> Result<Vec<&'t str>, usize> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if pointer.is_null() {
        return Err(0);
    }
    // No memory has so many, such as (size_t)-1.
    if count > isize::MAX as usize / size_of::<*const c_char>() {
        return Err(count);
    }
    // SAFETY: the caller promises that many pointers.
    let pointers = unsafe { std::slice::from_raw_parts(pointer, count) };
    // SAFETY: each of them is as `text` needs it.
    pointers.iter().enumerate().map(|(index, pointer)| unsafe { text(*pointer) }.ok_or(index)).collect()
}
