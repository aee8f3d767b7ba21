//! Doubts about an answer, each with the flag or the measurement that helps.

use crate::answer::Parameter;
use crate::model::loss::LossModel;
use std::fmt;

/// A doubt about an answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The drive amplitude is not known: the shape alone says little about friction.
    ShapeAlone {
        /// Interval of the friction ratio.
        friction_ratio: [f64; 2],
    },
    /// Viscous and sliding loss cannot be told apart on this curve.
    NotSeparable {
        /// Correlation of delta and x_F.
        correlation: f64,
    },
    /// The phases given run the other way and were turned over.
    PhaseSign,
    /// The phases fit no resonance while the amplitudes do: only amplitudes were used.
    PhasesIgnored,
    /// The curve jumps: more than one amplitude at one frequency.
    Jump {
        /// Where, Hz.
        frequency_hz: f64,
        /// Whether up and down sweeps differ.
        hysteresis: bool,
    },
    /// The curve has a second peak.
    SecondPeak {
        /// Of the main one, Hz.
        main_hz: f64,
        /// Of the other one, Hz.
        other_hz: f64,
        /// Its height relative to the main one.
        relative_height: f64,
    },
    /// All points lie on one flank of the line.
    OneFlank {
        /// Whether the points lie below the resonance.
        below: bool,
    },
    /// Too few points within the line.
    FewPointsInLine {
        /// How many.
        points: usize,
    },
    /// The curve leans: a Duffing term was needed.
    Leaning {
        /// Relative shift of the frequency at the highest amplitude.
        relative_shift: f64,
        /// The same shift over the full width of the line.
        line_widths: f64,
    },
    /// A background was needed and fitted.
    Background {
        /// Its size over the highest amplitude.
        relative: f64,
        /// Whether phases tell it from friction.
        phases: bool,
    },
    /// A delay was needed and fitted.
    Delay {
        /// s.
        delay_s: f64,
    },
    /// Up and down sweeps of one file differ.
    RunsDiffer {
        /// Mean difference over its standard error.
        z: f64,
    },
    /// The reference curve belongs to another resonator, or another drive.
    ReferenceDiffers {
        /// Relative difference of the natural frequencies.
        relative_frequency: f64,
        /// Decay rate of the reference over that of the curve.
        decay_rate_ratio: f64,
    },
    /// The reference curve itself shows sliding friction.
    ReferenceSlides {
        /// p value of it.
        p_value: f64,
    },
    /// The drive of some points lies within the friction: the mass sticks there.
    Stuck {
        /// How many points.
        points: usize,
    },
    /// The residual hangs together: the law does not hold to this accuracy.
    ModelMisfit {
        /// Residual over noise.
        excess: f64,
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
    /// The paper's inversion is biased here by this much.
    PaperBias {
        /// Relative bias of the friction, if the drive is known.
        friction: f64,
        /// Relative bias of Q.
        q_factor: f64,
    },
    /// Points left out: no number, or frequency zero.
    Dropped {
        /// No number.
        not_finite: usize,
        /// Frequency zero.
        zero_frequency: usize,
    },
    /// Points left out of the fit because they lie far off.
    Outliers {
        /// How many.
        points: usize,
    },
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
            Warning::ShapeAlone { .. } => "shape_alone",
            Warning::NotSeparable { .. } => "not_separable",
            Warning::PhaseSign => "phase_sign",
            Warning::PhasesIgnored => "phases_ignored",
            Warning::Jump { .. } => "jump",
            Warning::SecondPeak { .. } => "second_peak",
            Warning::OneFlank { .. } => "one_flank",
            Warning::FewPointsInLine { .. } => "few_points_in_line",
            Warning::Leaning { .. } => "leaning",
            Warning::Background { .. } => "background",
            Warning::Delay { .. } => "delay",
            Warning::RunsDiffer { .. } => "runs_differ",
            Warning::ReferenceDiffers { .. } => "reference_differs",
            Warning::ReferenceSlides { .. } => "reference_slides",
            Warning::Stuck { .. } => "stuck",
            Warning::ModelMisfit { .. } => "model_misfit",
            Warning::AmbiguousModel { .. } => "ambiguous_model",
            Warning::ModelNotPreferred { .. } => "model_not_preferred",
            Warning::PaperBias { .. } => "paper_bias",
            Warning::Dropped { .. } => "dropped",
            Warning::Outliers { .. } => "outliers",
            Warning::Undetermined { .. } => "undetermined",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::ShapeAlone { friction_ratio: [low, high] } => write!(
                f,
                "the drive amplitude comes from the shape alone, which leaves a friction ratio between {low:.2} and \
                 {high:.2} (95 %); --drive-amplitude or --reference narrows it"
            ),
            Warning::NotSeparable { correlation } => write!(
                f,
                "delta and x_F cannot be told apart on this curve (correlation {correlation:.4}); \
                 --drive-amplitude or --reference, or a sweep at another drive level, would"
            ),
            Warning::PhaseSign => f.write_str(
                "the phases rise through the resonance (convention e^(-i omega t)); their sign was turned over",
            ),
            Warning::PhasesIgnored => f.write_str(
                "the phases fit no resonance (folded, or of another quantity) while the amplitudes do; only \
                 amplitudes were used",
            ),
            Warning::Jump { frequency_hz, hysteresis } => write!(
                f,
                "the amplitude jumps at {frequency_hz:.6} Hz{}: not a single-valued curve; --band keeps to one \
                 branch",
                if *hysteresis { ", at another place up than down" } else { "" }
            ),
            Warning::SecondPeak { main_hz, other_hz, relative_height } => write!(
                f,
                "a second peak at {other_hz:.6} Hz ({:.0} % of the one at {main_hz:.6} Hz); isolate one with --band \
                 {:.6} {:.6}",
                100.0 * relative_height,
                main_hz - 0.4 * (main_hz - other_hz).abs(),
                main_hz + 0.4 * (main_hz - other_hz).abs()
            ),
            Warning::OneFlank { below } => write!(
                f,
                "every point lies {} the resonance: frequency, loss and drive trade off; measure across the line",
                if *below { "below" } else { "above" }
            ),
            Warning::FewPointsInLine { points } => {
                write!(f, "only {points} points within the width of the line: its shape is hardly seen")
            }
            Warning::Leaning { relative_shift, line_widths } => write!(
                f,
                "the curve leans: a Duffing term shifts the frequency by {:.2} line widths ({:.2e} of it) at the \
                 highest amplitude",
                line_widths, relative_shift
            ),
            Warning::Background { relative, phases } => write!(
                f,
                "a background (crosstalk) of {:.2} % of the highest amplitude was needed and fitted{}",
                100.0 * relative,
                if *phases { "" } else { "; amplitudes alone do not tell such a background from friction, phases would" }
            ),
            Warning::Delay { delay_s } => {
                write!(f, "a delay of {delay_s:.4e} s in the signal chain was needed and fitted")
            }
            Warning::RunsDiffer { z } => {
                write!(f, "sweeps up and down differ by {z:.1} standard errors: drift, or a sweep too fast")
            }
            Warning::ReferenceDiffers { relative_frequency, decay_rate_ratio } => write!(
                f,
                "the reference curve is of another resonator or setting: its frequency differs by {:.3} %, its \
                 decay rate is {decay_rate_ratio:.2} times the curve's",
                100.0 * relative_frequency
            ),
            Warning::ReferenceSlides { p_value } => write!(
                f,
                "the reference curve itself shows sliding friction ({}): x_0 comes out too small",
                crate::answer::p_value(*p_value)
            ),
            Warning::Stuck { points } => {
                write!(f, "{points} points lie where friction holds the mass for all or part of the cycle")
            }
            Warning::ModelMisfit { excess } => write!(
                f,
                "residuals are {excess:.1} times the noise between neighbours: the law holds only roughly; \
                 intervals are widened"
            ),
            Warning::AmbiguousModel { chosen, rival, delta_bic } => write!(
                f,
                "{rival} explains the data as well as {chosen} (BIC differs by {delta_bic:.1}); --model chooses"
            ),
            Warning::ModelNotPreferred { asked, preferred, delta_bic } => {
                write!(f, "the data prefer {preferred} to {asked} (BIC differs by {delta_bic:.1})")
            }
            Warning::PaperBias { friction, q_factor } => write!(
                f,
                "the inversion with a = 4/3 is biased on this curve: friction by {:+.0} %, Q by {:+.0} %; the exact \
                 model (the default) is not",
                100.0 * friction,
                100.0 * q_factor
            ),
            Warning::Dropped { not_finite, zero_frequency: 0 } => {
                write!(f, "left out: {not_finite} points that are no number")
            }
            Warning::Dropped { not_finite: 0, zero_frequency } => {
                write!(f, "left out: {zero_frequency} points at frequency zero")
            }
            Warning::Dropped { not_finite, zero_frequency } => write!(
                f,
                "left out: {not_finite} points that are no number, {zero_frequency} at frequency zero"
            ),
            Warning::Outliers { points } => {
                write!(f, "{points} points lie far off the curve and were left out")
            }
            Warning::Undetermined { parameter } => {
                write!(f, "the data do not determine {parameter}; points across the line would")
            }
        }
    }
}
