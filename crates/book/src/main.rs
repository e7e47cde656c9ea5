//! Builds the manual: chapters, a page for each node type, and the pictures of all documents in it.
//!
//! `cargo run -p trochoid-book --features html` writes `book/html` into Cargo's target folder. Without the feature, the
//! pages are written as Markdown and checked in the same way. Faults are reported together, and the build fails.

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

/// Faults of the book: one line each, with the place.
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

/// Builds the book and returns its first page.
///
/// # Errors
/// Fails with the faults found.
fn build() -> Result<PathBuf, Faults> {
    // Documents in the book use paths relative to the repository root.
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
    // A missing page would be reported again for every link to it.
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

/// Reads a text file.
fn text(path: &Path) -> Result<String, trochoid::io::Error> {
    const MOST: u64 = 1 << 24;
    trochoid::io::read_text(path, MOST)
}

/// Writes a file, creating its folders.
fn write(path: &Path, text: &str) -> Result<(), Fault> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(path, text));
    written.map_err(|source| Fault::File { path: path.into(), source })
}

/// Copies a file, creating its folders.
fn copy(from: &Path, to: &Path) -> Result<(), Fault> {
    let folder = to.parent().unwrap_or(Path::new("."));
    let copied = std::fs::create_dir_all(folder).and_then(|()| std::fs::copy(from, to));
    copied.map(drop).map_err(|source| Fault::File { path: from.into(), source })
}

#[cfg(all(test, feature = "html"))]
mod tests {
    /// As `main`, with the features of the other tests, so that little is compiled again.
    #[test]
    fn the_book_has_no_faults() {
        let faults = super::build().err().unwrap_or_default();
        assert!(faults.is_empty(), "{}", faults.iter().map(|fault| fault.told()).collect::<Vec<_>>().join("\n"));
    }
}
