//! Text of each warning.

use super::Warning;
use crate::answer::figures::{self, counted, figures};
use crate::answer::p_value;
use crate::answer::rounded::{Rounded, decay_times, exact_percent, plain, signed_percent};
use std::fmt;

/// Number of standard errors above which the exact number is not stated.
const MOST_ERRORS_TOLD: f64 = 1000.0;

/// A ratio; as a power of ten above a million.
fn multiple(ratio: f64) -> String {
    if ratio < 1e6 { figures(ratio, 2) } else { format!("{:.0e}", ratio.min(f64::MAX)) }
}

/// A relative bias; it cannot be stated if it is not finite.
fn bias(relative: f64) -> String {
    if relative.is_finite() { format!("by {}", signed_percent(relative)) } else { "without limit".into() }
}

/// A difference from the BIC of another model, with its direction: `higher by 1.2`.
fn bic_by(difference: f64) -> String {
    let direction = if difference < 0.0 { "lower" } else { "higher" };
    format!("{direction} by {:.1}", difference.abs())
}

/// A value with its error, formatted as in the report.
fn with_error([value, error]: [f64; 2], unit: &str) -> String {
    Rounded::new(value, error, unit).to_string()
}

/// A number with the given count of significant digits, with a power of ten below a hundredth and above a million.
fn powers(value: f64, digits: i32) -> String {
    let power = value.abs().log10().floor();
    if !power.is_finite() || (-2.0..6.0).contains(&power) {
        return figures(value, digits);
    }
    format!("{}×10{}", figures(value / 10f64.powf(power), digits), superscript(power as i32))
}

fn superscript(number: i32) -> String {
    let digit = |c: char| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c as usize - '0' as usize).unwrap_or(c);
    number.to_string().chars().map(|c| if c == '-' { '⁻' } else { digit(c) }).collect()
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::NotSeparable { correlation, decay_times: Some(recorded) } => write!(
                f,
                "{} recorded: delta and x_F cannot be separated (correlation {correlation:.3})",
                decay_times(*recorded)
            ),
            Warning::NotSeparable { correlation, decay_times: None } => {
                write!(f, "delta and x_F cannot be separated by this curve (correlation {correlation:.3})")
            }
            Warning::TooFewCycles { cycles } => {
                write!(f, "only {cycles:.1} cycles: too few to separate viscous from sliding loss")
            }
            Warning::SeveralModes { main_hz, other_hz, relative_amplitude } => write!(
                f,
                "more than one mode: {} Hz and {} Hz (relative amplitude {})",
                figures(*main_hz, 5),
                figures(*other_hz, 5),
                exact_percent(*relative_amplitude)
            ),
            Warning::SecondMode { main_hz, other_hz, relative_amplitude } => write!(
                f,
                "the record contains a mode at {} Hz and a second one at {} Hz (relative amplitude {}): \
                 the second was fitted and subtracted",
                figures(*main_hz, 5),
                figures(*other_hz, 5),
                exact_percent(*relative_amplitude)
            ),
            Warning::ModelMisfit { ratio, misfit: None } => write!(
                f,
                "residuals are {} times the noise: the loss law holds only approximately; intervals are \
                 widened",
                multiple(*ratio)
            ),
            Warning::ModelMisfit { ratio, misfit: Some(found) } => write!(
                f,
                "the amplitude deviates from the loss law by {} rms ({} at most, at {} s), {} times the \
                 noise; {}; intervals are widened",
                exact_percent(found.relative_rms),
                exact_percent(found.largest),
                figures(found.largest_at_s, 4),
                multiple(*ratio),
                found.shape
            ),
            Warning::FurtherLaw { model, delta_bic, ratio } => write!(
                f,
                "{model}, in which the shape of a loss is fitted, describes the decay better (BIC lower by \
                 {delta_bic:.0}); its residuals are {ratio:.1} times the noise"
            ),
            Warning::NoFreeLaw { amplitudes, needed } => write!(
                f,
                "the loss law could not be determined without a model: it needs {needed} amplitudes of a \
                 falling oscillation, and there are {amplitudes}"
            ),
            Warning::LawChanges { time_s } => {
                write!(f, "the loss follows another law from {} s on", figures(*time_s, 4))
            }
            Warning::SlowTail { amplitude, time_s, unit } => write!(
                f,
                "from {} s on, below {}, the decay is slower than any law of sliding friction predicts \
                 (pre-sliding) and was left out",
                figures(*time_s, 4),
                plain(*amplitude, 2, unit)
            ),
            Warning::Baseline { relative } => write!(
                f,
                "the mean level of the signal drifts along a curve, by {} % of the amplitude: the drift \
                 was subtracted",
                figures(100.0 * relative, 2)
            ),
            Warning::SensorCurve { relative } => write!(
                f,
                "the reading is a nonlinear function of the deflection, by {} % at the first amplitude: \
                 amplitude, x_F and fit are those of the linearised reading",
                figures(100.0 * relative, 2)
            ),
            Warning::SquaredReading { along_pendulum: true } => f.write_str(
                "the mean level of the acceleration follows its amplitude, as it does along a pendulum: \
                 gravity and centripetal acceleration vary there as the square of the deflection, at twice \
                 the frequency of the swing. Frequency, delta and x_F are not those of the swing",
            ),
            Warning::SquaredReading { along_pendulum: false } => f.write_str(
                "the mean level follows the amplitude, as in a signal that is the square of the \
                 deflection, for example a light power: frequency, delta and x_F are then not those of the \
                 deflection",
            ),
            Warning::TurningGravity => f.write_str(
                "the acceleration includes gravity, which turns with the pendulum: a sensor across the \
                 pendulum, at the distance r from the pivot, reads the part 1 - r/L of gravity, with L = \
                 g/omega^2. Frequency, delta and share of sliding friction are those of the swing; \
                 amplitude and x_F are not",
            ),
            Warning::OtherMotion { from_s, to_s } => write!(
                f,
                "another motion, from {} s to {} s, is left out",
                figures(*from_s, 4),
                figures(*to_s, 4)
            ),
            Warning::Spikes { samples, time_s } => {
                let (verb, first) = if *samples == 1 { ("was", "") } else { ("were", "the first ") };
                let counted = counted(*samples, "sample");
                let time = figures(*time_s, 4);
                write!(f, "{counted} far from the neighbouring values {verb} left out, {first}at {time} s")
            }
            Warning::Clipped { samples, inside } => {
                let place = if *inside { "some inside" } else { "all outside" };
                let verb = if *samples == 1 { "is" } else { "are" };
                write!(f, "{} {verb} clipped, {place} the fitted part", counted(*samples, "sample"))
            }
            Warning::AmbiguousModel { chosen, rival, delta_bic } => {
                let how = if *delta_bic < 0.0 { "better than" } else { "as well as" };
                write!(f, "{rival} explains the data {how} {chosen}: its BIC is {}", bic_by(*delta_bic))
            }
            Warning::ModelNotPreferred { asked, preferred, delta_bic } => {
                write!(f, "the data prefer {preferred} to {asked}: its BIC is {}", bic_by(-delta_bic))
            }
            Warning::ModelUndetermined { asked, reported } => {
                write!(f, "the data do not determine all parameters of {asked}: {reported} is reported")
            }
            Warning::LossyCompression { share } => write!(
                f,
                "the recording was compressed with loss, which removes weak signals next to the loudest: \
                 this alone may account for the {} % of the loss that is attributed to sliding friction",
                figures(100.0 * share, 2)
            ),
            Warning::ClockRebuilt { burst_samples, quantum_s, rate_error } => {
                match (burst_samples, quantum_s) {
                    (Some(samples), _) => write!(
                        f,
                        "each time stamp covers a burst of {samples} samples: the samples were spaced \
                         evenly between the stamps"
                    )?,
                    (None, Some(quantum)) => write!(
                        f,
                        "the time stamps are rounded to {} s: they were replaced by the uniform clock \
                         that fits them",
                        figures(*quantum, 2)
                    )?,
                    (None, None) => write!(f, "the clock was rebuilt from the time stamps")?,
                }
                if *rate_error > 0.0 {
                    write!(f, "; its rate, and with it the frequency, is known to {} %", figures(100.0 * rate_error, 1))?;
                }
                Ok(())
            }
            Warning::CoarseSampling { samples_per_cycle } => write!(
                f,
                "{samples_per_cycle:.1} samples per cycle: the frequency may be an alias; the loss is not \
                 affected"
            ),
            Warning::LowQDerivative { quality_factor } => write!(
                f,
                "a velocity or acceleration at a quality factor of {quality_factor:.0} was described by \
                 its amplitudes alone: frequency, delta and x_F may be off by more than their errors"
            ),
            Warning::Disturbance { time_s } => {
                write!(f, "a disturbance at {} s ends the usable decay", figures(*time_s, 4))
            }
            Warning::PhaseStep { time_s, radians } => write!(
                f,
                "the phase jumps by {} rad at {} s, as after a knock; a knock changes the amplitude as \
                 well, so that losses may be off by more than their errors",
                figures(*radians, 2),
                figures(*time_s, 4)
            ),
            Warning::Harmonics { order, relative_amplitude } => write!(
                f,
                "the waveform is not sinusoidal: harmonic {order} has a relative amplitude of {:.0} %; \
                 only the fundamental was fitted (possible causes: nonlinear sensor, end stop, hardening spring)",
                relative_amplitude * 100.0
            ),
            Warning::FrequencyDrift { relative } => write!(
                f,
                "the frequency drifts by {} % along the decay, more than its dependence on the amplitude \
                 explains: a second mode nearby, a turning plane of swing, play in the sensor or a \
                 disturbance may be the cause; the losses may be wrong as well",
                figures(100.0 * relative, 2)
            ),
            Warning::Play { relative_amplitude } => write!(
                f,
                "a third harmonic of {} % of the first amplitude lags in phase and stays constant while \
                 the amplitude falls, as with play or hysteresis between motion and sensor, or with \
                 friction that is not constant: frequency, delta and x_F may be off",
                figures(100.0 * relative_amplitude, 2)
            ),
            Warning::FrequencyUnknown => {
                f.write_str("the record holds only amplitudes, without a frequency: sliding friction is \
                             given as a loss rate")
            }
            Warning::Undetermined { parameter } => write!(f, "the data do not determine {parameter}"),
            Warning::ShapeAlone { friction_ratio: [low, high] } => write!(
                f,
                "the drive amplitude was estimated from the shape of the curve alone: the friction ratio \
                 lies between {low:.2} and {high:.2} (95 %)"
            ),
            Warning::PhaseSign => f.write_str(
                "the phases rise through the resonance (convention e^(-i omega t)) and were conjugated",
            ),
            Warning::PhasesIgnored => f.write_str(
                "the amplitudes fit a resonance but the phases do not (they may be folded, or belong to \
                 another quantity); only the amplitudes were used",
            ),
            Warning::Jump { frequency_hz, hysteresis } => write!(
                f,
                "the amplitude jumps at {} Hz{}: the curve is not single-valued",
                figures(*frequency_hz, 6),
                if *hysteresis { ", at different frequencies in upward and downward sweeps" } else { "" }
            ),
            Warning::SecondPeak { main_hz, other_hz, relative_height } => write!(
                f,
                "a second peak at {} Hz ({:.0} % of the one at {} Hz)",
                figures(*other_hz, 6),
                100.0 * relative_height,
                figures(*main_hz, 6)
            ),
            Warning::OneFlank { below } => write!(
                f,
                "every point lies {} the resonance: frequency, loss and drive are strongly correlated",
                if *below { "below" } else { "above" }
            ),
            Warning::FewPointsInLine { points } => {
                write!(f, "only {} within the width of the peak: its shape is hardly resolved", counted(*points, "point"))
            }
            Warning::Skewed { relative_shift, line_widths } => write!(
                f,
                "the peak is skewed: a Duffing term shifts the frequency by {} line widths (relative shift \
                 {}) at the highest amplitude",
                powers(*line_widths, 2),
                powers(*relative_shift, 2)
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
            Warning::AmplitudeOffset { relative } => write!(
                f,
                "a constant offset of {:.2} % of the highest amplitude in every amplitude was fitted (zero \
                 offset of the detector); phases would separate it from friction",
                100.0 * relative
            ),
            Warning::NoiseFloor { relative } => write!(
                f,
                "a noise floor of {:.2} % of the highest amplitude in every amplitude, added in quadrature, \
                 was fitted; phases would separate it from friction",
                100.0 * relative
            ),
            Warning::RivalInstrument {
                background,
                delay,
                offset,
                floor,
                duffing,
                drag,
                other_minimum,
                delta_bic,
                friction_displacement,
                unit,
            } => {
                let terms = match (duffing, background, delay) {
                    _ if *drag => "drag instead of the fitted terms of the instrument explains",
                    _ if *other_minimum => "another background or delay explains",
                    (Some(true), ..) => "a frequency that shifts with the amplitude (Duffing) explains",
                    (Some(false), ..) => "a frequency that does not shift with the amplitude explains",
                    _ if *offset == Some(true) => "a constant offset of every amplitude (zero offset of \
                                                   the detector) explains",
                    _ if *floor == Some(true) => "a noise floor added in quadrature to every amplitude \
                                                  explains",
                    (None, true, true) => "a background and a delay explain",
                    (None, true, false) => "a background explains",
                    (None, false, true) => "a delay without a background explains",
                    (None, false, false) => "a model without terms of the instrument explains",
                };
                write!(
                    f,
                    "{terms} the curve as well (BIC {}), with x_F = {}; the intervals include it",
                    bic_by(*delta_bic),
                    with_error(*friction_displacement, unit)
                )
            }
            Warning::NoViscousLoss { model } => write!(
                f,
                "{model} describes the curve without any viscous loss, which is unusual for a resonator: a \
                 detector that clips or saturates flattens the peak in the same way, and the losses are \
                 then wrong"
            ),
            Warning::Delay { delay_s } => {
                write!(f, "a delay of {} in the signal chain was fitted", figures::scaled(*delay_s, 3, "s"))
            }
            Warning::NegativeDelay { delay_s, errors } => {
                write!(f, "a delay of {} was fitted, ", figures::scaled(*delay_s, 3, "s"))?;
                if *errors < MOST_ERRORS_TOLD {
                    write!(f, "{}", figures(*errors, 2))?;
                } else {
                    write!(f, "more than {MOST_ERRORS_TOLD}")?;
                }
                f.write_str(
                    " standard errors below zero, but no response can precede its drive: the curve \
                     deviates from the model in another way, for example because an acceleration was read \
                     as a displacement, or because a gain, a background or the drive changes along the \
                     sweep; the losses may be wrong",
                )
            }
            Warning::RunsDiffer { z } => {
                f.write_str("sweeps up and down differ by ")?;
                if *z < MOST_ERRORS_TOLD {
                    write!(f, "{z:.1}")?;
                } else {
                    write!(f, "more than {MOST_ERRORS_TOLD}")?;
                }
                f.write_str(" standard errors: the resonator drifts, or the sweep is too fast")
            }
            Warning::Lag { shift_hz } => {
                write!(
                    f,
                    "the response lags behind the frequency, as in a sweep that is too fast for the \
                     resonator or a low-pass filter: f_0 is off by about {} Hz; wait longer at each point, \
                     or sweep up and down",
                    figures(*shift_hz, 2)
                )
            }
            Warning::ReferenceDiffers { relative_frequency, decay_rate_ratio } => {
                write!(
                    f,
                    "the reference curve may belong to another resonator or setting: its frequency differs \
                     by {:.3} %, ",
                    100.0 * relative_frequency
                )?;
                if decay_rate_ratio.is_finite() {
                    write!(f, "its decay rate is {decay_rate_ratio:.2} times the curve's")
                } else {
                    f.write_str("and the curve has no viscous loss to compare with that of the reference")
                }
            }
            Warning::DriveDiffers { given, by_shape, delta_bic, friction_displacement, unit } => write!(
                f,
                "the shape of the curve alone gives x_0 = {} instead of {}, which explains it {} (BIC \
                 {}), with x_F = {}",
                with_error(*by_shape, unit),
                plain(*given, 3, unit),
                if *delta_bic < 0.0 { "better" } else { "as well" },
                bic_by(*delta_bic),
                with_error(*friction_displacement, unit)
            ),
            Warning::ReferenceGain { ratio, delta_bic, friction_displacement, unit } => write!(
                f,
                "the shape of the curve alone gives {} times the drive of its reference, which explains \
                 both curves {} (BIC {}), with x_F = {}: the x_0 of the reference is valid only at the \
                 same gain and drive",
                figures(*ratio, 3),
                if *delta_bic < 0.0 { "better" } else { "as well" },
                bic_by(*delta_bic),
                with_error(*friction_displacement, unit)
            ),
            Warning::ReferenceSlides { p_value: p } => write!(
                f,
                "the reference curve itself shows sliding friction ({}): x_0 comes out too small",
                p_value(*p)
            ),
            Warning::Stuck { points } => {
                let points = counted(*points, "point");
                write!(f, "at {points} friction stops the mass for part or all of the cycle")
            }
            Warning::PaperBias { friction, q_factor } => write!(
                f,
                "the inversion with a = 4/3 is biased on this curve: friction {}, Q {}; the exact model (the default) \
                 is not",
                bias(*friction),
                bias(*q_factor)
            ),
            Warning::Dropped { not_finite, zero_frequency: 0 } => {
                let verb = if *not_finite == 1 { "was" } else { "were" };
                write!(f, "{} {verb} left out", counted(*not_finite, "non-finite point"))
            }
            Warning::Dropped { not_finite: 0, zero_frequency } => {
                let verb = if *zero_frequency == 1 { "was" } else { "were" };
                write!(f, "{} at frequency zero {verb} left out", counted(*zero_frequency, "point"))
            }
            Warning::Dropped { not_finite, zero_frequency } => {
                let not_finite = counted(*not_finite, "non-finite point");
                let zero = counted(*zero_frequency, "point");
                write!(f, "{not_finite} and {zero} at frequency zero were left out")
            }
            Warning::SearchCut => f.write_str(
                "the search was stopped at its limit of work: there may be a better fit, or a wider interval",
            ),
            Warning::Outliers { points } => {
                let verb = if *points == 1 { "was" } else { "were" };
                write!(f, "{} {verb} left out", counted(*points, "outlier"))
            }
            Warning::ScatteredErrors { scatter, no_fit } => write!(
                f,
                "the standard errors of the points scatter by {:.0} % from one to the next, as errors \
                 estimated from few repeats do, and {}: they were ignored, and the noise was estimated from \
                 the residuals",
                100.0 * scatter,
                if *no_fit { "no fit was found with them" } else { "the residuals do not follow them" }
            ),
            Warning::DriveReadback { scatter, no_fit } => write!(
                f,
                "the measured drive scatters by {:.2} % from point to point and {}: a smoothed drive was used",
                100.0 * scatter,
                if *no_fit { "no fit was found with the drive as read" } else { "the response does not follow it" }
            ),
            Warning::FewLevels { moving } => write!(
                f,
                "the line is fitted to {} that move: so few that their scatter gives its errors only roughly",
                counted(*moving, "level")
            ),
            Warning::ThresholdExtrapolated { ratio } => write!(
                f,
                "every level lies above the threshold (the lowest by a factor of {ratio:.1}): the \
                 threshold is extrapolated along the line"
            ),
            Warning::NotStraight { p_value: p, falling } => write!(
                f,
                "the amplitude does not rise along a straight line ({}): {}",
                p_value(*p),
                if *falling {
                    "the slope falls with the drive, as with drag, a detector that compresses or a detuned \
                     hardening spring; a curve was fitted, and slope and threshold are those at small \
                     amplitudes"
                } else {
                    "the slope rises with the drive (friction may decrease with speed); a curve was \
                     fitted, and slope and threshold are those at small amplitudes"
                }
            ),
            Warning::LevelPlateau { reading, levels, in_squares, unit } => write!(
                f,
                "{} below the threshold {} {} instead of zero (zero offset or noise of the detector): this \
                 was subtracted from every level, {}; the errors include both possibilities",
                counted(*levels, "level"),
                if *levels == 1 { "reads" } else { "read" },
                plain(*reading, 3, unit),
                if *in_squares { "in quadrature" } else { "as a constant" }
            ),
            Warning::AboveZero { reading, p_value: p, unit } => write!(
                f,
                "the line through the levels gives {} at zero drive ({}): a zero offset of the detector, \
                 or a slope that falls, may hide a threshold of up to this size",
                plain(*reading, 3, unit),
                p_value(*p)
            ),
            Warning::DriveUncalibrated => {
                f.write_str(
                    "the drive is not known in the unit of the amplitudes: the threshold is in the unit of the drive",
                )
            }
            Warning::Hysteresis { stuck_at, moving_at, unit } => write!(
                f,
                "the mass sticks at a drive of {} but moves at {}: static friction exceeds sliding friction, \
                 or a level had not settled",
                plain(*stuck_at, 4, unit),
                plain(*moving_at, 4, unit)
            ),
            Warning::Disagree { condition, p_value: p } => {
                write!(f, "{condition}: ring-down and resonance disagree ({})", p_value(*p))
            }
            Warning::NotShared { p_value: p, shared } => {
                let p = p_value(*p);
                if shared.is_empty() {
                    return write!(
                        f,
                        "the joint fit is rejected ({p}): at the same condition ring-down and resonance \
                         give different friction or damping"
                    );
                }
                let ones: Vec<String> = shared.iter().map(|p| format!("one {}", p.label())).collect();
                write!(
                    f,
                    "the joint fit, in which all measurements have {}, is rejected ({p}): they differ by \
                     more than their errors and the scatter of repeats; do not share parameters that change \
                     between the conditions",
                    ones.join(" and ")
                )
            }
            Warning::Failed { name } => write!(f, "{name} could not be analysed; the others were"),
            Warning::NegativeLoad { condition, .. } => write!(
                f,
                "{condition} is a negative load: it was left out of the laws of friction against load"
            ),
            Warning::NotUsed { name, why } => write!(f, "{name} is not in the joint fit: {why}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Parameter;
    use crate::model::loss::LossModel;

    #[test]
    fn a_value_is_rounded_to_its_error() {
        assert_eq!(with_error([3.364e-3, 7.6e-4], "rad"), "3.4 ± 0.8 mrad");
        assert_eq!(with_error([1.2346e-12, 1.4e-15], "m"), "1.2346 ± 0.0014 pm");
        assert_eq!(with_error([3.2e-11, 5e-13], "m"), "32.0 ± 0.5 pm");
        assert_eq!(with_error([2.5, 0.31], ""), "2.50 ± 0.31");
        assert_eq!(with_error([4e5, 0.0], "V"), "400 kV");
    }

    #[test]
    fn a_lean_that_is_hardly_there_keeps_its_digits() {
        let leaning = Warning::Skewed { relative_shift: -6.62e-7, line_widths: -3.17e-3 }.to_string();
        assert!(leaning.contains("by -3.2×10⁻³ line widths (relative shift -6.6×10⁻⁷)"), "{leaning}");
        let leaning = Warning::Skewed { relative_shift: 0.012, line_widths: 0.25 }.to_string();
        assert!(leaning.contains("by 0.25 line widths (relative shift 0.012)"), "{leaning}");
        let delay = Warning::Delay { delay_s: 5.3284e-3 }.to_string();
        assert!(delay.starts_with("a delay of 5.33 ms in"), "{delay}");
    }

    #[test]
    fn numbers_beyond_all_numbers_are_put_in_words() {
        let biased = Warning::PaperBias { friction: 5.67, q_factor: f64::INFINITY }.to_string();
        assert!(biased.contains("friction by +567 %, Q without limit; the exact"), "{biased}");
        let hardly = Warning::PaperBias { friction: -0.002, q_factor: 0.004 }.to_string();
        assert!(hardly.contains("friction by 0 %, Q by 0 %; the exact"), "{hardly}");
        let misfit = |ratio| Warning::ModelMisfit { ratio, misfit: None }.to_string();
        assert!(misfit(f64::INFINITY).starts_with("residuals are 2e308 times the noise"));
        assert!(misfit(34.2).starts_with("residuals are 34 times the noise"));
    }

    #[test]
    fn what_a_joint_fit_shares_is_named() {
        let said = |shared| Warning::NotShared { p_value: 1e-3, shared }.to_string();
        let all = said(vec![Parameter::NaturalFrequency, Parameter::DECAY_RATE]);
        assert!(all.contains("all measurements have one natural frequency and one decay rate"), "{all}");
        assert!(said(Vec::new()).ends_with("ring-down and resonance give different friction or damping"));
    }

    #[test]
    fn a_comparison_of_models_states_which_has_the_lower_bic() {
        let [chosen, rival] = [LossModel::VISCOUS_SLIDING, LossModel::VISCOUS_DRAG];
        let ambiguous = |delta_bic| Warning::AmbiguousModel { chosen, rival, delta_bic }.to_string();
        let data = "viscous+drag explains the data";
        assert_eq!(ambiguous(1.24), format!("{data} as well as viscous+sliding: its BIC is higher by 1.2"));
        assert_eq!(ambiguous(-1.24), format!("{data} better than viscous+sliding: its BIC is lower by 1.2"));
        let asked = Warning::ModelNotPreferred { asked: rival, preferred: chosen, delta_bic: 7.0 };
        let said = "the data prefer viscous+sliding to viscous+drag: its BIC is lower by 7.0";
        assert_eq!(asked.to_string(), said);
    }

    #[test]
    fn levels_of_the_drive_have_their_unit() {
        let sticks = Warning::Hysteresis { stuck_at: 8.0e-3, moving_at: 6.0e-3, unit: "V".to_owned() };
        let start = "the mass sticks at a drive of 8 mV but moves at 6 mV: static";
        assert!(sticks.to_string().starts_with(start), "{sticks}");
    }

    #[test]
    fn a_signal_without_a_unit_leaves_no_gap() {
        let tail = Warning::SlowTail { amplitude: 0.024, time_s: 52.5, unit: String::new() };
        assert!(tail.to_string().contains("below 0.024, the decay"), "{tail}");
    }
}
