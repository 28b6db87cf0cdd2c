//! The program `rotund`. Its commands are in the library, so that tests and `xtask` can call them.

use std::process::ExitCode;

fn main() -> ExitCode {
    rotund::main(std::env::args_os())
}
