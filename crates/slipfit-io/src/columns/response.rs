//! Which columns hold the response of a curve.

use std::f64::consts::PI;

use super::{
    chooser::{Chooser, Picked},
    role::Role,
    units,
};
use crate::{
    error::{Needed, OptionProblem, ReadProblem},
    report::Note,
};

/// A peak over the amplitudes at the ends of a curve.
pub(crate) const PEAK: f64 = 1.5;

/// How an amplitude is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    /// `10^(x/20)`.
    Decibel,
    /// The square of an amplitude.
    Power,
}

impl Scale {
    pub(crate) fn linear(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Decibel => units::from_decibels(value),
            Self::Power => value.sqrt(),
        }
    }
}

/// What the response is made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Response {
    /// With the phase and its factor to radians, if there is one.
    Amplitude(Picked, Scale, Option<(Picked, f64)>),
    Complex(Picked, Picked),
    /// Conductance, and susceptance if there is one.
    Admittance(Picked, Option<Picked>),
    /// Series resistance and reactance.
    Impedance(Picked, Option<Picked>),
}

impl Response {
    /// The columns read, with what they are.
    pub(super) fn columns(&self) -> Vec<(&'static str, &Picked)> {
        let (first, second) = match self {
            Self::Amplitude(a, _, phase) => (("amplitude", a), phase.as_ref().map(|p| ("phase", &p.0))),
            Self::Complex(re, im) => (("real", re), Some(("imaginary", im))),
            Self::Admittance(g, b) => (("conductance", g), b.as_ref().map(|b| ("susceptance", b))),
            Self::Impedance(r, x) => (("resistance", r), x.as_ref().map(|x| ("reactance", x))),
        };
        [Some(first), second].into_iter().flatten().collect()
    }
}

impl Chooser<'_> {
    pub(super) fn response(&mut self, taken: &[usize]) -> Result<Response, ReadProblem> {
        let o = self.options;
        let (real, imaginary) = (self.asked("real", &o.real)?, self.asked("imaginary", &o.imaginary)?);
        match (real, imaginary) {
            (Some(re), Some(im)) => {
                return Ok(Response::Complex(self.picked(re, "asked for"), self.picked(im, "asked for")));
            }
            (Some(one), None) | (None, Some(one)) => {
                let missing = if real.is_some() { "imaginary" } else { "real" };
                let other = if real.is_some() { Role::Imaginary } else { Role::Real };
                let Some(found) = self.of_role(other, taken) else {
                    let (given, columns) = (self.label(one), self.list());
                    return Err(ReadProblem::HalfComplex { given, missing, columns });
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
        if let Some(amplitude) = self.asked("amplitude", &o.amplitude)? {
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
        if let Some((x, y)) = self.signed_pair(taken) {
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
            Some(first) => match self.peaked_beside(first, taken) {
                Some(index) => self.amplitude(index, "the first column left that has a peak", taken),
                None => self.amplitude(first, "the first column left", taken),
            },
            None => Err(ReadProblem::NoColumn { needed: Needed::Amplitude, columns }),
        }
    }

    /// A conductance with the susceptance that belongs to it.
    fn admittance(&self, g: usize, why: &str, taken: &[usize]) -> Response {
        let b = self.of_role(Role::Susceptance, taken);
        let b = b.map(|b| self.picked_in(units::siemens, b, "named like a susceptance"));
        Response::Admittance(self.picked_in(units::siemens, g, why), b)
    }

    /// A series resistance with the reactance that belongs to it.
    fn impedance(&self, r: usize, why: &str, taken: &[usize]) -> Response {
        let x = self.of_role(Role::Reactance, taken);
        let x = x.map(|x| self.picked_in(units::ohms, x, "named like a reactance"));
        Response::Impedance(self.picked_in(units::ohms, r, why), x)
    }

    /// A column in the unit asked for, if that is one it may have.
    fn picked_in(&self, known: fn(&str) -> Option<f64>, index: usize, why: &str) -> Picked {
        let mut picked = self.picked(index, why);
        if let Some(unit) = self.options.unit.as_deref().filter(|unit| known(unit).is_some()) {
            unit.trim().clone_into(&mut picked.unit);
        }
        picked
    }

    /// `X` and `Y` beside `R`, a phase or a frequency, in volts or amperes.
    fn signed_pair(&self, taken: &[usize]) -> Option<(usize, usize)> {
        let named = |name: &str| {
            let is = |i: &&usize| {
                self.head.names[**i].bare.trim().eq_ignore_ascii_case(name) && !taken.contains(i)
            };
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
        let label = self.label(index);
        let in_decibels = |unit: &str| format!("{label}: levels in {unit} were made linear, 10^(x/20)");
        if let Some(linear) = units::linear_unit(&amplitude.unit) {
            self.notes.push(in_decibels(&amplitude.unit).into());
            linear.clone_into(&mut amplitude.unit);
            scale = Scale::Decibel;
        } else if units::is_squared(&amplitude.unit) {
            self.notes.push(format!("{label}: a power: its square root was taken").into());
            amplitude.unit = format!("√{}", amplitude.unit);
            scale = Scale::Power;
        } else if amplitude.unit.is_empty()
            && ["db", "dbm"].contains(&self.head.names[index].bare.to_lowercase().trim())
        {
            self.notes.push(in_decibels("dB").into());
            scale = Scale::Decibel;
        }
        let without: Vec<usize> = taken.iter().copied().chain([index]).collect();
        let phase = self.phase(&without)?;
        // No amplitude is negative; decibels are, below their reference.
        let negative = self.finite(index).any(|v| v < 0.0);
        let unnamed = self.head.names[index].header.is_empty() && given.is_none();
        if negative && scale == Scale::Linear && unnamed {
            let text = format!("{label} has no name and negative numbers: it was taken as levels in dB");
            let note = Note::new(text).hint("unit", "says otherwise");
            let part = "reads a part of a complex response";
            self.notes.push(note.hint("real", part).hint("imaginary", part));
            scale = Scale::Decibel;
        }
        Ok(Response::Amplitude(amplitude, scale, phase))
    }

    fn phase(&mut self, without: &[usize]) -> Result<Option<(Picked, f64)>, ReadProblem> {
        let given = self.asked("phase", &self.options.phase)?;
        // Where headers stand, a phase has one.
        let headed = self.head.names.iter().any(|n| !n.header.is_empty());
        let unnamed = || {
            let free = |i: &&usize| !without.contains(i) && self.filled(**i);
            self.near.iter().find(free).copied().filter(|_| !headed)
        };
        let (index, why) = match given {
            Some(index) => (index, "asked for"),
            None => match (self.of_role(Role::Phase, without), unnamed()) {
                (Some(index), _) => (index, "named like a phase"),
                (None, Some(index)) if self.turns_half(index) => {
                    (index, "it turns by half a turn, as phases do")
                }
                (None, Some(index)) if self.looks_like_phase(index) => {
                    (index, "the next column, within half a turn or two")
                }
                _ => return Ok(None),
            },
        };
        let mut picked = self.picked(index, why);
        if let Some(unit) = &self.options.phase_unit {
            unit.trim().clone_into(&mut picked.unit);
        }
        if let Some(factor) = units::radians(&picked.unit) {
            return Ok(Some((picked, factor)));
        }
        if let Some(unit) = &self.options.phase_unit {
            let problem = OptionProblem::UnknownUnit("deg or rad");
            return Err(ReadProblem::Option { option: "phase_unit", value: unit.clone(), problem });
        }
        let largest = self.finite(index).fold(0.0, |m: f64, v| m.max(v.abs()));
        let degrees = largest > 2.2 * PI;
        let (unit, word, factor) =
            if degrees { ("deg", "degrees", 1f64.to_radians()) } else { ("rad", "radians", 1.0) };
        let text = format!(
            "{} names no unit: its phases, up to {largest:.4}, were taken as {word}",
            self.label(index)
        );
        self.notes.push(Note::new(text).hint("phase_unit", "says otherwise"));
        unit.clone_into(&mut picked.unit);
        Ok(Some((picked, factor)))
    }

    /// Where the first column without a name turns as a phase does: the first other one with a peak.
    fn peaked_beside(&self, first: usize, taken: &[usize]) -> Option<usize> {
        let unnamed =
            |i: usize| self.head.names[i].header.is_empty() && !taken.contains(&i) && self.filled(i);
        if !unnamed(first) || !self.turns_half(first) {
            return None;
        }
        let peaked = |&i: &usize| {
            let values: Vec<f64> = self.finite(i).collect();
            let tenth = (values.len() / 10).max(1);
            let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
            // Means, so that one wild point is no peak.
            let highest = values.chunks(tenth).map(mean).fold(f64::NEG_INFINITY, f64::max);
            let ends = mean(&values[..tenth]).max(mean(&values[values.len() - tenth..]));
            values.iter().all(|v| *v > 0.0) && highest > PEAK * ends
        };
        self.near.iter().copied().filter(|&i| i != first && unnamed(i)).find(peaked)
    }

    /// Numbers that go one way, by half a turn or a good part of it, as the phase through a resonance.
    fn turns_half(&self, index: usize) -> bool {
        let values: Vec<f64> = self.finite(index).collect();
        if values.len() < 10 {
            return false;
        }
        let tenth = values.len() / 10;
        let mut sorted = values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let span = sorted[sorted.len() - 1 - tenth / 2] - sorted[tenth / 2];
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let means: Vec<f64> = values.chunks_exact(tenth).map(mean).collect();
        let net = means[means.len() - 1] - means[0];
        let one_way = means.windows(2).all(|w| (w[1] - w[0]) * net.signum() > -0.05 * span);
        let turn = [(0.4 * PI, 1.2 * PI), (72.0, 216.0)]
            .into_iter()
            .any(|(least, most)| (least..=most).contains(&span));
        one_way && turn && net.abs() > 0.8 * span
    }

    /// Numbers that stay within two turns and move by a good part of half a one.
    fn looks_like_phase(&self, index: usize) -> bool {
        let (low, high) =
            self.finite(index).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let span = high - low;
        ((20.0..=720.0).contains(&span) && high.max(-low) <= 720.0) || (0.3..=12.6).contains(&span)
    }
}
