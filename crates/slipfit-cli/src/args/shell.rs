//! `slipfit completions` and `slipfit man`.

use super::ReplaceArgs;
use clap::Args;
use clap_complete::Shell;
use std::path::PathBuf;

const COMPLETIONS_HELP: &str = "\
Where the shells look for them:
  slipfit completions bash > ~/.local/share/bash-completion/completions/slipfit
  slipfit completions zsh > ~/.zfunc/_slipfit        (with ~/.zfunc in fpath)
  slipfit completions fish > ~/.config/fish/completions/slipfit.fish
  slipfit completions powershell >> $PROFILE";

/// Shell completions of commands and options.
#[derive(Debug, Args)]
#[command(long_about = "Shell completions of commands and options.")]
#[command(after_help = COMPLETIONS_HELP, after_long_help = COMPLETIONS_HELP)]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum, value_name = "SHELL")]
    pub(crate) shell: Shell,
}

/// Manual pages.
///
/// Writes the page of slipfit itself to standard output, or with --out the pages of all commands to a folder:
/// slipfit.1, slipfit-ringdown.1 and so on.
#[derive(Debug, Args)]
pub(crate) struct ManArgs {
    /// Folder to write to; created if needed
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    pub(crate) out: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) replace: ReplaceArgs,
}
