//! What is written where, so that no two things take one place.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use trochoid::{Form, resolved};

/// Files of a run, by where they lead: their names, and what is written there.
pub(super) type Written = HashMap<PathBuf, (PathBuf, Form)>;

/// Takes a file for what is written beside a picture, unless it is one of the run already.
pub(super) fn take(path: &Path, form: Form, written: &mut Written) -> bool {
    let place = resolved(path);
    let is_free = !written.contains_key(&place);
    if is_free {
        written.insert(place, (path.into(), form));
    }
    is_free
}
