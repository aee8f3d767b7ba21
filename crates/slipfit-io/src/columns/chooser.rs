//! State of the choice of columns from a table.

use slipfit::answer::hint::Analysis;

use super::{
    content::Content,
    head::Head,
    role::{self, Role},
};
use crate::{
    error::{OptionProblem, ReadProblem},
    options::ReadOptions,
    report::{ColumnTaken, Note},
};

/// A column that will be read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChosenColumn {
    pub(crate) index: usize,
    /// Unit assumed for its numbers.
    pub(crate) unit: String,
    /// Reason for choosing this column.
    pub(crate) why: String,
}

impl ChosenColumn {
    /// The column in the form used by the report.
    pub(crate) fn taken(&self, head: &Head) -> ColumnTaken {
        ColumnTaken { column: head.info(self.index), unit: self.unit.clone(), why: self.why.clone() }
    }
}

/// A column of fractions of a second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fraction {
    pub(crate) index: usize,
    /// Number of its units per second.
    pub(crate) per_second: f64,
}

/// State of the choice of columns of a table.
pub(crate) struct Chooser<'a> {
    pub(crate) head: &'a Head,
    /// Numbers of all rows or of the first rows.
    pub(crate) values: &'a [Vec<f64>],
    pub(crate) options: &'a ReadOptions,
    pub(crate) roles: Vec<Role>,
    /// Columns of the table and run being read.
    pub(crate) near: Vec<usize>,
    pub(crate) notes: Vec<Note>,
    /// Numerical properties of the columns of a record.
    pub(super) contents: Vec<Content>,
    /// Whether the choice depended on the numbers, so that reading more rows could improve it.
    pub(super) by_content: bool,
    /// Fractions of a second to be added to whole seconds in the time column.
    pub(super) fraction: Option<Fraction>,
}

impl<'a> Chooser<'a> {
    /// Chooser for columns over time.
    pub(super) fn of_record(head: &'a Head, values: &'a [Vec<f64>], options: &'a ReadOptions) -> Self {
        let contents: Vec<Content> = values.iter().map(|column| Content::of(column)).collect();
        let mut roles = role::in_records(&head.names);
        for (role, (name, content)) in roles.iter_mut().zip(head.names.iter().zip(&contents)) {
            // A date column that increases from row to row also contains the time of day.
            if *role == Role::Never && role::names_date(name) && content.is_monotone() {
                *role = Role::Time;
            }
        }
        Self { contents, ..Self::new(head, values, options, roles) }
    }

    /// Chooser for columns over frequency or over drive levels.
    pub(crate) fn of_curve(head: &'a Head, values: &'a [Vec<f64>], options: &'a ReadOptions) -> Self {
        Self::new(head, values, options, head.names.iter().map(Role::in_curve).collect())
    }

    fn new(head: &'a Head, values: &'a [Vec<f64>], options: &'a ReadOptions, roles: Vec<Role>) -> Self {
        let (near, notes) = (head.all(), head.notes.clone());
        Self {
            head,
            values,
            options,
            roles,
            near,
            notes,
            contents: Vec::new(),
            by_content: false,
            fraction: None,
        }
    }

    pub(crate) fn label(&self, index: usize) -> String {
        self.head.label(index)
    }

    /// All columns, as listed in a message.
    pub(crate) fn list(&self) -> String {
        self.head.list(&self.head.all())
    }

    /// The column selected by an option.
    pub(crate) fn asked(
        &self,
        option: &'static str,
        wanted: &Option<String>,
    ) -> Result<Option<usize>, ReadProblem> {
        wanted.as_ref().map(|wanted| self.head.find(option, wanted, &self.near)).transpose()
    }

    /// Checks that no two of these options name the same column.
    pub(crate) fn check_distinct(
        &self,
        options: &[(&'static str, &Option<String>)],
    ) -> Result<(), ReadProblem> {
        let mut named: Vec<(&'static str, usize)> = Vec::new();
        for &(option, wanted) in options {
            let Some((value, index)) = wanted.clone().zip(self.asked(option, wanted)?) else { continue };
            if let Some((other, _)) = named.iter().find(|(_, taken)| *taken == index) {
                let problem = OptionProblem::SameColumn { column: self.label(index), other };
                return Err(ReadProblem::Option { option, value, problem });
            }
            named.push((option, index));
        }
        Ok(())
    }

    pub(crate) fn choose_column(&self, index: usize, why: &str) -> ChosenColumn {
        let unit = self.head.names[index].unit.clone();
        ChosenColumn { index, unit, why: format!("{}: {why}", self.label(index)) }
    }

    pub(crate) fn finite(&self, index: usize) -> impl Iterator<Item = f64> + '_ {
        self.values[index].iter().copied().filter(|v| v.is_finite())
    }

    pub(crate) fn filled(&self, index: usize) -> bool {
        self.finite(index).next().is_some()
    }

    pub(crate) fn varies(&self, index: usize) -> bool {
        let mut values = self.finite(index);
        values.next().is_some_and(|first| values.any(|v| v != first))
    }

    /// The first column with a role that holds numbers; varying columns are preferred to constant ones.
    pub(crate) fn of_role(&self, wanted: Role, without: &[usize]) -> Option<usize> {
        let fits = |i: &&usize| self.roles[**i] == wanted && !without.contains(i) && self.filled(**i);
        let varying = self.near.iter().filter(fits).find(|i| self.varies(**i));
        varying.or_else(|| self.near.iter().find(fits)).copied()
    }

    /// Problem that explains a missing column: the table holds a curve over frequency or amplitudes over drive levels.
    pub(super) fn not_over_time(&self, missing: &'static str) -> Option<ReadProblem> {
        let of = |wanted: Role| {
            let fits = |i: &usize| Role::in_curve(&self.head.names[*i]) == wanted && self.varies(*i);
            self.near.iter().copied().find(fits)
        };
        let is = |index: usize, holds, what, analysis| {
            Some(ReadProblem::NotOverTime { missing, column: self.label(index), holds, what, analysis })
        };
        if let Some(index) = of(Role::Frequency) {
            return is(index, "frequencies", "a resonance curve", Analysis::Resonance);
        }
        let drive = of(Role::Drive).filter(|_| of(Role::Amplitude).is_some())?;
        is(drive, "levels of a drive", "a table of amplitudes over drive levels", Analysis::Levels)
    }

    /// Notes the columns that hold numbers but are not read.
    pub(crate) fn note_unread(&mut self, taken: &[usize]) {
        let unread: Vec<usize> = (0..self.values.len())
            .filter(|i| !taken.contains(i) && self.filled(*i))
            .filter(|i| !self.head.names[*i].header.is_empty() || self.near.contains(i))
            .collect();
        if !unread.is_empty() {
            self.notes.push(Note::new(format!("not used: {}", self.head.list(&unread))));
        }
    }
}

/// The requested number of a table or run (default: the first) out of `found`.
pub(super) fn numbered(
    option: &'static str,
    wanted: Option<usize>,
    found: usize,
) -> Result<usize, ReadProblem> {
    match wanted.unwrap_or(1) {
        number if (1..=found).contains(&number) => Ok(number),
        number => Err(ReadProblem::Option {
            option,
            value: number.to_string(),
            problem: OptionProblem::NumberTooLarge(found),
        }),
    }
}
