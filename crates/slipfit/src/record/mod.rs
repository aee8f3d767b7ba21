//! A measured record: times, samples, and the kind of signal.

mod averaging;
mod bursts;
mod clean;
mod clock;
mod criteria;
mod rounding;
mod swings;
mod wraps;

use std::ops::Range;

pub use averaging::Averaging;
pub use clean::MIN_SAMPLES;
pub use clock::{Clock, ClockReport, Gap};
pub use criteria::ClockCriteria;
pub use swings::Swings;

use crate::Error;
use crate::model::displacement::derivative;

/// The quantity that the samples of a record represent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum SignalKind {
    /// Position or angle, or anything proportional to it.
    #[default]
    Displacement,
    /// Its first derivative in time.
    Velocity,
    /// Its second derivative in time.
    Acceleration,
    /// The amplitude of the oscillation (lock-in R, peak amplitude, dB made linear), never negative.
    Envelope,
    /// In-phase and quadrature outputs of a lock-in amplifier.
    LockIn,
}

impl SignalKind {
    /// Whether the samples oscillate with the motion; those of [`SignalKind::Envelope`] and [`SignalKind::LockIn`]
    /// follow its amplitude.
    #[must_use]
    pub fn oscillates(self) -> bool {
        !matches!(self, SignalKind::Envelope | SignalKind::LockIn)
    }

    /// Its name as an option and in files: `displacement`, `velocity`, `acceleration`, `envelope` or `lock-in`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Envelope => "envelope",
            Self::LockIn => "lock-in",
        }
    }

    /// The unit of displacement for samples in this unit: `mm` for a velocity in `mm/s`.
    ///
    /// ```
    /// use slipfit::SignalKind;
    /// assert_eq!(SignalKind::Velocity.displacement_unit("mm/s"), "mm");
    /// assert_eq!(SignalKind::Acceleration.displacement_unit("g"), "g");
    /// ```
    #[must_use]
    pub fn displacement_unit(self, unit: &str) -> String {
        self.integrated(unit).1
    }

    /// Power of `omega` by which a length in this unit is divided to give a displacement, and the unit of that.
    fn integrated(self, unit: &str) -> (i32, String) {
        let (order, ends): (u8, &[&str]) = match self {
            SignalKind::Velocity => (1, &["/s"]),
            SignalKind::Acceleration => (2, &["/s^2", "/s²", "/s2"]),
            _ => return (0, unit.to_owned()),
        };
        let cut = || ends.iter().find_map(|end| unit.strip_suffix(end)).map(str::to_owned);
        let of_displacement = match derivative(unit) {
            Some((base, found)) => (found == order).then_some(base),
            None => cut(),
        };
        of_displacement.map_or_else(|| (0, unit.to_owned()), |unit| (i32::from(order), unit))
    }
}

/// Samples of one oscillating quantity with their times.
///
/// Every constructor cleans the clock and reports in the [`ClockReport`] what it found:
///
/// - rows with a non-finite time or signal are dropped and counted;
/// - a row slightly out of order is moved to its place; a clearly corrupt stamp (one row, far from both neighbours)
///   is dropped with its row;
/// - a counter that restarts at zero while the motion goes on, after 2¹⁶, 2²⁴ or 2³² of its units or a second, a
///   minute, an hour or a day, is continued if the step across the restart is the usual one;
/// - where the clock jumps back permanently, another run begins: the run with most rows is kept, or the one that
///   [`Record::of_run`] names;
/// - repeated stamps are kept, unless the clock is uniform and only *written* with too few digits: then the uniform
///   clock is rebuilt;
/// - gaps and irregular steps are kept.
///
/// Sampling may be irregular. A clock is stored as uniform only if every stamp agrees with it to 1e-9 of a step (or
/// to the rounding of the stamps themselves), so that no jitter is hidden.
///
/// Times are in seconds and never decrease; the signal keeps its given unit, see [`Record::with_unit`].
///
/// ```
/// use slipfit::Record;
/// let time_s = vec![0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9];
/// let angle = vec![1.0, 0.5, -0.5, f64::NAN, -0.4, 0.4, 0.8, 0.3, -0.3, -0.7];
/// let record = Record::new(time_s, angle)?.with_unit("rad");
/// assert_eq!(record.len(), 9);
/// assert_eq!(record.clock_report().nonfinite_inner, 1);
/// assert_eq!(record.clock_report().gaps, 1);
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    clock: Clock,
    signal: Vec<f64>,
    quadrature: Option<Vec<f64>>,
    kind: SignalKind,
    unit: String,
    lossy: bool,
    turning_gravity: bool,
    report: ClockReport,
}

impl Record {
    /// A record from stamps (s) and samples, cleaned as described for [`Record`].
    ///
    /// # Errors
    /// - [`Error::Length`] if the two differ in length
    /// - [`Error::TooFewSamples`] if fewer than [`MIN_SAMPLES`] remain
    /// - [`Error::ConstantSignal`] if all samples are equal
    /// - [`Error::TimeOutOfOrder`] if more stamps go backwards than forwards, or the rows are shuffled
    /// - [`Error::TimeStandsStill`] if all stamps are equal
    pub fn new(time_s: Vec<f64>, signal: Vec<f64>) -> Result<Self, Error> {
        Self::from_stamps(time_s, signal, None, None)
    }

    /// One of several consecutive runs, counted from 1, each with its own clock; otherwise as [`Record::new`] or,
    /// with a quadrature, [`Record::lock_in`], which keep the longest. [`ClockReport::resets`] is one less than the
    /// number of runs.
    ///
    /// ```
    /// use slipfit::{Error, Record};
    /// let (mut time_s, mut signal) = (Vec::new(), Vec::new());
    /// for n in [20, 30, 10] {
    ///     time_s.extend((0..n).map(|i| 0.1 * f64::from(i)));
    ///     signal.extend((0..n).map(|i| f64::from(n) * f64::from(i).cos()));
    /// }
    /// let last = Record::of_run(3, time_s.clone(), signal.clone(), None)?;
    /// assert_eq!((last.len(), last.signal()[0]), (10, 10.0));
    /// assert_eq!(Record::of_run(4, time_s, signal, None), Err(Error::NoSuchRun { asked: 4, found: 3 }));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::NoSuchRun`] if there is no run with this number; otherwise as [`Record::new`].
    pub fn of_run(
        run: usize,
        time_s: Vec<f64>,
        signal: Vec<f64>,
        quadrature: Option<Vec<f64>>,
    ) -> Result<Self, Error> {
        Self::from_stamps(time_s, signal, quadrature, Some(run))
    }

    /// A record sampled at a constant rate (Hz), starting at 0 s.
    ///
    /// Non-finite samples keep their place in time but are dropped; only if they lie inside the record does it become
    /// one with stamps.
    ///
    /// # Errors
    /// [`Error::Parameter`] if the rate is not positive and finite; otherwise
    /// as [`Record::new`].
    pub fn uniform(rate_hz: f64, signal: Vec<f64>) -> Result<Self, Error> {
        Self::from_rate(rate_hz, signal, None)
    }

    /// The two outputs of a lock-in amplifier, in phase and in quadrature.
    ///
    /// # Errors
    /// As [`Record::new`]; a row is dropped if either output is not finite.
    pub fn lock_in(time_s: Vec<f64>, in_phase: Vec<f64>, quadrature: Vec<f64>) -> Result<Self, Error> {
        Self::from_stamps(time_s, in_phase, Some(quadrature), None)
    }

    /// As [`Record::lock_in`], sampled at a constant rate (Hz) from 0 s on.
    ///
    /// # Errors
    /// As [`Record::uniform`].
    pub fn lock_in_uniform(rate_hz: f64, in_phase: Vec<f64>, quadrature: Vec<f64>) -> Result<Self, Error> {
        Self::from_rate(rate_hz, in_phase, Some(quadrature))
    }

    /// Sets the kind of the samples.
    #[must_use]
    pub fn with_kind(mut self, kind: SignalKind) -> Self {
        self.kind = kind;
        self
    }

    /// Sets the unit of the samples, e.g. `"rad"`, `"mm"`, `"V"`; empty if unknown.
    #[must_use]
    pub fn with_unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Marks the samples as lossily compressed, as by MP3 or AAC. Such compression omits what is weak compared with
    /// the loudest signal and so ends a decay early, as friction does. Friction found in such a record has a
    /// [warning](crate::answer::Warning::LossyCompression).
    ///
    /// ```
    /// let signal = (0..100).map(|i| (0.3 * f64::from(i)).cos()).collect();
    /// let record = slipfit::Record::uniform(44100.0, signal)?.with_lossy_compression(true);
    /// assert!(record.is_lossily_compressed());
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    #[must_use]
    pub fn with_lossy_compression(mut self, lossy: bool) -> Self {
        self.lossy = lossy;
        self
    }

    /// Marks the samples as the transverse acceleration of a pendulum, from a sensor that turns with it and therefore
    /// also reads gravity: of `r θ'' + g sin θ` only the part `1 - r/L` of `g sin θ` remains, so that amplitudes are
    /// not those of the swing. The answer has a [warning](crate::answer::Warning::TurningGravity).
    ///
    /// ```
    /// let signal = (0..100).map(|i| (0.3 * f64::from(i)).cos()).collect();
    /// let record = slipfit::Record::uniform(100.0, signal)?.with_turning_gravity(true);
    /// assert!(record.has_turning_gravity());
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    #[must_use]
    pub fn with_turning_gravity(mut self, turning: bool) -> Self {
        self.turning_gravity = turning;
        self
    }

    /// Number of samples, at least [`MIN_SAMPLES`].
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "a record is never empty")]
    pub fn len(&self) -> usize {
        self.signal.len()
    }

    /// Time of sample `index` (s).
    ///
    /// # Panics
    /// Like a slice, if `index` is not below [`Record::len`].
    #[must_use]
    pub fn time_s(&self, index: usize) -> f64 {
        assert!(index < self.len(), "sample {index} of {}", self.len());
        self.clock.time_s(index)
    }

    /// The times of a range of samples (s).
    ///
    /// # Panics
    /// Like a slice, if the range ends beyond [`Record::len`].
    #[must_use]
    pub fn times_s(&self, range: Range<usize>) -> Vec<f64> {
        assert!(range.end <= self.len(), "samples {range:?} of {}", self.len());
        match &self.clock {
            Clock::Stamps(stamps) => stamps[range].to_vec(),
            &Clock::Uniform { start_s, interval_s } => {
                range.map(|i| start_s + i as f64 * interval_s).collect()
            }
        }
    }

    /// Time from the first to the last sample (s).
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.time_s(self.len() - 1) - self.time_s(0)
    }

    /// The samples, in the unit of [`Record::unit`].
    #[must_use]
    pub fn signal(&self) -> &[f64] {
        &self.signal
    }

    /// The quadrature output of a lock-in, as long as the signal.
    #[must_use]
    pub fn quadrature(&self) -> Option<&[f64]> {
        self.quadrature.as_deref()
    }

    /// The kind of the samples.
    #[must_use]
    pub fn kind(&self) -> SignalKind {
        self.kind
    }

    /// Unit of the samples; empty if unknown.
    #[must_use]
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Unit of the displacements of the motion: for a velocity or an acceleration whose unit is a time derivative,
    /// that unit times s or s².
    ///
    /// ```
    /// use slipfit::{Record, SignalKind};
    /// let record = Record::uniform(1.0, (0..32).map(f64::from).collect())?;
    /// let record = record.with_unit("mm/s").with_kind(SignalKind::Velocity);
    /// assert_eq!(record.displacement_unit(), "mm");
    /// # Ok::<(), slipfit::Error>(())
    /// ```
    #[must_use]
    pub fn displacement_unit(&self) -> String {
        self.integrated().1
    }

    /// Power of `omega` by which a length of the signal is divided to give a displacement, and the unit of that.
    pub(crate) fn integrated(&self) -> (i32, String) {
        self.kind.integrated(&self.unit)
    }

    /// Whether the samples were lossily compressed, see [`Record::with_lossy_compression`].
    #[must_use]
    pub fn is_lossily_compressed(&self) -> bool {
        self.lossy
    }

    /// Whether the samples contain gravity that turns with the motion, see [`Record::with_turning_gravity`].
    #[must_use]
    pub fn has_turning_gravity(&self) -> bool {
        self.turning_gravity
    }

    /// The times at which the samples were taken.
    #[must_use]
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// State of the clock before cleaning, and the corrections made.
    #[must_use]
    pub fn clock_report(&self) -> &ClockReport {
        &self.report
    }

    fn from_stamps(
        time_s: Vec<f64>,
        signal: Vec<f64>,
        quadrature: Option<Vec<f64>>,
        run: Option<usize>,
    ) -> Result<Self, Error> {
        check_length("signal", signal.len(), time_s.len())?;
        if let Some(quadrature) = &quadrature {
            check_length("quadrature", quadrature.len(), time_s.len())?;
        }
        let mut rows = clean::Rows { time_s, signal, quadrature };
        let mut report = ClockReport { rows: rows.signal.len(), ..ClockReport::default() };
        clean::drop_nonfinite(&mut rows, &mut report);
        clean::check_signal(&rows)?;
        let clock = clean::clock(&mut rows, &mut report, run)?;
        // Checked again, because the run that was kept may be short or constant.
        clean::check_signal(&rows)?;
        Ok(Self::assemble(clock, rows, report))
    }

    fn from_rate(rate_hz: f64, signal: Vec<f64>, quadrature: Option<Vec<f64>>) -> Result<Self, Error> {
        let interval_s = 1.0 / rate_hz;
        if !(rate_hz > 0.0 && rate_hz.is_finite() && interval_s > 0.0 && interval_s.is_finite()) {
            return Err(Error::Parameter { name: "rate_hz", value: rate_hz, range: "positive finite rates" });
        }
        if let Some(quadrature) = &quadrature {
            check_length("quadrature", quadrature.len(), signal.len())?;
        }
        let mut rows = clean::Rows { time_s: Vec::new(), signal, quadrature };
        let mut report = ClockReport { rows: rows.signal.len(), ..ClockReport::default() };
        let used = rows.finite_span();
        let start_s = used.start as f64 * interval_s;
        let inner_missing = used.clone().any(|i| !rows.finite(i));
        if inner_missing {
            rows.time_s = (0..rows.signal.len()).map(|i| i as f64 * interval_s).collect();
        }
        clean::drop_nonfinite(&mut rows, &mut report);
        clean::check_signal(&rows)?;
        let clock = if inner_missing {
            clean::clock(&mut rows, &mut report, None)?
        } else {
            report.median_step_s = interval_s;
            Clock::Uniform { start_s, interval_s }
        };
        Ok(Self::assemble(clock, rows, report))
    }

    fn assemble(clock: Clock, rows: clean::Rows, report: ClockReport) -> Self {
        let kind = if rows.quadrature.is_some() { SignalKind::LockIn } else { SignalKind::default() };
        let clean::Rows { signal, quadrature, .. } = rows;
        Self {
            clock,
            signal,
            quadrature,
            kind,
            unit: String::new(),
            lossy: false,
            turning_gravity: false,
            report,
        }
    }
}

fn check_length(name: &'static str, found: usize, expected: usize) -> Result<(), Error> {
    if found == expected { Ok(()) } else { Err(Error::Length { name, found, expected }) }
}

#[cfg(test)]
mod tests;
