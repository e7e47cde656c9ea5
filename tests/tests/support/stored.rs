//! Texts that are stored beside what makes them: sheets of values, messages. The command line's tests include this file too.

use std::path::Path;

/// With this in the environment, what is found is stored in place of being held against what was.
const UPDATE: &str = "TROCHOID_UPDATE";

fn updates() -> bool {
    std::env::var_os(UPDATE).is_some()
}

/// Lines of a text that is stored nowhere that are shown.
const SHOWN: usize = 10;

/// Holds a text against the one stored at a path.
///
/// # Errors
/// What differs, or that nothing is stored, and the command that stores what was found.
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

/// Holds what was said against what is stored, without the folder in which it was said; nothing is stored of silence.
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
    // Names of files within the folder first, then the folder itself, as it is reached and as it is.
    let mut said = format!("{}\n", said.trim_end());
    for folder in [Some(folder.to_owned()), folder.canonicalize().ok()].into_iter().flatten() {
        said =
            said.replace(&folder.join("").display().to_string(), "").replace(&folder.display().to_string(), "FOLDER");
    }
    holds(path, &said)
}

/// Where two texts part, with both lines.
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
