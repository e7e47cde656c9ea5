//! Looks.

use crate::error::{Fault, hand_over, there, trochoid_error};
use crate::options::{self, size_t, trochoid_options};
use crate::status::{guarded, or_panic, trochoid_kind, trochoid_status};
use crate::text::{text, texts};
use std::ffi::{CString, c_char};
use std::path::Path;
use std::sync::Arc;
use trochoid::{Kind, Look, LookBuilder, LookError, MAX_BYTES};

/// One output of a document, with inputs of yours. It never changes, and any threads may use it.
pub struct trochoid_look {
    pub(crate) look: Look,
    builder: LookBuilder,
    names: Vec<CString>,
}

/// An input of a look.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trochoid_slot {
    /// Name, as in trochoid_options. It lives as long as the look.
    pub name: *const c_char,
    /// Kind: one of trochoid_kind.
    pub kind: u32,
    /// Index of its first channel among those of all inputs.
    pub first: size_t,
    /// Number of its channels.
    pub channels: size_t,
    /// 1 if the output depends on it. If not, its samples are never read and may be NULL.
    pub is_used: u32,
}

impl trochoid_look {
    fn new(builder: LookBuilder) -> Result<Self, Fault> {
        let look = builder.build()?;
        let names = look.slots().iter().map(|slot| CString::new(slot.name.as_str()).unwrap_or_default()).collect();
        Ok(Self { look, builder, names })
    }

    /// Makes a look with one owner.
    fn owned(builder: LookBuilder) -> Result<*const Self, Fault> {
        Ok(Arc::into_raw(Arc::new(Self::new(builder)?)))
    }
}

fn kind_of(kind: Kind) -> trochoid_kind {
    match kind {
        Kind::Color => trochoid_kind::TROCHOID_COLOR,
        Kind::Weights(2) => trochoid_kind::TROCHOID_MASK,
        Kind::Weights(_) => trochoid_kind::TROCHOID_WEIGHTS,
        _ => trochoid_kind::TROCHOID_FIELD,
    }
}

/// Makes a look from the text of a document of so many bytes. options may be NULL. Release the look
/// with trochoid_look_release(), and the error, if error is not NULL, with trochoid_error_release().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_new(
    document: *const c_char,
    length: size_t,
    options: *const trochoid_options,
    look: *mut *const trochoid_look,
    error: *mut *mut trochoid_error,
) -> trochoid_status {
    let made = || {
        if document.is_null() {
            return Err(Fault::invalid("found NULL; expected the text of a document"));
        }
        if length > MAX_BYTES {
            // Such as a size that could not be told: (size_t)-1.
            return Err(Fault::invalid(format!("found a document of {length} bytes; expected at most {MAX_BYTES}")));
        }
        // SAFETY: the caller promises `length` bytes, which stay during the call.
        let bytes = unsafe { std::slice::from_raw_parts(document.cast::<u8>(), length) };
        let text = std::str::from_utf8(bytes).map_err(|error| {
            Fault::invalid(format!("the document is not UTF-8 from byte {} on: save it as UTF-8", error.valid_up_to()))
        })?;
        // SAFETY: options are null or as the header says.
        trochoid_look::owned(unsafe { options::apply(&options::read(options)?, LookBuilder::new(text))? })
    };
    // SAFETY: as the header says.
    unsafe { hand_over(look, "the look", error, made) }
}

/// Does the same with a document in a file.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_open(
    path: *const c_char,
    options: *const trochoid_options,
    look: *mut *const trochoid_look,
    error: *mut *mut trochoid_error,
) -> trochoid_status {
    let made = || {
        // SAFETY: null or a text that ends with a 0.
        let path = unsafe { text(path) };
        let path =
            path.ok_or_else(|| Fault::invalid("found a path that is NULL or not UTF-8; expected that of a document"))?;
        let builder = LookBuilder::open(Path::new(path)).map_err(LookError::from)?;
        // SAFETY: options are null or as the header says.
        trochoid_look::owned(unsafe { options::apply(&options::read(options)?, builder)? })
    };
    // SAFETY: as the header says.
    unsafe { hand_over(look, "the look", error, made) }
}

/// Makes a look of the same document with further assignments, at a frame. Release it too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_with(
    from: *const trochoid_look,
    assignments: *const *const c_char,
    assignment_count: size_t,
    frame: i64,
    look: *mut *const trochoid_look,
    error: *mut *mut trochoid_error,
) -> trochoid_status {
    let made = || {
        // SAFETY: null or a look of this library.
        let from = unsafe { there(from, "a look")? };
        // SAFETY: as many texts as the caller says.
        let assignments = unsafe { texts(assignments, assignment_count) };
        let assignments =
            assignments.map_err(|index| Fault::invalid(format!("assignments[{index}] is NULL or not UTF-8")))?;
        let builder = assignments.into_iter().fold(from.builder.clone(), |builder, set| builder.set(set));
        trochoid_look::owned(builder.frame(frame))
    };
    // SAFETY: as the header says.
    unsafe { hand_over(look, "the look", error, made) }
}

/// Counts one more owner of a look, and returns it. Each owner releases it once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_retain(look: *const trochoid_look) -> *const trochoid_look {
    if !look.is_null() {
        // SAFETY: a look of this library, which its owner has not released.
        unsafe { Arc::increment_strong_count(look) };
    }
    look
}

/// Releases a look. Shaders that were made of it stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_release(look: *const trochoid_look) {
    or_panic((), || {
        if !look.is_null() {
            // SAFETY: a look of this library, which this owner releases once.
            drop(unsafe { Arc::from_raw(look) });
        }
    });
}

/// Returns the number of inputs that were named.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_slots(look: *const trochoid_look) -> size_t {
    // SAFETY: null or a look of this library.
    or_panic(0, || unsafe { look.as_ref() }.map_or(0, |look| look.look.slots().len()))
}

/// Describes an input, counted from 0. TROCHOID_INVALID if there are not so many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_slot(
    look: *const trochoid_look,
    index: size_t,
    slot: *mut trochoid_slot,
) -> trochoid_status {
    guarded(|| {
        // SAFETY: null or a look of this library.
        let look = unsafe { look.as_ref() };
        let Some((look, known)) = look.and_then(|look| Some((look, look.look.slots().get(index)?))) else {
            return trochoid_status::TROCHOID_INVALID;
        };
        if slot.is_null() {
            return trochoid_status::TROCHOID_INVALID;
        }
        let told = trochoid_slot {
            name: look.names[index].as_ptr(),
            kind: kind_of(known.kind) as u32,
            first: known.first,
            channels: known.channels(),
            is_used: known.is_used.into(),
        };
        // SAFETY: not null, and a place for a slot by the caller's promise.
        unsafe { slot.write(told) };
        trochoid_status::TROCHOID_OK
    })
}

/// Returns the number of channels of all inputs together.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_inputs(look: *const trochoid_look) -> size_t {
    // SAFETY: null or a look of this library.
    or_panic(0, || unsafe { look.as_ref() }.map_or(0, |look| look.look.inputs()))
}

/// Returns the number of channels of the output: 3 for a color.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_channels(look: *const trochoid_look) -> size_t {
    // SAFETY: null or a look of this library.
    or_panic(0, || unsafe { look.as_ref() }.map_or(0, |look| look.look.channels()))
}

/// Returns the kind of the output: one of trochoid_kind; UINT32_MAX if there is no look. Its weights are
/// as many as its channels; a mask has one channel for both of its.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_look_kind(look: *const trochoid_look) -> u32 {
    // SAFETY: null or a look of this library.
    or_panic(u32::MAX, || unsafe { look.as_ref() }.map_or(u32::MAX, |look| kind_of(look.look.kind()) as u32))
}
