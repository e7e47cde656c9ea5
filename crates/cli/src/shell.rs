//! Printing: results on stdout, everything else on stderr, with colors on terminals only. A host gets both instead.

use crate::failure::{FAILED, Failure};
use crate::host;
use anstyle::Style;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
pub(crate) use trochoid_terminal::printable;

/// Style of headings.
pub(crate) const HEADING: Style = Style::new().bold();

/// Prints a result on stdout unchanged. A closed pipe is not an error.
///
/// # Errors
/// The text cannot be written for another reason, such as a full disk.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    if host::takes_text(text) {
        return Ok(());
    }
    let mut out = anstream::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(FAILED, format!("stdout: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints messages on stderr.
pub(crate) fn tell<'m, M: Display + 'm>(messages: impl IntoIterator<Item = &'m M, IntoIter: Clone>) {
    let messages = messages.into_iter();
    if !host::takes_messages(messages.clone()) {
        trochoid_terminal::tell(messages);
    }
}

/// Pretty-prints a JSON value on stdout.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    print(&format!("{value:#}\n"))
}

/// Wraps a text into indented lines of at most 96 characters.
pub(crate) fn wrap(text: &str, indent: usize) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let length = lines.last().map_or(0, |line| line.chars().count());
        match lines.last_mut() {
            Some(line) if length == 0 => line.push_str(word),
            Some(line) if indent + length + 1 + word.chars().count() <= 96 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines.iter().map(|line| format!("{:indent$}{line}\n", "")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_short_and_nothing_is_lost() {
        let text = "word ".repeat(60);
        let wrapped = wrap(&text, 4);
        assert!(wrapped.lines().all(|line| line.len() <= 96 && line.starts_with("    w")));
        assert_eq!(wrapped.split_whitespace().count(), 60);
    }
}
