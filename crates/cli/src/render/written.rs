//! The destinations of a run's files, so that no two files share one.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use trochoid::{Form, resolved};

/// Files of a run by resolved path: the path as given, and the kind of file.
pub(super) type Written = HashMap<PathBuf, (PathBuf, Form)>;

/// Reserves a path for a companion of a picture; returns `false` if the run writes there already.
pub(super) fn take(path: &Path, form: Form, written: &mut Written) -> bool {
    let place = resolved(path);
    let is_free = !written.contains_key(&place);
    if is_free {
        written.insert(place, (path.into(), form));
    }
    is_free
}
