//! Doubts about an answer, each with the flag or the measurement that helps.

use crate::answer::Parameter;
use crate::model::loss::LossModel;
use std::fmt;

/// A doubt about an answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Viscous and sliding loss cannot be told apart on this record.
    NotSeparable {
        /// Correlation of delta and x_F.
        correlation: f64,
        /// Decay times recorded.
        decay_times: f64,
    },
    /// Too few cycles to say anything but the total loss.
    TooFewCycles {
        /// Cycles recorded.
        cycles: f64,
    },
    /// The record holds more than one mode.
    SeveralModes {
        /// Frequency of the main one, Hz.
        main_hz: f64,
        /// Frequency of the strongest other one, Hz.
        other_hz: f64,
        /// Its amplitude relative to the main one.
        relative_amplitude: f64,
    },
    /// The residual is far above the noise: the law does not hold to this accuracy.
    ModelMisfit {
        /// Residual variance of the fundamental over that of the noise.
        excess: f64,
    },
    /// The amplitude lost follows another law in part of the record.
    LawChanges {
        /// Instant of the change, s.
        time_s: f64,
    },
    /// A tail below the sliding threshold that no Coulomb law gives.
    SlowTail {
        /// Amplitude below which the law fails, signal unit.
        amplitude: f64,
        /// Instant where it begins, s.
        time_s: f64,
        /// Signal unit.
        unit: String,
    },
    /// Samples at the rails of the converter.
    Clipped {
        /// How many.
        samples: usize,
        /// Whether some lie inside the fitted segment.
        inside: bool,
    },
    /// Two loss models explain the data equally well.
    AmbiguousModel {
        /// The one reported.
        chosen: LossModel,
        /// Its rival.
        rival: LossModel,
        /// BIC of the rival above the chosen one's.
        delta_bic: f64,
    },
    /// The model asked for is not the one the data prefer.
    ModelNotPreferred {
        /// The one asked for.
        asked: LossModel,
        /// The one preferred.
        preferred: LossModel,
        /// BIC of the one asked for above the preferred one's.
        delta_bic: f64,
    },
    /// Fewer than three samples a cycle: the frequency may be an alias.
    CoarseSampling {
        /// Samples per cycle.
        samples_per_cycle: f64,
    },
    /// A change of the signal that no decay makes (a jolt, a new start); the record is used up to it or from it.
    Disturbance {
        /// Its instant, s.
        time_s: f64,
    },
    /// The oscillation is far from a sinusoid.
    Harmonics {
        /// Multiple of the frequency.
        order: usize,
        /// Amplitude relative to the fundamental's.
        relative_amplitude: f64,
    },
    /// An amplitude record without its frequency: no friction displacement.
    FrequencyUnknown,
    /// An interval was refused: the estimate is not determined.
    Undetermined {
        /// The parameter.
        parameter: Parameter,
    },
}

impl Warning {
    /// Machine-readable code, as in the JSON answer.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::NotSeparable { .. } => "not_separable",
            Warning::TooFewCycles { .. } => "too_few_cycles",
            Warning::SeveralModes { .. } => "several_modes",
            Warning::ModelMisfit { .. } => "model_misfit",
            Warning::LawChanges { .. } => "law_changes",
            Warning::SlowTail { .. } => "slow_tail",
            Warning::Clipped { .. } => "clipped",
            Warning::AmbiguousModel { .. } => "ambiguous_model",
            Warning::ModelNotPreferred { .. } => "model_not_preferred",
            Warning::CoarseSampling { .. } => "coarse_sampling",
            Warning::Disturbance { .. } => "disturbance",
            Warning::Harmonics { .. } => "harmonics",
            Warning::FrequencyUnknown => "frequency_unknown",
            Warning::Undetermined { .. } => "undetermined",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NotSeparable { correlation, decay_times } => write!(
                f,
                "{decay_times:.2} of a decay time recorded: delta and x_F cannot be told apart (correlation \
                 {correlation:.4}); record down to a smaller amplitude"
            ),
            Warning::TooFewCycles { cycles } => {
                write!(f, "only {cycles:.1} cycles: too few to separate viscous from sliding loss")
            }
            Warning::SeveralModes { main_hz, other_hz, relative_amplitude } => write!(
                f,
                "more than one mode: {main_hz:.5} Hz and {other_hz:.5} Hz ({:.0} % as strong); isolate one with \
                 --band {:.4} {:.4}",
                relative_amplitude * 100.0,
                (main_hz - 0.4 * (main_hz - other_hz).abs()).max(0.1 * main_hz),
                main_hz + 0.4 * (main_hz - other_hz).abs()
            ),
            Warning::ModelMisfit { excess } => write!(
                f,
                "residuals are {:.1} times the noise: the law holds only roughly; intervals are widened",
                excess.sqrt()
            ),
            Warning::LawChanges { time_s } => write!(
                f,
                "the loss follows another law from {time_s:.4} s on; compare --end {time_s:.4} with --start \
                 {time_s:.4}"
            ),
            Warning::SlowTail { amplitude, time_s, unit } => write!(
                f,
                "from {time_s:.4} s on, below {}, the decay is slower than any sliding law \
                 gives (pre-sliding); left out (--end sets the limit by hand)",
                format!("{amplitude:.3} {unit}").trim_end()
            ),
            Warning::Clipped { samples, inside } => write!(
                f,
                "{samples} samples are clipped{}",
                if *inside {
                    ", some inside the fitted part; --start skips them"
                } else {
                    " outside the fitted part"
                }
            ),
            Warning::AmbiguousModel { chosen, rival, delta_bic } => write!(
                f,
                "{rival} explains the data as well as {chosen} (BIC differs by {delta_bic:.1}); --model chooses"
            ),
            Warning::ModelNotPreferred { asked, preferred, delta_bic } => {
                write!(f, "the data prefer {preferred} to {asked} (BIC differs by {delta_bic:.1})")
            }
            Warning::CoarseSampling { samples_per_cycle } => write!(
                f,
                "{samples_per_cycle:.1} samples a cycle: the frequency may be an alias; the loss is not affected"
            ),
            Warning::Disturbance { time_s } => {
                write!(
                    f,
                    "a disturbance at {time_s:.4} s ends the usable decay; --start and --end choose by hand"
                )
            }
            Warning::Harmonics { order, relative_amplitude } => write!(
                f,
                "no sinusoid: harmonic {order} is {:.0} % of the motion; what is fitted is its fundamental \
                 (a bent sensor, a stop that is hit, a spring that hardens?)",
                relative_amplitude * 100.0
            ),
            Warning::FrequencyUnknown => f.write_str(
                "the record holds amplitudes only: sliding friction is given as a rate of loss; \
                 --frequency-hz turns it into a friction displacement",
            ),
            Warning::Undetermined { parameter } => {
                write!(f, "the data do not determine {parameter}; a longer record would")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_that_is_advised_can_be_typed() {
        let modes = Warning::SeveralModes { main_hz: 80.52, other_hz: 297.667, relative_amplitude: 0.18 };
        assert!(modes.to_string().ends_with("--band 8.0520 167.3788"), "{modes}");
        let near = Warning::SeveralModes { main_hz: 0.59547, other_hz: 0.86035, relative_amplitude: 0.16 };
        assert!(near.to_string().ends_with("--band 0.4895 0.7014"), "{near}");
    }

    #[test]
    fn a_signal_without_a_unit_leaves_no_gap() {
        let tail = Warning::SlowTail { amplitude: 0.024, time_s: 52.5, unit: String::new() };
        assert!(tail.to_string().contains("below 0.024, the decay"), "{tail}");
    }
}
