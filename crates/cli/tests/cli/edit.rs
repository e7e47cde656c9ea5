//! `trochoid edit`: the editor is a separate program in the same folder.

use crate::scene::Run;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Creates a folder with `trochoid` in it, next to the build so that a hard link suffices: a copy could still be open
/// for writing in a process that another test starts, and could not be run then.
fn installed() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let bin = folder.path().join("bin");
    fs::create_dir(&bin).unwrap();
    let program = bin.join("trochoid");
    fs::hard_link(env!("CARGO_BIN_EXE_trochoid"), &program).unwrap();
    (folder, program)
}

fn run(program: &Path, arguments: &[&str]) -> Run {
    let folder = program.parent().unwrap();
    Run::of(Command::new(program).args(arguments).current_dir(folder).stdin(Stdio::null()))
}

#[test]
fn the_editor_in_the_same_folder_gets_the_arguments_and_gives_the_exit_code() {
    let (_folder, program) = installed();
    // A shell in place of the editor runs its first argument, the document.
    std::os::unix::fs::symlink("/bin/sh", program.with_file_name("trochoid-editor")).unwrap();
    let says = "printf '<%s>' \"$@\"\necho to stderr >&2\nexit 77\n";
    fs::write(program.with_file_name("a.json"), says).unwrap();
    let found = run(&program, &["edit", "a.json", "--allow", "two words", "--memory=8GB", "--allow=edit"]).code(77);
    assert_eq!(found.out, "<--allow><two words><--memory=8GB><--allow=edit>");
    assert_eq!(found.err, "to stderr\n");
}

#[test]
fn wrong_usage_and_help_need_no_editor() {
    let (_folder, program) = installed();
    run(&program, &["edit", "a.json", "b.json"]).fails(2, &["unexpected argument 'b.json'"]);
    run(&program, &["edit", "--memory", "1kB"]).fails(2, &["500MB"]);
    run(&program, &["edit", "--help"]).code(0).says(&[
        "Open the graph editor",
        "[GRAPH]",
        "--allow <PATH>",
        "--memory",
    ]);
}

#[test]
fn without_an_editor_the_command_that_makes_one_is_named() {
    let (folder, program) = installed();
    let missing = ["trochoid-editor: found no such program", "cargo install --path crates/editor"];
    run(&program, &["edit", "a.json"]).fails(1, &missing);
    // In a build folder of cargo, the remedy is to build the editor with the same profile.
    for (profile, command) in [
        ("debug", "build it: cargo build -p trochoid-editor\n"),
        ("release", "build it: cargo build --release -p trochoid-editor\n"),
        ("profiling", "build it: cargo build --profile profiling -p trochoid-editor\n"),
    ] {
        let built = folder.path().join(profile);
        fs::create_dir_all(built.join("deps")).unwrap();
        fs::hard_link(&program, built.join("trochoid")).unwrap();
        run(&built.join("trochoid"), &["edit"]).fails(1, &[command]);
    }
}
