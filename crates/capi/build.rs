//! Gives the shared library of a plain build a name, by which programs find it: without one, they look for the path at
//! which they were linked.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let is_linux = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux");
    // `cargo cbuild` gives its library another name, with a version, by itself.
    if is_linux && std::env::var_os("CARGO_FEATURE_CAPI").is_none() {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libtrochoid_capi.so");
    }
}
