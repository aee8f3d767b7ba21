//! Hints for analyses that failed.

use super::hint::{Analysis, Hint};
use crate::Error;
use crate::error::{BEYOND_NUMBERS, FALLS_AS_AMPLITUDES, NO_MORE_THAN_A_LINE};
use crate::model::displacement::Coordinate;

impl Error {
    /// What a person can do about the error in the requested analysis, usually by an option; empty if nothing is known
    /// beyond what the message says.
    ///
    /// ```
    /// use slipfit::{Error, answer::hint::Analysis};
    /// let error = Error::ConstantSignal { value: 0.0 };
    /// assert_eq!(error.hints(Analysis::Ringdown)[0].to_string(), "signal names another column");
    /// ```
    #[must_use]
    pub fn hints(&self, analysis: Analysis) -> Vec<Hint> {
        match self {
            Self::NoOscillation { reason } | Self::NotARingDown { reason, .. }
                if *reason == FALLS_AS_AMPLITUDES =>
            {
                vec![
                    Hint::new("kind", "takes them as amplitudes").with("envelope"),
                    Hint::new("signal", "names another column"),
                ]
            }
            Self::NoOscillation { .. } => vec![
                Hint::new("signal", "names another column"),
                Hint::new("kind", "gives the quantity that it contains"),
                Hint::new("band_hz", "limits the analysis to a range of frequencies"),
            ],
            Self::NoSuchRun { .. } => vec![Hint::new("run", "counts from 1")],
            Self::ConstantSignal { .. } => vec![Hint::new("signal", "names another column")],
            Self::TimeBackwards { .. } | Self::TimeOutOfOrder { .. } | Self::TimeStandsStill { .. } => {
                vec![Hint::new("time", "names another column"), Hint::new("rate_hz", "replaces these times")]
            }
            Self::NotARingDown { .. } | Self::OutsideRecord { .. } => free_decay_by_hand(),
            Self::TooFewSamples { .. } | Self::TooFewPoints { .. } => match analysis {
                Analysis::Ringdown => free_decay_by_hand(),
                Analysis::Resonance => vec![
                    Hint::advice("measure more points across the peak"),
                    Hint::new("background", "needs fewer").with("off"),
                    Hint::new("delay", "needs fewer").with("off"),
                    Hint::new("duffing", "needs fewer").with("off"),
                ],
                Analysis::Levels => {
                    vec![Hint::advice("measure at more levels of the drive, below and above the threshold")]
                }
            },
            // As the reason states, a change of unit helps.
            Self::NoFit { reason } if *reason == BEYOND_NUMBERS => Vec::new(),
            Self::NoFit { .. } => match analysis {
                Analysis::Ringdown => {
                    alternatives(["start_s", "end_s", "band_hz"], "chooses a cleaner part").into()
                }
                Analysis::Resonance => vec![
                    Hint::new("band_hz", "chooses a cleaner part"),
                    Hint::new("model", "chooses another law"),
                ],
                Analysis::Levels => other_columns_of_levels(),
            },
            Self::NoResonance { reason }
                if *reason == NO_MORE_THAN_A_LINE && analysis == Analysis::Resonance =>
            {
                vec![
                    Hint::advice("sweep over several widths of the peak, with ten points or more within it"),
                    Hint::new("band_hz", "limits the analysis to a range of frequencies"),
                ]
            }
            Self::NoResonance { .. } => match analysis {
                Analysis::Levels => other_columns_of_levels(),
                Analysis::Ringdown | Analysis::Resonance => vec![
                    Hint::new("amplitude", "names another column"),
                    Hint::new("frequency_unit", "gives the unit of the frequencies"),
                    Hint::new("band_hz", "limits the analysis to a range of frequencies"),
                ],
            },
            Self::ConflictingParameters { .. } => match analysis {
                Analysis::Resonance => alternatives(["drive_amplitude", "reference"], "is enough").into(),
                Analysis::Ringdown | Analysis::Levels => Vec::new(),
            },
            Self::MissingParameter { name: "drive_amplitude", .. } => {
                alternatives(["drive_amplitude", "reference"], "gives it").into()
            }
            Self::WrongCoordinate { unit, .. } => other_constants(unit),
            // The message is sufficient.
            Self::Parameter { .. }
            | Self::Band { .. }
            | Self::MissingParameter { .. }
            | Self::DoesNotHold { .. }
            | Self::Length { .. }
            | Self::NoSteadyMotion { .. }
            | Self::UnitMismatch { .. }
            | Self::NeitherLengthNorAngle { .. }
            | Self::BelowLeastAmplitude { .. }
            | Self::FrequencyNegative { .. }
            | Self::PointOutOfRange { .. } => Vec::new(),
        }
    }
}

fn alternatives<const N: usize>(options: [&'static str; N], advice: &'static str) -> [Hint; N] {
    options.map(|option| Hint::new(option, advice))
}

fn free_decay_by_hand() -> Vec<Hint> {
    let mut hints = alternatives(["start_s", "end_s"], "chooses the free decay by hand").to_vec();
    hints.push(Hint::advice("a longer record helps more"));
    hints
}

/// The constants that can calibrate a signal in `unit`, or the unit that the given constants require.
fn other_constants(unit: &str) -> Vec<Hint> {
    let angle = |advice: &'static str| ["deg", "rad"].map(|unit| Hint::new("unit", advice).with(unit));
    let read = || Hint::new("unit", "changes the unit read");
    if unit.is_empty() {
        angle("gives the unit of the angle").into()
    } else if Coordinate::Length.check_unit(unit).is_ok() {
        let constants = alternatives(["stiffness", "mass"], "calibrates a displacement");
        [constants, angle("takes the signal as an angle")].concat()
    } else if Coordinate::Angle.check_unit(unit).is_ok() {
        let mut hints = alternatives(["torsion_stiffness", "inertia"], "calibrates an angle").to_vec();
        hints.push(read());
        hints
    } else {
        vec![Hint::advice("a capacitance has no force"), read()]
    }
}

fn other_columns_of_levels() -> Vec<Hint> {
    alternatives(["drive", "amplitude"], "names another column").into()
}
