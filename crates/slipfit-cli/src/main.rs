//! The slipfit command: a decaying trace in, viscous and sliding loss out.

mod args;
mod batch;
mod command;
mod failure;
mod interrupt;
mod manifest;
mod output;
mod progress;
mod version;

use failure::{FAILED, Failure};
use std::process::ExitCode;

fn main() -> ExitCode {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        // A panic of a decoder on a broken file is reported as an error instead.
        if !slipfit_io::panic_becomes_error() {
            report(panic);
        }
    }));
    let cli = args::parse();
    interrupt::begin();
    let color = cli.color.into();
    let done = match &cli.command {
        args::Command::Ringdown(args) => command::ringdown::run(args, color),
        args::Command::Map(args) => command::map::run(args, color),
        args::Command::Inspect(args) => command::inspect::run(args, color),
        args::Command::App(args) => command::app::run(args, color),
        args::Command::Simulate(args) => command::simulate::run(args, color),
        args::Command::Resonance(args) => command::resonance::run(args, color),
        args::Command::Levels(args) => command::levels::run(args, color),
        args::Command::Series(args) => command::series::run(args, color),
        args::Command::Paper(args) => command::paper::run(args, color),
        args::Command::Atlas(args) => command::atlas::run(args, color),
        args::Command::Completions(args) => command::shell::completions(args),
        args::Command::Man(args) => command::shell::man(args),
    };
    match done {
        Ok(code) => code,
        Err(Failure::ClosedPipe) => ExitCode::SUCCESS,
        Err(Failure::Message(complaint)) => {
            output::print_error(&complaint.to_string(), color);
            ExitCode::from(FAILED)
        }
    }
}
