//! Errors for C: a text, and all faults as JSON.

use crate::status::{guarded, or_panic, trochoid_status};
use serde_json::{Value, json};
use std::ffi::{CString, c_char};
use trochoid::{Diagnostic, EvalError, LoadError, LookError, NotPointwise, PictureError};

/// What went wrong. Made by functions that fail; release it with trochoid_error_release().
pub struct trochoid_error {
    text: CString,
    json: CString,
}

/// A status with its explanation.
pub(crate) struct Fault {
    status: trochoid_status,
    message: String,
    diagnostics: Vec<Value>,
}

impl Fault {
    pub(crate) fn invalid(message: impl Into<String>) -> Self {
        Self { status: trochoid_status::TROCHOID_INVALID, message: message.into(), diagnostics: Vec::new() }
    }

    /// Hands the explanation to C, if it wants one, and returns the status.
    ///
    /// # Safety
    /// `to` is null or a place for a pointer.
    pub(crate) unsafe fn tell(self, to: *mut *mut trochoid_error) -> trochoid_status {
        if !to.is_null() {
            let json = json!({
                "status": self.status as i32, "message": self.message, "diagnostics": self.diagnostics
            });
            let error = trochoid_error { text: of(self.message), json: of(json.to_string()) };
            // SAFETY: the caller's promise.
            unsafe { to.write(Box::into_raw(Box::new(error))) };
        }
        self.status
    }
}

/// Runs a function of the interface that explains its faults.
///
/// # Safety
/// `error` is null or a place for a pointer.
pub(crate) unsafe fn explained(
    error: *mut *mut trochoid_error,
    run: impl FnOnce() -> Result<(), Fault>,
) -> trochoid_status {
    guarded(|| {
        if !error.is_null() {
            // SAFETY: the caller's promise.
            unsafe { error.write(std::ptr::null_mut()) };
        }
        match run() {
            Ok(()) => trochoid_status::TROCHOID_OK,
            // SAFETY: the caller's promise.
            Err(fault) => unsafe { fault.tell(error) },
        }
    })
}

/// Returns what a pointer of C leads to.
///
/// # Safety
/// The pointer is null, or leads to what stays while it is used.
pub(crate) unsafe fn there<'p, T>(pointer: *const T, expected: &str) -> Result<&'p T, Fault> {
    // SAFETY: the caller's promise.
    unsafe { pointer.as_ref() }.ok_or_else(|| Fault::invalid(format!("found NULL; expected {expected}")))
}

/// Makes something, and writes it where C wants it; null if it cannot be made.
///
/// # Safety
/// `error` and `to` are null or places for pointers.
pub(crate) unsafe fn hand_over<P: Null>(
    to: *mut P,
    what: &str,
    error: *mut *mut trochoid_error,
    make: impl FnOnce() -> Result<P, Fault>,
) -> trochoid_status {
    let run = || {
        if to.is_null() {
            return Err(Fault::invalid(format!("found NULL; expected a place for {what}")));
        }
        // SAFETY: not null, and a place for a pointer by the caller's promise.
        unsafe { to.write(P::NULL) };
        let made = make()?;
        // SAFETY: as above.
        unsafe { to.write(made) };
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { explained(error, run) }
}

/// A pointer that is handed over.
pub(crate) trait Null {
    /// The one that leads nowhere.
    const NULL: Self;
}

impl<T> Null for *const T {
    const NULL: Self = std::ptr::null();
}

impl<T> Null for *mut T {
    const NULL: Self = std::ptr::null_mut();
}

/// Returns a text for C, which has no zeros within.
fn of(text: String) -> CString {
    CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default()
}

impl From<LookError> for Fault {
    fn from(error: LookError) -> Self {
        let status = match &error {
            LookError::Load(LoadError::Io(_)) => trochoid_status::TROCHOID_IO,
            _ => trochoid_status::TROCHOID_INVALID,
        };
        let diagnostics = error.diagnostics().iter().map(Diagnostic::to_json).collect();
        Self { status, message: error.to_string(), diagnostics }
    }
}

impl From<NotPointwise> for Fault {
    fn from(error: NotPointwise) -> Self {
        let diagnostics = error.faults.iter().map(Diagnostic::to_json).collect();
        Self { diagnostics, ..Self::invalid(error.to_string()) }
    }
}

impl From<PictureError> for Fault {
    fn from(error: PictureError) -> Self {
        let status = match &error {
            PictureError::Passes(_) | PictureError::Evaluate(EvalError::Buffer { .. }) => {
                trochoid_status::TROCHOID_BUFFER
            }
            PictureError::Evaluate(EvalError::Cancelled) => trochoid_status::TROCHOID_CANCELLED,
            PictureError::Evaluate(
                EvalError::TooMuchMemory { .. } | EvalError::Memory { .. } | EvalError::Threads { .. },
            ) => trochoid_status::TROCHOID_MEMORY,
            PictureError::Evaluate(_) => trochoid_status::TROCHOID_IO,
            _ => trochoid_status::TROCHOID_INVALID,
        };
        Self { status, message: error.to_string(), diagnostics: Vec::new() }
    }
}

/// Returns the error as a text: every fault, with its place and what to do. It lives as long as the
/// error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_error_text(error: *const trochoid_error) -> *const c_char {
    // SAFETY: null or an error of this library.
    or_panic(c"".as_ptr(), || unsafe { error.as_ref() }.map_or(c"".as_ptr(), |error| error.text.as_ptr()))
}

/// Returns the error as JSON: "status", "message", and "diagnostics", a list of faults with "severity",
/// "file", "line", "column", "node", "port", "found", "expected", "remedy" and "used". A fault of the
/// options has the line 0, and "port" is the option, such as "output" or "inputs[1]". It lives as long
/// as the error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_error_json(error: *const trochoid_error) -> *const c_char {
    // SAFETY: null or an error of this library.
    or_panic(c"{}".as_ptr(), || unsafe { error.as_ref() }.map_or(c"{}".as_ptr(), |error| error.json.as_ptr()))
}

/// Releases an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn trochoid_error_release(error: *mut trochoid_error) {
    or_panic((), || {
        if !error.is_null() {
            // SAFETY: made by `tell`, and released once.
            drop(unsafe { Box::from_raw(error) });
        }
    });
}
