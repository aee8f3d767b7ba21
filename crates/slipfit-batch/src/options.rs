//! The contents of a table and how it is fitted.

use crate::error::Error;
use slipfit::{SignalKind, ringdown};
use std::collections::HashMap;

/// Options of [`fit_batch`](crate::fit_batch).
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The traces.
    pub signal: Signal,
    /// The times of their samples.
    pub clock: Clock,
    /// Which analysis is made of each trace.
    pub method: Method,
    /// Frequency of the oscillation, Hz, which amplitudes do not contain: without it, sliding friction is given
    /// only as a loss rate.
    pub frequency_hz: Option<Number>,
    /// Amplitudes are used up to the first one below this value, in their unit.
    pub min_amplitude: Option<Number>,
    /// Unit of the traces; empty if unknown. For levels in dB, the unit of the amplitudes they represent.
    pub unit: String,
    /// Whether the traces are levels in dB, which are converted to amplitudes `10^(x/20)`.
    pub levels: bool,
    /// Factors that convert the numbers of a column, by its name, to seconds, Hz or [`Self::unit`]; 1 for any
    /// other column. Durations and dates have a unit of their own.
    pub factors: HashMap<String, f64>,
    /// Options of [`Method::Analyse`], except `frequency_hz` and `min_amplitude`.
    pub ringdown: ringdown::Options,
    /// Columns of the table that are placed before those of the answer.
    pub keep: Vec<String>,
}

/// The columns of the traces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Signal {
    /// Amplitudes of the oscillation.
    Amplitude(String),
    /// X and Y of a lock-in amplifier. [`Method::Fit`] uses their modulus, which noise of `sigma` on each raises
    /// by `sigma²/2A`.
    LockIn(String, String),
    /// The oscillation itself, and which of its quantities was recorded; for [`Method::Analyse`].
    Oscillation(String, SignalKind),
}

impl Signal {
    /// The quantity that was recorded.
    pub(crate) fn kind(&self) -> SignalKind {
        match self {
            Self::Amplitude(_) => SignalKind::Envelope,
            Self::LockIn(..) => SignalKind::LockIn,
            Self::Oscillation(_, kind) => *kind,
        }
    }
}

/// Times of the samples.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Clock {
    /// At a constant interval, s.
    Interval(Number),
    /// At the times, s, given in a column of lists.
    Times(String),
}

/// A number for each row.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Number {
    /// The same number for all rows.
    Same(f64),
    /// The numbers of a column.
    Column(String),
}

/// Which analysis is made of each trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Method {
    /// Viscous and sliding loss fitted to amplitudes, without model comparison.
    #[default]
    Fit,
    /// The whole analysis, [`slipfit::ringdown::analyse`].
    Analyse,
}

impl Options {
    /// Options of the fit of amplitudes at a constant interval, s.
    pub fn fit(signal: Signal, interval_s: Number) -> Self {
        Self::new(signal, Clock::Interval(interval_s), Method::Fit)
    }

    /// Options with only what is needed; all others have their default.
    pub fn new(signal: Signal, clock: Clock, method: Method) -> Self {
        Self {
            signal,
            clock,
            method,
            frequency_hz: None,
            min_amplitude: None,
            unit: String::new(),
            levels: false,
            factors: HashMap::new(),
            ringdown: ringdown::Options::default(),
            keep: Vec::new(),
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let wrong = |option, problem: String| Err(Error::Option { option, problem });
        if self.method == Method::Fit && matches!(self.signal, Signal::Oscillation(..)) {
            let problem = "an oscillation needs the method analyse; fit takes amplitudes, or X and Y";
            return wrong("method", problem.to_owned());
        }
        if self.frequency_hz.is_some() && matches!(self.signal, Signal::Oscillation(..)) {
            let problem = "only for amplitudes, or X and Y; an oscillation has a frequency of its own";
            return wrong("frequency_hz", problem.to_owned());
        }
        if let Signal::Oscillation(name, _) = &self.signal
            && self.ringdown.lockin.is_some()
        {
            let problem = "a filter at the output of a lock-in is for amplitudes, or X and Y";
            return wrong("time_constant_s", format!("{problem}; the signal `{name}` is an oscillation"));
        }
        if self.ringdown.band_hz.is_some() && !matches!(self.signal, Signal::Oscillation(..)) {
            let problem =
                "only for an oscillation; amplitudes, or X and Y, are those of one frequency already";
            return wrong("band_hz", problem.to_owned());
        }
        if self.levels && !matches!(self.signal, Signal::Amplitude(_)) {
            let problem = "levels in dB are those of amplitudes; X, Y and oscillations have signs";
            return wrong("unit", problem.to_owned());
        }
        let traces = match &self.signal {
            Signal::Amplitude(name) | Signal::Oscillation(name, _) => [Some(name), None],
            Signal::LockIn(x, y) => [Some(x), Some(y)],
        };
        if let Clock::Times(name) = &self.clock
            && traces.contains(&Some(name))
        {
            return wrong("time", format!("`{name}` is the column of the traces"));
        }
        let interval = match &self.clock {
            Clock::Interval(number) => Some(number),
            Clock::Times(_) => None,
        };
        let numbers = [
            ("dt", interval),
            ("frequency_hz", self.frequency_hz.as_ref()),
            ("min_amplitude", self.min_amplitude.as_ref()),
        ];
        for (option, number) in numbers {
            if let Some(Number::Same(value)) = number
                && !(*value > 0.0 && value.is_finite())
            {
                return wrong(option, format!("{value} must be a positive number"));
            }
        }
        Ok(())
    }
}
