//! `slipfit completions` and `slipfit man`: descriptions of the command line for other programs.

use crate::args::{Cli, CompletionsArgs, ManArgs};
use crate::failure::Failure;
use crate::output::{Outputs, Target};
use clap::CommandFactory;
use clap_mangen::Man;
use std::process::ExitCode;

pub(crate) fn completions(args: &CompletionsArgs) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "slipfit", &mut script);
    Target::stdout().write(|out| out.write_all(&script))?;
    Ok(ExitCode::SUCCESS)
}

pub(crate) fn man(args: &ManArgs) -> Result<ExitCode, Failure> {
    match &args.out {
        None => {
            // The same as the pages in the folder.
            let mut command = Cli::command().disable_help_subcommand(true);
            command.build();
            Target::stdout().write(|out| Man::new(command).render(out))?;
        }
        Some(folder) => {
            let mut command = Cli::command().disable_help_subcommand(true);
            command.build();
            let mut pages = Vec::new();
            collect(command, &mut pages);
            let names = pages.iter().map(|(name, _)| name.as_str());
            let to = Outputs::new(args.replace.force, [])?.folder(folder, names)?;
            for (name, page) in &pages {
                to.write(name, |out| page.render(out))?;
            }
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The pages of a command and of its subcommands, with their file names.
fn collect(command: clap::Command, pages: &mut Vec<(String, Man)>) {
    for below in command.get_subcommands().filter(|c| !c.is_hide_set()).cloned() {
        collect(below, pages);
    }
    let page = Man::new(command);
    pages.push((page.get_filename(), page));
}
