//! Options set by the caller before the analysis.

use crate::Error;
use crate::answer::calibration::Calibration;
use crate::error::POSITIVE;
use crate::model::loss::LossModel;

/// Options of [`analyse`](super::analyse). By default everything is determined from the record.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// First instant used, in s on the record's clock.
    pub start_s: Option<f64>,
    /// Last instant used, in s on the record's clock.
    pub end_s: Option<f64>,
    /// Amplitude below which the decay is not followed, in the signal's unit.
    pub min_amplitude: Option<f64>,
    /// Frequency band of the oscillation, in Hz; everything outside it is ignored.
    pub band_hz: Option<[f64; 2]>,
    /// The model to report, whichever one the data prefer.
    pub model: Option<LossModel>,
    /// Whether to also estimate the loss against the amplitude without a model, and of which kind.
    pub law: Option<LawOption>,
    /// Low-pass of the lock-in amplifier that recorded the amplitude.
    pub lockin: Option<LowPass>,
    /// Frequency of the oscillation, Hz, for records that do not show it (a bare amplitude, the outputs of a
    /// lock-in): without it sliding friction can only be given as a rate of loss.
    pub frequency_hz: Option<f64>,
    /// Mechanical constant that turns displacements into forces.
    pub calibration: Option<Calibration>,
}

/// Constraint on a law without a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum LawOption {
    /// Any smooth loss.
    Free,
    /// A loss that increases with the amplitude.
    Rising,
}

impl LawOption {
    /// All options.
    pub const ALL: &[LawOption] = &[Self::Free, Self::Rising];

    /// Name used in options.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Rising => "rising",
        }
    }
}

impl std::str::FromStr for LawOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|law| law.name() == text);
        found.copied().ok_or_else(|| format!("no law `{text}`; one of free, rising"))
    }
}

/// A lock-in's output filter: `order` equal first-order stages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// Time constant of one stage, in s.
    pub time_constant_s: f64,
    /// Number of stages, 1 to 8.
    pub order: u32,
}

impl Options {
    /// Checks that the decay of an answer starts above [`min_amplitude`](Self::min_amplitude); one that
    /// starts below it leaves nothing to fit.
    ///
    /// # Errors
    /// [`Error::BelowLeastAmplitude`].
    pub fn check_reached(&self, answer: &super::Answer) -> Result<(), Error> {
        match (self.min_amplitude, answer.parameter(crate::Parameter::InitialAmplitude)) {
            (Some(least), Some(initial)) if initial.value <= least => Err(Error::BelowLeastAmplitude {
                least,
                initial: initial.value,
                unit: answer.signal_unit.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Checks every given number independently of the record; [`analyse`](super::analyse) calls this first.
    ///
    /// # Errors
    /// [`Error::Parameter`] and [`Error::Band`] with the number that is out of range.
    pub fn check(&self) -> Result<(), Error> {
        let finite = [("start_s", self.start_s), ("end_s", self.end_s)];
        for (name, value) in finite {
            if let Some(value) = value.filter(|v| !v.is_finite()) {
                return Err(Error::Parameter { name, value, range: "finite times" });
            }
        }
        if let (Some(start), Some(end)) = (self.start_s, self.end_s)
            && end <= start
        {
            return Err(Error::Parameter { name: "end_s", value: end, range: "times after start_s" });
        }
        let positive = [
            ("min_amplitude", self.min_amplitude),
            ("frequency_hz", self.frequency_hz),
            ("time_constant_s", self.lockin.map(|l| l.time_constant_s)),
            ("band_hz", self.band_hz.map(|b| b[1])),
        ];
        for (name, value) in positive {
            if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return Err(Error::Parameter { name, value, range: POSITIVE });
            }
        }
        if let Some([low, high]) = self.band_hz.filter(|b| !(b[0] >= 0.0 && b[0] < b[1])) {
            return Err(Error::Band { low_hz: low, high_hz: high });
        }
        if let Some(order) = self.lockin.map(|l| l.order).filter(|o| !(1..=8).contains(o)) {
            return Err(Error::Parameter { name: "order", value: f64::from(order), range: "1 to 8" });
        }
        self.calibration.map_or(Ok(()), Calibration::check)
    }
}
