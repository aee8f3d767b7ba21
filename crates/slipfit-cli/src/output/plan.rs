//! Inputs and outputs of a run, checked before anything is analysed.
//!
//! No output may be an input, no two outputs may be the same file, and a file that slipfit did not write is
//! replaced only with `--force`.

use super::origin;
use super::place::{Identity, Place, identity};
use super::sink::Sink;
use crate::failure::Failure;
use file_id::get_file_id;
use std::collections::{BTreeMap, HashMap};
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The files of a run.
pub(crate) struct Outputs {
    force: bool,
    /// Files that are read, by their identity on disk, regardless of their names.
    inputs: HashMap<Identity, PathBuf>,
    /// Flag and path of the outputs added so far.
    taken: HashMap<Identity, String>,
}

/// A checked output.
#[derive(Debug, Clone)]
pub(crate) struct Target {
    /// As requested.
    named: PathBuf,
    place: Place,
    force: bool,
}

impl Outputs {
    /// The outputs of a run that reads `inputs`; a folder stands for the files in it.
    ///
    /// # Errors
    /// Standard output is redirected to one of the inputs.
    pub(crate) fn new<'a>(force: bool, inputs: impl IntoIterator<Item = &'a Path>) -> Result<Self, Failure> {
        let mut outputs = Self { force, inputs: HashMap::new(), taken: HashMap::new() };
        for path in inputs {
            outputs.read(path);
        }
        let stdout = Path::new("/dev/stdout");
        if fs::metadata(stdout).is_ok_and(|m| m.is_file())
            && let Ok(id) = get_file_id(stdout)
        {
            let id = Identity::OnDisk(id);
            if let Some(input) = outputs.inputs.get(&id) {
                return Err(Failure::new(format!("standard output is the input {}", input.display()))
                    .hint("redirect it to another file"));
            }
            outputs.taken.insert(id, "standard output".to_owned());
        }
        Ok(outputs)
    }

    fn read(&mut self, path: &Path) {
        let path = if path.as_os_str() == "-" { Path::new("/dev/stdin") } else { path };
        if let Ok(entries) = fs::read_dir(path) {
            for entry in entries.flatten() {
                if let Ok(id) = get_file_id(entry.path()) {
                    self.inputs.insert(Identity::OnDisk(id), entry.path());
                }
            }
        } else if let Ok(identity) = identity(path) {
            self.inputs.insert(identity, path.to_owned());
        }
    }

    /// Adds the output that `flag` requests; `-` is standard output.
    ///
    /// # Errors
    /// It is an input, or another output, or a file that slipfit did not write, or cannot be written.
    pub(crate) fn add(&mut self, flag: &str, path: &Path) -> Result<Target, Failure> {
        let target = self.add_own(flag, path)?;
        if let Some(file) = target.file()
            && file.exists()
            && !self.force
        {
            let shown = format!("{flag} {}", path.display());
            let ours = origin::is_ours(file);
            if !ours.map_err(|e| Failure::new(format!("{shown}: cannot be written: {e}")))? {
                return Err(origin::foreign(&shown));
            }
        }
        Ok(Target { force: self.force, ..target })
    }

    /// The same for a file of which the caller knows that it may be replaced.
    ///
    /// # Errors
    /// It is an input, or another output, or cannot be written.
    pub(crate) fn add_own(&mut self, flag: &str, path: &Path) -> Result<Target, Failure> {
        let shown = format!("{flag} {}", path.display());
        let failed = |e: io::Error| Failure::new(format!("{shown}: cannot be written: {e}"));
        let place = Place::of(path).map_err(failed)?;
        let identity = match &place {
            Place::Stdout => Identity::Stdout,
            Place::Direct(path) | Place::File(path) => identity(path).map_err(failed)?,
        };
        if let Some(input) = self.inputs.get(&identity) {
            let same = if input == path { String::new() } else { format!(" {}", input.display()) };
            return Err(Failure::new(format!(
                "{shown}: this is the input{same}, which is never overwritten"
            ))
            .hint("name another file"));
        }
        if !matches!(place, Place::Direct(_))
            && let Some(other) = self.taken.insert(identity, shown.clone())
        {
            return Err(match place {
                Place::Stdout => {
                    let other = other.trim_end_matches(" -");
                    Failure::new(format!("{other} and {flag} both go to standard output"))
                        .hint("name a file for all but one of them")
                }
                _ => Failure::new(format!("{other} and {shown} are the same file")).hint("name another file"),
            });
        }
        if let Place::File(file) = &place
            && file.exists()
        {
            OpenOptions::new().write(true).open(file).map_err(failed)?;
        }
        Ok(Target { named: path.to_owned(), place, force: true })
    }

    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.inputs.values().map(PathBuf::as_path)
    }

    pub(super) fn is_forced(&self) -> bool {
        self.force
    }

    /// The files `names` in `folder`, which is created if needed.
    ///
    /// # Errors
    /// The folder cannot be created, or those of [`Self::add`].
    pub(crate) fn folder<'a>(
        mut self,
        folder: &Path,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Result<Folder, Failure> {
        fs::create_dir_all(folder).map_err(|e| {
            Failure::new(format!("--out {}: the folder cannot be created: {e}", folder.display()))
        })?;
        let mut targets = BTreeMap::new();
        for name in names {
            targets.insert(name.to_owned(), self.add("--out", &folder.join(name))?);
        }
        Ok(Folder(targets))
    }
}

/// Files of one folder, by name.
pub(crate) struct Folder(BTreeMap<String, Target>);

impl Folder {
    /// Writes one of them.
    pub(crate) fn write(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        match self.0.get(name) {
            Some(target) => target.write(write),
            None => Err(Failure::new(format!("{name}: a file that was not planned; please report this"))),
        }
    }
}

impl Target {
    /// Standard output, which needs no check.
    pub(crate) fn stdout() -> Self {
        Self { named: PathBuf::from("-"), place: Place::Stdout, force: false }
    }

    /// As requested.
    pub(crate) fn named(&self) -> &Path {
        &self.named
    }

    pub(crate) fn is_stdout(&self) -> bool {
        self.place == Place::Stdout
    }

    /// The regular file, with links resolved.
    pub(crate) fn file(&self) -> Option<&Path> {
        match &self.place {
            Place::File(path) => Some(path),
            _ => None,
        }
    }

    fn name(&self) -> String {
        if self.is_stdout() { "standard output".to_owned() } else { self.named.display().to_string() }
    }

    /// Opens it for a writer that outlives a call; nothing changes before [`Sink::finish`].
    pub(crate) fn open(&self) -> Result<Sink, Failure> {
        Sink::open(self.name(), &self.place, self.force)
    }

    /// Writes it with `write`.
    pub(crate) fn write(&self, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
        let mut sink = self.open()?;
        write(&mut sink).map_err(|e| Failure::writing(&self.name(), &e))?;
        sink.finish()
    }
}
