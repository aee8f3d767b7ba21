//! Warnings: what limits an answer, and what would help.

use super::hint::Hint;
use super::misfit::Misfit;
use super::p_value;
use super::parameter::Parameter;
use crate::model::loss::LossModel;
use std::fmt;

/// A reason to treat an answer with caution.
///
/// Its text says what was found; [`Warning::hints`] say what helps, naming options by their field, so
/// that each program spells them its own way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Viscous and sliding loss cannot be separated by these data.
    NotSeparable {
        /// Correlation of delta and x_F.
        correlation: f64,
        /// Decay times recorded; `None` for a curve.
        decay_times: Option<f64>,
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
    /// A second mode was fitted and subtracted.
    SecondMode {
        /// Frequency of the stronger one, Hz.
        main_hz: f64,
        /// Frequency of the one subtracted, Hz.
        other_hz: f64,
        /// Its amplitude relative to the stronger one.
        relative_amplitude: f64,
    },
    /// The residual is far above the noise: the law does not hold to this accuracy.
    ModelMisfit {
        /// Residual over the noise.
        ratio: f64,
        /// What it is along a decay, where there are amplitudes enough.
        misfit: Option<Misfit>,
    },
    /// A law whose shape is fitted describes the decay better than those compared.
    FurtherLaw {
        /// The model with it.
        model: LossModel,
        /// Its BIC is lower than that of the best model without it by this.
        delta_bic: f64,
        /// Residual over the noise that it leaves.
        ratio: f64,
    },
    /// The amplitudes give no law without a model.
    NoFreeLaw {
        /// Amplitudes in the free decay.
        amplitudes: usize,
        /// As many are needed.
        needed: usize,
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
        /// Whether some lie inside the fitted window.
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
    /// A change of the signal that no decay makes (a jolt, a new start); the record is used up to it.
    Disturbance {
        /// Its instant, s.
        time_s: f64,
    },
    /// The waveform is far from sinusoidal.
    Harmonics {
        /// Multiple of the frequency.
        order: usize,
        /// Amplitude relative to the fundamental's.
        relative_amplitude: f64,
    },
    /// An amplitude record without its frequency: no friction displacement.
    FrequencyUnknown,
    /// The data set no upper limit to a parameter.
    Undetermined {
        /// The parameter.
        parameter: Parameter,
    },
    /// The drive amplitude is not known: the shape of a curve alone says little about friction.
    ShapeAlone {
        /// Interval of the friction ratio.
        friction_ratio: [f64; 2],
    },
    /// The phases given have the opposite sign and were conjugated.
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
        /// Frequency of the main one, Hz.
        main_hz: f64,
        /// Frequency of the other one, Hz.
        other_hz: f64,
        /// Its height relative to the main one.
        relative_height: f64,
    },
    /// All points lie on one flank of the peak.
    OneFlank {
        /// Whether the points lie below the resonance.
        below: bool,
    },
    /// Too few points within the width of the peak.
    FewPointsInLine {
        /// How many.
        points: usize,
    },
    /// The peak is skewed (Duffing): the frequency depends on the amplitude.
    Leaning {
        /// Relative shift of the frequency at the highest amplitude.
        relative_shift: f64,
        /// The same shift over the full width of the peak.
        line_widths: f64,
    },
    /// A background was added automatically or asked for.
    Background {
        /// Its size over the highest amplitude.
        relative: f64,
        /// Whether phases separate it from friction.
        phases: bool,
    },
    /// Other terms of the instrument than those fitted explain the curve as well, and give other losses.
    RivalInstrument {
        /// They have a background.
        background: bool,
        /// They have a delay.
        delay: bool,
        /// BIC with them above the one reported.
        delta_bic: f64,
        /// Friction displacement with them, and its standard error.
        friction_displacement: [f64; 2],
        /// Unit of the response.
        unit: String,
    },
    /// A delay was added automatically or asked for.
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
    /// The paper's inversion is biased here by this much.
    PaperBias {
        /// Relative bias of the friction.
        friction: f64,
        /// Relative bias of Q.
        q_factor: f64,
    },
    /// Points left out: not finite, or at frequency zero.
    Dropped {
        /// Not finite.
        not_finite: usize,
        /// At frequency zero.
        zero_frequency: usize,
    },
    /// The search for the fit or its intervals was ended after a set amount of work.
    SearchCut,
    /// Outliers left out of the fit.
    Outliers {
        /// How many points.
        points: usize,
    },
    /// No drive level lies below the threshold: it is extrapolated.
    ThresholdExtrapolated {
        /// Lowest level over the threshold.
        ratio: f64,
    },
    /// The amplitude does not rise along a straight line: drag or a nonlinear spring besides.
    Bent {
        /// p value of a straight line.
        p_value: f64,
        /// Whether the slope falls with the drive.
        falling: bool,
    },
    /// Drive and amplitude have different units: no Q and no friction displacement.
    DriveUncalibrated,
    /// Levels at which the mass stuck lie above those at which it moved.
    Hysteresis {
        /// Highest stuck level.
        stuck_at: f64,
        /// Lowest moving level.
        moving_at: f64,
    },
    /// Ring-down and resonance disagree at one condition of a series.
    Disagree {
        /// The condition.
        condition: String,
        /// p value of their agreement.
        p_value: f64,
    },
    /// The measurements of a series do not share the parameters that they should.
    NotShared {
        /// p value of it.
        p_value: f64,
    },
    /// A measurement of a series could not be analysed; the others were.
    Failed {
        /// Its name.
        name: String,
    },
    /// A measurement of a series gives no friction displacement and damping.
    NotUsed {
        /// Its name.
        name: String,
        /// Why.
        why: &'static str,
    },
}

/// A part as a percentage of two digits.
fn percent(part: f64) -> String {
    let digits = (1.0 - (100.0 * part.abs().max(1e-9)).log10().floor()).clamp(0.0, 6.0);
    format!("{:.*} %", digits as usize, 100.0 * part)
}

/// Limits about `main` that leave `other` outside.
fn band_about(main: f64, other: f64, decimals: i32) -> [f64; 2] {
    let reach = 0.4 * (main - other).abs();
    let digits = 10f64.powi(decimals);
    [(main - reach).max(0.1 * main), main + reach].map(|v| (v * digits).round() / digits)
}

impl Warning {
    /// Machine-readable code, as in JSON.
    pub fn code(&self) -> &'static str {
        match self {
            Warning::NotSeparable { .. } => "not_separable",
            Warning::TooFewCycles { .. } => "too_few_cycles",
            Warning::SeveralModes { .. } => "several_modes",
            Warning::SecondMode { .. } => "second_mode",
            Warning::ModelMisfit { .. } => "model_misfit",
            Warning::FurtherLaw { .. } => "further_law",
            Warning::NoFreeLaw { .. } => "no_free_law",
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
            Warning::ShapeAlone { .. } => "shape_alone",
            Warning::PhaseSign => "phase_sign",
            Warning::PhasesIgnored => "phases_ignored",
            Warning::Jump { .. } => "jump",
            Warning::SecondPeak { .. } => "second_peak",
            Warning::OneFlank { .. } => "one_flank",
            Warning::FewPointsInLine { .. } => "few_points_in_line",
            Warning::Leaning { .. } => "leaning",
            Warning::Background { .. } => "background",
            Warning::RivalInstrument { .. } => "rival_instrument",
            Warning::Delay { .. } => "delay",
            Warning::RunsDiffer { .. } => "runs_differ",
            Warning::ReferenceDiffers { .. } => "reference_differs",
            Warning::ReferenceSlides { .. } => "reference_slides",
            Warning::Stuck { .. } => "stuck",
            Warning::PaperBias { .. } => "paper_bias",
            Warning::Dropped { .. } => "dropped",
            Warning::SearchCut => "search_cut",
            Warning::Outliers { .. } => "outliers",
            Warning::ThresholdExtrapolated { .. } => "threshold_extrapolated",
            Warning::Bent { .. } => "bent",
            Warning::DriveUncalibrated => "drive_uncalibrated",
            Warning::Hysteresis { .. } => "hysteresis",
            Warning::Disagree { .. } => "disagree",
            Warning::NotShared { .. } => "not_shared",
            Warning::Failed { .. } => "failed",
            Warning::NotUsed { .. } => "not_used",
        }
    }

    /// What helps: options with values where they are known, or another measurement.
    pub fn hints(&self) -> Vec<Hint> {
        let either = |a: &'static str, b: &'static str, advice: &'static str| {
            vec![Hint::new(a, advice), Hint::new(b, advice)]
        };
        match self {
            Warning::NotSeparable { decay_times: Some(_), .. } => {
                vec![Hint::advice("record down to a smaller amplitude")]
            }
            Warning::NotSeparable { decay_times: None, .. } => {
                let mut hints = either("drive_amplitude", "reference", "separates them");
                hints.push(Hint::advice("so does a sweep at another drive level"));
                hints
            }
            Warning::SeveralModes { main_hz, other_hz, .. }
            | Warning::SecondMode { main_hz, other_hz, .. } => {
                vec![Hint::new("band_hz", "isolates one").with(band_about(*main_hz, *other_hz, 4))]
            }
            Warning::SecondPeak { main_hz, other_hz, .. } => {
                vec![Hint::new("band_hz", "isolates one").with(band_about(*main_hz, *other_hz, 6))]
            }
            Warning::ModelMisfit { misfit: Some(_), .. } => {
                vec![Hint::new("law", "shows the loss without a model").with("free")]
            }
            Warning::FurtherLaw { model, .. } => {
                vec![Hint::new("model", "reports it").with(model.name())]
            }
            Warning::LawChanges { time_s } => vec![
                Hint::new("end_s", "analyses the part before").with((time_s * 1e4).round() / 1e4),
                Hint::new("start_s", "the part after").with((time_s * 1e4).round() / 1e4),
            ],
            Warning::SlowTail { .. } => vec![Hint::new("end_s", "sets the limit by hand")],
            Warning::Clipped { inside: true, .. } => vec![Hint::new("start_s", "skips them")],
            Warning::AmbiguousModel { .. } => vec![Hint::new("model", "chooses")],
            Warning::Disturbance { .. } => either("start_s", "end_s", "chooses by hand"),
            Warning::FrequencyUnknown => {
                vec![Hint::new("frequency_hz", "turns it into a friction displacement")]
            }
            Warning::Undetermined { .. } => vec![Hint::advice("points across the peak would")],
            Warning::ShapeAlone { .. } => either("drive_amplitude", "reference", "narrows it"),
            Warning::RivalInstrument { background, .. } => {
                vec![Hint::new("background", "chooses").with(if *background { "on" } else { "off" })]
            }
            Warning::Jump { .. } => vec![Hint::new("band_hz", "keeps to one branch")],
            Warning::OneFlank { .. } => vec![Hint::advice("measure across the peak")],
            Warning::ThresholdExtrapolated { .. } => vec![Hint::advice("lower levels would show it")],
            Warning::DriveUncalibrated => {
                either("drive_gain", "q_factor", "gives Q and the friction displacement")
            }
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NotSeparable { correlation, decay_times: Some(decay_times) } => write!(
                f,
                "{decay_times:.2} of a decay time recorded: delta and x_F cannot be separated (correlation \
                 {correlation:.4})"
            ),
            Warning::NotSeparable { correlation, decay_times: None } => {
                write!(f, "delta and x_F cannot be separated by this curve (correlation {correlation:.4})")
            }
            Warning::TooFewCycles { cycles } => {
                write!(f, "only {cycles:.1} cycles: too few to separate viscous from sliding loss")
            }
            Warning::SeveralModes { main_hz, other_hz, relative_amplitude } => write!(
                f,
                "more than one mode: {main_hz:.5} Hz and {other_hz:.5} Hz ({:.0} % as strong)",
                relative_amplitude * 100.0
            ),
            Warning::SecondMode { main_hz, other_hz, relative_amplitude } => write!(
                f,
                "beside the mode at {main_hz:.5} Hz a second one at {other_hz:.5} Hz ({:.2} % as strong) was \
                 fitted and subtracted",
                relative_amplitude * 100.0
            ),
            Warning::ModelMisfit { ratio, misfit: None } => write!(
                f,
                "residuals are {ratio:.1} times the noise: the law holds only roughly; intervals are widened"
            ),
            Warning::ModelMisfit { ratio, misfit: Some(found) } => write!(
                f,
                "the amplitude keeps to the law within {} ({} at most, at {:.4} s), {ratio:.1} times the noise: \
                 {}; intervals are widened",
                percent(found.relative_rms),
                percent(found.largest),
                found.largest_at_s,
                found.shape
            ),
            Warning::FurtherLaw { model, delta_bic, ratio } => write!(
                f,
                "{model}, with a loss whose shape is fitted, describes the decay better (BIC lower by {delta_bic:.0}) \
                 and leaves {ratio:.1} times the noise"
            ),
            Warning::NoFreeLaw { amplitudes, needed } => write!(
                f,
                "no law without a model: it takes {needed} amplitudes of a falling oscillation, there are \
                 {amplitudes}"
            ),
            Warning::LawChanges { time_s } => write!(f, "the loss follows another law from {time_s:.4} s on"),
            Warning::SlowTail { amplitude, time_s, unit } => write!(
                f,
                "from {time_s:.4} s on, below {}, the decay is slower than any sliding law gives (pre-sliding) and \
                 was left out",
                format!("{amplitude:.3} {unit}").trim_end()
            ),
            Warning::Clipped { samples, inside } => {
                let place = if *inside { "some inside" } else { "all outside" };
                write!(f, "{samples} samples are clipped, {place} the fitted part")
            }
            Warning::AmbiguousModel { chosen, rival, delta_bic } => {
                write!(f, "{rival} explains the data as well as {chosen} (BIC differs by {delta_bic:.1})")
            }
            Warning::ModelNotPreferred { asked, preferred, delta_bic } => {
                write!(f, "the data prefer {preferred} to {asked} (BIC differs by {delta_bic:.1})")
            }
            Warning::CoarseSampling { samples_per_cycle } => write!(
                f,
                "{samples_per_cycle:.1} samples a cycle: the frequency may be an alias; the loss is not affected"
            ),
            Warning::Disturbance { time_s } => {
                write!(f, "a disturbance at {time_s:.4} s ends the usable decay")
            }
            Warning::Harmonics { order, relative_amplitude } => write!(
                f,
                "the waveform is not sinusoidal: harmonic {order} is {:.0} % of the motion; the fundamental is \
                 fitted (a nonlinear sensor, a stop that is hit, a hardening spring?)",
                relative_amplitude * 100.0
            ),
            Warning::FrequencyUnknown => {
                f.write_str("the record holds amplitudes only: sliding friction is given as a rate of loss")
            }
            Warning::Undetermined { parameter } => write!(f, "the data do not determine {parameter}"),
            Warning::ShapeAlone { friction_ratio: [low, high] } => write!(
                f,
                "the drive amplitude comes from the shape alone, which leaves a friction ratio between {low:.2} and \
                 {high:.2} (95 %)"
            ),
            Warning::PhaseSign => f.write_str(
                "the phases rise through the resonance (convention e^(-i omega t)) and were conjugated",
            ),
            Warning::PhasesIgnored => f.write_str(
                "the phases fit no resonance (folded, or of another quantity) while the amplitudes do; only \
                 amplitudes were used",
            ),
            Warning::Jump { frequency_hz, hysteresis } => write!(
                f,
                "the amplitude jumps at {frequency_hz:.6} Hz{}: not a single-valued curve",
                if *hysteresis { ", at another place up than down" } else { "" }
            ),
            Warning::SecondPeak { main_hz, other_hz, relative_height } => write!(
                f,
                "a second peak at {other_hz:.6} Hz ({:.0} % of the one at {main_hz:.6} Hz)",
                100.0 * relative_height
            ),
            Warning::OneFlank { below } => write!(
                f,
                "every point lies {} the resonance: frequency, loss and drive trade off",
                if *below { "below" } else { "above" }
            ),
            Warning::FewPointsInLine { points } => {
                write!(f, "only {points} points within the width of the peak: its shape is hardly resolved")
            }
            Warning::Leaning { relative_shift, line_widths } => write!(
                f,
                "the peak is skewed: a Duffing term shifts the frequency by {line_widths:.2} line widths \
                 ({relative_shift:.2e} of it) at the highest amplitude"
            ),
            Warning::Background { relative, phases } => write!(
                f,
                "a background (crosstalk) of {:.2} % of the highest amplitude was fitted{}",
                100.0 * relative,
                if *phases {
                    ""
                } else {
                    "; amplitudes alone do not separate it from friction, phases would"
                }
            ),
            Warning::RivalInstrument { background, delay, delta_bic, friction_displacement, unit } => {
                let terms = match (background, delay) {
                    (true, true) => "a background and a delay explain",
                    (true, false) => "a background explains",
                    (false, true) => "a delay without a background explains",
                    (false, false) => "no term of the instrument explains",
                };
                let [value, error] = friction_displacement;
                let text = format!("{value:.3e} ± {error:.1e} {unit}");
                write!(
                    f,
                    "{terms} the curve as well (BIC differs by {:.1}), with x_F = {}; the intervals count it",
                    delta_bic.abs(),
                    text.trim_end()
                )
            }
            Warning::Delay { delay_s } => {
                write!(f, "a delay of {delay_s:.4e} s in the signal chain was fitted")
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
            Warning::ReferenceSlides { p_value: p } => write!(
                f,
                "the reference curve itself shows sliding friction ({}): x_0 comes out too small",
                p_value(*p)
            ),
            Warning::Stuck { points } => {
                write!(f, "{points} points lie where friction holds the mass for all or part of the cycle")
            }
            Warning::PaperBias { friction, q_factor } => write!(
                f,
                "the inversion with a = 4/3 is biased on this curve: friction by {:+.0} %, Q by {:+.0} %; the exact \
                 model (the default) is not",
                100.0 * friction,
                100.0 * q_factor
            ),
            Warning::Dropped { not_finite, zero_frequency: 0 } => {
                write!(f, "left out: {not_finite} non-finite points")
            }
            Warning::Dropped { not_finite: 0, zero_frequency } => {
                write!(f, "left out: {zero_frequency} points at frequency zero")
            }
            Warning::Dropped { not_finite, zero_frequency } => {
                write!(f, "left out: {not_finite} non-finite points, {zero_frequency} at frequency zero")
            }
            Warning::SearchCut => f.write_str(
                "the search was cut after a set amount of work: there may be a better fit, or a wider interval",
            ),
            Warning::Outliers { points } => write!(f, "{points} outliers were left out"),
            Warning::ThresholdExtrapolated { ratio } => write!(
                f,
                "every level lies above the threshold (the lowest {ratio:.1} times): it is extrapolated along the \
                 line"
            ),
            Warning::Bent { p_value: p, falling } => write!(
                f,
                "the amplitude does not rise along a straight line ({}): {}",
                p_value(*p),
                if *falling {
                    "the slope falls with the drive, as drag or a detuned hardening spring make it"
                } else {
                    "the slope rises with the drive; friction may weaken with speed"
                }
            ),
            Warning::DriveUncalibrated => {
                f.write_str("drive levels have a unit of their own: the threshold is given in it")
            }
            Warning::Hysteresis { stuck_at, moving_at } => write!(
                f,
                "stuck at {stuck_at:.4e}, moving at {moving_at:.4e}: static friction above kinetic, or a level not \
                 waited out"
            ),
            Warning::Disagree { condition, p_value: p } => {
                write!(f, "{condition}: ring-down and resonance disagree ({})", p_value(*p))
            }
            Warning::NotShared { p_value: p } => {
                write!(f, "the measurements do not share the parameters that they should ({})", p_value(*p))
            }
            Warning::Failed { name } => write!(f, "{name} could not be analysed; the others were"),
            Warning::NotUsed { name, why } => write!(f, "{name} is not in the joint fit: {why}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::hint::HintValue;

    #[test]
    fn a_band_that_is_advised_leaves_the_other_mode_outside() {
        let band = |main_hz, other_hz| {
            let modes = Warning::SeveralModes { main_hz, other_hz, relative_amplitude: 0.18 };
            modes.hints().remove(0).value
        };
        assert_eq!(band(80.52, 297.667), Some(HintValue::Range([8.052, 167.3788])));
        assert_eq!(band(0.59547, 0.86035), Some(HintValue::Range([0.4895, 0.7014])));
    }

    #[test]
    fn a_signal_without_a_unit_leaves_no_gap() {
        let tail = Warning::SlowTail { amplitude: 0.024, time_s: 52.5, unit: String::new() };
        assert!(tail.to_string().contains("below 0.024, the decay"), "{tail}");
    }
}
