//! Builds the book: its chapters, a page for each node type, and every picture of a document that stands in it.
//!
//! `cargo run -p trochoid-book --features html` writes `book/html` into Cargo's target folder; without the feature the
//! pages are written as Markdown, and everything is checked just the same. What is wrong is said at once, and fails.

mod chapters;
mod documents;
mod fault;
mod links;
mod node_page;
#[cfg(feature = "html")]
mod pages;

use fault::{Fault, Faults};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    match build() {
        Ok(place) => {
            println!("the book: {}", place.display());
            ExitCode::SUCCESS
        }
        Err(faults) => {
            for fault in &faults {
                eprintln!("{}", fault.told());
            }
            eprintln!("faults of the book: {}", faults.len());
            ExitCode::FAILURE
        }
    }
}

/// Builds the book, and says where it begins.
///
/// # Errors
/// What is wrong with it.
fn build() -> Result<PathBuf, Faults> {
    // Documents of the book read beneath the repository's root.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("crates/book lies in the repository");
    let of = |path: &Path, source| vec![Fault::File { path: path.into(), source }];
    std::env::set_current_dir(root).map_err(|error| of(root, error))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    let book = target.join("book");
    let source = book.join("src");
    if source.exists() {
        std::fs::remove_dir_all(&source).map_err(|error| of(&source, error))?;
    }
    let mut faults = chapters::write_all(Path::new("docs"), &book);
    // What has no page yet would be linked to in vain from everywhere.
    if faults.is_empty() {
        faults = links::check(&source);
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    #[cfg(feature = "html")]
    return pages::write(&book);
    #[cfg(not(feature = "html"))]
    Ok(source.join("SUMMARY.md"))
}

/// The text of a file.
fn text(path: &Path) -> Result<String, trochoid::io::Error> {
    const MOST: u64 = 1 << 24;
    trochoid::io::read_text(path, MOST)
}

/// Writes a file, and the folders above it.
fn write(path: &Path, text: &str) -> Result<(), Fault> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(path, text));
    written.map_err(|source| Fault::File { path: path.into(), source })
}

/// Copies a file, and makes the folders above it.
fn copy(from: &Path, to: &Path) -> Result<(), Fault> {
    let folder = to.parent().unwrap_or(Path::new("."));
    let copied = std::fs::create_dir_all(folder).and_then(|()| std::fs::copy(from, to));
    copied.map(drop).map_err(|source| Fault::File { path: from.into(), source })
}
