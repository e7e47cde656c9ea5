//! `trochoid schema`.

use crate::failure::Failure;
use crate::shell;

/// Prints the JSON Schema of documents, for editors and for other programs.
///
/// # Errors
/// stdout cannot be written.
pub(crate) fn run() -> Result<(), Failure> {
    shell::print_json(&trochoid::schema(trochoid::registry()))
}
