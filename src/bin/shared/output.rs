//! Standard output. `print!` and `println!` of the standard library panic where it cannot be
//! written; the commands use these instead.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// Prints like [`std::print!`]. Ends the command if standard output cannot be written.
macro_rules! print {
    ($($text:tt)*) => { $crate::output::write(format_args!($($text)*)) };
}

/// Prints like [`std::println!`]. Ends the command if standard output cannot be written.
macro_rules! println {
    () => { $crate::output::write(format_args!("\n")) };
    ($($text:tt)*) => { $crate::output::write(format_args!("{}\n", format_args!($($text)*))) };
}

/// Writes to standard output. A reader that wants no more, such as `head`, ends the command with
/// exit code 0, any other error with 1 and a message.
pub fn write(text: Arguments<'_>) {
    let Err(error) = std::io::stdout().write_fmt(text) else { return };
    if error.kind() == ErrorKind::BrokenPipe {
        std::process::exit(0);
    }
    eprintln!("{}: standard output cannot be written: {error}", env!("CARGO_BIN_NAME"));
    std::process::exit(1);
}
