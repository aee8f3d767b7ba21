//! Which columns make the curve, and why.

use slipfit::SignalKind;

use super::{
    SweepOptions, SweepProblem,
    role::{self, Role},
};
use crate::{
    ReadProblem, Table,
    columns::{asked, info_of, label, names::Name, units},
    report::{ColumnInfo, ColumnTaken},
};

/// A column of the table that will be read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Picked {
    pub(super) index: usize,
    pub(super) unit: String,
    pub(super) why: String,
}

/// How the frequency is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Frequency {
    /// Times a factor to Hz.
    Plain(Picked, f64),
    /// The factor for its unit to seconds.
    Period(Picked, f64),
    /// Times a factor, from a centre in Hz or from one that stands in a column, with its factor.
    Shift(Picked, f64, Centre),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Centre {
    Hz(f64),
    Column(Picked, f64),
}

/// How an amplitude is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    Linear,
    /// `10^(x/20)`.
    Decibel,
    /// The square of an amplitude.
    Power,
}

/// What the response is made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Response {
    Amplitude {
        amplitude: Picked,
        scale: Scale,
        phase: Option<(Picked, f64)>,
    },
    Complex(Picked, Picked),
    /// Conductance, and susceptance if there is one.
    Admittance(Picked, Option<Picked>),
    /// Series resistance and reactance.
    Impedance(Picked, Option<Picked>),
}

/// Everything to be read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Choice {
    pub(super) frequency: Frequency,
    pub(super) response: Response,
    pub(super) drive: Option<Picked>,
    pub(super) std_error: Option<Picked>,
    pub(super) kind: SignalKind,
    pub(super) unit: String,
    pub(super) runs: usize,
    pub(super) run: usize,
    /// Whether a name says that this is a curve.
    pub(super) named: bool,
    pub(super) notes: Vec<String>,
}

/// A table on its way to a choice.
pub(super) struct Chooser<'a> {
    table: &'a Table,
    options: &'a SweepOptions,
    names: Vec<Name>,
    roles: Vec<Role>,
    notes: Vec<String>,
    /// Columns of the run read.
    near: Vec<usize>,
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

    fn filled(&self, index: usize) -> bool {
        self.table.columns[index].values.iter().any(|v| v.is_finite())
    }

    fn finite(&self, index: usize) -> impl Iterator<Item = f64> + '_ {
        self.table.columns[index].values.iter().copied().filter(|v| v.is_finite())
    }

    fn label(&self, index: usize) -> String {
        label(&info_of(&self.names, index))
    }

    fn list(&self) -> String {
        asked::list(&self.names, &(0..self.names.len()).collect::<Vec<_>>())
    }

    fn asked(&self, flag: &'static str, wanted: &Option<String>) -> Result<Option<usize>, ReadProblem> {
        wanted.as_ref().map(|w| asked::find(&self.names, flag, w, &self.near)).transpose()
    }

    fn picked(&self, index: usize, why: &str) -> Picked {
        let unit = self.names[index].unit.clone();
        Picked { index, unit, why: format!("{}: {why}", self.label(index)) }
    }

    /// The first column of a role that holds numbers; those that vary before those that do not.
    fn of_role(&self, wanted: Role, without: &[usize]) -> Option<usize> {
        let fits = |i: &&usize| self.roles[**i] == wanted && !without.contains(i) && self.filled(**i);
        let varies = |i: &&usize| {
            let mut values = self.finite(**i);
            values.next().is_some_and(|first| values.any(|v| v != first))
        };
        self.near.iter().filter(fits).find(varies).or_else(|| self.near.iter().find(fits)).copied()
    }

    fn frequency(&mut self) -> Result<Frequency, ReadProblem> {
        let given = self.asked("--frequency", &self.options.frequency)?;
        let (index, role, why) = match given {
            Some(index) => (index, self.roles[index], "asked for"),
            None => self.find_frequency()?,
        };
        let unit = match self.options.frequency_unit.as_deref() {
            Some(unit) => unit.trim().to_owned(),
            None => self.names[index].unit.clone(),
        };
        let seconds = match units::measures(&unit) {
            Some(units::Measures::Time(seconds)) if role::to_hz(&unit).is_none() => Some(seconds.of(1.0)),
            _ => None,
        };
        let mut picked = self.picked(index, why);
        if let Some(seconds) = seconds {
            picked.unit = unit;
            return Ok(Frequency::Period(picked, seconds));
        }
        let factor = match role::to_hz(&unit) {
            Some(factor) => {
                picked.unit = unit;
                factor
            }
            None if self.options.frequency_unit.is_some() => {
                return Err(ReadProblem::Sweep(SweepProblem::UnknownUnit {
                    flag: "--frequency-unit",
                    unit,
                    known: "--frequency-unit takes Hz, kHz, MHz, rad/s, rpm, or s, ms and us of a period",
                }));
            }
            None if role == Role::Period => {
                picked.unit = "s".to_owned();
                self.notes.push(format!(
                    "{} names no unit: its periods were taken as seconds; --frequency-unit says otherwise",
                    self.label(index)
                ));
                return Ok(Frequency::Period(picked, 1.0));
            }
            None => self.guessed_unit(index, &mut picked),
        };
        // A slip of the pen is below zero here and there, shifts from a centre are as a rule.
        let (all, below) = self.finite(index).fold((0, 0), |(n, m), v| (n + 1, m + usize::from(v < 0.0)));
        let negative = below * 10 > all;
        let shift = self.options.centre_hz.is_some() || role == Role::Shift || (negative && given.is_none());
        if !shift {
            return Ok(Frequency::Plain(picked, factor));
        }
        let centre = self.centre(index)?;
        Ok(Frequency::Shift(picked, factor, centre))
    }

    /// The unit of a frequency that names none.
    fn guessed_unit(&mut self, index: usize, picked: &mut Picked) -> f64 {
        let bare = self.names[index].bare.to_lowercase();
        let header = self.names[index].header.trim().to_lowercase();
        let angular = ["omega", "ω", "kreisfreq", "angular", "pulsa"].iter().any(|w| bare.contains(w));
        let (unit, factor) = if angular || bare == "w" {
            ("rad/s", 1.0 / std::f64::consts::TAU)
        } else {
            match role::to_hz(&header).filter(|_| header.ends_with("hz") || header == "rpm") {
                // A column headed by its unit alone.
                Some(factor) => {
                    picked.unit = self.names[index].header.trim().to_owned();
                    return if picked.unit == "mHz" { 1e-3 } else { factor };
                }
                None => ("Hz", 1.0),
            }
        };
        self.notes.push(format!(
            "{} names no unit: its frequencies were taken as {unit}; --frequency-unit says otherwise",
            self.label(index)
        ));
        picked.unit = unit.to_owned();
        factor
    }

    fn find_frequency(&mut self) -> Result<(usize, Role, &'static str), ReadProblem> {
        for (role, why) in [
            (Role::Frequency, "named like a frequency"),
            (Role::Shift, "named like a shift of the frequency"),
            (Role::Period, "named like a period"),
        ] {
            let found = self.of_role(role, &[]);
            // Of a frequency that never changes and shifts from it, the shifts are the sweep.
            let constant = |i: usize| {
                let mut values = self.finite(i);
                values.next().is_some_and(|first| values.all(|v| v == first))
            };
            let Some(index) = found else { continue };
            if role == Role::Frequency && constant(index) && self.of_role(Role::Shift, &[]).is_some() {
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
        // Without a name: the first column that never repeats itself much and is never negative.
        let unnamed = |i: &usize| self.roles[*i] == Role::Unknown && self.filled(*i);
        let usable = |i: &usize| {
            let values: Vec<f64> = self.finite(*i).collect();
            let steps = || values.windows(2).filter(|w| w[0] != w[1]);
            let up = steps().filter(|w| w[1] > w[0]).count();
            let all = steps().count();
            let one_way = up.max(all - up) * 50 >= all * 49;
            all > 0 && one_way && values.iter().all(|v| *v >= 0.0)
        };
        let named = self.names.iter().any(|n| !n.header.is_empty());
        match self.near.iter().copied().filter(|i| unnamed(i)).find(|i| usable(i)) {
            Some(index) if !named || self.near.len() > 1 => {
                Ok((index, Role::Unknown, "its numbers go one way, as frequencies do"))
            }
            _ => Err(ReadProblem::Sweep(SweepProblem::NoFrequency { columns: self.list() })),
        }
    }

    fn is_record(&self, time: usize) -> ReadProblem {
        ReadProblem::Sweep(SweepProblem::TimeRecord { column: self.label(time) })
    }

    /// A column of times beside samples that swing about: no curve.
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
            let unit = &self.names[index].unit;
            let factor = role::to_hz(unit).unwrap_or(1.0);
            return Ok(Centre::Column(self.picked(index, "named like a centre frequency"), factor));
        }
        let named = self.table.named_values.iter().find_map(|(name, value)| {
            let parsed = Name::parse(name);
            let number: f64 = value.split_whitespace().next()?.parse().ok()?;
            let factor = role::to_hz(&parsed.unit).unwrap_or(1.0);
            (role::role(&parsed) == Role::Centre && number > 0.0).then_some(number * factor)
        });
        let missing = || ReadProblem::Sweep(SweepProblem::NoCentre { column: self.label(shift) });
        named.map(Centre::Hz).ok_or_else(missing)
    }

    fn response(&mut self, taken: &[usize]) -> Result<Response, ReadProblem> {
        let o = self.options;
        let (real, imaginary) = (self.asked("--real", &o.real)?, self.asked("--imaginary", &o.imaginary)?);
        match (real, imaginary) {
            (Some(re), Some(im)) => {
                return Ok(Response::Complex(self.picked(re, "asked for"), self.picked(im, "asked for")));
            }
            (Some(one), None) | (None, Some(one)) => {
                let missing = if real.is_some() { "imaginary" } else { "real" };
                let other = if real.is_some() { Role::Imaginary } else { Role::Real };
                let Some(found) = self.of_role(other, taken) else {
                    let (given, columns) = (self.label(one), self.list());
                    return Err(ReadProblem::Sweep(SweepProblem::HalfComplex { given, missing, columns }));
                };
                let (one, found) = (self.picked(one, "asked for"), self.picked(found, "named so"));
                return Ok(if real.is_some() {
                    Response::Complex(one, found)
                } else {
                    Response::Complex(found, one)
                });
            }
            (None, None) => {}
        }
        if let Some(amplitude) = self.asked("--amplitude", &o.amplitude)? {
            let alone = o.phase.is_none() && o.unit.is_none();
            return match self.roles[amplitude] {
                Role::Conductance if alone => Ok(self.admittance(amplitude, "asked for", taken)),
                Role::Resistance if alone => Ok(self.impedance(amplitude, "asked for", taken)),
                _ => self.amplitude(amplitude, "asked for", taken),
            };
        }
        let role = |role| self.of_role(role, taken);
        if let (Some(re), Some(im)) = (role(Role::Real), role(Role::Imaginary)) {
            let (re, im) =
                (self.picked(re, "named like a real part"), self.picked(im, "named like an imaginary part"));
            return Ok(Response::Complex(re, im));
        }
        if let Some((x, y)) = self.lock_in_pair(taken) {
            let why = "an output of a lock-in";
            return Ok(Response::Complex(self.picked(x, why), self.picked(y, why)));
        }
        if let Some(g) = role(Role::Conductance) {
            return Ok(self.admittance(g, "named like a conductance", taken));
        }
        if let Some(amplitude) = role(Role::Amplitude) {
            return self.amplitude(amplitude, "named like an amplitude", taken);
        }
        if let Some(r) = role(Role::Resistance) {
            return Ok(self.impedance(r, "named like a series resistance", taken));
        }
        let columns = self.list();
        let free = |i: &&usize| {
            !taken.contains(i) && self.filled(**i) && matches!(self.roles[**i], Role::Unknown | Role::Real)
        };
        match self.near.iter().find(free).copied() {
            Some(index) => self.amplitude(index, "the first column left", taken),
            None => Err(ReadProblem::Sweep(SweepProblem::NoResponse { columns })),
        }
    }

    /// A conductance with the susceptance that belongs to it.
    fn admittance(&self, g: usize, why: &str, taken: &[usize]) -> Response {
        let b = self.of_role(Role::Susceptance, taken).map(|b| self.picked(b, "named like a susceptance"));
        Response::Admittance(self.picked(g, why), b)
    }

    /// A series resistance with the reactance that belongs to it.
    fn impedance(&self, r: usize, why: &str, taken: &[usize]) -> Response {
        let x = self.of_role(Role::Reactance, taken).map(|x| self.picked(x, "named like a reactance"));
        Response::Impedance(self.picked(r, why), x)
    }

    /// `X` and `Y` beside `R`, a phase or a frequency, in volts or amperes.
    fn lock_in_pair(&self, taken: &[usize]) -> Option<(usize, usize)> {
        let named = |name: &str| {
            let is =
                |i: &&usize| self.names[**i].bare.trim().eq_ignore_ascii_case(name) && !taken.contains(i);
            self.near.iter().find(is).copied()
        };
        let (x, y) = (named("x")?, named("y")?);
        let signed = |i: usize| self.finite(i).any(|v| v < 0.0);
        (signed(x) || signed(y)).then_some((x, y))
    }

    fn amplitude(&mut self, index: usize, why: &str, taken: &[usize]) -> Result<Response, ReadProblem> {
        let given = self.options.unit.clone();
        let mut amplitude = self.picked(index, why);
        if let Some(unit) = &given {
            unit.trim().clone_into(&mut amplitude.unit);
        }
        let mut scale = Scale::Linear;
        match units::measures(&amplitude.unit) {
            Some(units::Measures::Level(linear)) => {
                self.notes.push(format!(
                    "{}: levels in {} were made linear, 10^(x/20)",
                    self.label(index),
                    amplitude.unit
                ));
                linear.clone_into(&mut amplitude.unit);
                scale = Scale::Decibel;
            }
            _ if squared(&amplitude.unit) => {
                self.notes.push(format!("{}: a power: its square root was taken", self.label(index)));
                amplitude.unit = format!("√{}", amplitude.unit);
                scale = Scale::Power;
            }
            None if amplitude.unit.is_empty()
                && ["db", "dbm"].contains(&self.names[index].bare.to_lowercase().trim()) =>
            {
                self.notes.push(format!("{}: levels in dB were made linear, 10^(x/20)", self.label(index)));
                scale = Scale::Decibel;
            }
            _ => {}
        }
        let without: Vec<usize> = taken.iter().copied().chain([index]).collect();
        let phase = self.phase(&without)?;
        // No amplitude is negative; decibels are, below their reference.
        let negative = self.finite(index).any(|v| v < 0.0);
        let unnamed = self.names[index].header.is_empty() && given.is_none();
        if negative && scale == Scale::Linear && unnamed {
            self.notes.push(format!(
                "{} has no name and negative numbers: it was taken as levels in dB; --unit says otherwise, --real and \
                 --imaginary read a complex response",
                self.label(index)
            ));
            scale = Scale::Decibel;
        }
        Ok(Response::Amplitude { amplitude, scale, phase })
    }

    fn phase(&mut self, without: &[usize]) -> Result<Option<(Picked, f64)>, ReadProblem> {
        let given = self.asked("--phase", &self.options.phase)?;
        // Where headers stand, a phase has one.
        let headed = self.names.iter().any(|n| !n.header.is_empty());
        let unnamed = || {
            let free = |i: &&usize| !without.contains(i) && self.filled(**i);
            self.near.iter().find(free).copied().filter(|_| !headed)
        };
        let (index, why) = match given {
            Some(index) => (index, "asked for"),
            None => match (self.of_role(Role::Phase, without), unnamed()) {
                (Some(index), _) => (index, "named like a phase"),
                (None, Some(index)) if self.looks_like_phase(index) => {
                    (index, "the next column, within half a turn or two")
                }
                _ => return Ok(None),
            },
        };
        let mut picked = self.picked(index, why);
        let unit = self.options.phase_unit.clone().unwrap_or_else(|| picked.unit.clone());
        let factor = match unit.trim().to_lowercase().as_str() {
            "rad" | "radian" | "radians" => 1.0,
            "mrad" => 1e-3,
            "deg" | "degree" | "degrees" | "grad" | "\u{b0}" => 1f64.to_radians(),
            "turn" | "turns" | "rev" => std::f64::consts::TAU,
            _ if self.options.phase_unit.is_some() => {
                return Err(ReadProblem::Sweep(SweepProblem::UnknownUnit {
                    flag: "--phase-unit",
                    unit,
                    known: "--phase-unit takes deg or rad",
                }));
            }
            _ => {
                let largest = self.finite(index).fold(0.0, |m: f64, v| m.max(v.abs()));
                let degrees = largest > 2.2 * std::f64::consts::TAU / 2.0;
                let taken = if degrees { "deg" } else { "rad" };
                picked.unit = taken.to_owned();
                self.notes.push(format!(
                    "{} names no unit: its phases, up to {largest:.4}, were taken as {}; --phase-unit says otherwise",
                    self.label(index),
                    if degrees { "degrees" } else { "radians" }
                ));
                return Ok(Some((picked, if degrees { 1f64.to_radians() } else { 1.0 })));
            }
        };
        picked.unit = unit.trim().to_owned();
        Ok(Some((picked, factor)))
    }

    /// Numbers that stay within two turns and move by a good part of half a one.
    fn looks_like_phase(&self, index: usize) -> bool {
        let (low, high) =
            self.finite(index).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let span = high - low;
        ((20.0..=720.0).contains(&span) && high.max(-low) <= 720.0) || (0.3..=12.6).contains(&span)
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
        let fits = |i: &&usize| self.roles[**i] == Role::StdError && !taken.contains(i) && own(**i);
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

fn squared(unit: &str) -> bool {
    ["w", "mw", "uw", "\u{b5}w", "\u{3bc}w", "nw", "v^2", "v\u{b2}", "m^2", "m\u{b2}", "rad^2", "rad\u{b2}"]
        .contains(&unit.trim().to_lowercase().as_str())
}

impl Frequency {
    pub(super) fn indices(&self) -> Vec<usize> {
        match self {
            Self::Plain(p, _) | Self::Period(p, _) | Self::Shift(p, _, Centre::Hz(_)) => vec![p.index],
            Self::Shift(p, _, Centre::Column(c, _)) => vec![p.index, c.index],
        }
    }
}

impl Response {
    pub(super) fn indices(&self) -> Vec<usize> {
        match self {
            Self::Amplitude { amplitude, phase, .. } => {
                [Some(amplitude.index), phase.as_ref().map(|(p, _)| p.index)].into_iter().flatten().collect()
            }
            Self::Complex(a, b) => vec![a.index, b.index],
            Self::Admittance(a, b) | Self::Impedance(a, b) => {
                [Some(a.index), b.as_ref().map(|b| b.index)].into_iter().flatten().collect()
            }
        }
    }
}

impl Picked {
    /// As the report has it.
    pub(super) fn taken(&self, columns: &[ColumnInfo]) -> ColumnTaken {
        ColumnTaken { column: columns[self.index].clone(), unit: self.unit.clone(), why: self.why.clone() }
    }
}
