//! Choice of the response columns of a curve.

use std::f64::consts::PI;

use super::{
    chooser::{Chooser, ChosenColumn},
    name::words,
    quadrature::Pair,
    role::Role,
    scale::{self, Scale, Written},
    scattering::scattering,
    units,
};
use crate::{
    error::{Needed, OptionProblem, ReadProblem},
    report::Note,
};

/// Minimum ratio of a peak to the amplitudes at the ends of a curve.
pub(crate) const PEAK: f64 = 1.5;

/// Columns that make up the response.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Response {
    /// Amplitude, and phase with its factor to radians, if there is one.
    Amplitude(ChosenColumn, Scale, Option<(ChosenColumn, f64)>),
    Complex(ChosenColumn, ChosenColumn),
    /// Conductance, and susceptance if there is one.
    Admittance(ChosenColumn, Option<ChosenColumn>),
    /// Series resistance and reactance.
    Impedance(ChosenColumn, Option<ChosenColumn>),
    /// Modulus of an admittance or, if `is_impedance`, of an impedance; with the angle and its factor to radians, if
    /// there is one.
    Modulus {
        of: ChosenColumn,
        is_impedance: bool,
        angle: Option<(ChosenColumn, f64)>,
    },
}

impl Response {
    /// The columns read, with their roles.
    pub(super) fn columns(&self) -> Vec<(&'static str, &ChosenColumn)> {
        let (first, second) = match self {
            Self::Amplitude(a, _, phase) => (("amplitude", a), phase.as_ref().map(|p| ("phase", &p.0))),
            Self::Complex(re, im) => (("real", re), Some(("imaginary", im))),
            Self::Admittance(g, b) => (("conductance", g), b.as_ref().map(|b| ("susceptance", b))),
            Self::Impedance(r, x) => (("resistance", r), x.as_ref().map(|x| ("reactance", x))),
            Self::Modulus { of, angle, is_impedance } => {
                let what = if *is_impedance { "impedance" } else { "admittance" };
                ((what, of), angle.as_ref().map(|a| ("phase", &a.0)))
            }
        };
        [Some(first), second].into_iter().flatten().collect()
    }
}

/// Channel number in a header: 2 of `Channel 2 Phase (deg)` and `CH2 (dB)`.
fn channel(header: &str) -> Option<u32> {
    let lower = header.to_lowercase();
    ["channel", "kanal", "canal", "chan", "ch"].into_iter().find_map(|word| {
        let at = lower.find(word)?;
        let begins = lower[..at].chars().next_back().is_none_or(|c| !c.is_alphabetic());
        let number = lower[at + word.len()..].trim_start_matches([' ', '_', '#', '.']);
        let digits = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
        number[..digits].parse().ok().filter(|_| begins)
    })
}

/// Whether a unit is one of angles.
fn is_angle(unit: &str) -> bool {
    units::radians(unit).is_some()
}

impl Chooser<'_> {
    pub(super) fn response(&mut self, taken: &[usize]) -> Result<Response, ReadProblem> {
        let o = self.options;
        let (real, imaginary) = (self.asked("real", &o.real)?, self.asked("imaginary", &o.imaginary)?);
        match (real, imaginary) {
            (Some(re), Some(im)) => {
                return Ok(Response::Complex(
                    self.choose_column(re, "asked for"),
                    self.choose_column(im, "asked for"),
                ));
            }
            (Some(one), None) | (None, Some(one)) => {
                let missing = if real.is_some() { "imaginary" } else { "real" };
                let other = if real.is_some() { Role::Imaginary } else { Role::Real };
                let beside = self.quadrature_pairs(taken).iter().find_map(|pair| pair.other(one));
                let Some(found) = beside.or_else(|| self.of_role(other, taken)) else {
                    let (given, columns) = (self.label(one), self.list());
                    return Err(ReadProblem::HalfComplex { given, missing, columns });
                };
                let (one, found) =
                    (self.choose_column(one, "asked for"), self.choose_column(found, "named so"));
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
                Role::Admittance | Role::Impedance if o.unit.is_none() => {
                    self.modulus(amplitude, "asked for", taken)
                }
                _ => self.amplitude(amplitude, "asked for", taken),
            };
        }
        let role = |role| self.of_role(role, taken);
        if let (Some(re), Some(im)) = (role(Role::Real), role(Role::Imaginary)) {
            let (re, im) = (
                self.choose_column(re, "named like a real part"),
                self.choose_column(im, "named like an imaginary part"),
            );
            return Ok(Response::Complex(re, im));
        }
        if let Some(pair) = self.quadrature_pair(taken) {
            let [x, y] = [pair.real, pair.imaginary].map(|i| self.choose_column(i, Pair::WHY));
            return Ok(Response::Complex(x, y));
        }
        if let Some(g) = role(Role::Conductance) {
            return Ok(self.admittance(g, "named like a conductance", taken));
        }
        if let Some(y) = role(Role::Admittance) {
            return self.modulus(y, "named like an admittance", taken);
        }
        if let Some(z) = role(Role::Impedance) {
            return self.modulus(z, "named like an impedance", taken);
        }
        if let Some(amplitude) = role(Role::Amplitude) {
            if let Some(with_phase) = self.amplitude_of_phase(amplitude, taken) {
                let text = format!(
                    "{} has a phase and {} has none: the first was taken",
                    self.label(with_phase),
                    self.label(amplitude)
                );
                self.notes.push(Note::new(text).hint("amplitude", "names another"));
                return self.amplitude(with_phase, "the amplitude of the channel that has a phase", taken);
            }
            return self.amplitude(amplitude, "named like an amplitude", taken);
        }
        if let Some(r) = role(Role::Resistance) {
            return Ok(self.impedance(r, "named like a series resistance", taken));
        }
        if let Some(response) = self.unnamed_parts(taken) {
            return Ok(response);
        }
        let columns = self.list();
        let free = |i: &&usize| {
            !taken.contains(i) && self.filled(**i) && matches!(self.roles[**i], Role::Unknown | Role::Real)
        };
        let channel = |i: &usize| self.is_channel(*i) && self.peak_over_ends(*i) >= PEAK;
        let channel = self.near.iter().filter(free).copied().find(channel);
        // A constant column, such as a reference, is not chosen if another one varies.
        let moving = || self.near.iter().filter(free).copied().find(|i| self.varies(*i));
        match channel.or_else(moving).or_else(|| self.near.iter().find(free).copied()) {
            Some(first) if channel.is_some() => {
                self.amplitude(first, "the first channel that has a peak", taken)
            }
            Some(first) => match self.peaked_partner_of_phase(first, taken) {
                Some(index) => self.amplitude(index, "the first column left that has a peak", taken),
                None => self.amplitude(first, "the first column left", taken),
            },
            None => Err(ReadProblem::NoColumn { needed: Needed::Amplitude, columns }),
        }
    }

    /// The first phase that does not belong to another channel.
    fn phase_of(&self, amplitude: usize, without: &[usize]) -> Option<usize> {
        let others: Vec<usize> =
            self.near.iter().copied().filter(|&i| self.is_of_another(amplitude, i)).collect();
        let without = [without, &others].concat();
        let ports = |i: usize| scattering(&self.head.names[i].header);
        let is_same = |i: &usize| ports(*i).is_some() && ports(*i) == ports(amplitude);
        let of_other: Vec<usize> = self.near.iter().copied().filter(|i| !is_same(i)).collect();
        let same = self.of_role(Role::Phase, &[&without[..], &of_other].concat());
        same.or_else(|| self.of_role(Role::Phase, &without))
    }

    /// If the only phases belong to another channel, the amplitude of that channel.
    fn amplitude_of_phase(&self, amplitude: usize, taken: &[usize]) -> Option<usize> {
        if self.options.phase.is_some() || self.phase_of(amplitude, taken).is_some() {
            return None;
        }
        let phase = self.of_role(Role::Phase, taken)?;
        let others: Vec<usize> =
            self.near.iter().copied().filter(|&i| self.is_of_another(phase, i)).collect();
        let same =
            |i: &usize| self.roles[*i] == Role::Amplitude && channel(&self.head.names[*i].header).is_some();
        self.of_role(Role::Amplitude, &[taken, &others].concat()).filter(same)
    }

    /// Whether two columns name different channels.
    fn is_of_another(&self, one: usize, other: usize) -> bool {
        let of = |i: usize| channel(&self.head.names[i].header);
        of(one).zip(of(other)).is_some_and(|(one, other)| one != other)
    }

    /// Two columns without names to which a resonance fits as real and imaginary part.
    fn unnamed_parts(&mut self, taken: &[usize]) -> Option<Response> {
        let unnamed = |i: &usize| self.head.names[*i].header.is_empty();
        let free = |i: &usize| unnamed(i) && !taken.contains(i) && self.filled(*i);
        let mut free = self.near.iter().copied().filter(free);
        let (first, second) = (free.next()?, free.next()?);
        if self.options.unit.is_some() || self.options.phase.is_some() {
            return None;
        }
        if !self.are_parts(*taken.first()?, first, second) {
            return None;
        }
        let (a, b) = (self.label(first), self.label(second));
        let text = format!(
            "{a} and {b} have no names: a resonance fits them far better as real and imaginary part than \
             as amplitude and phase: they were taken as such"
        );
        let note = Note::new(text).hint("amplitude", "names a column of amplitudes");
        self.notes.push(note.hint("phase", "names a column of phases"));
        let why = "a resonance fits it best so";
        Some(Response::Complex(self.choose_column(first, why), self.choose_column(second, why)))
    }

    /// A conductance with the susceptance that belongs to it.
    fn admittance(&self, g: usize, why: &str, taken: &[usize]) -> Response {
        let b = self.of_role(Role::Susceptance, taken);
        let b = b.map(|b| self.choose_column_in(units::siemens, b, "named like a susceptance"));
        Response::Admittance(self.choose_column_in(units::siemens, g, why), b)
    }

    /// A series resistance with the reactance that belongs to it.
    fn impedance(&self, r: usize, why: &str, taken: &[usize]) -> Response {
        let x = self.of_role(Role::Reactance, taken);
        let x = x.map(|x| self.choose_column_in(units::ohms, x, "named like a reactance"));
        Response::Impedance(self.choose_column_in(units::ohms, r, why), x)
    }

    /// The modulus of an admittance or an impedance with its angle; in such exports theta is the angle, in any unit.
    fn modulus(&mut self, of: usize, why: &str, taken: &[usize]) -> Result<Response, ReadProblem> {
        let is_impedance = self.roles[of] == Role::Impedance;
        let without: Vec<usize> = taken.iter().copied().chain([of]).collect();
        let theta = |i: &usize| {
            let bare = self.head.names[*i].bare.trim().to_lowercase();
            ["theta", "\u{3b8}", "\u{3d1}"].contains(&bare.as_str()) && !without.contains(i)
        };
        if self.of_role(Role::Phase, &without).is_none()
            && let Some(index) = self.near.iter().copied().find(theta)
        {
            self.roles[index] = Role::Phase;
        }
        let angle = self.phase(of, &without)?;
        let known = if is_impedance { units::ohms } else { units::siemens };
        Ok(Response::Modulus { of: self.choose_column_in(known, of, why), is_impedance, angle })
    }

    /// A column, in the requested unit if that is a known one.
    fn choose_column_in(&self, known: fn(&str) -> Option<f64>, index: usize, why: &str) -> ChosenColumn {
        let mut chosen = self.choose_column(index, why);
        if let Some(unit) = self.options.unit.as_deref().filter(|unit| known(unit).is_some()) {
            unit.trim().clone_into(&mut chosen.unit);
        }
        chosen
    }

    fn amplitude(&mut self, index: usize, why: &str, taken: &[usize]) -> Result<Response, ReadProblem> {
        let given = self.options.unit.clone();
        let mut amplitude = self.choose_column(index, why);
        if let Some(unit) = &given {
            unit.trim().clone_into(&mut amplitude.unit);
        }
        let label = self.label(index);
        let name = Some(self.head.names[index].bare.as_str()).filter(|_| given.is_none());
        let Written { mut scale, unit, done } = scale::written(&amplitude.unit, name);
        amplitude.unit = unit;
        if name.is_some_and(|name| scale::may_be_power(&amplitude.unit, name)) {
            let text = format!(
                "{label} may hold powers, but its unit does not say so: its values were taken as amplitudes"
            );
            self.notes.push(Note::new(text).hint("unit", "takes square roots, such as V^2"));
        }
        if let Some(done) = done {
            let note = Note::new(format!("{label}: {done}"));
            let as_they_are = matches!(scale, Scale::Times(_) | Scale::Power);
            self.notes.push(if as_they_are { note.hint("unit", "names another") } else { note });
        }
        let without: Vec<usize> = taken.iter().copied().chain([index]).collect();
        let phase = self.phase(index, &without)?;
        if scale == Scale::Linear && self.head.names[index].header.is_empty() && given.is_none() {
            scale = self.scale_without_name(index, taken);
        }
        Ok(Response::Amplitude(amplitude, scale, phase))
    }

    /// Scale of a column without name and unit.
    fn scale_without_name(&mut self, index: usize, taken: &[usize]) -> Scale {
        let label = self.label(index);
        // Amplitudes are not negative; levels in decibels are, below their reference.
        if self.finite(index).any(|v| v < 0.0) {
            let text = format!("{label} has no name and negative numbers: it was taken as levels in dB");
            let note = Note::new(text).hint("unit", "gives another");
            let part = "reads a part of a complex response";
            self.notes.push(note.hint("real", part).hint("imaginary", part));
            return Scale::Decibel;
        }
        let decibels = taken.first().and_then(|over| self.fits_decibels(*over, index));
        let (scale, text) = match decibels {
            Some(true) => (
                Scale::Decibel,
                format!(
                    "{label} has no name, and a resonance fits it best as levels in dB: it was taken as \
                     such"
                ),
            ),
            Some(false) => return Scale::Linear,
            None => (Scale::Linear, format!("{label} names no unit: its amplitudes were taken as linear")),
        };
        self.notes.push(Note::new(text).hint("unit", "gives another"));
        scale
    }

    fn phase(&mut self, of: usize, without: &[usize]) -> Result<Option<(ChosenColumn, f64)>, ReadProblem> {
        let given = self.asked("phase", &self.options.phase)?;
        // If the table has headers, a phase has one too.
        let headed = self.head.names.iter().any(|n| !n.header.is_empty());
        let unnamed = || {
            let free = |i: &&usize| !without.contains(i) && self.filled(**i);
            self.near.iter().find(free).copied().filter(|_| !headed)
        };
        let (index, why) = match given {
            Some(index) => (index, "asked for"),
            None => {
                match (self.phase_of(of, without).or_else(|| self.angle_of_amplitude(of, without)), unnamed())
                {
                    (Some(index), _) => (index, "named like a phase"),
                    (None, Some(index)) if self.turns_half(index) => {
                        (index, "it turns by half a turn, as phases do")
                    }
                    (None, Some(index)) if self.looks_like_phase(index) => {
                        (index, "the next column, within half a turn or two")
                    }
                    _ => return Ok(None),
                }
            }
        };
        let mut chosen = self.choose_column(index, why);
        let bare = self.head.names[index].bare.trim();
        if let Some(unit) = &self.options.phase_unit {
            unit.trim().clone_into(&mut chosen.unit);
        } else if chosen.unit.is_empty() && units::radians(bare).is_some() {
            // A column headed by its unit alone.
            bare.clone_into(&mut chosen.unit);
        }
        if let Some(factor) = units::radians(&chosen.unit) {
            return Ok(Some((chosen, factor)));
        }
        if let Some(unit) = &self.options.phase_unit {
            let problem = OptionProblem::UnknownUnit("deg, rad, cycles or pi");
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
        self.notes.push(Note::new(text).hint("phase_unit", "gives another"));
        unit.clone_into(&mut chosen.unit);
        Ok(Some((chosen, factor)))
    }

    /// An angle next to an amplitude, which is its phase if named so: `Ang`, `\u{398}`, `deg`, or `S21 (deg)` next to
    /// `S21 (dB)`.
    fn angle_of_amplitude(&self, of: usize, without: &[usize]) -> Option<usize> {
        let name = |i: usize| &self.head.names[i];
        let called = |i: usize| {
            let angle = ["ang", "angle", "theta", "\u{3b8}", "\u{3d1}", "deg", "degrees", "rad"];
            let first = words(&name(i).bare);
            first.first().is_some_and(|word| angle.contains(&word.as_str()))
                && self.roles[i] == Role::Unknown
                && self.roles[of] == Role::Amplitude
        };
        let in_degrees = |i: usize| {
            let same = name(i).bare.trim().eq_ignore_ascii_case(name(of).bare.trim());
            same && !name(of).bare.trim().is_empty() && is_angle(&name(i).unit) && !is_angle(&name(of).unit)
        };
        let fits = |i: &usize| {
            !without.contains(i)
                && self.filled(*i)
                && (called(*i) || in_degrees(*i))
                && self.looks_like_phase(*i)
                && self.peak_over_ends(*i) < PEAK
        };
        self.near.iter().copied().find(fits)
    }

    /// If the first column without a name varies like a phase: the first other one with a peak.
    fn peaked_partner_of_phase(&self, first: usize, taken: &[usize]) -> Option<usize> {
        let unnamed =
            |i: usize| self.head.names[i].header.is_empty() && !taken.contains(&i) && self.filled(i);
        if !unnamed(first) || !self.turns_half(first) {
            return None;
        }
        let peaked = |&i: &usize| self.peak_over_ends(i) > PEAK;
        self.near.iter().copied().filter(|&i| i != first && unnamed(i)).find(peaked)
    }

    /// Whether the numbers change in one direction by about half a turn, like the phase through a resonance.
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

    /// Whether the numbers stay within two turns and vary by a good part of half a turn.
    fn looks_like_phase(&self, index: usize) -> bool {
        let (low, high) =
            self.finite(index).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let span = high - low;
        ((20.0..=720.0).contains(&span) && high.max(-low) <= 720.0) || (0.3..=12.6).contains(&span)
    }
}
