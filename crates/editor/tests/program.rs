//! Tests of the editor program that need no display.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trochoid-editor"));
    let folder = tempfile::tempdir().unwrap();
    command.args(arguments).current_dir(folder.path());
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "CLICOLOR_FORCE"] {
        command.env_remove(variable);
    }
    command.output().unwrap()
}

#[track_caller]
fn ends(arguments: &[&str], code: i32, words: &[&str]) {
    let output = run(arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(output.stdout.is_empty(), "{:?}", output.stdout);
    for word in words {
        assert!(said.contains(word), "no \"{word}\" in: {said}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_display_it_says_what_it_needs() {
    let warning = "warning: --allow gone: found nothing there; expected a file or folder";
    let error = "error: no window can be opened: neither DISPLAY nor WAYLAND_DISPLAY is set\n  remedy: ";
    ends(&["--allow", "gone", "--memory", "8GB"], 1, &[warning, error]);
}

#[test]
fn a_document_that_cannot_be_read_is_named() {
    ends(&["gone.json"], 1, &["error: gone.json: "]);
}

#[test]
fn wrong_usage_has_an_exit_code_of_its_own() {
    ends(&["a.json", "b.json"], 2, &["unexpected argument 'b.json'", "Usage: trochoid-editor"]);
    ends(&["--memory", "1kB"], 2, &["500MB"]);
}
