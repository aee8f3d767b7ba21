//! Choice of the drive column of a curve.

use slipfit::SignalKind;

use super::{
    chooser::{Chooser, ChosenColumn},
    name,
    response::{PEAK, Response},
    role::Role,
    scale::{self, Scale},
    units::{self, Measures},
};
use crate::{error::ReadProblem, report::Note};

/// The drive at each point of a curve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Drive {
    pub(crate) column: ChosenColumn,
    /// A base motion that is a velocity or an acceleration is divided by omega as often as such a response.
    pub(crate) kind: SignalKind,
    /// Levels are converted to linear values like those of the response.
    pub(crate) scale: Scale,
}

impl Drive {
    fn of(column: ChosenColumn) -> Self {
        let scale = scale::written(&column.unit, None).scale;
        Self { column, kind: SignalKind::Displacement, scale }
    }
}

impl Chooser<'_> {
    /// Whether the option states that there is no drive; a column may be named `none`.
    pub(super) fn is_without_drive(&self) -> bool {
        let none = |wanted: &str| wanted.trim().eq_ignore_ascii_case("none");
        self.options.drive.as_deref().is_some_and(none)
            && !self.head.names.iter().any(|name| none(&name.bare))
    }

    pub(super) fn drive(
        &mut self,
        response: &Response,
        taken: &[usize],
    ) -> Result<Option<Drive>, ReadProblem> {
        if self.is_without_drive() {
            return Ok(None);
        }
        if let Some(index) = self.asked("drive", &self.options.drive)? {
            return Ok(Some(match self.roles[index] {
                Role::Base => self.base(index, "asked for"),
                _ => Drive::of(self.choose_column(index, "asked for")),
            }));
        }
        let response = response.columns()[0].1.clone();
        let Some(index) = self.of_role(Role::Drive, taken) else {
            return Ok(self.base_as_drive(taken).or_else(|| self.other_channel(&response, taken)));
        };
        if units::is_per_force(&response.unit) {
            let (label, unit) = (self.label(index), &response.unit);
            let text = format!(
                "{label} is named like a drive, but a response in {unit} has already been divided by its \
                 drive: it was not used"
            );
            self.notes.push(Note::new(text).hint("drive", "divides it out"));
            return Ok(None);
        }
        if !self.is_positive(index) {
            self.note_not_positive(index, "a drive", "divided out", "drive");
            return Ok(None);
        }
        Ok(Some(Drive::of(self.choose_column(index, "named like a drive; divided out"))))
    }

    fn is_positive(&self, index: usize) -> bool {
        self.finite(index).all(|v| v > 0.0)
    }

    pub(super) fn note_not_positive(&mut self, index: usize, like: &str, used: &str, option: &'static str) {
        let label = self.label(index);
        let text =
            format!("{label} is named like {like} but is not above zero throughout: it was not {used}");
        self.notes.push(Note::new(text).hint(option, "insists"));
    }

    /// The motion of the base, used if nothing else is the drive.
    fn base_as_drive(&mut self, taken: &[usize]) -> Option<Drive> {
        let index = self.of_role(Role::Base, taken)?;
        if !self.is_positive(index) {
            self.note_not_positive(index, "the motion of a base", "divided out", "drive");
            return None;
        }
        let drive = self.base(index, "named like the motion of the base; divided out");
        let label = self.label(index);
        let made = match drive.kind {
            SignalKind::Velocity => ", converted to a displacement like the response,",
            SignalKind::Acceleration => ", divided by omega^2 to a displacement,",
            _ => "",
        };
        let text = format!(
            "{label} was taken as the motion of the base{made} that drives the mass through its spring; \
             damping and friction are assumed not to act against the base: where they do, give the motion \
             of the mass relative to the base"
        );
        self.notes.push(Note::new(text).hint("drive", "names another drive, or none"));
        Some(drive)
    }

    fn base(&self, index: usize, why: &str) -> Drive {
        let column = self.choose_column(index, why);
        let kind = match units::measures(&column.unit) {
            Some(Measures::Signal(kind @ (SignalKind::Velocity | SignalKind::Acceleration))) => kind,
            _ => SignalKind::Displacement,
        };
        Drive { kind, ..Drive::of(column) }
    }

    /// Whether a column is named as one of several channels, which does not identify its content.
    pub(super) fn is_channel(&self, index: usize) -> bool {
        let words = name::words(&self.head.names[index].bare);
        let channel = ["ch", "chan", "channel", "kanal", "canal", "canale", "voie", "cha", "chb"];
        self.roles[index] == Role::Unknown
            && words.first().is_some_and(|word| channel.contains(&word.as_str()))
    }

    /// The only other channel in the unit of the response that has no peak.
    fn other_channel(&mut self, response: &ChosenColumn, taken: &[usize]) -> Option<Drive> {
        if !self.is_channel(response.index) || self.peak_over_ends(response.index) < PEAK {
            return None;
        }
        let free = |i: &usize| !taken.contains(i) && self.is_channel(*i) && self.filled(*i);
        let others: Vec<usize> = self.near.iter().copied().filter(free).collect();
        let &[other] = &others[..] else { return None };
        let unit = |i: usize| &self.head.names[i].unit;
        let steady = self.is_positive(other) && self.peak_over_ends(other) < PEAK;
        if !steady || unit(other) != unit(response.index) {
            return None;
        }
        let text = format!(
            "{} has a peak and {} has none: the first was taken as the response, the other as the drive and divided out",
            self.label(response.index),
            self.label(other)
        );
        let note = Note::new(text).hint("amplitude", "names the response");
        self.notes.push(note.hint("drive", "names the drive, or none"));
        Some(Drive::of(self.choose_column(other, "the channel without a peak; divided out")))
    }

    /// Greatest mean over a tenth of the rows, relative to that over the tenths at the ends; 0 if any value is not
    /// positive. Means are used so that a single outlier is not a peak.
    pub(super) fn peak_over_ends(&self, index: usize) -> f64 {
        let values: Vec<f64> = self.finite(index).collect();
        if values.is_empty() || values.iter().any(|v| *v <= 0.0) {
            return 0.0;
        }
        let tenth = (values.len() / 10).max(1);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let highest = values.chunks(tenth).map(mean).fold(f64::NEG_INFINITY, f64::max);
        highest / mean(&values[..tenth]).max(mean(&values[values.len() - tenth..]))
    }
}
