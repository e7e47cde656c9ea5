//! `trochoid edit`: runs the editor, which is a separate program so that no other command depends on a window system.

use crate::failure::{FAILED, Failure};
use crate::host;
use std::env::consts::EXE_SUFFIX;
use std::ffi::OsString;
use std::path::Path;
use std::process::Command;
use trochoid::quoted_path;

pub(crate) fn run() -> Result<(), Failure> {
    if host::is_there() {
        let found = "found edit within another program, which it would replace; expected another command";
        return Err(Failure::usage(found, "run the program trochoid"));
    }
    let own = std::env::current_exe()
        .map_err(|error| Failure::new(FAILED, format!("the folder of this program cannot be found: {error}")))?;
    let editor = own.with_file_name(format!("trochoid-editor{EXE_SUFFIX}"));
    if !editor.is_file() {
        let fault = format!("{}: found no such program; expected the editor", quoted_path(&editor));
        return Err(Failure { code: FAILED, ..Failure::usage(fault, remedy(&editor)) });
    }
    let mut command = Command::new(&editor);
    command.args(arguments(std::env::args_os().skip(1)));
    let error = hand_over(&mut command);
    Err(Failure::new(FAILED, format!("{}: cannot be run: {error}", quoted_path(&editor))))
}

/// Returns the editor's arguments: all arguments but the name of the command, which only options may precede.
fn arguments(all: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut all: Vec<OsString> = all.collect();
    if let Some(name) = all.iter().position(|argument| argument == "edit") {
        all.remove(name);
    }
    all
}

/// Returns the cargo command that puts the editor next to this program: a build in a target folder, else an
/// installation.
fn remedy(editor: &Path) -> String {
    let folder = editor.parent().filter(|folder| folder.join("deps").is_dir());
    let profile = match folder.and_then(|folder| folder.file_name()?.to_str()) {
        None => return "install it, in the folder of the sources: cargo install --path crates/editor".into(),
        Some("debug") => String::new(),
        Some("release") => "--release ".into(),
        Some(profile) => format!("--profile {profile} "),
    };
    format!("build it: cargo build {profile}-p trochoid-editor")
}

/// Replaces this process with another program; returns only if that fails.
#[cfg(unix)]
fn hand_over(command: &mut Command) -> std::io::Error {
    std::os::unix::process::CommandExt::exec(command)
}

/// Runs another program and exits with its code; returns only if it cannot be started.
#[cfg(not(unix))]
fn hand_over(command: &mut Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(i32::from(FAILED))),
        Err(error) => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_editor_gets_every_argument_but_the_name_of_the_command() {
        for (all, handed_on) in [
            ("edit", ""),
            ("edit a.json --allow b", "a.json --allow b"),
            ("--memory 8GB edit a.json", "--memory 8GB a.json"),
            ("edit edit --allow=edit", "edit --allow=edit"),
        ] {
            let found = arguments(all.split_whitespace().map(OsString::from));
            assert_eq!(found, handed_on.split_whitespace().collect::<Vec<_>>(), "{all}");
        }
    }
}
