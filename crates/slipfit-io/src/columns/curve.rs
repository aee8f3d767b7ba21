//! Choice of the columns of a curve over frequency, with reasons.

use slipfit::{SignalKind, answer::hint::Hint};

use super::{
    chooser::{Chooser, ChosenColumn, numbered},
    drive::Drive,
    frequency::Frequency,
    head::Head,
    name,
    response::Response,
    role::Role,
    scattering::scattering,
    units::{self, Measures},
};
use crate::{
    error::{OptionProblem, ReadProblem},
    options::ReadOptions,
    report::Note,
};

/// Columns and settings with which a curve is read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Choice {
    pub(crate) frequency: Frequency,
    pub(crate) response: Response,
    pub(crate) drive: Option<Drive>,
    pub(crate) std_error: Option<ChosenColumn>,
    pub(crate) kind: SignalKind,
    pub(crate) unit: String,
    pub(crate) runs: usize,
    pub(crate) run: usize,
    /// Whether a name identifies this as a curve.
    pub(crate) named: bool,
    pub(crate) notes: Vec<Note>,
}

impl Choice {
    /// The columns read, with their roles.
    pub(crate) fn columns(&self) -> Vec<(&'static str, &ChosenColumn)> {
        let mut columns = self.frequency.columns();
        columns.extend(self.response.columns());
        columns.extend(self.drive.as_ref().map(|d| ("drive", &d.column)));
        columns.extend(self.std_error.as_ref().map(|e| ("std_error", e)));
        columns
    }
}

/// Chooses the columns of a curve.
pub(crate) fn choose(head: &Head, values: &[Vec<f64>], options: &ReadOptions) -> Result<Choice, ReadProblem> {
    Chooser::of_curve(head, values, options).curve()
}

impl Chooser<'_> {
    fn curve(mut self) -> Result<Choice, ReadProblem> {
        let (runs, run) = self.take_run()?;
        let o = self.options;
        if let Some(kind) = o.kind.filter(|kind| !kind.oscillates()) {
            let (value, problem) = (kind.name().to_owned(), OptionProblem::NotOfResponse);
            return Err(ReadProblem::Option { option: "kind", value, problem });
        }
        self.check_distinct(&[
            ("frequency", &o.frequency),
            ("amplitude", &o.amplitude),
            ("real", &o.real),
            ("imaginary", &o.imaginary),
            ("phase", &o.phase),
            ("drive", if self.is_without_drive() { &None } else { &o.drive }),
            ("std_error", &o.std_error),
        ])?;
        let frequency = self.frequency()?;
        let indices = |columns: Vec<(&str, &ChosenColumn)>| columns.into_iter().map(|c| c.1.index).collect();
        let mut taken: Vec<usize> = indices(frequency.columns());
        let response = self.response(&taken)?;
        taken.extend::<Vec<usize>>(indices(response.columns()));
        let drive = self.drive(&response, &taken)?;
        taken.extend(drive.as_ref().map(|d| d.column.index));
        let std_error = self.std_error(&response, &taken)?;
        taken.extend(std_error.as_ref().map(|e| e.index));
        let (kind, unit) = self.kind(&response);
        self.note_reflection(&response);
        self.note_unread(&taken);
        let named = self.roles[taken[0]] != Role::Unknown && self.of_role(Role::Time, &[]).is_none();
        let notes = self.notes;
        Ok(Choice { frequency, response, drive, std_error, kind, unit, runs, run, named, notes })
    }

    /// Selects a run; each curve in groups of columns begins with a frequency.
    fn take_run(&mut self) -> Result<(usize, usize), ReadProblem> {
        let leads = |role: Role| matches!(role, Role::Frequency | Role::Period | Role::Shift);
        let names = &self.head.names;
        let starts: Vec<usize> =
            (0..names.len()).filter(|&i| leads(self.roles[i]) && self.filled(i)).collect();
        let stem = |i: usize| names[i].stem();
        let alike = starts.len() > 1 && starts.iter().all(|&i| stem(i) == stem(starts[0]));
        let apart = starts.windows(2).all(|w| w[1] > w[0] + 1);
        let runs = if alike && apart { starts.len() } else { 1 };
        let run = numbered("run", self.options.run, runs)?;
        if runs > 1 {
            let from = if run == 1 { 0 } else { starts[run - 1] };
            self.near = (from..starts.get(run).copied().unwrap_or(names.len())).collect();
            let text = format!("the file has {runs} curves in groups of columns: number {run} was read");
            self.notes.push(Note::new(text).hint("run", "reads another"));
        }
        Ok((runs, run))
    }

    fn std_error(
        &mut self,
        response: &Response,
        taken: &[usize],
    ) -> Result<Option<ChosenColumn>, ReadProblem> {
        if let Some(index) = self.asked("std_error", &self.options.std_error)? {
            return Ok(Some(self.choose_column(index, "asked for")));
        }
        let Response::Amplitude(amplitude, scale, _) = response else { return Ok(None) };
        if scale.factor().is_none() {
            return Ok(None);
        }
        let names = &self.head.names;
        let theirs = name::words(&names[amplitude.index].bare);
        // Errors of another quantity contain its name or follow its column.
        let own = |i: usize| {
            let words = name::words(&names[i].bare);
            let of_other = ["f", "freq", "frequency", "phase", "phi", "drive", "t"];
            !words.iter().any(|w| of_other.contains(&w.as_str()))
                && (words.iter().any(|w| theirs.contains(w)) || i == amplitude.index + 1)
        };
        let fits = |i: &&usize| {
            let error = self.roles[**i] == Role::StdError && own(**i);
            (error || self.is_differential(**i, amplitude.index)) && !taken.contains(i)
        };
        let Some(index) = self.near.iter().find(fits).copied() else { return Ok(None) };
        if self.finite(index).any(|v| v <= 0.0) || !self.filled(index) {
            self.note_not_positive(index, "a standard error", "used", "std_error");
            return Ok(None);
        }
        Ok(Some(self.choose_column(index, "named like the standard error of the amplitude")))
    }

    /// Whether a column is named as the error of another, like `dA`, `ΔA` or `u_A` of `A`, and has its unit or none.
    fn is_differential(&self, index: usize, of: usize) -> bool {
        let (name, amplitude) = (&self.head.names[index], &self.head.names[of]);
        let bare = name.bare.to_lowercase();
        let rest = ["d", "δ", "∆", "u", "s", "e", "σ"].iter().filter_map(|p| bare.strip_prefix(p));
        let wanted = amplitude.bare.to_lowercase();
        let says = |rest: &str| rest.trim_matches(['_', ' ']) == wanted;
        matches!(self.roles[index], Role::Unknown | Role::Amplitude)
            && !wanted.is_empty()
            && (name.unit.is_empty() || name.unit == amplitude.unit)
            && rest.into_iter().any(says)
    }

    /// Notes that the curve is a reflection coefficient (S11), whose resonance is a dip.
    fn note_reflection(&mut self, response: &Response) {
        let names = &self.head.names;
        let ports = |index: usize| scattering(&names[index].header);
        let Some((_, first)) = response.columns().first().copied() else { return };
        if ports(first.index).is_none_or(|(into, from)| into != from) {
            return;
        }
        let text = format!(
            "{} is a reflection: its resonance is a dip, fitted with a background, and Q and damping are those \
             of the resonator loaded by the instrument",
            self.head.label(first.index)
        );
        let through = (0..names.len()).find(|&i| ports(i).is_some_and(|(into, from)| into != from));
        let note = match through {
            None => Note::new(format!("{text}; a transmission (S21) has no such background")),
            Some(index) => {
                let [one, other] = if matches!(response, Response::Complex(..)) {
                    ["real", "imaginary"]
                } else {
                    ["amplitude", "phase"]
                };
                let named =
                    |option, index: usize, advice: String| Hint::new(option, advice).with((index + 1) as f64);
                let partner = (index + 1..names.len()).find(|&i| ports(i) == ports(index));
                let mut note = Note::new(text);
                note.hints.push(named(
                    one,
                    index,
                    format!("reads the transmission, {}", self.head.label(index)),
                ));
                note.hints.extend(
                    partner.map(|i| named(other, i, format!("its other part, {}", self.head.label(i)))),
                );
                note
            }
        };
        self.notes.push(note);
    }

    /// Kind of the response, and unit of the curve.
    fn kind(&mut self, response: &Response) -> (SignalKind, String) {
        let (unit, index) = match response {
            Response::Amplitude(amplitude, ..) => (amplitude.unit.clone(), amplitude.index),
            Response::Complex(re, _) => {
                (self.options.unit.clone().unwrap_or_else(|| re.unit.clone()), re.index)
            }
            Response::Admittance(..) | Response::Impedance(..) | Response::Modulus { .. } => {
                return (SignalKind::Velocity, "F".to_owned());
            }
        };
        if let Some(kind) = self.options.kind {
            return (kind, unit);
        }
        let name = &self.head.names[index];
        // The kind is named by a word, not by a single letter, which has another meaning here.
        let long = name::words(&name.bare).first().is_some_and(|w| w.chars().count() > 3);
        let bare = name.bare.to_lowercase();
        let named = |words: &[&str]| words.iter().any(|word| bare.contains(word));
        let kind = match (Role::in_record(name), units::measures(&unit)) {
            // A response to a force has a separate name for each kind.
            (_, None) if named(&["mobilit", "movilidad"]) => SignalKind::Velocity,
            (_, None) if named(&["inertanc", "accelerance"]) => SignalKind::Acceleration,
            (Role::Signal { kind: kind @ (SignalKind::Velocity | SignalKind::Acceleration), .. }, _)
                if long =>
            {
                kind
            }
            (_, Some(Measures::Signal(kind))) => kind,
            _ => SignalKind::Displacement,
        };
        (kind, unit)
    }
}
