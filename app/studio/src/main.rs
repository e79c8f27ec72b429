//! The `relievo` program: see the library of the same name.

use std::io::{stderr, stdout};
use std::process::ExitCode;

use relievo::cli;

fn main() -> ExitCode {
    cli::log_to_stderr();
    let cancel = cli::cancel_on_interrupt();
    let code = cli::run(
        std::env::args_os(),
        &mut stdout().lock(),
        &mut stderr(),
        &cancel,
    );
    ExitCode::from(code)
}
