//! `trochoid schema`: prints the JSON Schema of documents.

use crate::failure::Failure;
use crate::shell;

/// Prints the JSON Schema of documents, for editors and for other programs.
///
/// # Errors
/// Writing to stdout fails.
pub(crate) fn run() -> Result<(), Failure> {
    shell::print_json(&trochoid::schema(trochoid::registry()))
}
