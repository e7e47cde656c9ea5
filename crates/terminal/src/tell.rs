use anstyle::{AnsiColor, Style};
use std::fmt::Display;
use std::io::Write;

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();
const NOTE: Style = AnsiColor::Green.on_default().bold();
const REMEDY: Style = AnsiColor::Cyan.on_default().bold();

/// Prints messages to stderr, colored only on terminals. Errors while printing are ignored.
pub fn tell<'m, M: Display + 'm>(messages: impl IntoIterator<Item = &'m M>) {
    let mut err = anstream::stderr().lock();
    for message in messages {
        let _ = writeln!(err, "{}", paint(&message.to_string()));
    }
}

/// Colors the leading word of each line that marks the type of message.
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

/// Replaces control characters in text from a document or file, so that it cannot control the terminal.
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
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
}
