//! Drives: the motion of the far end of the spring.

use super::local::{CHIRP_SPAN, Chirp, Local, Tone};
use super::transition::{C64, Constants};
use crate::error::Error;
use crate::model::oscillator::{above_zero, finite, moderate};
use crate::numeric::double_double::{self as dd, Dd};
use crate::numeric::trig::{PI_A, PI_B, PI_C};

/// Motion `u(t)` of the base, the spring's far end; the force on the mass is `k (u - x)`.
///
/// A force `P(t)` on the mass is equivalent to a base moving by `P/k`.
///
/// ```
/// # use slipfit::motion::simulate::Drive;
/// // Driven at 2 rad/s with amplitude 0.1, switched off at 40 s: a ring-down follows.
/// let drive = Drive::harmonic(0.1, 2.0)?.until(40.0)?;
/// assert_eq!(drive.displacement(0.0), 0.1);
/// assert_eq!(drive.displacement(40.0), 0.0);
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// In order of time; the first stage extends to minus infinity.
    stages: Vec<(f64, Source)>,
}

/// One harmonic of a drive: `amplitude cos(omega t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Displacement.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub omega: f64,
    /// Phase at time zero, rad.
    pub phase: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Source {
    Harmonics { offset: f64, harmonics: Vec<Harmonic> },
    Chirp { amplitude: f64, omega: (f64, f64), time: (f64, f64), rate: f64 },
    Sampled { time_s: Vec<f64>, value: Vec<f64> },
}

impl Drive {
    fn from_source(source: Source) -> Self {
        Self { stages: vec![(f64::NEG_INFINITY, source)] }
    }

    /// No drive: a base at rest at zero.
    pub fn none() -> Self {
        Self::from_source(Source::Harmonics { offset: 0.0, harmonics: Vec::new() })
    }

    /// A base at rest at `offset`; a constant force `offset k`.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless finite.
    pub fn hold(offset: f64) -> Result<Self, Error> {
        moderate("offset", offset)?;
        Ok(Self::from_source(Source::Harmonics { offset, harmonics: Vec::new() }))
    }

    /// `amplitude cos(omega t)`, the drive of eq. (2) of Vitorino, Vieira and Rodrigues.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `omega > 0` and both are finite.
    pub fn harmonic(amplitude: f64, omega: f64) -> Result<Self, Error> {
        Self::harmonics(0.0, &[Harmonic { amplitude, omega, phase: 0.0 }])
    }

    /// A constant and any number of harmonics, of any frequencies.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless every `omega > 0` and all values are finite.
    pub fn harmonics(offset: f64, harmonics: &[Harmonic]) -> Result<Self, Error> {
        moderate("offset", offset)?;
        for h in harmonics {
            strength("amplitude", h.amplitude)?;
            frequency("omega", h.omega)?;
            finite("phase", h.phase)?;
        }
        Ok(Self::from_source(Source::Harmonics { offset, harmonics: harmonics.to_vec() }))
    }

    /// A frequency sweep, up or down: `amplitude cos(phase(t))`. `phase'` changes linearly from `omega_start` to
    /// `omega_end` between the two times and is constant before and after; the phase is zero at `start_s`.
    ///
    /// Within an arc the quadratic part of the phase is kept below 1e-3 rad and expanded to the fourth power, with
    /// each power in closed form. The error is below 1e-17 of the amplitude, for slow and fast sweeps alike.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless frequencies are above zero and `start_s < end_s`.
    pub fn chirp(
        amplitude: f64,
        omega_start: f64,
        omega_end: f64,
        start_s: f64,
        end_s: f64,
    ) -> Result<Self, Error> {
        strength("amplitude", amplitude)?;
        frequency("omega_start", omega_start)?;
        frequency("omega_end", omega_end)?;
        finite("start_s", start_s)?;
        finite("end_s", end_s)?;
        if start_s >= end_s {
            return Err(Error::Parameter { name: "end_s", value: end_s, range: "after start_s" });
        }
        let rate = (omega_end - omega_start) / (end_s - start_s);
        finite("sweep rate", rate)?;
        let (omega, time) = ((omega_start, omega_end), (start_s, end_s));
        Ok(Self::from_source(Source::Chirp { amplitude, omega, time, rate }))
    }

    /// A sampled drive: linear interpolation between the samples, constant before the first and after the last.
    ///
    /// # Errors
    /// [`Error::Length`] if the arrays differ, [`Error::TooFewSamples`] if empty,
    /// [`Error::TimeBackwards`] unless times increase, [`Error::Parameter`] for a value
    /// that is not finite.
    pub fn sampled(time_s: Vec<f64>, displacement: Vec<f64>) -> Result<Self, Error> {
        if time_s.len() != displacement.len() {
            return Err(Error::Length {
                name: "displacement",
                found: displacement.len(),
                expected: time_s.len(),
            });
        }
        if time_s.is_empty() {
            return Err(Error::TooFewSamples { found: 0, needed: 1 });
        }
        for (t, x) in time_s.iter().zip(&displacement) {
            finite("time_s", *t)?;
            moderate("displacement", *x)?;
        }
        // A slope too steep to represent would make the motion undefined.
        let steep = |i: &usize| {
            let slope = (displacement[i + 1] - displacement[*i]) / (time_s[i + 1] - time_s[*i]);
            time_s[*i] < time_s[i + 1] && slope.abs() > 1e150
        };
        if let Some(i) = (0..time_s.len() - 1).find(steep) {
            return Err(Error::Parameter {
                name: "displacement",
                value: displacement[i + 1],
                range: "slopes below 1e150 per s",
            });
        }
        if let Some(i) = time_s.windows(2).position(|w| w[0] >= w[1]) {
            return Err(Error::TimeBackwards { index: i + 1, previous: time_s[i], next: time_s[i + 1] });
        }
        Ok(Self::from_source(Source::Sampled { time_s, value: displacement }))
    }

    /// This drive up to `time_s`, then `next` (in its own absolute time).
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `time_s` is finite and after earlier changes of this drive.
    pub fn then(mut self, time_s: f64, next: Self) -> Result<Self, Error> {
        finite("time_s", time_s)?;
        let last = self.stages.last().map_or(f64::NEG_INFINITY, |s| s.0);
        if time_s <= last {
            return Err(Error::Parameter {
                name: "time_s",
                value: time_s,
                range: "after the drive's earlier changes",
            });
        }
        let current = next.stages.iter().rposition(|s| s.0 <= time_s).unwrap_or(0);
        for (i, (from, source)) in next.stages.into_iter().enumerate().skip(current) {
            self.stages.push((if i == current { time_s } else { from }, source));
        }
        Ok(self)
    }

    /// This drive, switched off at `time_s`: the base is at zero from then on.
    ///
    /// # Errors
    /// As [`Drive::then`].
    pub fn until(self, time_s: f64) -> Result<Self, Error> {
        self.then(time_s, Self::none())
    }

    /// The highest angular frequency of a harmonic or a sweep, rad/s; `None` for a drive that has neither.
    pub(crate) fn highest_omega(&self) -> Option<f64> {
        let of = |source: &Source| match source {
            Source::Harmonics { harmonics, .. } => harmonics.iter().map(|h| h.omega).reduce(f64::max),
            Source::Chirp { omega, .. } => Some(omega.0.max(omega.1)),
            Source::Sampled { .. } => None,
        };
        self.stages.iter().filter_map(|(_, source)| of(source)).reduce(f64::max)
    }

    /// Whether output at `rate_hz` can resolve this drive: its frequency must lie below half that rate.
    ///
    /// # Errors
    /// [`Error::Parameter`] naming the drive's frequency if it does not, or an invalid rate.
    pub fn check_sampling(&self, rate_hz: f64) -> Result<(), Error> {
        above_zero("rate_hz", rate_hz)?;
        match self.highest_omega().map(|w| w / std::f64::consts::TAU) {
            Some(value) if value >= 0.5 * rate_hz => Err(Error::Parameter {
                name: "drive frequency_hz",
                value,
                range: "below half the sampling rate (raise rate_hz)",
            }),
            _ => Ok(()),
        }
    }

    /// Position of the base at a time.
    pub fn displacement(&self, time_s: f64) -> f64 {
        let stage = self.stage_at(time_s);
        self.stages[stage].1.value(Dd::from_f64(time_s))
    }

    fn stage_at(&self, time_s: f64) -> usize {
        self.stages.partition_point(|s| s.0 <= time_s).saturating_sub(1)
    }

    /// Writes the drive relative to the time `t` into `out`, whose buffers are reused.
    pub(super) fn localise(&self, k: &Constants, t: Dd, out: &mut Local) {
        let stage = self.stage_at(t.hi);
        let next = self.stages.get(stage + 1).map(|s| s.0);
        out.slope = 0.0;
        out.chirp = None;
        out.end = f64::INFINITY;
        out.end_time = None;
        out.range = (f64::NEG_INFINITY, f64::INFINITY);
        self.stages[stage].1.localise(k, t, out);
        out.stage_ends = false;
        if let Some(at) = next {
            out.range = (f64::NEG_INFINITY, f64::INFINITY);
            let left = Dd::from_f64(at).sub(t).value();
            if left <= out.end {
                out.end = left;
                out.end_time = Some(at);
                out.stage_ends = true;
            }
        }
    }
}

fn strength(name: &'static str, value: f64) -> Result<(), Error> {
    // Below this, its derivatives would underflow.
    if value == 0.0 || (1e-150..=1e100).contains(&value.abs()) {
        Ok(())
    } else {
        Err(Error::Parameter { name, value, range: "zero, or a magnitude of 1e-150 to 1e100" })
    }
}

fn frequency(name: &'static str, value: f64) -> Result<(), Error> {
    // Its cube must not overflow.
    if value > 0.0 && value <= 1e50 {
        Ok(())
    } else {
        Err(Error::Parameter { name, value, range: "0 < omega <= 1e50 rad/s" })
    }
}

/// `e^(i (omega t + phase))`.
fn turn(omega: f64, t: Dd, phase: f64) -> C64 {
    let (sin, cos) = angle(omega, t, phase).sin_cos();
    C64::new(cos, sin)
}

/// `omega t + phase` within half a turn, reduced in double-double precision.
#[inline]
fn angle(omega: f64, t: Dd, phase: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    const ONE_TURN: f64 = 1.0 / TAU;
    let p = dd::two_product(t.hi, omega);
    let turns = (p.hi * ONE_TURN + MAGIC) - MAGIC;
    if turns.abs() < TURNS && phase.abs() <= PI {
        // The first difference is exact, and so are the products of the turns with the first two parts.
        let small = (p.lo + t.lo * omega) - turns * (2.0 * PI_B) - turns * (2.0 * PI_C);
        let angle = (p.hi - turns * (2.0 * PI_A)) + small + phase;
        return if angle > PI {
            angle - TAU
        } else if angle < -PI {
            angle + TAU
        } else {
            angle
        };
    }
    let p = t.scale(omega).add(Dd::from_f64(phase));
    let two_pi = dd::PI.scale(2.0);
    let turns = (p.hi / two_pi.hi).round();
    p.sub(two_pi.scale(turns)).value()
}

/// Number of turns below which [`angle`] may use pi in three parts.
const TURNS: f64 = 33_554_432.0;

/// Phase of a chirp, rad, and its frequency, `t` after its start.
fn chirp_phase(omega: f64, rate: f64, t: Dd) -> (Dd, f64) {
    (t.scale(omega).add(t.mul(t).scale(0.5 * rate)), omega + rate * t.hi)
}

impl Source {
    fn value(&self, t: Dd) -> f64 {
        match self {
            Self::Harmonics { offset, harmonics } => {
                offset + harmonics.iter().map(|h| h.amplitude * turn(h.omega, t, h.phase).re).sum::<f64>()
            }
            Self::Chirp { amplitude, omega, time, rate } => {
                let (phase, _, _) = Self::chirp_at(*omega, *time, *rate, t);
                amplitude * phase.re
            }
            Self::Sampled { time_s, value } => {
                let i = time_s.partition_point(|s| *s <= t.hi);
                if i == 0 {
                    return value[0];
                }
                if i == time_s.len() {
                    return value[i - 1];
                }
                let slope = (value[i] - value[i - 1]) / (time_s[i] - time_s[i - 1]);
                value[i - 1] + slope * t.sub(Dd::from_f64(time_s[i - 1])).value()
            }
        }
    }

    /// Phasor, frequency and rate of a chirp at a time.
    fn chirp_at(omega: (f64, f64), time: (f64, f64), rate: f64, t: Dd) -> (C64, f64, f64) {
        let since = t.sub(Dd::from_f64(time.0));
        if since.hi < 0.0 {
            return (turn(omega.0, since, 0.0), omega.0, 0.0);
        }
        let after = t.sub(Dd::from_f64(time.1));
        let unit = |p: Dd| turn(1.0, p, 0.0);
        if after.hi < 0.0 {
            let (phase, w) = chirp_phase(omega.0, rate, since);
            return (unit(phase), w, rate);
        }
        let whole = Dd::from_f64(time.1).sub(Dd::from_f64(time.0));
        let (phase, _) = chirp_phase(omega.0, rate, whole);
        (unit(phase.add(after.scale(omega.1))), omega.1, 0.0)
    }

    fn localise(&self, k: &Constants, t: Dd, out: &mut Local) {
        match self {
            Self::Harmonics { offset, harmonics } => {
                out.value = *offset;
                let mut most = 0.0;
                out.tones.resize_with(harmonics.len(), || Tone::new(k, f64::NAN, 0.0, 0.0));
                for (h, tone) in harmonics.iter().zip(&mut out.tones) {
                    let angle = angle(h.omega, t, h.phase);
                    // The small divisors depend on the frequency, not on the time.
                    *tone = if tone.omega == h.omega {
                        tone.at(h.amplitude, angle)
                    } else {
                        Tone::new(k, h.omega, h.amplitude, angle)
                    };
                    out.value += tone.c.re;
                    most += h.amplitude.abs();
                }
                out.range = (offset - most, offset + most);
            }
            Self::Chirp { amplitude, omega, time, rate } => {
                let (unit, w, rate) = Self::chirp_at(*omega, *time, *rate, t);
                let c = unit * *amplitude;
                out.value = c.re;
                out.range = (-amplitude.abs(), amplitude.abs());
                if t.hi < time.1 {
                    let next = if t.hi < time.0 { time.0 } else { time.1 };
                    out.end = Dd::from_f64(next).sub(t).value();
                    out.end_time = Some(next);
                }
                out.tones.clear();
                if rate == 0.0 {
                    out.tones.push(Tone::new(k, w, *amplitude, unit.arg()));
                } else {
                    out.chirp = Some(Chirp { omega: w, rate, c });
                    let span = (2.0 * CHIRP_SPAN / rate.abs()).sqrt();
                    if span < out.end {
                        out.end = span;
                        out.end_time = None;
                    }
                }
            }
            Self::Sampled { time_s, value } => {
                out.tones.clear();
                let i = time_s.partition_point(|s| *s <= t.hi);
                out.value = value[i.saturating_sub(1)];
                if i < time_s.len() {
                    out.end = Dd::from_f64(time_s[i]).sub(t).value();
                    out.end_time = Some(time_s[i]);
                    if i > 0 {
                        out.slope = (value[i] - value[i - 1]) / (time_s[i] - time_s[i - 1]);
                        out.value += out.slope * t.sub(Dd::from_f64(time_s[i - 1])).value();
                    }
                } else {
                    out.range = (out.value, out.value);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_that_of_doubled_arithmetic_however_late() {
        for (omega, phase) in [(0.3, 0.0), (7.7, 1.5), (1e5, -3.1), (1e-7, 3.0), (2.0, 40.0)] {
            for k in 0..60 {
                let t = Dd::from_f64(1e-3 * 1.7f64.powi(k)).div(Dd::from_f64(3.0 * omega));
                let p = t.scale(omega).add(Dd::from_f64(phase));
                let two_pi = dd::PI.scale(2.0);
                let exact = p.sub(two_pi.scale((p.hi / two_pi.hi).round())).value();
                let found = angle(omega, t, phase);
                let apart = (found - exact).rem_euclid(std::f64::consts::TAU);
                let apart = apart.min(std::f64::consts::TAU - apart);
                assert!(found.abs() <= 3.2, "{omega} {phase} {t:?}: {found} {exact}");
                assert!(apart < 9e-16, "{omega} {phase} {t:?}: {found} {exact}");
            }
        }
    }
}
