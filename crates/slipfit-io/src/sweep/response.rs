//! Which columns hold the response.

use super::choice::{Picked, Response, Scale};
use super::choose::Chooser;
use super::{SweepProblem, role::Role};
use crate::{ReadProblem, columns::units};

impl Chooser<'_> {
    pub(super) fn response(&mut self, taken: &[usize]) -> Result<Response, ReadProblem> {
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
}

fn squared(unit: &str) -> bool {
    ["w", "mw", "uw", "\u{b5}w", "\u{3bc}w", "nw", "v^2", "v\u{b2}", "m^2", "m\u{b2}", "rad^2", "rad\u{b2}"]
        .contains(&unit.trim().to_lowercase().as_str())
}
