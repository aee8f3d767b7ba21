//! Where an output goes, and which file that is.

use file_id::{FileId, get_file_id};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Identifies a file.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Identity {
    Stdout,
    OnDisk(FileId),
    /// It does not exist yet.
    ByName(PathBuf),
}

/// Where the bytes go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Place {
    Stdout,
    /// A device or a pipe, which is written to directly.
    Direct(PathBuf),
    /// A regular file with links resolved, which is replaced as a whole.
    File(PathBuf),
}

/// Number of links followed before a chain of them counts as a cycle.
const MOST_LINKS: usize = 40;

impl Place {
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        if path.as_os_str() == "-" || path == Path::new("/dev/stdout") {
            return Ok(Self::Stdout);
        }
        // A redirected descriptor belongs to the shell, even if it is a file.
        let device = ["/dev", "/proc"].iter().any(|folder| path.starts_with(folder));
        match fs::metadata(path) {
            Ok(m) if m.is_dir() => Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a folder")),
            Ok(m) if device || !m.is_file() => Ok(Self::Direct(path.to_owned())),
            _ if path.as_os_str().as_encoded_bytes().ends_with(b"/") => {
                Err(io::Error::new(io::ErrorKind::NotADirectory, "this names a folder"))
            }
            Ok(_) => fs::canonicalize(path).map(Self::File),
            Err(e) if e.kind() == io::ErrorKind::NotFound => resolve(path).map(Self::File),
            Err(e) => Err(e),
        }
    }
}

pub(super) fn identity(path: &Path) -> io::Result<Identity> {
    match get_file_id(path) {
        Ok(id) => Ok(Identity::OnDisk(id)),
        Err(_) => resolve(path).map(Identity::ByName),
    }
}

/// The full name of a file that does not exist yet, with its links followed to the end.
fn resolve(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
        let folder = fs::canonicalize(folder)
            .map_err(|e| io::Error::new(e.kind(), format!("there is no folder {}", folder.display())))?;
        let full = folder.join(name);
        match fs::read_link(&full) {
            Ok(next) => path = folder.join(next),
            Err(_) => return Ok(full),
        }
    }
    Err(io::Error::other("its links form a loop"))
}
