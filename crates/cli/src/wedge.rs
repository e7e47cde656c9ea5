//! Wedges: several values of a knob, of each of which all frames are rendered.

use crate::failure::Failure;
use trochoid::LoadError;

/// Most values of a wedge: Open Job Description takes no more.
const MOST: usize = 1024;

/// A knob and its values.
#[derive(Debug)]
pub(crate) struct Wedge {
    /// Path of the knob, such as `storm.height`.
    pub(crate) knob: String,
    /// Values, as `--set` takes them.
    pub(crate) values: Vec<String>,
    /// Names of the folders of the values' pictures, which differ and need no quotes.
    pub(crate) folders: Vec<String>,
}

impl Wedge {
    /// Reads `NODE.KNOB=3,4,5`. Commas within brackets and quotes belong to a value.
    ///
    /// # Errors
    /// The text has another form, or it has too many values or one of them twice.
    pub(crate) fn parse(text: &str) -> Result<Self, Failure> {
        let refuse = |found: &str, expected: &str| {
            let message = format!("--wedge {}: found {found}; expected {expected}", trochoid::quoted(text));
            Failure::usage(message, "give a knob and its values, such as storm.height=3,4,5")
        };
        let Some((knob, values)) = text.split_once('=').filter(|(knob, _)| knob.contains('.')) else {
            return Err(refuse("no knob with values", "NODE.KNOB=VALUE,VALUE…"));
        };
        let values: Vec<String> = split(values).into_iter().map(|value| value.trim().to_owned()).collect();
        if values.len() > MOST {
            return Err(refuse(&format!("{} values", values.len()), &format!("at most {MOST}")));
        }
        let twice = values.iter().enumerate().find(|(at, value)| value.is_empty() || values[..*at].contains(value));
        match twice {
            Some((_, value)) if value.is_empty() => return Err(refuse("an empty value", "a value between commas")),
            Some((_, value)) => return Err(refuse(&format!("{value} twice"), "each value once")),
            None => {}
        }
        let folders = folders(knob, &values);
        Ok(Self { knob: knob.into(), values, folders })
    }

    /// Returns the assignments, one for each value.
    pub(crate) fn assignments(&self) -> impl Iterator<Item = String> {
        self.values.iter().map(|value| format!("{}={value}", self.knob))
    }
}

/// Returns the failure of a document with a value of the wedge.
pub(crate) fn refused(error: LoadError) -> Failure {
    match error {
        LoadError::Invalid(mut faults) => {
            // The document and --set have been accepted before.
            for fault in faults.iter_mut().filter(|fault| fault.is_assigned) {
                (fault.file, fault.is_assigned) = (format!("--wedge {}", fault.file), false);
            }
            LoadError::Invalid(faults).into()
        }
        error => error.into(),
    }
}

/// Splits a list of values at the commas that are outside of brackets and quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut quoted, mut escaped, mut begin) = (0_usize, false, false, 0);
    let mut values = Vec::new();
    for (at, sign) in text.char_indices() {
        match sign {
            _ if std::mem::take(&mut escaped) => {}
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth = depth.saturating_sub(1),
            ',' if !quoted && depth == 0 => {
                values.push(&text[begin..at]);
                begin = at + 1;
            }
            _ => {}
        }
    }
    values.push(&text[begin..]);
    values
}

/// Returns a name for the folder of each value: `storm.height=3`, with `_` for what a shell or a pattern could read as
/// something else, and a number after it if two would be the same.
fn folders(knob: &str, values: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for value in values {
        let name = crate::job::plain_name(&format!("{knob}={value}"));
        let numbered = (2..).map(|number| format!("{name}.{number}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| !names.contains(name));
        names.extend(free);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_split_at_their_own_commas() {
        let wedge = Wedge::parse(r#"camera.position=[0,6,30],[0, 1, 2], "a,\"b" ,-3"#).unwrap();
        assert_eq!(wedge.values, ["[0,6,30]", "[0, 1, 2]", r#""a,\"b""#, "-3"]);
        assert_eq!(wedge.assignments().next().unwrap(), "camera.position=[0,6,30]");
    }

    #[test]
    fn folders_differ_and_need_no_quotes() {
        let wedge = Wedge::parse("sky.a=#fff,%fff,'fff',3.5,../x").unwrap();
        assert_eq!(wedge.folders, ["sky.a=_fff", "sky.a=_fff.2", "sky.a=_fff_", "sky.a=3.5", "sky.a=.._x"]);
    }

    #[test]
    fn what_is_no_wedge_is_told() {
        for (text, word) in [("height", "NODE.KNOB"), ("a.b=", "empty"), ("a.b=1,,2", "empty"), ("a.b=1,1", "1 twice")]
        {
            let failure = Wedge::parse(text).unwrap_err();
            assert!(failure.messages[0].text().contains(word), "{failure:?}");
        }
        assert!(
            Wedge::parse(&format!("a.b={}", (0..1025).map(|n| n.to_string()).collect::<Vec<_>>().join(","))).is_err()
        );
    }
}
