//! The program; see [`afterimage::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    afterimage::cli::run(std::env::args_os())
}
