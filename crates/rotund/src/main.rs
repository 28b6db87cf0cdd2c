//! The program `rotund`; everything is in the library so that tests and `xtask` can call it.

use std::process::ExitCode;

fn main() -> ExitCode {
    rotund::main(std::env::args_os())
}
