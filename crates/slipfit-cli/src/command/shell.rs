//! `slipfit completions` and `slipfit man`: the command line described for others.

use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::failure::Failure;
use crate::output;
use clap::CommandFactory;
use clap_mangen::Man;
use std::path::Path;
use std::process::ExitCode;

pub(crate) fn completions(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "slipfit", &mut script);
    output::to_path(Path::new("-"), |out| out.write_all(&script))?;
    Ok(ExitCode::SUCCESS)
}

pub(crate) fn man(args: &ManArgs) -> Result<ExitCode, Failure> {
    match &args.out {
        None => {
            // As the pages of the folder have it.
            let mut command = Cli::command().disable_help_subcommand(true);
            command.build();
            output::to_path(Path::new("-"), |out| Man::new(command).render(out))?;
        }
        Some(folder) => {
            output::make_folder(folder)?;
            clap_mangen::generate_to(Cli::command(), folder)
                .map_err(|e| Failure::writing(&folder.display().to_string(), &e))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
