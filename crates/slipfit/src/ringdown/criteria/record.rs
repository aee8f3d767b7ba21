//! Thresholds for selecting the samples of a record and for subtracting disturbances from them.

use crate::inference::criteria::criteria;

criteria! {
    /// Single samples far from their neighbours.
    pub struct SpikeCriteria in "spikes" {
        /// Deviations of the surroundings, or steps of the converter, by which a spike must differ from its
        /// neighbours.
        deviations: f64 = 6.0, source "a sample in 5e8 of normal noise", moves "spread in records with spikes";
        /// Maximum ratio of the largest to the smallest time step around a spike.
        step_range: f64 = 1.5, source "no gap lies beside it", moves "spread in records with spikes";
        /// Maximum fraction of the samples that may be spikes.
        most_part: f64 = 0.02, source "one in fifty; more are part of the signal", moves "spread in records with spikes";
        /// Minimum number of spikes with exactly the same value for this value to mark dropouts.
        least_lost: usize = 3, source "noise does not repeat a value once", moves "bias in records with dropouts";
        /// Maximum fraction of the samples that may be dropouts.
        most_lost: f64 = 0.1, source "one in ten; more are part of the signal", moves "bias in records with dropouts";
    }
}

criteria! {
    /// A rest in which the steps of the converter hide the motion.
    pub struct ResolutionCriteria in "resolution" {
        /// Steps on either side of the level of a rest within which the motion is hidden.
        steps: f64 = 1.0, source "no friction claimed in 600 viscous decays of 12 to 200 steps, in 155 without a limit",
            moves "false friction in coarse records";
        /// Number of cycles kept after the last visible motion.
        kept_cycles: f64 = 0.5, source "a swing that friction does not stop ends in them", moves "spread after a stop";
        /// Minimum number of cycles of such a rest.
        rest_cycles: f64 = 1.0, source "a shorter rest has few samples that share an error", moves "spread in coarse records";
        /// The last 1/this number of the samples give the level of the rest.
        last_part: usize = 32, source "a rest as long as it takes to see one", moves "false friction in coarse records";
        /// Minimum number of these samples.
        least_last: usize = 8, source "half of them may be noise", moves "false friction in coarse records";
        /// Maximum number of distinct values among them.
        most_values: usize = 3, source "noise below half a step reaches the next steps only", moves "false friction in coarse records";
        /// Maximum number of half cycles before the rest whose median length is taken as half a period.
        turns: usize = 7, source "half of them may be cut short by the steps", moves "the end of coarse records";
    }
}

criteria! {
    /// A requested frequency band.
    pub struct BandCriteria in "band" {
        /// Time, in units of `1/(high - low)`, over which the filter smears the ends of a record.
        reach: f64 = 4.0, source "the response of the filter has fallen to a tenth", moves "coverage within a band";
        /// Ratio of the residuals before the start of the decay to those after it above which the samples
        /// before it are driven.
        driven: f64 = 3.0, source "three deviations of noise", moves "coverage within a band";
        /// Maximum number of modes outside the band that are fitted and subtracted before filtering.
        modes: usize = 3, source "a neighbour to either side, and hum", moves "coverage within a band";
        /// Maximum number of rounds of filtering the residuals and fitting the motion again.
        rounds: usize = 12, source "errors at the ends halve from one to the next", moves "coverage within a band";
        /// Change of the losses, as a fraction of their standard errors, below which the rounds end.
        settled: f64 = 0.1, source "small against the error that is reported", moves "coverage within a band";
    }
}

criteria! {
    /// A displacement held at a deflection before its release.
    pub struct HeldCriteria in "held" {
        /// Maximum range of the means of its windows, relative to their distance from the rest position.
        level_range: f64 = 0.3, source "four deviations of means to 7 % of it", moves "refusals of held records";
        /// Deflection to the other side, relative to that at the release, that counts as an oscillation.
        across: f64 = 0.5, source "three deviations of noise of a sixth of the amplitude", moves "the start of the decay";
        /// Maximum fraction of the samples before the hold with such a deflection.
        across_part: f64 = 0.01, source "three deviations of normal noise", moves "the start of the decay";
        /// Maximum deflection after the hold, relative to that at the release.
        widest: f64 = 1.2, source "a release gives no energy; noise", moves "the start of the decay";
        /// Deflection, relative to that at the release, below which the hold is left; the first half cycle
        /// reaches as far to the other side.
        left: f64 = 0.3, source "a fifth of a cycle", moves "the start of the decay";
        /// Minimum ratio of the length of the hold to the time in which it is left: a crest of a sine lasts
        /// at most twice that time. The mass must reach the other side within the same multiple of that time.
        leaving_times: f64 = 4.0, source "twice the top of a sine", moves "the start of the decay";
        /// Noise deviations of the held mass beyond which a sample counts as released.
        release_errors: f64 = 3.0, source "a sample in 400 by chance", moves "the start of the decay";
    }
}

criteria! {
    /// Samples cut off at the ends of a range.
    pub struct ClippingCriteria in "clipping" {
        /// Number of equal consecutive samples at an extreme of the record that count as clipped.
        run: usize = 4, source "chosen by simulation", moves "clipping warnings";
        /// Minimum number of such runs in a clipped record.
        runs: usize = 3, source "chosen by simulation", moves "clipping warnings";
        /// Minimum number of samples at the extremes of a record for these to be the ends of its range.
        returns: usize = 6, source "chosen by simulation", moves "clipping warnings";
        /// Minimum number of runs that they must form.
        return_runs: usize = 4, source "a mass held before its release is one run",
            moves "clipping warnings";
        /// Minimum number of runs if successive crests have one each.
        crest_runs: usize = 3, source "half a cycle and its neighbours", moves "clipping warnings";
        /// Number of equal consecutive samples at an extreme that may be a clipped crest if the fitted motion
        /// exceeds it.
        cut_run: usize = 2, source "a smooth crest with noise repeats no value", moves "bias after clipping";
        /// Standard deviations of the noise by which it must exceed it on average.
        cut_errors: f64 = 2.0, source "half a step of a converter is 1.73 of its rounding",
            moves "bias after clipping";
        /// Minimum number of such runs within the fitted window.
        cut_runs: usize = 2, source "a mass held before its release is one run", moves "bias after clipping";
        /// Maximum ratio of the gap between two such runs to their mean length.
        gap_ratio: usize = 20, source "a crest that is flat for a tenth of a half cycle",
            moves "clipping warnings";
        /// Minimum ratio of the samples at that extreme to those at any of the four levels next to it: at
        /// most 2.4 for a steady sinusoid quantised in a converter's steps.
        return_ratio: f64 = 4.0, source "1/(sqrt(2) - 1) = 2.4 for a sinusoid", moves "clipping warnings";
        /// Fraction of the largest amplitude above which crests may be clipped.
        from_amplitude: f64 = 0.9, source "chosen by simulation", moves "window start";
        /// Number of blocks with round crests that end the clipped part.
        round_blocks: usize = 2, source "chosen by simulation", moves "window start";
        /// 1/this number of the clipped blocks are left out after the last flat one.
        margin_part: usize = 20, source "chosen by simulation", moves "bias after clipping";
        /// Standard deviations of the noise by which crests after the clipped ones must stay below the
        /// ceiling.
        margin_errors: f64 = 3.0, source "one crest in 700 by chance", moves "bias after clipping";
        /// Minimum amplitude, in converter steps, for distinguishing its crests from flat ones.
        least_steps: f64 = 8.0, source "chosen by simulation", moves "window start";
        /// Minimum ratio of the length of a flat crest to that of a sinusoid quantised in the converter's
        /// steps.
        plateau_ratio: f64 = 2.5, source "chosen by simulation", moves "window start";
        /// Minimum number of samples of a flat crest.
        plateau_samples: usize = 4, source "chosen by simulation", moves "window start";
        /// Fraction of the amplitude above which a run of equal samples is a crest.
        plateau_height: f64 = 0.5, source "chosen by simulation", moves "window start";
        /// Minimum number of flat crests in a clipped block.
        plateaus: usize = 2, source "chosen by simulation", moves "window start";
        /// A clipped block has at least one flat crest per this number of cycles.
        plateau_cycles: f64 = 8.0, source "chosen by simulation", moves "window start";
        /// A block that touches the ceiling belongs to the clipped ones if it follows them within 1/this
        /// number of their count.
        straggler_part: usize = 5, source "chosen by simulation", moves "window start";
        /// Minimum number of blocks that must remain after the clipped ones.
        least_after: usize = 8, source "chosen by simulation", moves "window start";
    }
}

criteria! {
    /// A short motion in a record that is quiet for most of its length.
    pub struct ActivePartCriteria in "active_part" {
        /// Ratio of the variance of the strongest window to the median of all windows.
        strongest_ratio: f64 = 10.0, source "amplitude over noise of 4", moves "refusals of long records";
        /// Ratio of the variance to that median above which a window belongs to the motion.
        active_ratio: f64 = 3.0, source "amplitude over noise of 2", moves "refusals of long records";
        /// Length of the quiet part kept after the motion, relative to the length of the motion.
        rest_kept: f64 = 2.0, source "the place of rest is known as well as the motion",
            moves "bias after a stop";
        /// Ratio of amplitude to noise at the end of such a part above which the motion continues after it.
        goes_on: f64 = 4.0, source "a sample in 1e4 by chance", moves "spread at low Q";
        /// Maximum ratio of the variance of stretches elsewhere, each as long as the part, to that of the
        /// part, if the stretches are not as quiet as the windows.
        elsewhere_ratio: f64 = 0.05, source "a drift of a fifth of the amplitude", moves "refusals of long records";
        /// Maximum fraction of the record for such a part.
        most_of_record: f64 = 0.5, source "chosen by simulation", moves "refusals of long records";
    }
}

criteria! {
    /// A baseline that wanders along a curve.
    pub struct BaselineCriteria in "baseline" {
        /// Minimum number of cycles of a record, since with fewer a baseline resembles the decay.
        least_cycles: f64 = 10.0, source "a polynomial and a decay of a cycle each hardly correlate", moves "coverage with drift";
        /// Maximum degree of the polynomial.
        most_degree: usize = 16, source "two periods of a sine, to a thousandth", moves "coverage with drift";
        /// Minimum number of levels per degree.
        levels_per_degree: usize = 3, source "a bend takes three levels", moves "coverage with drift";
        /// Range relative to the first amplitude above which a straight or parabolic baseline is subtracted
        /// as well.
        steep: f64 = 1.0, source "the record spans more by it than by the motion", moves "coverage with drift";
        /// Ratio of the noise variance after subtraction of a baseline to that before below which it is
        /// subtracted.
        gain: f64 = 0.5, source "chosen by simulation", moves "coverage with drift";
        /// Range relative to the first amplitude above which a baseline cannot be an artefact of a large
        /// oscillation at another frequency.
        wide: f64 = 0.05, source "a pendulum from 75° feigns 2 %", moves "coverage with drift";
        /// Ratio of the noise variance after subtraction to that before below which a wide baseline is
        /// subtracted: wandering noise hides its contribution to the first amplitudes.
        gain_of_wide: f64 = 2.0, source "chosen by simulation", moves "coverage with drift";
        /// Maximum ratio of the variance within single cycles after subtraction of a wide baseline to that
        /// before.
        noise_of_wide: f64 = 1.1, source "at most 1.1 in 45 simulated drifts; steps, gaps and held frames raise it by more",
            moves "coverage with drift";
        /// Ratio of the second harmonic in phase with the motion to the change of the level above which the
        /// motion causes the latter.
        second_harmonic: f64 = 0.25, source "a reading that bends has 1, a spring harder to one side 1/3",
            moves "bias with bent readings";
        /// Standard errors by which that harmonic must be significant.
        second_harmonic_errors: f64 = 5.0, source "a record in 2e6 by chance", moves "bias with bent readings";
        /// Number of samples that determine the levels of a longer record: of more, every second, third, … is
        /// left out.
        most_samples: usize = 300_000, source "the fit of the waveform takes no more", moves "time of analysis";
        /// Minimum number of samples per cycle that are kept.
        samples_per_cycle: f64 = 16.0, source "twice the eight parameters fitted to a cycle",
            moves "time of analysis";
        /// Range of the levels of the cycles, relative to the first amplitude, above which they count as
        /// moving.
        moving: f64 = 2e-3, source "chosen by simulation", moves "coverage with drift, time of analysis";
        /// Standard errors that this range must exceed in addition.
        moving_errors: f64 = 6.0, source "chosen by simulation", moves "coverage with drift, time of analysis";
    }
}

criteria! {
    /// A reading that is a nonlinear function of the deflection.
    pub struct SensorCriteria in "sensor" {
        /// Relative amplitude of the strongest harmonic above which a curve is searched for if no motion
        /// describes every sample.
        strong_line: f64 = 5e-4, source "bends the amplitude by a part in 700", moves "bias with bent readings";
        /// Minimum number of samples per cycle for detecting harmonics.
        samples_per_cycle: f64 = 8.0, source "of the third harmonic, more than two", moves "bias with bent readings";
        /// Expected ratio of the saturation of a flattening curve to its cubic coefficient, used if the
        /// samples do not determine it.
        saturation: f64 = 1.0, source "a sine has 0.3, a hyperbolic tangent 1.2, x/√(1 + x²) 1.5, an arc tangent 1.8",
            moves "bias with bent readings";
        /// Standard deviation of that ratio.
        saturation_width: f64 = 1.0, source "the same curves, and a cubic, which has none", moves "coverage with bent readings";
        /// Fraction of the cubic coefficient of a pendulum, derived from its frequency shift, above which a
        /// hidden harmonic is attributed to a side view of the pendulum; and relative standard deviation with
        /// which the coefficient is constrained.
        pendulum: f64 = 0.5, source "nearer to the one of a pendulum than to none", moves "bias of tracked pendulums";
        /// Maximum number of rounds of estimating the curve from the residuals of the motion and fitting the
        /// motion to the straightened reading.
        rounds: usize = 12, source "the first takes the amplitude as it is read: of a cubic part of a tenth it makes an eighth",
            moves "bias with bent readings";
        /// Maximum number of times that an estimate is halved if the curve does not rise to the highest
        /// reading.
        halvings: usize = 5, source "less than a sixteenth is no step", moves "bias with bent readings";
        /// Change of the odd coefficients, as a fraction of their standard errors, and of the quadratic one,
        /// as a fraction of a strong line, below which the rounds end.
        settled: f64 = 0.1, source "small against the error that is reported", moves "bias with bent readings";
        /// Standard errors of the cubic coefficient above which a curve is accepted; the intervals include
        /// its error.
        significance: f64 = 3.0, source "a record in 400 by chance", moves "bias with bent readings";
        /// The same for the quadratic coefficient.
        quadratic_significance: f64 = 5.0, source "a record in 2e6 by chance", moves "bias with bent readings";
        /// Minimum ratio of the third harmonic in phase with the motion to that in quadrature.
        in_phase: f64 = 2.0, source "losses make harmonics in quadrature", moves "bias with bent readings";
        /// Standard errors of the component in quadrature that it may have by chance.
        phase_errors: f64 = 4.0, source "twice two standard errors", moves "bias with bent readings";
        /// Maximum ratio of the third harmonic to the first amplitude.
        most: f64 = 0.05, source "a cubic gives the sine of 60 degrees to 1 %; beyond it the wave is warned of",
            moves "bias with bent readings";
        /// Maximum ratio of the third harmonic to the first amplitude for a curve that saturates.
        most_saturated: f64 = 0.1, source "it gives the hyperbolic tangent of 1.5 to 0.4 %", moves "bias with bent readings";
        /// Ratio of the third harmonic to the first amplitude above which a reading that no curve straightens
        /// causes a warning.
        unstraightened: f64 = 0.01, source "reads an amplitude too small by 3 %", moves "warnings of bent readings";
        /// Standard errors by which that harmonic must be significant.
        unstraightened_errors: f64 = 5.0, source "a record in 2e6 by chance", moves "warnings of bent readings";
        /// Standard errors above which friction is detected in the presence of a curve.
        friction_errors: f64 = 3.0, source "a side in 700 by chance", moves "false friction with bent readings";
    }
}

criteria! {
    /// A reading of the square of the deflection, whose level follows its amplitude.
    pub struct SquaredReadingCriteria in "squared_reading" {
        /// Minimum number of levels along the decay.
        least_levels: usize = 8, source "four times the unknowns of a line", moves "squared readings unwarned";
        /// Fraction of the variance of the levels that the amplitudes must explain.
        explained: f64 = 0.8, source "0.88 to 1 in simulated squares at 30 to 50 dB, below 0.3 in displacements", moves "squared readings unwarned";
        /// Maximum deviation from one of the slope of the level against the amplitude, for a square.
        square_within: f64 = 0.15, source "0.96 to 1.03 in simulated squares", moves "squared readings unwarned";
        /// Minimum slope for a sensor along a pendulum.
        pendulum_least: f64 = 0.1, source "a sensor at 0.61 of the length of the simple pendulum", moves "squared readings unwarned";
        /// Maximum slope for a sensor along a pendulum.
        pendulum_most: f64 = 0.5, source "a sensor at 1.5 times that length", moves "squared readings unwarned";
        /// Maximum relative difference of the level at rest from the acceleration of gravity.
        gravity_within: f64 = 0.03, source "offsets of accelerometers in telephones reach 2 %", moves "squared readings unwarned";
    }
}

criteria! {
    /// Another motion in the same record, separate from the one analysed.
    pub struct OtherMotionCriteria in "other_motion" {
        /// Root mean square of a cycle, relative to the first amplitude, above which it is motion.
        least_amplitude: f64 = 0.1, source "more than hum and drift in a cycle", moves "coverage in records of several releases";
        /// Ratio of the root mean square of a cycle to the noise above which it is motion.
        least_noise: f64 = 4.0, source "a cycle of noise exceeds it never", moves "coverage in records of several releases";
        /// Fraction of that limit below which a cycle is at rest.
        quiet: f64 = 0.5, source "a slow fall through the limit is no rest", moves "coverage in records of several releases";
        /// Minimum number of cycles of rest between two motions.
        rest_cycles: usize = 2, source "beats rest for no longer at once", moves "coverage in records of several releases";
        /// Minimum number of cycles of another motion.
        least_cycles: usize = 3, source "a jolt is shorter", moves "coverage in records of several releases";
    }
}

criteria! {
    /// A steady line in addition to the decay, such as mains hum.
    pub struct SteadyLineCriteria in "steady_line" {
        /// The line is searched for in the last 1/this number of the samples.
        part: usize = 3, source "chosen by simulation", moves "refusals of records with hum";
        /// Maximum number of samples of a record for this search.
        most_samples: usize = 300_000, source "chosen by simulation", moves "time of analysis";
        /// Minimum number of cycles of the line in them.
        cycles: f64 = 3.0, source "fewer are a drift of the offset", moves "refusals of records with hum";
        /// Fraction of their variance that the line must explain.
        explained: f64 = 0.5, source "more than all noise", moves "refusals of records with hum";
        /// Maximum relative change of its amplitude over them.
        change: f64 = 0.1, source "the motion itself falls by more where it was three times as large",
            moves "refusals of records with hum";
        /// Maximum ratio of its amplitude to the largest deflection.
        most_amplitude: f64 = 0.3, source "chosen by simulation", moves "refusals of records with hum";
        /// Ratio of the variance about the motion to the noise of single cycles above which a line is
        /// searched for, and factor by which its subtraction must reduce the variance.
        noise: f64 = 4.0, source "twice the noise", moves "coverage of records with hum";
    }
}

criteria! {
    /// The rest after the motion, and its start.
    pub struct StopCriteria in "stop" {
        /// Number of periods without a sample that indicate a recorder at rest.
        silence_periods: f64 = 3.0, source "chosen by simulation", moves "stops reported";
        /// Maximum number of samples after the silence, in units of those of one period.
        samples_after: f64 = 0.5, source "chosen by simulation", moves "stops reported";
        /// Amplitudes of the last block, and errors of a sample, beyond which the following samples are
        /// another motion.
        another_motion: f64 = 5.0, source "a decay does not grow, and noise lies beyond once in 2e6 samples",
            moves "stops reported";
        /// The last 1/this number of the samples after the decay give the rest position.
        tail_part: usize = 4, source "chosen by simulation", moves "stops reported";
        /// Minimum number of samples that give the rest position.
        tail_samples: usize = 8, source "chosen by simulation", moves "stops reported";
        /// Number of periods for which the record must continue after the decay.
        tail_periods: f64 = 2.0, source "chosen by simulation", moves "stops reported";
        /// Standard deviations about the rest position within which the mass is at rest.
        rest_deviations: f64 = 4.0, source "one sample in 1e4 by chance", moves "time of the stop";
        /// Probability that any of the samples at rest exceeds the number of standard deviations derived from it; that number
        /// replaces `rest_deviations` if it is larger.
        rest_chance: f64 = 0.01, source "at 4 deviations one rest of 3000 samples in three has one beyond",
            moves "stops reported";
        /// Standard errors above which the level of the rest drifts along a straight line.
        drift_errors: f64 = 4.0, source "one rest in 1e4 by chance", moves "stops reported";
        /// Maximum ratio of the deviation used to that observed at rest, when the noise of the motion is
        /// larger.
        most_deviation: f64 = 3.0, source "chosen by simulation", moves "time of the stop";
        /// Converter steps about the rest position within which the mass is at rest.
        rest_steps: f64 = 2.0, source "chosen by simulation", moves "time of the stop";
        /// Minimum duration of a rest in periods.
        rest_periods: f64 = 1.5, source "chosen by simulation", moves "stops reported";
        /// Minimum ratio of the oscillation before the rest to the width of the rest for a motion that stops.
        last_swing: f64 = 3.0, source "chosen by simulation", moves "stops reported";
    }
}
