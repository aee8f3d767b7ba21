//! Where output goes.

use crate::failure::Failure;
use anstream::{AutoStream, ColorChoice};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes styled text to standard output.
pub(crate) fn print(text: &str, color: ColorChoice) -> Result<(), Failure> {
    let mut out = AutoStream::new(io::stdout().lock(), color);
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|e| Failure::writing("standard output", &e))
}

/// Writes styled text to standard error; nobody is left to hear of a failure there.
pub(crate) fn print_error(text: &str, color: ColorChoice) {
    let mut out = AutoStream::new(io::stderr().lock(), color);
    let _ = out.write_all(text.as_bytes());
}

/// Whether a path stands for standard output.
pub(crate) fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Lets `write` fill a file, or standard output where the path is `-`.
pub(crate) fn to_path(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    let (name, mut out): (String, Box<dyn Write>) = if is_stdout(path) {
        ("standard output".to_owned(), Box::new(BufWriter::new(io::stdout().lock())))
    } else {
        let name = path.display().to_string();
        let file = File::create(path).map_err(|e| Failure::writing(&name, &e))?;
        (name, Box::new(BufWriter::with_capacity(1 << 16, file)))
    };
    write(&mut out).and_then(|()| out.flush()).map_err(|e| Failure::writing(&name, &e))
}

/// Where a writer that outlives a call may put its bytes.
pub(crate) type Sink = BufWriter<Box<dyn Write + Send>>;

/// Opens a file, or standard output where the path is `-`; its name for messages.
pub(crate) fn open(path: &Path) -> Result<(String, Sink), Failure> {
    let (name, out): (String, Box<dyn Write + Send>) = if is_stdout(path) {
        ("standard output".to_owned(), Box::new(io::stdout()))
    } else {
        let name = path.display().to_string();
        let file = File::create(path).map_err(|e| Failure::writing(&name, &e))?;
        (name, Box::new(file))
    };
    Ok((name, BufWriter::with_capacity(1 << 16, out)))
}

/// Makes a folder, and those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path)
        .map_err(|e| Failure::new(format!("--out {}: cannot be made: {e}", path.display())))
}
