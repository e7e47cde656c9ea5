//! Errors for C: a text, and all faults as JSON.

use crate::status::{or_panic, trochoid_status};
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

/// Returns the error as JSON: "status", "message", and "diagnostics", a list of faults with "file",
/// "line", "column", "node", "found", "expected" and "remedy". It lives as long as the error.
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
