//! What is printed: results on stdout, everything else on stderr, colors on terminals alone.

use crate::failure::{FAILED, Failure};
use anstyle::{AnsiColor, Style};
use std::io::{ErrorKind, Write};

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();
const NOTE: Style = AnsiColor::Green.on_default().bold();
const REMEDY: Style = AnsiColor::Cyan.on_default().bold();
/// Headings of manuals.
pub(crate) const HEADING: Style = Style::new().bold();

/// Prints a result on stdout as it stands. A reader that has gone away is no error.
///
/// # Errors
/// The text cannot be written for another reason, such as a full disk.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = anstream::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(FAILED, format!("stdout: cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a JSON value on stdout, with line breaks.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    print(&format!("{value:#}\n"))
}

/// Prints messages on stderr. Where even that fails, nobody listens.
pub(crate) fn tell<'m>(messages: impl IntoIterator<Item = &'m String>) {
    let mut err = anstream::stderr().lock();
    for message in messages {
        let _ = writeln!(err, "{}", paint(message));
    }
}

/// Colors the words at the start of lines that say what a message is.
fn paint(message: &str) -> String {
    let words = [("error:", ERROR), ("warning:", WARNING), ("note:", NOTE), ("  remedy:", REMEDY)];
    let lines = message.lines().map(|line| {
        let line = printable(line);
        match words.iter().find(|(word, _)| line.starts_with(word)) {
            Some((word, style)) => format!("{style}{word}{style:#}{}", &line[word.len()..]),
            None => line,
        }
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A text of a document or file without control characters, so that it cannot steer the terminal.
pub(crate) fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// Words broken into lines of at most 96 characters, each indented.
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
    fn only_the_leading_words_are_painted() {
        let painted = paint("error: a: error: b\u{1b}[2J\n  remedy: c");
        assert_eq!(anstream::adapter::strip_str(&painted).to_string(), "error: a: error: b\u{fffd}[2J\n  remedy: c");
        assert!(painted.starts_with('\u{1b}') && painted.contains("\n\u{1b}"));
        assert!(!paint("found error: b").contains('\u{1b}'));
    }

    #[test]
    fn lines_are_short_and_nothing_is_lost() {
        let text = "word ".repeat(60);
        let wrapped = wrap(&text, 4);
        assert!(wrapped.lines().all(|line| line.len() <= 96 && line.starts_with("    w")));
        assert_eq!(wrapped.split_whitespace().count(), 60);
    }
}
