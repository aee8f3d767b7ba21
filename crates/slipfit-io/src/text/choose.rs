//! Which columns are read, and why.

use slipfit::SignalKind;

use super::{
    content::{self, Content},
    layout::{self, Group, Layout},
    names::Role,
    units::{self, Measures, Seconds},
};
use crate::{ReadOptions, ReadProblem, report::ColumnInfo};

/// Rank of a column whose name says nothing.
const UNKNOWN_RANK: u8 = 40;

/// Where the times come from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Time {
    Column(Taken),
    Intervals(Taken),
    Rate(f64),
}

/// A column that will be read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Taken {
    pub(super) index: usize,
    pub(super) unit: String,
    pub(super) why: String,
    /// From its unit to seconds; of a signal nothing.
    pub(super) seconds: Seconds,
    /// Decibels to be made linear.
    pub(super) level: bool,
}

/// What will be read from a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub(super) time: Time,
    pub(super) signal: Taken,
    pub(super) quadrature: Option<Taken>,
    pub(super) kind: SignalKind,
    pub(super) tables: usize,
    pub(super) runs: usize,
    pub(super) group: Group,
    pub(super) notes: Vec<String>,
    /// Whether the numbers decided, so that more of them could decide better.
    pub(super) by_content: bool,
}

/// A table on its way to a choice.
struct Chooser<'a> {
    layout: &'a Layout,
    columns: &'a [Vec<f64>],
    contents: Vec<Content>,
    options: &'a ReadOptions,
    notes: Vec<String>,
    by_content: bool,
    /// A column named like a time that holds none.
    misnamed: Option<usize>,
}

/// Chooses columns from what the first rows hold.
pub(super) fn choose(
    layout: &Layout,
    columns: &[Vec<f64>],
    options: &ReadOptions,
) -> Result<Choice, ReadProblem> {
    if options.time.is_some() && options.rate_hz.is_some() {
        return Err(ReadProblem::Conflict("--time", "--rate-hz"));
    }
    let contents = columns.iter().map(|c| Content::of(c)).collect();
    let notes = layout.notes.clone();
    Chooser { layout, columns, contents, options, notes, by_content: false, misnamed: None }.run()
}

impl Chooser<'_> {
    fn run(mut self) -> Result<Choice, ReadProblem> {
        let empty: Vec<bool> = self.contents.iter().map(|c| c.filled == 0.0).collect();
        let groups = layout::groups(&self.layout.names, &empty);
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
                "{tables} tables stand side by side; number {} was read, --table reads another",
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

    /// The group to read, how many tables there are and how many runs in its.
    fn group(&self, groups: &[Group]) -> Result<(Group, usize, usize), ReadProblem> {
        let tables = groups.iter().map(|g| g.table).max().unwrap_or(0);
        let all = || (0..self.columns.len()).collect::<Vec<_>>();
        let holder = match &self.options.signal {
            Some(wanted) if self.options.table.is_none() && self.options.run.is_none() => {
                let index =
                    self.find("--signal", wanted, &groups.first().map_or_else(all, |g| g.columns.clone()))?;
                groups.iter().find(|g| g.columns.contains(&index))
            }
            _ => None,
        };
        let table = holder.map(|g| g.table).or(self.options.table).unwrap_or(1);
        if table == 0 || table > tables {
            return Err(ReadProblem::UnknownGroup { flag: "--table", wanted: table, found: tables });
        }
        let runs = groups.iter().filter(|g| g.table == table).count();
        let run = holder.map(|g| g.run).or(self.options.run).unwrap_or(1);
        let group = groups.iter().find(|g| g.table == table && g.run == run).cloned();
        let group = group.ok_or(ReadProblem::UnknownGroup { flag: "--run", wanted: run, found: runs })?;
        Ok((group, tables, runs))
    }

    /// A column by number or name; names are looked for in `near` first.
    fn find(&self, flag: &'static str, wanted: &str, near: &[usize]) -> Result<usize, ReadProblem> {
        let all: Vec<usize> = (0..self.columns.len()).collect();
        let key = wanted.trim().to_lowercase();
        let names = &self.layout.names;
        let whole = |i: &usize| names[*i].header.to_lowercase() == key;
        let bare = |i: &usize| !names[*i].bare.is_empty() && names[*i].bare.to_lowercase() == key;
        let part = |i: &usize| names[*i].header.to_lowercase().contains(&key);
        let tests: [&dyn Fn(&usize) -> bool; 3] = [&whole, &bare, &part];
        if !key.is_empty() {
            for test in &tests[..2] {
                for place in [near, &all] {
                    if let Some(index) = place.iter().copied().find(|i| test(i)) {
                        return Ok(index);
                    }
                }
            }
        }
        if let Ok(number) = key.parse::<usize>() {
            if (1..=all.len()).contains(&number) {
                return Ok(number - 1);
            }
            return Err(self.unknown(flag, wanted));
        }
        if key.is_empty() {
            return Err(self.unknown(flag, wanted));
        }
        for place in [near, &all] {
            let fits: Vec<usize> = place.iter().copied().filter(|i| part(i)).collect();
            match fits[..] {
                [] => {}
                [index] => return Ok(index),
                _ => {
                    return Err(ReadProblem::AmbiguousColumn {
                        flag,
                        wanted: wanted.to_owned(),
                        candidates: self.list(&fits),
                    });
                }
            }
        }
        Err(self.unknown(flag, wanted))
    }

    fn unknown(&self, flag: &'static str, wanted: &str) -> ReadProblem {
        let all: Vec<usize> = (0..self.columns.len()).collect();
        ReadProblem::UnknownColumn { flag, wanted: wanted.to_owned(), columns: self.list(&all) }
    }

    fn list(&self, indices: &[usize]) -> String {
        const MOST: usize = 12;
        let mut names: Vec<String> = indices.iter().take(MOST).map(|&i| self.label(i)).collect();
        if indices.len() > MOST {
            names.push(format!("{} more", indices.len() - MOST));
        }
        names.join(", ")
    }

    fn label(&self, index: usize) -> String {
        label(&info(self.layout, index))
    }

    fn role(&self, index: usize) -> Role {
        match self.layout.names[index].role() {
            Role::Time if self.misnamed == Some(index) => Role::Unknown,
            role => role,
        }
    }

    fn time(
        &mut self,
        asked: Option<usize>,
        group: &Group,
        signal: Option<usize>,
    ) -> Result<Time, ReadProblem> {
        if let Some(rate) = self.options.rate_hz {
            if let Some(&named) = group.columns.iter().find(|&&c| self.role(c) == Role::Time) {
                let label = self.label(named);
                self.notes.push(format!("{label} was not read: the rate given stands in its place"));
            }
            return Ok(Time::Rate(rate));
        }
        if let Some(index) = asked {
            return self.time_taken(index, "asked for");
        }
        let others =
            || group.columns.iter().copied().filter(|&c| Some(c) != signal && self.contents[c].filled > 0.0);
        let named: Vec<usize> = others().filter(|&c| self.role(c) == Role::Time).collect();
        let usable = |c: usize| self.contents[c].is_monotone() || self.is_interval(c);
        let monotone: Vec<usize> =
            others().filter(|&c| self.contents[c].is_monotone() && self.role(c) != Role::Never).collect();
        // A counter of rows tells no rate.
        let by_content = monotone
            .iter()
            .copied()
            .find(|&c| !self.contents[c].counts)
            .filter(|_| others().count() > 1 || signal.is_some());
        if let Some(index) = named.iter().copied().find(|&c| usable(c)) {
            return self.time_taken(index, "named like a time");
        }
        match (named.first().copied(), by_content) {
            (Some(wrong), Some(index)) => {
                self.misnamed = Some(wrong);
                let (wrong, right) = (self.label(wrong), self.label(index));
                self.notes.push(format!("{wrong} is named like a time but does not go up; {right} does"));
                self.by_content = true;
                self.time_taken(index, "its numbers go up steadily")
            }
            (Some(index), None) => self.time_taken(index, "named like a time"),
            (None, Some(index)) => {
                self.by_content = true;
                self.time_taken(index, "its numbers go up steadily")
            }
            (None, None) => {
                let interval = others().rfind(|&c| self.is_interval(c));
                match interval {
                    Some(index) if self.columns.len() > 1 => self.time_taken(
                        index,
                        "its numbers are nearly constant, as times since the row before are",
                    ),
                    _ => Err(ReadProblem::NoTime {
                        columns: self.list(&group.columns),
                        rate_hz: layout::named_rate_hz(&self.layout.named_values),
                    }),
                }
            }
        }
    }

    /// Whether a column holds the times between rows.
    fn is_interval(&self, index: usize) -> bool {
        let content = self.contents[index];
        let named = self.layout.names[index].is_step() && content.least >= 0.0 && content.greatest > 0.0;
        !content.is_monotone() && (content.is_interval() || named)
    }

    fn time_taken(&mut self, index: usize, why: &str) -> Result<Time, ReadProblem> {
        let content = self.contents[index];
        let interval = self.is_interval(index);
        let name = &self.layout.names[index];
        let label = self.label(index);
        let known = self.options.time_unit.as_deref().or(Some(name.unit.as_str()).filter(|u| !u.is_empty()));
        let (unit, seconds) = match known {
            Some(unit) => match units::measures(unit) {
                Some(Measures::Time(seconds)) => (unit.to_owned(), seconds),
                _ if self.options.time_unit.is_some() => {
                    return Err(ReadProblem::UnknownTimeUnit { unit: unit.to_owned() });
                }
                _ => ("s".to_owned(), Seconds::Same),
            },
            None if name.bare.to_lowercase().starts_with("milli") => ("ms".to_owned(), Seconds::Over(1e3)),
            None if name.bare.to_lowercase().starts_with("micro") => ("us".to_owned(), Seconds::Over(1e6)),
            None if interval && content.greatest >= 1.0 => {
                self.notes.push(format!(
                    "{label}: steps of {:.0} were taken as milliseconds; --time-unit says otherwise",
                    content.greatest
                ));
                ("ms".to_owned(), Seconds::Over(1e3))
            }
            // Microcontrollers count milliseconds; nobody samples an oscillator every few seconds.
            None if !interval && content.whole && (2.0..=1000.0).contains(&content.mean_step) => {
                self.notes.push(format!(
                    "{label} names no unit and holds whole numbers {:.1} apart: they were taken as milliseconds; --time-unit says otherwise",
                    content.mean_step
                ));
                ("ms".to_owned(), Seconds::Over(1e3))
            }
            None => {
                self.notes.push(format!(
                    "{label} names no unit: its times were taken as seconds; --time-unit says otherwise"
                ));
                ("s".to_owned(), Seconds::Same)
            }
        };
        let taken = Taken { index, unit, why: format!("{label}: {why}"), seconds, level: false };
        Ok(if interval { Time::Intervals(taken) } else { Time::Column(taken) })
    }

    /// Columns that could be the signal.
    fn candidates(&self, group: &Group, time: Option<usize>) -> Vec<usize> {
        group
            .columns
            .iter()
            .copied()
            .filter(|&c| Some(c) != time && self.contents[c].filled > 0.0)
            .filter(|&c| !matches!(self.role(c), Role::Time | Role::Never))
            .filter(|&c| self.role(c) != Role::Unknown || !self.is_second_clock(c, group))
            .collect()
    }

    /// An unnamed column beside others that goes up like a time or a counter.
    fn is_second_clock(&self, column: usize, group: &Group) -> bool {
        group.columns.len() > 2 && self.contents[column].is_monotone() && self.contents[column].moving > 0.5
    }

    fn lock_in_pair(&self, candidates: &[usize]) -> Option<(usize, usize)> {
        let by_role = |role: Role| candidates.iter().copied().find(|&c| self.role(c) == role);
        if let (Some(i), Some(q)) = (by_role(Role::InPhase), by_role(Role::Quadrature)) {
            return Some((i, q));
        }
        let named = |name: &str| {
            candidates.iter().copied().find(|&c| self.layout.names[c].bare.trim().eq_ignore_ascii_case(name))
        };
        let (x, y) = (named("x")?, named("y")?);
        let electrical = |c: usize| {
            let unit = self.layout.names[c].unit.as_str();
            unit.ends_with('V') || unit.ends_with('A')
        };
        let beside = self.layout.names.iter().any(|n| {
            let name = n.bare.to_lowercase();
            ["r", "phase", "theta", "mag", "frequency"].contains(&name.trim())
        });
        let asked = self.options.kind == Some(SignalKind::LockIn);
        let open = self.options.kind.is_none();
        (asked || (open && (beside || (electrical(x) && electrical(y))))).then_some((x, y))
    }

    fn rank(&self, index: usize) -> u8 {
        match self.role(index) {
            // An amplitude is no phase's poor relation: R and theta come from one instrument.
            Role::Signal { like: "named like an angle", .. } if self.has_r() => 0,
            Role::Signal { rank, .. } => rank,
            _ => UNKNOWN_RANK,
        }
    }

    fn has_r(&self) -> bool {
        self.layout.names.iter().any(|n| n.bare.trim().eq_ignore_ascii_case("r"))
    }

    /// The column that is most likely the signal.
    fn best(&mut self, candidates: &[usize]) -> Result<(usize, String), ReadProblem> {
        let varies = |c: &usize| self.contents[*c].greatest > self.contents[*c].least;
        let varying: Vec<usize> = candidates.iter().copied().filter(varies).collect();
        let from = if varying.is_empty() { candidates } else { &varying };
        let top = from.iter().map(|&c| self.rank(c)).max();
        let mut best: Vec<usize> = from.iter().copied().filter(|&c| Some(self.rank(c)) == top).collect();
        let like = match best.first().map(|&c| self.role(c)) {
            None => {
                let all: Vec<usize> = (0..self.columns.len()).collect();
                return Err(ReadProblem::NoSignal { columns: self.list(&all) });
            }
            Some(Role::Signal { like, .. }) => like,
            Some(_) => "",
        };
        if let [only] = best[..] {
            let why = if like.is_empty() { "the only column left" } else { like };
            return Ok((only, why.to_owned()));
        }
        self.by_content = true;
        let among = self.list(&best);
        let ringing: Vec<usize> = best.iter().copied().filter(|&c| self.contents[c].is_ringing()).collect();
        if !ringing.is_empty() {
            best = ringing;
        }
        let derived = |c: usize| {
            best.iter()
                .any(|&other| other != c && content::is_derivative(&self.columns[c], &self.columns[other]))
        };
        let original: Vec<usize> = best.iter().copied().filter(|&c| !derived(c)).collect();
        if !original.is_empty() {
            best = original;
        }
        // Sizes compare only within one unit.
        let unit = &self.layout.names[best[0]].unit;
        let greatest = best
            .iter()
            .copied()
            .filter(|&c| self.layout.names[c].unit == *unit)
            .reduce(|held, c| if self.contents[c].swing > self.contents[held].swing { c } else { held })
            .unwrap_or(best[0]);
        let prefix = if like.is_empty() { String::new() } else { format!("{like}, and ") };
        Ok((greatest, format!("{prefix}oscillates and dies down most among {among}")))
    }

    fn kind_of(&self, index: usize) -> SignalKind {
        // A unit given or named apart says more than the name; m alone says nothing.
        let named_apart = self.options.signal_unit.is_some() || self.layout.names[index].unit.is_empty();
        match units::measures(self.written_unit(index)).filter(|_| named_apart) {
            Some(Measures::Signal(kind)) if kind != SignalKind::Displacement => return kind,
            _ => {}
        }
        match self.role(index) {
            // Oscilloscopes call a waveform an amplitude; an envelope is never negative.
            Role::Signal { kind: SignalKind::Envelope, .. }
                if self.contents[index].least < 0.0 && !self.signal_taken(index, "").level =>
            {
                SignalKind::Displacement
            }
            Role::Signal { kind, .. } => kind,
            _ => SignalKind::Displacement,
        }
    }

    /// The unit given, in the header, or else named above the table.
    fn written_unit(&self, index: usize) -> &str {
        let in_header = self.layout.names[index].unit.as_str();
        let named = || layout::named_unit(&self.layout.named_values).unwrap_or_default();
        match &self.options.signal_unit {
            Some(given) => given.trim(),
            None if in_header.is_empty() => named(),
            None => in_header,
        }
    }

    fn signal_taken(&self, index: usize, why: &str) -> Taken {
        let written = self.written_unit(index);
        let (unit, level) = match units::measures(written) {
            Some(Measures::Level(linear)) => (linear.to_owned(), true),
            _ => (written.to_owned(), false),
        };
        let why = format!("{}: {why}", self.label(index));
        Taken { index, unit, why, seconds: Seconds::Same, level }
    }
}

/// A column as the report names it.
pub(super) fn info(layout: &Layout, index: usize) -> ColumnInfo {
    let name = &layout.names[index];
    ColumnInfo { number: index + 1, header: name.header.clone(), unit: name.unit.clone() }
}

/// ``column 4 `Weg / rad` `` or `column 4`.
pub(super) fn label(column: &ColumnInfo) -> String {
    if column.header.is_empty() {
        format!("column {}", column.number)
    } else {
        format!("column {} `{}`", column.number, column.header)
    }
}
