//! Choice of the columns of a record.

use slipfit::SignalKind;

use super::{
    chooser::{Chooser, ChosenColumn, Fraction, numbered},
    clock::Time,
    groups::{self, Group},
    head::Head,
    role::Role,
};
use crate::{
    error::{Needed, OptionProblem, ReadProblem},
    options::ReadOptions,
    report::Note,
};

/// What will be read from a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice {
    pub(crate) time: Time,
    pub(crate) signal: ChosenColumn,
    pub(crate) quadrature: Option<ChosenColumn>,
    /// Fractions of a second to be added to times in whole seconds.
    pub(crate) fraction: Option<Fraction>,
    /// Whether signal and quadrature are in decibels and have to be made linear.
    pub(crate) levels: [bool; 2],
    pub(crate) kind: SignalKind,
    /// Whether the signal contains gravity, whose direction turns with the motion.
    pub(crate) turning_gravity: bool,
    pub(crate) parts: usize,
    pub(crate) part: usize,
    pub(crate) runs: usize,
    pub(crate) run: usize,
    /// The run requested when the columns do not hold several runs side by side; it counts runs that follow each other.
    pub(crate) rows_run: Option<usize>,
    pub(crate) notes: Vec<Note>,
    /// Whether the choice depended on the numbers, so that reading more rows could improve it.
    pub(crate) by_content: bool,
    /// Whether the signal is the only column apart from the times and has no name of a motion: another table may hold
    /// one.
    pub(crate) last_resort: bool,
}

/// Chooses columns from the first rows of a file with this name.
pub(crate) fn choose(
    head: &Head,
    values: &[Vec<f64>],
    file: &str,
    options: &ReadOptions,
) -> Result<Choice, ReadProblem> {
    let given = [("time", &options.time), ("time_unit", &options.time_unit)];
    let given = given.into_iter().find_map(|(option, value)| Some((option, value.clone()?)));
    if let (Some((option, value)), Some(_)) = (given, options.rate_hz) {
        let problem = OptionProblem::Excludes("a sampling rate");
        return Err(ReadProblem::Option { option, value, problem });
    }
    Chooser::of_record(head, values, options).record(file)
}

impl Chooser<'_> {
    fn record(mut self, file: &str) -> Result<Choice, ReadProblem> {
        let options = self.options;
        let (group, parts, runs) = self.group()?;
        self.near = group.columns;
        self.check_distinct(&[
            ("signal", &options.signal),
            ("quadrature", &options.quadrature),
            ("time", &options.time),
        ])?;
        let signal = self.asked("signal", &options.signal)?;
        let quadrature = self.asked("quadrature", &options.quadrature)?;
        let time = self.asked("time", &options.time)?;
        let time = self.time(time, signal)?;
        let mut candidates = self.candidates(time.column().map(|t| t.index));
        let last_resort = candidates.is_empty() && signal.is_none();
        if candidates.is_empty() {
            candidates.extend(self.only_other(time.column().map(|t| t.index)));
        }
        let pair = match (signal, quadrature) {
            (None, None) => self.lock_in_pair(&candidates),
            (None, Some(q)) => candidates.iter().copied().find(|&c| c != q).map(|i| (i, q)),
            (Some(s), None) if options.kind == Some(SignalKind::LockIn) => {
                candidates.iter().copied().find(|&c| c > s).map(|q| (s, q))
            }
            (Some(s), q) => q.map(|q| (s, q)),
        };
        let (signal, quadrature, why, found_kind) = match (pair, signal) {
            (Some((x, y)), _) => {
                let why = if options.quadrature.is_some() { "asked for" } else { "an output of a lock-in" };
                (x, Some(y), why.to_owned(), SignalKind::LockIn)
            }
            (None, Some(index)) => (index, None, "asked for".to_owned(), self.kind_of(index)),
            (None, None) => {
                let (index, why) = self.best(&candidates)?;
                (index, None, why, self.kind_of(index))
            }
        };
        let time = match self.nearer_time(&time, signal) {
            Some(nearer) if options.time.is_none() => {
                self.time_taken(nearer, "named like a time, the one beside the signal")?
            }
            _ => time,
        };
        let (signal_taken, level) = self.signal_taken(signal, &why);
        let kind = match options.kind.unwrap_or(found_kind) {
            SignalKind::LockIn if quadrature.is_none() => {
                let columns = self.head.list(&self.near);
                return Err(ReadProblem::NoColumn { needed: Needed::Quadrature, columns });
            }
            _ if level && options.kind.is_none() => SignalKind::Envelope,
            _ if quadrature.is_some() => SignalKind::LockIn,
            kind => kind,
        };
        let of_place = options.kind.is_none() && quadrature.is_none();
        let kind = if of_place { self.kind_of_place(signal, file).unwrap_or(kind) } else { kind };
        let unsaid = options.kind.is_none() && signal_taken.unit.is_empty() && !level;
        if unsaid && quadrature.is_none() && self.roles[signal] == Role::Unknown {
            let text = format!(
                "nothing says which quantity {} is: it was taken as a displacement",
                self.label(signal)
            );
            self.notes.push(Note::new(text).hint("kind", "gives another"));
        }
        self.note_another_unit(signal);
        if parts > 1 {
            let text = format!("the file has {parts} tables side by side: number {} was read", group.table);
            self.notes.push(Note::new(text).hint("part", "reads another"));
        }
        if runs > 1 {
            let text =
                format!("the file has {runs} runs in groups of columns: number {} was read", group.run);
            self.notes.push(Note::new(text).hint("run", "reads another"));
        }
        let turning_gravity = kind == SignalKind::Acceleration && self.turns_in_gravity(signal);
        let quadrature = quadrature.map(|q| self.signal_taken(q, &why));
        Ok(Choice {
            time,
            signal: signal_taken,
            levels: [level, quadrature.as_ref().is_some_and(|q| q.1)],
            quadrature: quadrature.map(|q| q.0),
            fraction: self.fraction,
            kind,
            turning_gravity,
            parts,
            part: group.table,
            runs,
            run: group.run,
            rows_run: options.run.filter(|_| runs == 1),
            notes: self.notes,
            by_content: self.by_content,
            last_resort,
        })
    }

    /// The group of columns to read, the number of tables, and the number of runs in its table.
    fn group(&mut self) -> Result<(Group, usize, usize), ReadProblem> {
        let empty: Vec<bool> = self.contents.iter().map(|c| c.filled == 0.0).collect();
        let groups = groups::groups(&self.head.names, &empty);
        let parts = groups.iter().map(|g| g.table).max().unwrap_or(0);
        let options = self.options;
        if let Some(first) = groups.first() {
            self.near.clone_from(&first.columns);
        }
        let unasked = options.part.is_none() && options.run.is_none();
        let holder = match &options.signal {
            Some(_) if unasked => {
                let index = self.asked("signal", &options.signal)?;
                groups.iter().find(|g| index.is_some_and(|i| g.columns.contains(&i)))
            }
            _ => None,
        };
        let part = numbered("part", holder.map(|g| g.table).or(options.part), parts)?;
        let runs = groups.iter().filter(|g| g.table == part).count();
        let run = numbered("run", holder.map(|g| g.run).or(options.run.filter(|_| runs > 1)), runs)?;
        let group = groups.iter().find(|g| g.table == part && g.run == run).cloned();
        let missing = ReadProblem::NoColumn { needed: Needed::Signal, columns: self.list() };
        Ok((group.ok_or(missing)?, parts, runs))
    }
}
