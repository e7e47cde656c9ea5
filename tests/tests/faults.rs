//! Errors as data: no function returns its error as text, from which callers could not learn what was found.

use crate::architecture::sources;
use crate::support::root;

/// Returns the parameters of a generic type from the text after its `<`; none if the list does not end.
fn parameters(text: &str) -> Vec<&str> {
    let (mut depth, mut begin, mut last) = (0_usize, 0, ' ');
    let mut found = Vec::new();
    for (at, c) in text.char_indices() {
        match c {
            '<' | '(' | '[' | '{' => depth += 1,
            '>' if last == '-' => {}
            '>' | ')' | ']' | '}' if depth == 0 => {
                found.push(&text[begin..at]);
                return found;
            }
            '>' | ')' | ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                found.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
        last = c;
    }
    Vec::new()
}

/// Returns whether a type is text, or contains text.
fn is_text(ty: &str) -> bool {
    ty.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| matches!(word, "String" | "str"))
}

/// Returns a source without comments, with the same lines.
fn code(text: &str) -> String {
    text.lines()
        .map(|line| if line.trim_start().starts_with("//") { "\n".into() } else { format!("{line}\n") })
        .collect()
}

/// Returns the lines of a source with a `Result` whose error is text, or with text as the error of a conversion.
fn told(text: &str) -> Vec<usize> {
    let text = code(text);
    let results = text.match_indices("Result<").filter(|(at, found)| {
        let parameters = parameters(&text[at + found.len()..]);
        parameters.get(1).is_some_and(|error| is_text(error))
    });
    let named = ["type Err = ", "type Error = "].into_iter().flat_map(|name| text.match_indices(name));
    let named = named.filter(|(at, found)| text[at + found.len()..].split(';').next().is_some_and(is_text));
    results.chain(named).map(|(at, _)| text[..at].matches('\n').count() + 1).collect()
}

#[test]
fn errors_are_data_and_no_text() {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(root().join("crates")).expect("the crates") {
        sources(&entry.expect("a crate").path().join("src"), &mut files);
    }
    assert!(files.len() > 500, "only {} sources", files.len());
    // In some crates, code that only tests use has a file of its own.
    let code = files.iter().filter(|(place, _)| !place.ends_with("/testing.rs"));
    let faults: Vec<String> =
        code.flat_map(|(place, text)| told(text).into_iter().map(move |line| format!("{place}:{line}"))).collect();
    assert!(faults.is_empty(), "give the error a type that holds what was found:\n{}", faults.join("\n"));
}

#[test]
fn text_is_found_however_it_is_written() {
    for source in [
        "fn a() -> Result<u8, String> {",
        "fn a() -> Result<Vec<(u8, char)>, &'static str> {",
        "fn a(\n) -> std::result::Result<\n    HashMap<u8, Box<dyn Fn(u8) -> u8>>,\n    Cow<'static, str>,\n> {",
        "type Outcome<T> = Result<T, Vec<String>>;",
        "impl FromStr for A {\n    type Err = String;",
        "struct A { thread: Option<JoinHandle<Result<String, String>>> }",
    ] {
        assert_eq!(told(source).len(), 1, "{source}");
    }
    for source in [
        "fn a() -> Result<String, Error> {",
        "fn a() -> Result<HashMap<String, u8>> {",
        "fn a() -> Result<Result<String, u8>, StringError> {",
        "/// Result<u8, String>\nlet less = Result < a;",
    ] {
        assert_eq!(told(source), [0; 0], "{source}");
    }
    assert_eq!(told("\n// b\nfn a() -> Result<u8, String>"), [3]);
}
