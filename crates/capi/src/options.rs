//! Options of looks.

use crate::error::Fault;
use crate::status::{guarded, trochoid_illegal, trochoid_status};
use crate::text::{text, texts};
use std::ffi::c_char;
use std::path::Path;
use trochoid::{Illegal, LookBuilder};

/// How a look is made. Fill it with trochoid_options_init().
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct trochoid_options {
    /// Size of this structure in bytes, by which later versions know what is in it.
    pub struct_size: size_t,
    /// What messages call the document; NULL for "look" or the file's name.
    pub name: *const c_char,
    /// Folder that the document's paths are relative to, whose files it may read; NULL for the
    /// current folder, or that of the document's file.
    pub folder: *const c_char,
    /// Name of the output; NULL for the only one.
    pub output: *const c_char,
    /// Names of the inputs for which you supply samples, in this order: a node ("light"), a color of
    /// the palette ("palette.foam"), a knob of the document that ports take as it is
    /// ("knobs.calm"), or a color or number at a port ("water.weight", "water.stops[1].color").
    pub inputs: *const *const c_char,
    /// Number of inputs.
    pub input_count: size_t,
    /// Changes of the document, such as "water.smooth=true" or "palette.foam=#fff".
    pub assignments: *const *const c_char,
    /// Number of assignments.
    pub assignment_count: size_t,
    /// Frame, for documents with keys; 1 by default.
    pub frame: i64,
    /// Number of samples that the look will shade in all, if you know that they are few: machine code
    /// is made only where it pays. 0 if not known.
    pub samples: u64,
    /// What happens to illegal samples: one of trochoid_illegal.
    pub illegal: u32,
    /// Files and folders that the document may read besides its own folder.
    pub allow: *const *const c_char,
    /// Number of these.
    pub allow_count: size_t,
    /// Number of threads that make a picture; 0 for one on each core. Shading runs on the caller's.
    pub threads: size_t,
}

/// C's name of `usize`, for the header.
pub(crate) type size_t = usize;

const DEFAULT: trochoid_options = trochoid_options {
    struct_size: size_of::<trochoid_options>(),
    name: std::ptr::null(),
    folder: std::ptr::null(),
    output: std::ptr::null(),
    inputs: std::ptr::null(),
    input_count: 0,
    assignments: std::ptr::null(),
    assignment_count: 0,
    frame: 1,
    samples: 0,
    illegal: trochoid_illegal::TROCHOID_REFUSE as u32,
    allow: std::ptr::null(),
    allow_count: 0,
    threads: 0,
};

/// Fills options with every default. size is sizeof(trochoid_options) as your program was compiled, so
/// that newer libraries, whose options are longer, write no further.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_options_init(options: *mut trochoid_options, size: size_t) -> trochoid_status {
    guarded(|| {
        let own = size_of::<trochoid_options>();
        if options.is_null() || size < size_of::<size_t>() {
            return trochoid_status::TROCHOID_INVALID;
        }
        let made = trochoid_options { struct_size: size.min(own), ..DEFAULT };
        // SAFETY: there are as many bytes as the caller says, and no more than the library's own options have are copied.
        unsafe { std::ptr::copy_nonoverlapping((&raw const made).cast::<u8>(), options.cast::<u8>(), size.min(own)) };
        trochoid_status::TROCHOID_OK
    })
}

/// Returns the caller's options, with defaults for what its version of the structure does not have.
///
/// # Safety
/// The pointer is null, or leads to as many bytes as its first field says.
pub(crate) unsafe fn read(options: *const trochoid_options) -> Result<trochoid_options, Fault> {
    let mut all = DEFAULT;
    if options.is_null() {
        return Ok(all);
    }
    // SAFETY: there is at least the size.
    let size = unsafe { (&raw const (*options).struct_size).read() };
    if size < size_of::<size_t>() || size > size_of::<trochoid_options>() {
        let expected = size_of::<trochoid_options>();
        return Err(Fault::invalid(format!(
            "found a struct_size of {size}; expected at most {expected}: begin with trochoid_options_init()"
        )));
    }
    // SAFETY: both are at least that long, and any bytes make the fields of the structure, which are numbers and pointers.
    unsafe { std::ptr::copy_nonoverlapping(options.cast::<u8>(), (&raw mut all).cast::<u8>(), size) };
    Ok(all)
}

/// Applies options to a look in the making.
///
/// # Safety
/// The pointers lead to what their documentation says.
pub(crate) unsafe fn apply(options: &trochoid_options, mut builder: LookBuilder) -> Result<LookBuilder, Fault> {
    let optional = |pointer: *const c_char, what: &str| match pointer.is_null() {
        true => Ok(None),
        // SAFETY: the caller's promise.
        false => unsafe { text(pointer) }.map(Some).ok_or_else(|| Fault::invalid(format!("{what} is not UTF-8"))),
    };
    if let Some(name) = optional(options.name, "name")? {
        builder = builder.named(name);
    }
    if let Some(folder) = optional(options.folder, "folder")? {
        builder = builder.within(Path::new(folder));
    }
    if let Some(output) = optional(options.output, "output")? {
        builder = builder.output(output);
    }
    let list = |pointer, count, what: &str| {
        // SAFETY: the caller's promise.
        unsafe { texts(pointer, count) }
            .map_err(|index| Fault::invalid(format!("{what}[{index}] is NULL or not UTF-8")))
    };
    for name in list(options.inputs, options.input_count, "inputs")? {
        builder = builder.bind(name);
    }
    for assignment in list(options.assignments, options.assignment_count, "assignments")? {
        builder = builder.set(assignment);
    }
    for path in list(options.allow, options.allow_count, "allow")? {
        builder = builder.allow(Path::new(path));
    }
    if options.samples > 0 {
        builder = builder.expecting(usize::try_from(options.samples).unwrap_or(usize::MAX));
    }
    let illegal = match options.illegal {
        0 => Illegal::Refuse,
        1 => Illegal::Clamp,
        other => {
            return Err(Fault::invalid(format!(
                "found {other} in illegal; expected TROCHOID_REFUSE or TROCHOID_CLAMP"
            )));
        }
    };
    Ok(builder.frame(options.frame).illegal(illegal).threads(options.threads))
}
