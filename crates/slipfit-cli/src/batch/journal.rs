//! Rows on disk as soon as they are done, so that nothing finished is lost.

use super::table::Form;
use crate::failure::Failure;
use slipfit_report::row::{Column, Row};
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A file that rows are added to, one line each; what is written stays, whenever
/// and however the program ends.
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
    rows: Vec<Row>,
    columns: &'static [Column],
    shown: Instant,
}

/// The table itself is renewed no more often than this; the rows are always safe.
const RENEWED_EVERY: Duration = Duration::from_secs(2);

/// Where the rows of a table are kept until it is complete.
fn place(table: &Path) -> PathBuf {
    let mut name = table.file_name().unwrap_or_default().to_owned();
    name.push(".rows");
    table.with_file_name(name)
}

impl Journal {
    /// Begins a table, or goes on with one and gives the rows it has.
    pub(crate) fn open(
        table: &Path,
        signature: &str,
        columns: &'static [Column],
        resume: bool,
    ) -> Result<(Self, Vec<Row>), Failure> {
        let path = place(table);
        let name = path.display().to_string();
        let failed = |e: &std::io::Error| Failure::writing(&name, e);
        if let Some(folder) = table.parent().filter(|f| !f.as_os_str().is_empty() && !f.is_dir()) {
            let (table, folder) = (table.display(), folder.display());
            return Err(Failure::new(format!("--table {table}: there is no folder {folder}")));
        }
        let mut kept = Vec::new();
        let mut text = format!("{signature}\n");
        if resume && path.exists() {
            let held = fs::read_to_string(&path).map_err(|e| failed(&e))?;
            // A line without an end was being written when the program ended.
            let whole = held.rfind('\n').map_or("", |end| &held[..end]);
            let mut lines = whole.split('\n');
            let before = lines.next().unwrap_or_default();
            if !before.is_empty() && before != signature {
                return Err(Failure::new(format!(
                    "--resume: {name} was begun by `{before}`, not by `{signature}`"
                ))
                .hint("the same options go on with it; without --resume the table begins anew"));
            }
            for line in lines {
                if let Some(row) = Row::parse(line, columns) {
                    text.push_str(line);
                    text.push('\n');
                    kept.push(row);
                }
            }
        }
        // What is kept is in place before the new file takes the old one's name.
        let fresh = path.with_extension("rows.new");
        fs::write(&fresh, &text).and_then(|()| fs::rename(&fresh, &path)).map_err(|e| failed(&e))?;
        let file = OpenOptions::new().append(true).open(&path).map_err(|e| failed(&e))?;
        Ok((Self { path, file, rows: kept.clone(), columns, shown: Instant::now() }, kept))
    }

    /// Adds a row: one write of one line. Now and then the table is renewed too,
    /// so that there is one to look at.
    pub(crate) fn add(&mut self, row: &Row, table: &Path, form: Form) -> Result<(), Failure> {
        self.write(row)?;
        self.rows.push(row.clone());
        if self.shown.elapsed() >= RENEWED_EVERY {
            self.replace(table, &form.render(&self.rows, self.columns)?)?;
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

    /// Writes the complete table in one step and removes the journal.
    pub(crate) fn finish(self, table: &Path, content: &[u8]) -> Result<(), Failure> {
        self.replace(table, content)?;
        fs::remove_file(&self.path).map_err(|e| Failure::writing(&self.path.display().to_string(), &e))
    }

    /// Writes what there is of the table and keeps the journal, to be gone on with.
    pub(crate) fn suspend(self, table: &Path, content: &[u8]) -> Result<(), Failure> {
        self.replace(table, content)
    }

    fn replace(&self, table: &Path, content: &[u8]) -> Result<(), Failure> {
        let fresh = self.path.with_extension("rows.new");
        fs::write(&fresh, content)
            .and_then(|()| fs::rename(&fresh, table))
            .map_err(|e| Failure::writing(&table.display().to_string(), &e))
    }
}
