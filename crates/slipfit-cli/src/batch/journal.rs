//! Writes rows to disk as soon as they are done, so that nothing finished is lost.

use super::table::Table;
use crate::failure::Failure;
use crate::output::Outputs;
use slipfit_report::row::Row;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A file to which rows are added, one line each. Written rows remain whenever and however the program ends. The
/// file is locked while the program runs.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    table: Table,
    rows: Vec<Row>,
    shown: Instant,
}

/// Minimum time between two updates of the table itself; the rows are always saved.
const RENEWED_EVERY: Duration = Duration::from_secs(2);

/// Where the rows of a table are kept until it is complete.
fn place(table: &Path) -> PathBuf {
    let mut name = table.file_name().unwrap_or_default().to_owned();
    name.push(".rows");
    table.with_file_name(name)
}

impl Journal {
    /// Begins a table, or continues one and returns the rows it has.
    pub(super) fn open(
        table: Table,
        outputs: &mut Outputs,
        signature: &str,
        resume: bool,
    ) -> Result<(Self, Vec<Row>), Failure> {
        let Some(target) = table.to.file() else {
            return Err(Failure::new(format!("--table {}: this is not a file", table.to.named().display()))
                .hint("--json - or --md - write the answer to one file to standard output"));
        };
        let path = place(target);
        outputs.add("--table, its journal", &path)?;
        let name = path.display().to_string();
        let failed = |e: io::Error| Failure::writing(&name, &e);
        let mut file = lock(&path, &table)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        // A last line without a line end was being written when the program ended.
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let before = whole.lines().next().unwrap_or_default();
        let mut kept = Vec::new();
        if !resume || before.is_empty() {
            file.set_len(0).map_err(failed)?;
            file.write_all(format!("{signature}\n").as_bytes()).map_err(failed)?;
        } else if before == signature {
            kept.extend(whole.lines().skip(1).filter_map(|line| Row::parse(line, table.columns)));
            file.set_len(whole.len() as u64).map_err(failed)?;
        } else {
            return Err(Failure::new(format!(
                "--resume: {name} was begun by `{before}`, not by `{signature}`"
            ))
            .hint("the same options continue it; without --resume the table begins anew"));
        }
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        Ok((Self { path, file, table, rows: kept.clone(), shown: Instant::now() }, kept))
    }

    /// Adds a row with one write of one line. The table is updated from time to time, so that there is one to
    /// look at.
    pub(super) fn add(&mut self, row: &Row) -> Result<(), Failure> {
        self.write(row)?;
        self.rows.push(row.clone());
        if self.shown.elapsed() >= RENEWED_EVERY {
            self.table.write(&self.rows)?;
            self.shown = Instant::now();
        }
        Ok(())
    }

    fn write(&mut self, row: &Row) -> Result<(), Failure> {
        let mut line = serde_json::to_string(row)
            .map_err(|e| Failure::new(format!("{}: a row could not be written: {e}", self.path.display())))?;
        line.push('\n');
        self.file
            .write_all(line.as_bytes())
            .and_then(|()| self.file.flush())
            .map_err(|e| Failure::writing(&self.path.display().to_string(), &e))
    }

    /// Writes the table in one step and removes the journal, unless the run was interrupted.
    pub(super) fn finish(self, rows: &[Row], interrupted: bool) -> Result<(), Failure> {
        self.table.write(rows)?;
        if interrupted {
            return Ok(());
        }
        fs::remove_file(&self.path).map_err(|e| Failure::writing(&self.path.display().to_string(), &e))
    }
}

/// The journal, locked by this run.
fn lock(path: &Path, table: &Table) -> Result<File, Failure> {
    let failed = |e: io::Error| Failure::writing(&path.display().to_string(), &e);
    loop {
        let mut options = OpenOptions::new();
        let file = options.read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let table = table.to.named().display();
                return Err(Failure::new(format!("--table {table}: another run is writing it"))
                    .hint("wait for it, or name another table"));
            }
            // On a file system without locks, concurrent runs cannot be detected.
            Err(TryLockError::Error(e)) if e.kind() == io::ErrorKind::Unsupported => return Ok(file),
            Err(TryLockError::Error(e)) => return Err(failed(e)),
        }
        // The previous run may have removed the file between the opening and the locking here.
        let held = file.metadata().map_err(failed)?;
        if fs::metadata(path).is_ok_and(|there| same(&held, &there)) {
            return Ok(file);
        }
    }
}

#[cfg(unix)]
fn same(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// On this system a name becomes free only when no process has the file open.
#[cfg(not(unix))]
fn same(_: &fs::Metadata, _: &fs::Metadata) -> bool {
    true
}
