//! Builds the HTML book with mdBook.

use crate::fault::{Fault, Faults};
use mdbook_driver::MDBook;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber, span};

/// Builds the HTML pages in the folder `book` and returns the first one.
///
/// # Errors
/// Fails if mdBook fails or warns.
pub(crate) fn write(book: &Path) -> Result<PathBuf, Faults> {
    let warnings = Warnings::default();
    let built = tracing::subscriber::with_default(warnings.clone(), || MDBook::load(book)?.build());
    let mut faults = warnings.0.lock().map(|mut found| std::mem::take(&mut *found)).unwrap_or_default();
    faults.extend(built.err().map(Fault::Html));
    if faults.is_empty() { Ok(book.join("html/index.html")) } else { Err(faults) }
}

/// Collects the warnings of mdBook.
#[derive(Clone, Default)]
struct Warnings(Arc<Mutex<Faults>>);

impl Subscriber for Warnings {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::WARN
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut text = Text(String::new());
        event.record(&mut text);
        if let Ok(mut warnings) = self.0.lock() {
            warnings.push(Fault::Warned(text.0));
        }
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

/// Message of an event.
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}
