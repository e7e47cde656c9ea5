//! The program `trochoid`.

use std::process::ExitCode;

#[global_allocator]
static HEAP: trochoid::Heap = trochoid::Heap;

fn main() -> ExitCode {
    trochoid_cli::main()
}
