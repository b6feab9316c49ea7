//! `cupola manual`: manual pages and completions for shells, from the definitions of the options.
//! Only `scripts/install` runs it, so it is built with the feature `manual` alone.

use crate::failure::Failure;
use clap::CommandFactory;
use clap_complete::Shell;
use std::path::PathBuf;
use std::process::ExitCode;

/// Write manual pages, and completions for bash, fish and zsh.
#[derive(clap::Args)]
pub struct Arguments {
    /// Existing folder to write to
    folder: PathBuf,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let folder = &arguments.folder;
    let failed = |error| Failure::new(format!("{}: {error}", folder.display()));
    let command = visible(crate::Arguments::command());
    clap_mangen::generate_to(command.clone(), folder).map_err(failed)?;
    for shell in [Shell::Bash, Shell::Fish, Shell::Zsh] {
        clap_complete::generate_to(shell, &mut command.clone(), "cupola", folder).map_err(failed)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The command without its hidden subcommands, which have neither a page nor a completion.
fn visible(command: clap::Command) -> clap::Command {
    let mut shown = clap::Command::new("cupola").version(env!("CARGO_PKG_VERSION")).arg_required_else_help(true);
    if let Some(about) = command.get_about() {
        shown = shown.about(about.clone());
    }
    if let Some(help) = command.get_after_help() {
        shown = shown.after_help(help.clone());
    }
    shown.subcommands(command.get_subcommands().filter(|each| !each.is_hide_set()).cloned())
}
