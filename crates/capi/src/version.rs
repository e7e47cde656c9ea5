//! Versions of the interface and of the library.

use std::ffi::c_char;

/// Version of this interface. It grows whenever something that exists changes.
pub const TROCHOID_ABI: u32 = 1;

/// Returns TROCHOID_ABI of the library, to be compared with that of the header.
#[unsafe(no_mangle)]
pub extern "C" fn trochoid_abi() -> u32 {
    TROCHOID_ABI
}

/// Returns the version of Trochoid, such as "0.1.0". It lives as long as the program.
#[unsafe(no_mangle)]
pub extern "C" fn trochoid_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
