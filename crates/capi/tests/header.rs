//! The header in `include` is the one of the interface; `TROCHOID_UPDATE=1 cargo test -p trochoid-capi` writes it anew.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use cbindgen::{Builder, Config};
use std::path::Path;

#[test]
fn the_header_is_that_of_the_interface() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let sources = ["version", "status", "error", "options", "look", "batch", "shader", "picture"];
    let builder = Builder::new().with_config(Config::from_file(root.join("cbindgen.toml")).unwrap());
    let builder = sources.iter().fold(builder, |builder, name| builder.with_src(root.join(format!("src/{name}.rs"))));
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let (made, path) = (String::from_utf8(made).unwrap(), root.join("include/trochoid.h"));
    // A module that is missing from the list, or there twice, would be here.
    let exported = std::fs::read_dir(root.join("src")).unwrap().map(|file| file.unwrap().path());
    let exported: usize =
        exported.map(|path| std::fs::read_to_string(path).unwrap().matches("#[unsafe(no_mangle)]").count()).sum();
    assert_eq!(made.matches(");\n").count(), exported + 1, "a function is missing, or told twice");
    if std::env::var_os("TROCHOID_UPDATE").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(known == made, "the header differs from the interface: write it anew, and look at what changed");
}
