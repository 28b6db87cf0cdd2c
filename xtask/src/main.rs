//! The binary behind `cargo xtask`; everything is in the library so that tests can call it.

use std::process::ExitCode;

fn main() -> ExitCode {
    xtask::main(std::env::args_os())
}
