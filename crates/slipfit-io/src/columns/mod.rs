//! Which columns are read, and why.

pub(crate) mod asked;
mod clock;
mod content;
mod groups;
pub(crate) mod named;
pub(crate) mod names;
mod signal;
pub(crate) mod units;

use slipfit::SignalKind;

use self::{
    content::Content,
    groups::Group,
    names::{Name, Role},
    units::Seconds,
};
use crate::{ReadOptions, ReadProblem, report::ColumnInfo};

/// A table as its file describes it, before its numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Head {
    /// Sheet, variable, group or track; empty where the file has one table only.
    pub(crate) name: String,
    /// One for each column; empty names without a header.
    pub(crate) names: Vec<Name>,
    /// Samples per second, where the format itself states it.
    pub(crate) rate_hz: Option<f64>,
    /// Values named beside the table.
    pub(crate) named_values: Vec<(String, String)>,
    /// Sentences about what was odd.
    pub(crate) notes: Vec<String>,
}

/// Where the times come from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Time {
    Column(Taken),
    Intervals(Taken),
    Rate(f64),
}

/// A column that will be read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Taken {
    pub(crate) index: usize,
    pub(crate) unit: String,
    pub(crate) why: String,
    /// From its unit to seconds; of a signal nothing.
    pub(crate) seconds: Seconds,
    /// Decibels to be made linear.
    pub(crate) level: bool,
}

/// What will be read from a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice {
    pub(crate) time: Time,
    pub(crate) signal: Taken,
    pub(crate) quadrature: Option<Taken>,
    pub(crate) kind: SignalKind,
    pub(crate) tables: usize,
    pub(crate) runs: usize,
    pub(crate) group: Group,
    pub(crate) notes: Vec<String>,
    /// Whether the numbers decided, so that more of them could decide better.
    pub(crate) by_content: bool,
}

/// A table on its way to a choice.
struct Chooser<'a> {
    head: &'a Head,
    columns: &'a [Vec<f64>],
    contents: Vec<Content>,
    options: &'a ReadOptions,
    notes: Vec<String>,
    by_content: bool,
    /// A column named like a time that holds none.
    misnamed: Option<usize>,
}

/// Chooses columns from what the first rows hold.
pub(crate) fn choose(
    head: &Head,
    columns: &[Vec<f64>],
    options: &ReadOptions,
) -> Result<Choice, ReadProblem> {
    if options.time.is_some() && options.rate_hz.is_some() {
        return Err(ReadProblem::Conflict("--time", "--rate-hz"));
    }
    let contents = columns.iter().map(|c| Content::of(c)).collect();
    let notes = head.notes.clone();
    Chooser { head, columns, contents, options, notes, by_content: false, misnamed: None }.run()
}

impl Chooser<'_> {
    fn role(&self, index: usize) -> Role {
        match self.head.names[index].role() {
            Role::Time if self.misnamed == Some(index) => Role::Unknown,
            role => role,
        }
    }

    fn run(mut self) -> Result<Choice, ReadProblem> {
        let empty: Vec<bool> = self.contents.iter().map(|c| c.filled == 0.0).collect();
        let groups = groups::groups(&self.head.names, &empty);
        let (group, tables, runs) = self.group(&groups)?;
        let asked = |flag, wanted: &Option<String>| {
            wanted.as_ref().map(|w| self.find(flag, w, &group.columns)).transpose()
        };
        let signal = asked("--signal", &self.options.signal)?;
        let quadrature = asked("--quadrature", &self.options.quadrature)?;
        let time = asked("--time", &self.options.time)?;
        let time = self.time(time, &group, signal)?;
        let time_index = match &time {
            Time::Column(taken) | Time::Intervals(taken) => Some(taken.index),
            Time::Rate(_) => None,
        };
        let candidates = self.candidates(&group, time_index);
        let pair = match (signal, quadrature) {
            (None, None) => self.lock_in_pair(&candidates),
            (None, Some(q)) => candidates.iter().copied().find(|&c| c != q).map(|i| (i, q)),
            (Some(s), None) if self.options.kind == Some(SignalKind::LockIn) => {
                candidates.iter().copied().find(|&c| c > s).map(|q| (s, q))
            }
            (Some(s), q) => q.map(|q| (s, q)),
        };
        let (signal, quadrature, why, found_kind) = match (pair, signal) {
            (Some((x, y)), _) => {
                let why =
                    if self.options.quadrature.is_some() { "asked for" } else { "an output of a lock-in" };
                (x, Some(y), why.to_owned(), SignalKind::LockIn)
            }
            (None, Some(index)) => (index, None, "asked for".to_owned(), self.kind_of(index)),
            (None, None) => {
                let (index, why) = self.best(&candidates)?;
                (index, None, why, self.kind_of(index))
            }
        };
        let mut kind = self.options.kind.unwrap_or(found_kind);
        if kind == SignalKind::LockIn && quadrature.is_none() {
            return Err(ReadProblem::NoSignal { columns: self.list(&group.columns) });
        }
        if quadrature.is_some() {
            kind = SignalKind::LockIn;
        }
        let signal_taken = self.signal_taken(signal, &why);
        if signal_taken.level && self.options.kind.is_none() {
            kind = SignalKind::Envelope;
        }
        let quadrature = quadrature.map(|q| self.signal_taken(q, &why));
        let told = self.options.kind.is_some() || !signal_taken.unit.is_empty() || signal_taken.level;
        if !told && quadrature.is_none() && self.role(signal) == Role::Unknown {
            let label = self.label(signal);
            self.notes.push(format!(
                "nothing says what {label} is: it was taken as a displacement; --kind says otherwise"
            ));
        }
        if tables > 1 {
            self.notes.push(format!(
                "{tables} tables stand side by side; number {} was read, --part reads another",
                group.table
            ));
        }
        if runs > 1 {
            self.notes.push(format!(
                "{runs} runs stand in groups of columns; number {} was read, --run reads another",
                group.run
            ));
        }
        Ok(Choice {
            time,
            signal: signal_taken,
            quadrature,
            kind,
            tables,
            runs,
            group,
            notes: self.notes,
            by_content: self.by_content,
        })
    }
}

/// A column as the report names it.
pub(crate) fn info(head: &Head, index: usize) -> ColumnInfo {
    info_of(&head.names, index)
}

/// The same of names alone.
pub(crate) fn info_of(names: &[Name], index: usize) -> ColumnInfo {
    let name = &names[index];
    ColumnInfo { number: index + 1, header: name.header.clone(), unit: name.unit.clone() }
}

/// ``column 4 `Weg / rad` `` or `column 4`.
pub(crate) fn label(column: &ColumnInfo) -> String {
    if column.header.is_empty() {
        format!("column {}", column.number)
    } else {
        format!("column {} `{}`", column.number, column.header)
    }
}
