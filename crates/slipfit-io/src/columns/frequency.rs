//! Choice of the frequency column of a curve.

use std::f64::consts::{E, TAU};

use super::{
    chooser::{Chooser, ChosenColumn},
    multiple::{multiple_of_hertz, number_of_hertz},
    name::{self, Name},
    role::Role,
    units::{self, Measures},
};
use crate::{
    error::{Needed, OptionProblem, ReadProblem},
    report::Note,
};

/// How the frequency is written.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Frequency {
    /// Column and factor to Hz.
    Plain(ChosenColumn, f64),
    /// Column of logarithms, their base, and the factor of the frequencies to Hz.
    Logarithm(ChosenColumn, f64, f64),
    /// Column and factor of its unit to seconds.
    Period(ChosenColumn, f64),
    /// Column of shifts with its factor, and the centre: in Hz, or in a column with its own factor.
    Shift(ChosenColumn, f64, Centre),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Centre {
    Hz(f64),
    Column(ChosenColumn, f64),
}

impl Frequency {
    /// The columns read, with their roles; the first is the swept one.
    pub(super) fn columns(&self) -> Vec<(&'static str, &ChosenColumn)> {
        match self {
            Self::Plain(p, _) | Self::Logarithm(p, ..) => vec![("frequency", p)],
            Self::Period(p, _) => vec![("period", p)],
            Self::Shift(p, _, Centre::Hz(_)) => vec![("shift", p)],
            Self::Shift(p, _, Centre::Column(c, _)) => vec![("shift", p), ("centre", c)],
        }
    }

    /// The column of the frequencies, periods or shifts.
    pub(super) fn swept(&self) -> &ChosenColumn {
        let (Self::Plain(p, _) | Self::Logarithm(p, ..) | Self::Period(p, _) | Self::Shift(p, ..)) = self;
        p
    }
}

/// Base and factor to Hz of a column of logarithms, from its header or the given unit: `log10 f`, `lg(f/kHz)`,
/// `ln omega`, `log10 kHz`.
fn logarithm(header: &str) -> Option<(f64, f64)> {
    let lower = header.trim().to_lowercase();
    let (rest, base) = [("log10", 10.0), ("log_10", 10.0), ("log", 10.0), ("lg", 10.0), ("ln", E)]
        .into_iter()
        .find_map(|(word, base)| Some((lower.strip_prefix(word)?, base)))?;
    let words = name::words(rest);
    let of = words.first()?.as_str();
    let angular = matches!(of, "omega" | "\u{3c9}" | "w");
    // `logf` is accepted as one word, `logger` is not.
    let apart =
        !rest.starts_with(char::is_alphabetic) || matches!(of, "f" | "freq" | "frequency" | "frequenz");
    let frequency = matches!(of, "f" | "nu" | "\u{3bd}") || of.starts_with("freq") || of.starts_with("frec");
    // Units are case-sensitive: mHz and MHz.
    let marks = |c: char| c.is_whitespace() || "()[]{},;".contains(c);
    let unit = header.trim().split(marks).flat_map(|part| [Some(part), part.split_once('/').map(|p| p.1)]);
    let factor = unit.flatten().find_map(units::hertz);
    let factor = factor.unwrap_or(if angular { 1.0 / TAU } else { 1.0 });
    let unit_alone = units::hertz(rest.trim_matches(|c: char| marks(c))).is_some();
    (apart && (frequency || angular) || unit_alone).then_some((base, factor))
}

/// Whether a column holds frequencies divided by a reference: `f/f0`, `\u{3c9}/\u{3c9}_n`, `normalised frequency`.
fn is_ratio(name: &Name) -> bool {
    let letters = ["f", "\u{3bd}", "nu", "\u{3c9}", "omega", "w", "freq", "frequency", "frequenz"];
    let over = || {
        let (above, below) = name.header.split_once('/')?;
        let first = |part: &str| name::words(part).into_iter().find(|word| letters.contains(&word.as_str()));
        let begins = name::words(below).into_iter().next()?;
        let known = units::hertz(below).is_some() || units::measures(below).is_some();
        Some(!known && letters.contains(&begins.as_str()) && first(above).is_some())
    };
    let words = name::words(&name.bare);
    let has = |parts: &[&str]| words.iter().any(|word| parts.iter().any(|part| word.starts_with(part)));
    let named = has(&["freq", "frequen", "fr\u{e9}quen", "frecuen"])
        && has(&["norm", "reduc", "relativ", "ratio", "dimensionless"])
        || has(&["frequenzverh", "frequenzquot"]);
    let unit = name.unit.trim();
    over() == Some(true) || named && (unit.is_empty() || matches!(unit, "1" | "-" | "%"))
}

/// Whether a name denotes an angular frequency.
fn is_angular(bare: &str) -> bool {
    let bare = bare.to_lowercase();
    let words = ["omega", "\u{3c9}", "kreisfreq", "angular", "pulsa"];
    bare.trim() == "w" || words.iter().any(|word| bare.contains(word))
}

impl Chooser<'_> {
    pub(super) fn frequency(&mut self) -> Result<Frequency, ReadProblem> {
        let given = self.asked("frequency", &self.options.frequency)?;
        let (index, role, why) = match given {
            Some(index) => (index, self.roles[index], "asked for"),
            None => self.find_frequency()?,
        };
        let unit = self.options.frequency_unit.as_deref();
        if let Some(hz) = unit.and_then(number_of_hertz) {
            let chosen = ChosenColumn { unit: "Hz".to_owned(), ..self.choose_column(index, why) };
            let text = format!("{} was multiplied by {hz} Hz", self.label(index));
            self.notes.push(text.into());
            return Ok(Frequency::Plain(chosen, hz));
        }
        if unit.is_none() && is_ratio(&self.head.names[index]) {
            return Err(ReadProblem::FrequencyRatio { column: self.label(index) });
        }
        if let Some((base, factor)) = logarithm(unit.unwrap_or(&self.head.names[index].header)) {
            return Ok(self.logarithms(index, why, base, factor));
        }
        let unit = match unit {
            Some(unit) => unit.trim().to_owned(),
            None => self.head.names[index].unit.clone(),
        };
        let multiple = multiple_of_hertz(&unit).filter(|_| role != Role::Period);
        let seconds = match units::measures(&unit) {
            Some(Measures::Time(seconds)) if units::hertz(&unit).is_none() && multiple.is_none() => {
                Some(seconds.of(1.0))
            }
            _ => None,
        };
        let mut chosen = self.choose_column(index, why);
        if units::is_per_second(&unit) && is_angular(&self.head.names[index].bare) {
            let text = format!(
                "{} is named like an angular frequency: {unit} was taken as rad/s",
                self.label(index)
            );
            self.notes.push(Note::new(text).hint("frequency_unit", "gives another"));
            "rad/s".clone_into(&mut chosen.unit);
            return Ok(Frequency::Plain(chosen, 1.0 / TAU));
        }
        if let Some(seconds) = seconds {
            chosen.unit = unit;
            return Ok(Frequency::Period(chosen, seconds));
        }
        let factor = match units::hertz(&unit).or(multiple) {
            Some(factor) => {
                chosen.unit = unit;
                factor
            }
            None if self.options.frequency_unit.is_some() => {
                let known = "Hz, kHz, MHz, rad/s, rpm, s, ms or us for periods, log10 Hz for logarithms, or for \
                             ratios the frequency that 1 stands for, such as \"80.1 Hz\"";
                let problem = OptionProblem::UnknownUnit(known);
                return Err(ReadProblem::Option { option: "frequency_unit", value: unit, problem });
            }
            None if role == Role::Period => {
                chosen.unit = "s".to_owned();
                self.note_unit(index, "periods", "seconds");
                return Ok(Frequency::Period(chosen, 1.0));
            }
            None => self.guessed_unit(index, &mut chosen),
        };
        // A few negative numbers are errors; shifts from a centre are often negative.
        let (all, below) = self.finite(index).fold((0, 0), |(n, m), v| (n + 1, m + usize::from(v < 0.0)));
        let negative = below * 10 > all;
        let shift = self.options.centre_hz.is_some() || role == Role::Shift || (negative && given.is_none());
        if !shift {
            return Ok(Frequency::Plain(chosen, factor));
        }
        let centre = self.centre(index)?;
        Ok(Frequency::Shift(chosen, factor, centre))
    }

    /// A column of logarithms of frequencies.
    fn logarithms(&mut self, index: usize, why: &str, base: f64, factor: f64) -> Frequency {
        let mut chosen = self.choose_column(index, why);
        let base_name = if base == 10.0 { "10" } else { "e" };
        let times = if factor == 1.0 { String::new() } else { format!(" times {factor:.6}") };
        let text = format!(
            "{} holds logarithms of frequencies: {base_name}^x{times} was taken as Hz",
            self.label(index)
        );
        self.notes.push(Note::new(text).hint("frequency_unit", "gives another, such as Hz or \"log10 kHz\""));
        "Hz".clone_into(&mut chosen.unit);
        Frequency::Logarithm(chosen, base, factor)
    }

    /// Unit of a frequency column that names none.
    fn guessed_unit(&mut self, index: usize, chosen: &mut ChosenColumn) -> f64 {
        let header = self.head.names[index].header.trim().to_lowercase();
        let (unit, factor) = if is_angular(&self.head.names[index].bare) {
            ("rad/s", 1.0 / TAU)
        } else {
            match units::hertz(&header).filter(|_| header.ends_with("hz") || header == "rpm") {
                // A column headed by its unit alone.
                Some(factor) => {
                    chosen.unit = self.head.names[index].header.trim().to_owned();
                    return if chosen.unit == "mHz" { 1e-3 } else { factor };
                }
                None => ("Hz", 1.0),
            }
        };
        self.note_unit(index, "frequencies", unit);
        chosen.unit = unit.to_owned();
        factor
    }

    fn note_unit(&mut self, index: usize, what: &str, taken: &str) {
        let text = format!("{} names no unit: its {what} were taken as {taken}", self.label(index));
        self.notes.push(Note::new(text).hint("frequency_unit", "gives another"));
    }

    fn find_frequency(&mut self) -> Result<(usize, Role, &'static str), ReadProblem> {
        for (role, why) in [
            (Role::Frequency, "named like a frequency"),
            (Role::Shift, "named like a shift of the frequency"),
            (Role::Period, "named like a period"),
        ] {
            // If a frequency and its ratio to another one are both present, the frequency is read.
            let ratios: Vec<usize> =
                self.near.iter().copied().filter(|&i| is_ratio(&self.head.names[i])).collect();
            let found = self.of_role(role, &ratios).or_else(|| self.of_role(role, &[]));
            let Some(index) = found else { continue };
            // If the frequency is constant and shifts from it are present, the shifts are the sweep.
            let constant = || !self.varies(index) && self.of_role(Role::Shift, &[]).is_some();
            if role == Role::Frequency && constant() {
                continue;
            }
            if let Some(time) = self.time_record(Some(index)) {
                return Err(self.is_record(time));
            }
            return Ok((index, role, why));
        }
        if let Some(time) = self.time_record(None) {
            return Err(self.is_record(time));
        }
        // Without a name: the first column that changes in one direction and is never negative.
        let unnamed = |i: &usize| self.roles[*i] == Role::Unknown && self.filled(*i);
        let usable = |i: &usize| {
            let values: Vec<f64> = self.finite(*i).collect();
            let steps = || values.windows(2).filter(|w| w[0] != w[1]);
            let up = steps().filter(|w| w[1] > w[0]).count();
            let all = steps().count();
            let one_way = up.max(all - up) * 50 >= all * 49;
            all > 0 && one_way && values.iter().all(|v| *v >= 0.0)
        };
        let named = self.head.names.iter().any(|n| !n.header.is_empty());
        match self.near.iter().copied().filter(|i| unnamed(i)).find(|i| usable(i)) {
            Some(index) if !named || self.near.len() > 1 => {
                Ok((index, Role::Unknown, "its numbers are monotonic, as frequencies are"))
            }
            _ => {
                let varies = |role| self.of_role(role, &[]).is_some_and(|index| self.varies(index));
                let levels = varies(Role::Drive) && varies(Role::Amplitude);
                let needed = if levels { Needed::FrequencyOfLevels } else { Needed::Frequency };
                Err(ReadProblem::NoColumn { needed, columns: self.list() })
            }
        }
    }

    fn is_record(&self, time: usize) -> ReadProblem {
        ReadProblem::TimeRecord { column: self.label(time), instead_of: "a resonance curve" }
    }

    /// The time column, if the table is a record and not a curve.
    fn time_record(&self, frequency: Option<usize>) -> Option<usize> {
        let time = self.of_role(Role::Time, &[])?;
        let curve = |i: &usize| {
            matches!(self.roles[*i], Role::Amplitude | Role::Real | Role::Conductance | Role::Phase)
        };
        let has_curve = self.near.iter().any(curve) && frequency.is_some();
        (!has_curve).then_some(time)
    }

    fn centre(&self, shift: usize) -> Result<Centre, ReadProblem> {
        if let Some(hz) = self.options.centre_hz {
            return Ok(Centre::Hz(hz));
        }
        if let Some(index) = self.of_role(Role::Centre, &[shift]) {
            let unit = &self.head.names[index].unit;
            let factor = units::hertz(unit).unwrap_or(1.0);
            return Ok(Centre::Column(self.choose_column(index, "named like a centre frequency"), factor));
        }
        let named = self.head.named_values.iter().find_map(|(name, value)| {
            let parsed = Name::parse(name);
            let number: f64 = value.split_whitespace().next()?.parse().ok()?;
            let factor = units::hertz(&parsed.unit).unwrap_or(1.0);
            (Role::in_curve(&parsed) == Role::Centre && number > 0.0).then_some(number * factor)
        });
        let missing = || ReadProblem::NoCentre { column: self.label(shift) };
        named.map(Centre::Hz).ok_or_else(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_frequencies_are_told_from_frequencies() {
        for header in
            ["f/f0", "f / f_res", "\u{3c9}/\u{3c9}0", "\u{3a9}/\u{3c9}_n", "omega/omega0", "frequency/f0"]
        {
            assert!(is_ratio(&Name::parse(header)), "{header}");
        }
        for header in
            ["normalised frequency", "frequency ratio (1)", "Frequenzverh\u{e4}ltnis", "relative frequency"]
        {
            assert!(is_ratio(&Name::parse(header)), "{header}");
        }
        for header in
            ["f/Hz", "f / kHz", "\u{3c9}/s^-1", "f (Hz)", "relative frequency (Hz)", "log10(f/Hz)", "A/f"]
        {
            assert!(!is_ratio(&Name::parse(header)), "{header}");
        }
        assert_eq!(number_of_hertz("80.1 Hz"), Some(80.1));
        assert_eq!(number_of_hertz("2kHz"), Some(2e3));
        assert_eq!([number_of_hertz("Hz"), number_of_hertz("60 V"), number_of_hertz("log10 Hz")], [None; 3]);
    }

    #[test]
    fn logarithms_of_frequencies_are_told_by_their_header() {
        for (header, wanted) in [
            ("log10 f", Some((10.0, 1.0))),
            ("log10(f/Hz)", Some((10.0, 1.0))),
            ("log10(f)", Some((10.0, 1.0))),
            ("lg(f/kHz)", Some((10.0, 1e3))),
            ("log f [MHz]", Some((10.0, 1e6))),
            ("log10 frequency (mHz)", Some((10.0, 1e-3))),
            ("logf", Some((10.0, 1.0))),
            ("ln omega", Some((E, 1.0 / TAU))),
            ("log10 kHz", Some((10.0, 1e3))),
            ("log10(Hz)", Some((10.0, 1.0))),
            ("log10 A", None),
            ("logger frequency", None),
            ("f (Hz)", None),
            ("log", None),
        ] {
            assert_eq!(logarithm(header), wanted, "{header}");
        }
    }
}
