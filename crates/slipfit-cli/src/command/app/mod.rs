//! `slipfit app`: serves the browser page from this program on the loopback interface.

mod answer;
mod given_file;
mod server;
mod site;

use crate::args::AppArgs;
use crate::failure::{BUILD_PAGE, Failure, WITHOUT_PAGE, note_line};
use crate::output::{print, print_error};
use anstream::ColorChoice;
use answer::Served;
use given_file::GivenFile;
use std::net::{Ipv4Addr, TcpListener};
use std::process::ExitCode;

pub(crate) fn run(args: &AppArgs, color: ColorChoice) -> Result<ExitCode, Failure> {
    if site::SITE.is_empty() {
        return Err(Failure::new(WITHOUT_PAGE).hint(BUILD_PAGE));
    }
    let files = args.files.iter().map(|path| GivenFile::new(path)).collect::<Result<Vec<_>, _>>()?;
    let refused = |e: std::io::Error| {
        Failure::new(format!("--port {}: 127.0.0.1 cannot be served there: {e}", args.port))
            .hint("--port 0 takes a free one")
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, args.port)).map_err(refused)?;
    let port = listener.local_addr().map_err(refused)?.port();
    let served = Served::new(port, token()?, site::SITE, files);
    let address = served.address();
    print(&format!("{address}\n"), color)?;
    print_error(&note_line("served on this machine only, until Ctrl-C"), color);
    if !args.no_browser
        && let Err(e) = open::that_detached(&address)
    {
        print_error(&note_line(&format!("no browser could be opened ({e}): open the address above")), color);
    }
    server::serve(&listener, served)
}

/// 128 random bits.
fn token() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)
        .map_err(|e| Failure::new(format!("the system gives no random numbers: {e}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
