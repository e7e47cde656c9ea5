//! Failures of commands: exit codes and messages, and their conversion from the errors of the library.

use crate::remedies;
use std::cmp::Reverse;
use std::fmt;
use trochoid::accuracy::PlanFileError;
use trochoid::certificate::{CertificateError, KeyError};
use trochoid::{Diagnostic, EvalError, LoadError, OutputError, ReferenceError, RunStatus, Severity, in_bytes};
use trochoid_terminal::enough_memory;
pub(crate) use trochoid_terminal::{FAILED, INVALID};

/// Exit code if a required guarantee or tolerance is not met, or a certificate does not hold.
pub(crate) const MISSED: u8 = 3;
/// Exit code after an interruption by the user.
pub(crate) const INTERRUPTED: u8 = 130;

/// Message after an interruption by the user.
pub(crate) const INTERRUPTION: &str = "interrupted; finished files are complete, and no partial files remain";

/// Failure of a command: its exit code, and the messages for stderr.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Failure {
    /// The exit code.
    pub(crate) code: u8,
    /// Messages.
    pub(crate) messages: Vec<Message>,
}

/// Message of a failure, or a warning beside one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    /// First word of the message.
    severity: Severity,
    /// Rest of the message, perhaps with a second line `  remedy: …`.
    text: String,
}

impl Message {
    pub(crate) fn error(text: impl ToString) -> Self {
        Self { severity: Severity::Error, text: text.to_string() }
    }

    /// Returns the message without its first word.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    fn with_remedy(mut self, remedy: &str) -> Self {
        if !remedy.is_empty() {
            self.text.push_str("\n  remedy: ");
            self.text.push_str(remedy);
        }
        self
    }
}

impl From<&Diagnostic> for Message {
    fn from(diagnostic: &Diagnostic) -> Self {
        let diagnostic = remedies::diagnostic(diagnostic);
        Self { severity: diagnostic.severity, text: diagnostic.statement().to_string() }
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.severity, self.text)
    }
}

impl Failure {
    pub(crate) fn new(code: u8, message: impl ToString) -> Self {
        Self { code, messages: vec![Message::error(message)] }
    }

    /// Returns a failure whose messages have been printed already.
    pub(crate) fn silent(code: u8) -> Self {
        Self { code, messages: Vec::new() }
    }

    /// Returns the failure after an interruption by the user.
    pub(crate) fn interrupted() -> Self {
        Self::new(INTERRUPTED, INTERRUPTION)
    }

    /// Returns a usage failure: `message` says what was found and expected, `remedy` what to do.
    pub(crate) fn usage(message: impl ToString, remedy: impl ToString) -> Self {
        Self { code: INVALID, messages: vec![Message::error(message).with_remedy(&remedy.to_string())] }
    }

    /// Returns the failure of an evaluation; `place` is a prefix such as "frame 3: ".
    pub(crate) fn evaluated(place: &str, error: &EvalError) -> Self {
        let EvalError::TooMuchMemory { place: at, found, total, limit, remedy } = error else {
            return Self::new(FAILED, format!("{place}{}", remedies::evaluation(error)));
        };
        let (takes, most) = (in_bytes(*total), in_bytes(*limit));
        let text = format!("{place}{at}: found a frame that takes about {takes}: {found}; expected at most {most}");
        let remedy = format!("{remedy}; or allow more: --memory {}", enough_memory(*total));
        Self { code: FAILED, ..Self::usage(text, remedy) }
    }

    /// Returns the failure to name or write files; `option` gives their pattern.
    pub(crate) fn written(error: &OutputError, option: &str) -> Self {
        match error {
            OutputError::Pattern(faults) => {
                let message = |fault| {
                    let (text, remedy) = remedies::name(fault, option);
                    Message::error(text).with_remedy(&remedy)
                };
                Self { code: INVALID, messages: faults.iter().map(message).collect() }
            }
            OutputError::Refused(refused) => refused.diagnostic().into(),
            OutputError::Foreign(file) => Self::usage(file, remedies::REPLACE),
            OutputError::Io(error) => Self::new(FAILED, remedies::written(error)),
            error => Self::new(FAILED, error),
        }
    }

    /// Adds another failure's messages, and keeps the higher exit code.
    pub(crate) fn join(&mut self, other: Self) {
        self.code = self.code.max(other.code);
        self.messages.extend(other.messages);
    }

    /// Returns the failure with a place, such as "a.json: ", before each error.
    pub(crate) fn at(mut self, place: &str) -> Self {
        let errors = self.messages.iter_mut().filter(|message| message.severity == Severity::Error);
        errors.for_each(|message| message.text.insert_str(0, place));
        self
    }

    /// Adds warnings after the errors.
    pub(crate) fn warning(mut self, warnings: &[Diagnostic]) -> Self {
        self.messages.extend(warnings.iter().map(Message::from));
        self
    }

    /// Joins all failures into one; returns `Ok` if there are none.
    pub(crate) fn all(failures: impl IntoIterator<Item = Self>) -> Result<(), Self> {
        let mut all = Self::default();
        failures.into_iter().for_each(|failure| all.join(failure));
        if all.code == 0 { Ok(()) } else { Err(all) }
    }

    /// Returns the status of a run that ended with this failure.
    pub(crate) fn status(&self) -> RunStatus {
        match self.code {
            INTERRUPTED => RunStatus::Interrupted,
            MISSED => RunStatus::Missed,
            _ => RunStatus::Failed,
        }
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Io(_) => Self::new(FAILED, error),
            LoadError::Invalid(mut diagnostics) => {
                diagnostics.sort_by_key(|diagnostic| Reverse(diagnostic.severity));
                Self { code: INVALID, messages: diagnostics.iter().map(Message::from).collect() }
            }
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::from(&error)
    }
}

impl From<&OutputError> for Failure {
    fn from(error: &OutputError) -> Self {
        Self::written(error, "--out")
    }
}

impl From<PlanFileError> for Failure {
    fn from(error: PlanFileError) -> Self {
        match error {
            PlanFileError::Read(_) => Self::new(FAILED, error),
            PlanFileError::NoPlan { .. } => {
                Self::usage(error, "make one: trochoid plan GRAPH --tolerance 1/64 --out FILE")
            }
        }
    }
}

impl From<KeyError> for Failure {
    fn from(error: KeyError) -> Self {
        let code = if matches!(error, KeyError::Read(_)) { FAILED } else { INVALID };
        Self::new(code, error)
    }
}

impl From<CertificateError> for Failure {
    fn from(error: CertificateError) -> Self {
        match error {
            error if error.is_cancelled() => Self::interrupted(),
            CertificateError::Document(LoadError::Invalid(faults)) => LoadError::Invalid(once(faults)).into(),
            CertificateError::Document(error) => error.into(),
            CertificateError::Reference(ReferenceError::Eval(error)) => Self::evaluated("", &error),
            CertificateError::Write(error) => Self { code: FAILED, ..error.into() },
            CertificateError::NoCertificate { .. } => Self::new(INVALID, error),
            error => Self::new(FAILED, error),
        }
    }
}

/// Removes repeated remedies: of consecutive faults with the same remedy, only the last keeps it.
pub(crate) fn once(mut faults: Vec<Diagnostic>) -> Vec<Diagnostic> {
    for index in 1..faults.len() {
        let (before, rest) = faults.split_at_mut(index);
        let (one, next) = (&mut before[index - 1], &rest[0]);
        if (&one.remedy, &one.means) == (&next.remedy, &next.means) {
            one.remedy.clear();
            one.means = None;
        }
    }
    faults
}

/// Formats a number of diagnostics: "1 error", "2 warnings".
pub(crate) fn count(severity: Severity, number: usize) -> String {
    format!("{number} {severity}{}", if number == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use trochoid::DocumentPlace;

    #[test]
    fn what_takes_too_much_memory_says_how_much_would_do() {
        let error = EvalError::TooMuchMemory {
            place: Box::new(DocumentPlace { document: "a.json".into(), line: 1, column: 2 }),
            found: "pictures 2.5 GB".into(),
            total: 2_500_000_000,
            limit: 1_000_000_000,
            remedy: "lower it",
        };
        let failure = Failure::evaluated("frame 3: ", &error);
        let expected = "error: frame 3: a.json:1:2: found a frame that takes about 2.5 GB: pictures 2.5 GB; expected at most \
                        1.0 GB\n  remedy: lower it; or allow more: --memory 2800MB";
        assert_eq!((failure.code, failure.messages[0].to_string()), (FAILED, expected.to_string()));
    }

    #[test]
    fn the_higher_code_counts_and_no_message_is_lost() {
        assert_eq!(Failure::all([]), Ok(()));
        let all = Failure::all([Failure::usage("a", "b"), Failure::new(FAILED, "c")]).unwrap_err();
        assert_eq!(all.code, INVALID);
        let messages: Vec<String> = all.messages.iter().map(ToString::to_string).collect();
        assert_eq!(messages, ["error: a\n  remedy: b", "error: c"]);
    }
}
