//! Writing to an output.
//!
//! A regular file is written next to the old one under a temporary name, flushed to disk and renamed, so that a
//! full disk, a crash or a kill leaves the old one unchanged.

use super::origin;
use super::place::Place;
use crate::failure::Failure;
use crate::interrupt::Unfinished;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::NamedTempFile;

const PREFIX: &str = ".slipfit-";
const SUFFIX: &str = ".tmp";
/// Files left by a killed run are removed by the next one if they are at least this old.
const STALE: Duration = Duration::from_secs(60);

/// An output being written; if it is dropped before [`Sink::finish`], everything stays as it was.
pub(crate) struct Sink {
    name: String,
    /// The regular file that it replaces.
    file: Option<PathBuf>,
    force: bool,
    out: BufWriter<Out>,
}

enum Out {
    Stdout(io::Stdout),
    Direct(File),
    TempFile(NamedTempFile, Unfinished),
}

impl Sink {
    pub(super) fn open(name: String, place: &Place, force: bool) -> Result<Self, Failure> {
        let mut file = None;
        let out = match place {
            Place::Stdout => Ok(Out::Stdout(io::stdout())),
            // Opened for appending, so that a redirected file keeps its content.
            Place::Direct(path) => OpenOptions::new().append(true).open(path).map(Out::Direct),
            Place::File(path) => {
                file = Some(path.clone());
                temp_file_next_to(path).map(|new| {
                    let unfinished = Unfinished::new(new.path());
                    Out::TempFile(new, unfinished)
                })
            }
        };
        let out = out.map_err(|e| Failure::writing(&name, &e))?;
        Ok(Self { name, file, force, out: BufWriter::with_capacity(1 << 16, out) })
    }

    /// Puts the file in place of the old one.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        let Self { name, file, force, out } = self;
        let failed = |e: &io::Error| Failure::writing(&name, e);
        let out = out.into_inner().map_err(|e| failed(e.error()))?;
        match (out, file) {
            (Out::TempFile(new, unfinished), Some(path)) => {
                keep_permissions(&path, new.as_file()).map_err(|e| failed(&e))?;
                new.as_file().sync_all().map_err(|e| failed(&e))?;
                // Another program may have created one in the meantime.
                if !force && path.exists() && !origin::is_ours(&path).unwrap_or(false) {
                    return Err(origin::foreign(&name));
                }
                new.persist(path).map_err(|e| failed(&e.error))?;
                drop(unfinished);
                Ok(())
            }
            (mut out, _) => out.flush().map_err(|e| failed(&e)),
        }
    }
}

/// A new file in the folder of `path`.
fn temp_file_next_to(path: &Path) -> io::Result<NamedTempFile> {
    let folder = path.parent().unwrap_or(Path::new("."));
    remove_stale(folder);
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // As for any new file: reduced by the umask.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let file = builder.tempfile_in(folder)?;
    // Tells other runs that this file is in use; a folder without locks works as well.
    let _ = file.as_file().try_lock();
    Ok(file)
}

fn remove_stale(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !(name.starts_with(PREFIX) && name.ends_with(SUFFIX)) {
            continue;
        }
        let modified = entry.metadata().and_then(|m| m.modified()).ok();
        let old = modified.and_then(|m| m.elapsed().ok()).is_some_and(|age| age > STALE);
        if old && File::open(entry.path()).is_ok_and(|f| f.try_lock().is_ok()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Gives the new file the permissions of the old one, and its owner where that is allowed.
fn keep_permissions(old: &Path, new: &File) -> io::Result<()> {
    let Ok(metadata) = fs::metadata(old) else { return Ok(()) };
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt as _, fchown};
        let ours = new.metadata()?;
        if (metadata.uid(), metadata.gid()) != (ours.uid(), ours.gid()) {
            // Only root may change the owner; the contents matter more.
            let _ = fchown(new, Some(metadata.uid()), Some(metadata.gid()));
        }
    }
    new.set_permissions(metadata.permissions())
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Stdout(out) => out.write(bytes),
            Self::Direct(out) => out.write(bytes),
            Self::TempFile(out, _) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Stdout(out) => out.flush(),
            Self::Direct(out) => out.flush(),
            Self::TempFile(out, _) => out.flush(),
        }
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
