//! Which columns make the curve, and why.

use slipfit::SignalKind;

use super::{
    SweepOptions,
    choice::{Choice, Picked, Response, Scale},
    role::{self, Role},
};
use crate::{
    ReadProblem, Table,
    columns::{asked, info_of, label, names::Name, units},
    report::ColumnInfo,
};

/// A table on its way to a choice.
pub(super) struct Chooser<'a> {
    pub(super) table: &'a Table,
    pub(super) options: &'a SweepOptions,
    pub(super) names: Vec<Name>,
    pub(super) roles: Vec<Role>,
    pub(super) notes: Vec<String>,
    /// Columns of the run read.
    pub(super) near: Vec<usize>,
}

impl<'a> Chooser<'a> {
    pub(super) fn new(table: &'a Table, options: &'a SweepOptions) -> Self {
        let names: Vec<Name> = table
            .columns
            .iter()
            .map(|c| {
                let parsed = Name::parse(&c.header);
                if parsed.unit.is_empty() { Name { unit: c.unit.clone(), ..parsed } } else { parsed }
            })
            .collect();
        let roles = names.iter().map(role::role).collect();
        let near = (0..names.len()).collect();
        Self { table, options, names, roles, notes: table.notes.clone(), near }
    }

    pub(super) fn columns(&self) -> Vec<ColumnInfo> {
        (0..self.names.len()).map(|i| info_of(&self.names, i)).collect()
    }

    pub(super) fn run(mut self) -> Result<Choice, ReadProblem> {
        let (runs, run) = self.take_run()?;
        let frequency = self.frequency()?;
        let mut taken = frequency.indices();
        let response = self.response(&taken)?;
        taken.extend(response.indices());
        let drive = self.drive(&taken)?;
        taken.extend(drive.as_ref().map(|d| d.index));
        let std_error = self.std_error(&response, &taken)?;
        let (kind, unit) = self.kind(&response);
        self.tell_unread(&taken, std_error.as_ref());
        let named = self.roles[taken[0]] != Role::Unknown && self.of_role(Role::Time, &[]).is_none();
        let notes = self.notes;
        Ok(Choice { frequency, response, drive, std_error, kind, unit, runs, run, named, notes })
    }

    /// Curves in groups of columns begin with a frequency each.
    fn take_run(&mut self) -> Result<(usize, usize), ReadProblem> {
        let leads = |role: Role| matches!(role, Role::Frequency | Role::Period | Role::Shift);
        let starts: Vec<usize> =
            (0..self.names.len()).filter(|&i| leads(self.roles[i]) && self.filled(i)).collect();
        let stem = |i: usize| self.names[i].stem();
        let alike = starts.len() > 1 && starts.iter().all(|&i| stem(i) == stem(starts[0]));
        let apart = starts.windows(2).all(|w| w[1] > w[0] + 1);
        let runs = if alike && apart { starts.len() } else { 1 };
        let run = self.options.run.unwrap_or(1);
        if run == 0 || run > runs {
            return Err(ReadProblem::UnknownGroup { flag: "--run", wanted: run, found: runs });
        }
        if runs > 1 {
            let from = if run == 1 { 0 } else { starts[run - 1] };
            let to = starts.get(run).copied().unwrap_or(self.names.len());
            self.near = (from..to).collect();
            self.notes.push(format!(
                "{runs} curves stand in groups of columns; number {run} was read, --run reads another"
            ));
        }
        Ok((runs, run))
    }

    pub(super) fn filled(&self, index: usize) -> bool {
        self.table.columns[index].values.iter().any(|v| v.is_finite())
    }

    pub(super) fn finite(&self, index: usize) -> impl Iterator<Item = f64> + '_ {
        self.table.columns[index].values.iter().copied().filter(|v| v.is_finite())
    }

    pub(super) fn label(&self, index: usize) -> String {
        label(&info_of(&self.names, index))
    }

    pub(super) fn list(&self) -> String {
        asked::list(&self.names, &(0..self.names.len()).collect::<Vec<_>>())
    }

    pub(super) fn asked(
        &self,
        flag: &'static str,
        wanted: &Option<String>,
    ) -> Result<Option<usize>, ReadProblem> {
        wanted.as_ref().map(|w| asked::find(&self.names, flag, w, &self.near)).transpose()
    }

    pub(super) fn picked(&self, index: usize, why: &str) -> Picked {
        let unit = self.names[index].unit.clone();
        Picked { index, unit, why: format!("{}: {why}", self.label(index)) }
    }

    /// The first column of a role that holds numbers; those that vary before those that do not.
    pub(super) fn of_role(&self, wanted: Role, without: &[usize]) -> Option<usize> {
        let fits = |i: &&usize| self.roles[**i] == wanted && !without.contains(i) && self.filled(**i);
        let varies = |i: &&usize| {
            let mut values = self.finite(**i);
            values.next().is_some_and(|first| values.any(|v| v != first))
        };
        self.near.iter().filter(fits).find(varies).or_else(|| self.near.iter().find(fits)).copied()
    }

    fn drive(&mut self, taken: &[usize]) -> Result<Option<Picked>, ReadProblem> {
        if let Some(index) = self.asked("--drive", &self.options.drive)? {
            return Ok(Some(self.picked(index, "asked for")));
        }
        let Some(index) = self.of_role(Role::Drive, taken) else { return Ok(None) };
        if self.finite(index).any(|v| v <= 0.0) {
            self.notes.push(format!(
                "{} is named like a drive but is not above zero throughout: it was not divided out; --drive insists",
                self.label(index)
            ));
            return Ok(None);
        }
        Ok(Some(self.picked(index, "named like a drive; divided out")))
    }

    fn std_error(&mut self, response: &Response, taken: &[usize]) -> Result<Option<Picked>, ReadProblem> {
        if let Some(index) = self.asked("--std-error", &self.options.std_error)? {
            return Ok(Some(self.picked(index, "asked for")));
        }
        let Response::Amplitude { amplitude, scale: Scale::Linear, .. } = response else { return Ok(None) };
        // Errors of something else name it, or stand behind it.
        let own = |i: usize| {
            let words = crate::columns::names::words(&self.names[i].bare);
            let of_other = ["f", "freq", "frequency", "phase", "phi", "drive", "t"];
            let bare = self.names[amplitude.index].bare.to_lowercase();
            let theirs = crate::columns::names::words(&bare);
            !words.iter().any(|w| of_other.contains(&w.as_str()))
                && (words.iter().any(|w| theirs.contains(w)) || i == amplitude.index + 1)
        };
        let fits = |i: &&usize| {
            let error = self.roles[**i] == Role::StdError && own(**i);
            (error || self.differential(**i, amplitude.index)) && !taken.contains(i)
        };
        let Some(index) = self.near.iter().find(fits).copied() else { return Ok(None) };
        if self.finite(index).any(|v| v <= 0.0) || !self.filled(index) {
            self.notes.push(format!(
                "{} is named like a standard error but is not above zero throughout: it was not used; --std-error insists",
                self.label(index)
            ));
            return Ok(None);
        }
        Ok(Some(self.picked(index, "named like the standard error of the amplitude")))
    }

    /// `dA`, `ΔA` or `u_A` beside `A`, in its unit.
    fn differential(&self, index: usize, of: usize) -> bool {
        let (name, amplitude) = (&self.names[index], &self.names[of]);
        let bare = name.bare.to_lowercase();
        let rest = ["d", "δ", "∆", "u", "s", "e", "σ"].iter().filter_map(|p| bare.strip_prefix(p));
        let wanted = amplitude.bare.to_lowercase();
        let says = |rest: &str| rest.trim_matches(['_', ' ']) == wanted;
        matches!(self.roles[index], Role::Unknown | Role::Amplitude)
            && !wanted.is_empty()
            && (name.unit.is_empty() || name.unit == amplitude.unit)
            && rest.into_iter().any(says)
    }

    /// What the response is, and the unit of the curve.
    fn kind(&mut self, response: &Response) -> (SignalKind, String) {
        let (unit, name) = match response {
            Response::Amplitude { amplitude, .. } => (amplitude.unit.clone(), amplitude.index),
            Response::Complex(re, _) => {
                (self.options.unit.clone().unwrap_or_else(|| re.unit.clone()), re.index)
            }
            Response::Admittance(..) | Response::Impedance(..) => {
                return (SignalKind::Velocity, "F".to_owned());
            }
        };
        let by_unit = match units::measures(&unit) {
            Some(units::Measures::Signal(kind)) => kind,
            _ => SignalKind::Displacement,
        };
        let by_name = match self.names[name].role() {
            crate::columns::names::Role::Signal { kind, .. }
                if matches!(kind, SignalKind::Velocity | SignalKind::Acceleration)
                    && long_word(&self.names[name].bare) =>
            {
                kind
            }
            _ => by_unit,
        };
        (self.options.kind.unwrap_or(by_name), unit)
    }

    /// Columns nobody will look at, so that nobody has to wonder.
    fn tell_unread(&mut self, taken: &[usize], std_error: Option<&Picked>) {
        let unread: Vec<usize> = (0..self.names.len())
            .filter(|i| !taken.contains(i) && std_error.is_none_or(|s| s.index != *i) && self.filled(*i))
            .filter(|i| !self.names[*i].header.is_empty() || self.near.contains(i))
            .collect();
        if !unread.is_empty() {
            self.notes.push(format!("not used: {}", asked::list(&self.names, &unread)));
        }
    }
}

/// Whether a name begins with a word, not with a letter that means something else here.
fn long_word(bare: &str) -> bool {
    crate::columns::names::words(bare).first().is_some_and(|w| w.chars().count() > 3)
}
