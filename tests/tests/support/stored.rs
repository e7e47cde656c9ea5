//! Stored texts of tests: sheets of values and messages. The tests of the command line include this file, too.

use std::path::Path;

/// Environment variable that makes tests store the texts that they find, instead of comparing them.
const UPDATE: &str = "TROCHOID_UPDATE";

fn updates() -> bool {
    std::env::var_os(UPDATE).is_some()
}

/// Maximum number of lines that are shown of a text that is not stored.
const SHOWN: usize = 10;

/// Compares a text with the one stored at a path.
///
/// # Errors
/// The texts differ, or none is stored; the error has the command that stores the found text.
pub(crate) fn holds(path: &Path, found: &str) -> Result<(), String> {
    let stored = std::fs::read_to_string(path);
    if stored.as_ref().is_ok_and(|stored| stored == found) {
        return Ok(());
    }
    if updates() {
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all).and_then(|()| std::fs::write(path, found));
        return made.map_err(|error| format!("{}: cannot be stored: {error}", path.display()));
    }
    let what = match stored {
        Ok(stored) => difference(path, &stored, found),
        Err(error) => {
            let beginning: Vec<&str> = found.lines().take(SHOWN).collect();
            let more = if found.lines().nth(SHOWN).is_some() { "\n…" } else { "" };
            format!("{}: cannot be read: {error}; found\n{}{more}", path.display(), beginning.join("\n"))
        }
    };
    Err(format!(
        "{what}\n  remedy: if what was found is right, run the same test with {UPDATE}=1 and look at `git diff`"
    ))
}

/// Compares a message with the stored one, without the folder of the run. Empty messages are not stored.
///
/// # Errors
/// As [`holds`].
pub(crate) fn holds_said(path: &Path, said: &str, folder: &Path) -> Result<(), String> {
    if said.is_empty() && !path.exists() {
        return Ok(());
    }
    if said.is_empty() && updates() {
        return std::fs::remove_file(path).map_err(|error| format!("{}: cannot be removed: {error}", path.display()));
    }
    // First the names of files in the folder, then the folder itself; by its given path, and by its canonical path.
    let mut said = format!("{}\n", said.trim_end());
    for folder in [Some(folder.to_owned()), folder.canonicalize().ok()].into_iter().flatten() {
        said =
            said.replace(&folder.join("").display().to_string(), "").replace(&folder.display().to_string(), "FOLDER");
    }
    holds(path, &said)
}

/// Returns the first difference of two texts, with both lines.
fn difference(path: &Path, stored: &str, found: &str) -> String {
    let (mut expected, mut now) = (stored.lines(), found.lines());
    let mut line = 1;
    loop {
        match (expected.next(), now.next()) {
            (None, None) => return format!("{}: found other white space than stored", path.display()),
            (a, b) if a == b => line += 1,
            (a, b) => {
                let [a, b] = [a, b].map(|line| line.unwrap_or("the end of the text"));
                let word = a.split(' ').zip(b.split(' ')).position(|(a, b)| a != b).map_or(0, |at| at + 1);
                let path = path.display();
                return format!(
                    "{path}:{line}: differs from word {word} on: found\n    {b}\nexpected, as stored,\n    {a}"
                );
            }
        }
    }
}
