//! Errors: why something could not be computed, with the values a user needs to correct the input.

/// Something that could not be computed.
///
/// A fit that converges but describes the data poorly is not an error: it is an answer with warnings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter lies outside its physical range.
    #[error("{}", out_of_range(name, *value, range))]
    Parameter {
        /// The parameter, as the caller names it.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The allowed range, in words or as an interval.
        range: &'static str,
    },
    /// A time limit that excludes the whole record.
    #[error("{name} = {value_s} leaves no samples: the record extends from {from_s} s to {to_s} s")]
    OutsideRecord {
        /// The time, as the caller names it.
        name: &'static str,
        /// The time given (s).
        value_s: f64,
        /// First time stamp (s).
        from_s: f64,
        /// Last time stamp (s).
        to_s: f64,
    },
    /// A parameter that is needed was not given.
    #[error("{name} is missing: {hint}")]
    MissingParameter {
        /// The parameter, as the caller names it.
        name: &'static str,
        /// What could be given instead.
        hint: &'static str,
    },
    /// The same quantity was given twice.
    #[error("{}", conflict(first, second))]
    ConflictingParameters {
        /// The first parameter.
        first: &'static str,
        /// The second, or two that determine the same quantity together, such as `mass and stiffness`.
        second: &'static str,
    },
    /// A method was requested outside its range of validity.
    #[error("{method} is not possible here: {why}")]
    DoesNotHold {
        /// The method.
        method: &'static str,
        /// The condition that fails.
        why: &'static str,
    },
    /// Two arrays that belong together have different lengths.
    #[error("{name} has {found} values where {expected} were expected")]
    Length {
        /// The array.
        name: &'static str,
        /// Its length.
        found: usize,
        /// The length it should have.
        expected: usize,
    },
    /// The record has too few samples to be analysed.
    #[error("{found} usable sample{}; at least {needed} are needed", if *found == 1 { "" } else { "s" })]
    TooFewSamples {
        /// Usable samples found.
        found: usize,
        /// Minimum number of samples.
        needed: usize,
    },
    /// Every sample has the same value: nothing oscillates.
    #[error("the signal is constant ({value}): nothing oscillates")]
    ConstantSignal {
        /// The constant value.
        value: f64,
    },
    /// Time decreases at this sample, or stays constant where it must increase.
    #[error("{}", does_not_rise(*index, *previous, *next))]
    TimeBackwards {
        /// Index of the first invalid sample.
        index: usize,
        /// Time of its predecessor.
        previous: f64,
        /// Time of the sample.
        next: f64,
    },
    /// The rows of a record are not in order of time: they are reversed or shuffled.
    #[error("time goes backwards at sample {index}: {previous} s, then {next} s, {}", out_of_order(*backward, *forward))]
    TimeOutOfOrder {
        /// Index of the first sample that is earlier than its predecessor.
        index: usize,
        /// Time of its predecessor.
        previous: f64,
        /// Time of the sample.
        next: f64,
        /// Number of steps from row to row in which time decreases.
        backward: usize,
        /// Number of steps in which time increases.
        forward: usize,
    },
    /// A frequency band whose limits do not increase.
    #[error(
        "band_hz = {low_hz} {high_hz} is not a rising pair of frequencies: the lower one must come first"
    )]
    Band {
        /// The first frequency given (Hz).
        low_hz: f64,
        /// The second (Hz).
        high_hz: f64,
    },
    /// A run was requested that the record does not have.
    #[error("run = {asked}: the record has {found}")]
    NoSuchRun {
        /// Number of the run requested, from 1.
        asked: usize,
        /// Number of runs in the record.
        found: usize,
    },
    /// All time stamps are equal.
    #[error("time stands still: every stamp is {time_s} s")]
    TimeStandsStill {
        /// The common time.
        time_s: f64,
    },
    /// The record shows no oscillation.
    #[error("no oscillation found: {reason}")]
    NoOscillation {
        /// What was found instead.
        reason: &'static str,
    },
    /// The record oscillates, but has no sufficiently long stretch of free decay.
    #[error("not a ring-down: {}{reason}", too_few(*cycles, *needed))]
    NotARingDown {
        /// Cycles of free decay found.
        cycles: f64,
        /// Minimum number of cycles.
        needed: f64,
        /// What was found.
        reason: &'static str,
    },
    /// A driven record has no sufficiently long steady motion.
    #[error("no steady motion: {cycles:.1} cycles of the drive ({needed} are needed)")]
    NoSteadyMotion {
        /// Cycles found; zero if nothing oscillates.
        cycles: f64,
        /// Minimum number of cycles.
        needed: f64,
    },
    /// A mechanical constant was given for a signal that it cannot calibrate: a constant of a displacement for an
    /// angle, or vice versa.
    #[error("the constant is for {expected}; the signal {}", in_unit(unit))]
    WrongCoordinate {
        /// What the constant is for: a displacement or an angle.
        expected: &'static str,
        /// The unit of the signal.
        unit: String,
    },
    /// A force was given, but the displacements have a unit that a force over a stiffness cannot have.
    #[error(
        "a force divided by a stiffness is a length or an angle, but the unit of the displacement, \
         `{unit}`, is neither"
    )]
    NeitherLengthNorAngle {
        /// The unit of the displacement.
        unit: String,
    },
    /// Two units that cannot be converted into each other.
    #[error("`{found}` cannot be converted to `{expected}`")]
    UnitMismatch {
        /// The unit found.
        found: String,
        /// The unit needed.
        expected: String,
    },
    /// The decay already begins below the minimum amplitude requested.
    #[error("min_amplitude = {least} {unit}: the decay already begins at {initial} {unit}")]
    BelowLeastAmplitude {
        /// The minimum amplitude.
        least: f64,
        /// The amplitude at the start.
        initial: f64,
        /// Unit of both.
        unit: String,
    },
    /// No loss model could be fitted.
    #[error("no loss model could be fitted: {reason}")]
    NoFit {
        /// Why.
        reason: &'static str,
    },
    /// A point of a resonance curve has a negative frequency.
    #[error("point {index} has the frequency {value} Hz, below zero (a shift needs its centre frequency)")]
    FrequencyNegative {
        /// Index of the point.
        index: usize,
        /// Its frequency, Hz.
        value: f64,
    },
    /// A value of one point of a curve is outside its allowed range.
    #[error("point {index}: {}", out_of_range(name, *value, range))]
    PointOutOfRange {
        /// The column.
        name: &'static str,
        /// Index of the point.
        index: usize,
        /// Its value.
        value: f64,
        /// The allowed range.
        range: &'static str,
    },
    /// The curve has fewer points than the model has parameters.
    #[error(
        "{points} points for {parameters} free parameters: at least {} are needed, and more are better",
        parameters + 1
    )]
    TooFewPoints {
        /// Number of points of the curve (a complex point counts as two).
        points: usize,
        /// Free parameters.
        parameters: usize,
    },
    /// The curve shows no resonance.
    #[error("no resonance found: {reason}")]
    NoResonance {
        /// What was found instead.
        reason: &'static str,
    },
}

fn conflict(first: &str, second: &str) -> String {
    if second.contains(" and ") {
        format!("{second} determine {first}, and all three are given: leave one of them out")
    } else {
        format!("{first} and {second} determine the same quantity: give one of them")
    }
}

/// Message about a value outside its range.
pub fn out_of_range(name: &str, value: f64, range: &str) -> String {
    if range == POSITIVE {
        format!("{name} = {value} must be a positive number")
    } else {
        format!("{name} = {value} is outside {range}")
    }
}

/// The part of the message about the number of cycles; empty if there are enough, or none.
fn too_few(cycles: f64, needed: f64) -> String {
    // Not a number if the cycles could not be counted.
    if !(cycles > 0.0 && cycles < needed) {
        return String::new();
    }
    format!("{cycles:.1} cycles of free decay above the noise ({needed} are needed); ")
}

fn does_not_rise(index: usize, previous: f64, next: f64) -> String {
    if next == previous {
        format!("time does not increase at sample {index}: {previous} s twice")
    } else {
        format!("time goes backwards at sample {index}: {previous} s, then {next} s")
    }
}

/// Message about the number of backward steps between rows, and the remedy.
pub fn out_of_order(backward: usize, forward: usize) -> String {
    if forward == 0 {
        "as in every step: the record runs from its end to its start; reverse its rows".to_owned()
    } else {
        format!(
            "as in {backward} of {} steps: the rows are not in order; sort them by time",
            backward + forward
        )
    }
}

fn in_unit(unit: &str) -> String {
    if unit.is_empty() { "has no unit".to_owned() } else { format!("is in {unit}") }
}

/// Range of a number above zero.
pub(crate) const POSITIVE: &str = "the positive numbers";

/// Reason of [`Error::NoResonance`] for points that may be a peak or a straight line.
pub(crate) const NO_MORE_THAN_A_LINE: &str = "a straight line describes the points equally well: if there \
                                              is a peak, the sweep is too narrow or too coarse to show it";

/// Reason of [`Error::NotARingDown`] and [`Error::NoOscillation`] for samples that may be amplitudes.
pub(crate) const FALLS_AS_AMPLITUDES: &str =
    "the samples fall without oscillating and none is negative, as in a record of amplitudes";

/// Reason of [`Error::NoFit`] for numbers outside the range in which a fit is possible.
pub(crate) const BEYOND_NUMBERS: &str = "signal or duration lie outside 1e-60 to 1e60, where powers of \
                                         them exceed the range of numbers; choose another unit";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeated_time_is_told_from_one_that_goes_back() {
        let refusal = |next| Error::TimeBackwards { index: 4, previous: 0.5, next }.to_string();
        assert_eq!(refusal(0.5), "time does not increase at sample 4: 0.5 s twice");
        assert_eq!(refusal(0.25), "time goes backwards at sample 4: 0.5 s, then 0.25 s");
    }

    #[test]
    fn a_reversed_record_is_told_from_an_unsorted_one() {
        let refusal = |backward, forward| {
            Error::TimeOutOfOrder { index: 1, previous: 0.5, next: 0.25, backward, forward }.to_string()
        };
        assert_eq!(
            refusal(9, 0),
            "time goes backwards at sample 1: 0.5 s, then 0.25 s, as in every step: the record runs from its end to \
             its start; reverse its rows"
        );
        assert_eq!(
            refusal(4, 5),
            "time goes backwards at sample 1: 0.5 s, then 0.25 s, as in 4 of 9 steps: the rows are not in \
             order; sort them by time"
        );
    }

    #[test]
    fn of_three_constants_that_determine_each_other_two_are_asked_for() {
        let refusal = |first, second| Error::ConflictingParameters { first, second }.to_string();
        assert_eq!(
            refusal("frequency_hz", "mass and stiffness"),
            "mass and stiffness determine frequency_hz, and all three are given: leave one of them out"
        );
        assert_eq!(
            refusal("q_factor", "zeta"),
            "q_factor and zeta determine the same quantity: give one of them"
        );
    }

    #[test]
    fn enough_cycles_are_not_called_too_few() {
        let refusal = |cycles| Error::NotARingDown { cycles, needed: 2.0, reason: "it grows" }.to_string();
        assert_eq!(refusal(7.8), "not a ring-down: it grows");
        assert_eq!(refusal(0.0), "not a ring-down: it grows");
        assert_eq!(refusal(f64::NAN), "not a ring-down: it grows");
        assert_eq!(
            refusal(1.6),
            "not a ring-down: 1.6 cycles of free decay above the noise (2 are needed); it grows"
        );
    }
}
