//! Thresholds that decide which samples of a record are analysed, and what is subtracted from them.

use crate::inference::criteria::criteria;

criteria! {
    /// Single samples far off their neighbours.
    pub struct SpikeCriteria in "spikes" {
        /// Deviations of the surroundings, or steps of the converter, that a sample lies off its neighbours.
        deviations: f64 = 6.0, source "a sample in 5e8 of normal noise", moves "spread in records with spikes";
        /// Greatest over least step between the stamps about it.
        step_range: f64 = 1.5, source "no gap lies beside it", moves "spread in records with spikes";
        /// Part of the samples that may be spikes.
        most_part: f64 = 0.02, source "one in fifty; more are part of the signal", moves "spread in records with spikes";
        /// Spikes with one value to the last digit that stands for lost samples.
        least_lost: usize = 3, source "noise does not repeat a value once", moves "bias in records with dropouts";
        /// Part of the samples that may be lost.
        most_lost: f64 = 0.1, source "one in ten; more are part of the signal", moves "bias in records with dropouts";
    }
}

criteria! {
    /// A rest in which the steps of the converter hide the motion.
    pub struct ResolutionCriteria in "resolution" {
        /// Steps to either side of the level of a rest within which the motion is hidden.
        steps: f64 = 1.0, source "no friction claimed in 600 viscous decays of 12 to 200 steps, in 155 without a limit",
            moves "false friction in coarse records";
        /// Cycles kept behind the last motion that shows.
        kept_cycles: f64 = 0.5, source "a swing that friction does not stop ends in them", moves "spread after a stop";
        /// Cycles of such a rest at least.
        rest_cycles: f64 = 1.0, source "a shorter rest has few samples that share an error", moves "spread in coarse records";
        /// The last one in so many samples show the level of the rest.
        last_part: usize = 32, source "a rest as long as it takes to see one", moves "false friction in coarse records";
        /// So many of them at least.
        least_last: usize = 8, source "half of them may be noise", moves "false friction in coarse records";
        /// Different values that they take at most.
        most_values: usize = 3, source "noise below half a step reaches the next steps only", moves "false friction in coarse records";
        /// Half cycles before it whose median length is half a period.
        turns: usize = 7, source "half of them may be cut short by the steps", moves "the end of coarse records";
    }
}

criteria! {
    /// A band of frequencies that is asked for.
    pub struct BandCriteria in "band" {
        /// Times `1/(high - low)` within which its filter smears the ends of a record.
        reach: f64 = 4.0, source "the response of the filter has fallen to a tenth", moves "coverage within a band";
        /// What the motion leaves before the start of the decay, over what it leaves behind, that is no motion of the law.
        driven: f64 = 3.0, source "three deviations of noise", moves "coverage within a band";
        /// Modes outside of it, at most, that are fitted and subtracted before the filter.
        modes: usize = 3, source "a neighbour to either side, and hum", moves "coverage within a band";
        /// Rounds, at most, in which what the motion leaves is filtered and the motion fitted again.
        rounds: usize = 12, source "errors at the ends halve from one to the next", moves "coverage within a band";
        /// Part of their standard errors by which the losses change in the last of them.
        settled: f64 = 0.1, source "small against the error that is reported", moves "coverage within a band";
    }
}

criteria! {
    /// A displacement held aside before its release.
    pub struct HeldCriteria in "held" {
        /// Range of the means of its windows, over their distance from the place of rest, at most.
        level_range: f64 = 0.3, source "four deviations of means to 7 % of it", moves "refusals of held records";
        /// Deflection to the other side, over that of the release, that is a swing.
        across: f64 = 0.5, source "three deviations of noise of a sixth of the amplitude", moves "the start of the decay";
        /// Part of the samples before it that may be deflected as far.
        across_part: f64 = 0.01, source "three deviations of normal noise", moves "the start of the decay";
        /// Widest deflection behind it over that of the release.
        widest: f64 = 1.2, source "a release gives no energy; noise", moves "the start of the decay";
        /// Deflection over that of the release at which it is left; the first swing reaches as far to the other side.
        left: f64 = 0.3, source "a fifth of a cycle", moves "the start of the decay";
        /// Length over the time in which it is left, at least: the top of a sine lasts at most twice as long. Within as
        /// much of that time the mass has swung across.
        leaving_times: f64 = 4.0, source "twice the top of a sine", moves "the start of the decay";
        /// Deviations of the noise of the held mass beyond which a sample shows it released.
        release_errors: f64 = 3.0, source "a sample in 400 by chance", moves "the start of the decay";
    }
}

criteria! {
    /// Samples cut off at the ends of a range.
    pub struct ClippingCriteria in "clipping" {
        /// Equal samples in a row at an extreme of the record that count as clipped.
        run: usize = 4, source "chosen by simulation", moves "clipping warnings";
        /// Such runs in a clipped record.
        runs: usize = 3, source "chosen by simulation", moves "clipping warnings";
        /// Samples at the extremes of a record that make them the ends of its range.
        returns: usize = 6, source "chosen by simulation", moves "clipping warnings";
        /// Runs in which they lie.
        return_runs: usize = 4, source "a mass held before its release is one run",
            moves "clipping warnings";
        /// Runs that are enough where one crest after another has one.
        crest_runs: usize = 3, source "half a cycle and its neighbours", moves "clipping warnings";
        /// Equal samples in a row at an extreme that may be a clipped crest, where the fitted motion goes
        /// beyond it.
        cut_run: usize = 2, source "a smooth crest with noise repeats no value", moves "bias after clipping";
        /// Standard deviations of the noise by which it goes beyond, on average.
        cut_errors: f64 = 2.0, source "half a step of a converter is 1.73 of its rounding",
            moves "bias after clipping";
        /// Such runs within the fitted window.
        cut_runs: usize = 2, source "a mass held before its release is one run", moves "bias after clipping";
        /// Gap between two such runs over their mean length, at most.
        gap_ratio: usize = 20, source "a crest that is flat for a tenth of a half cycle",
            moves "clipping warnings";
        /// Samples at that extreme over those at any of the four levels next to it: at most 2.4 for a
        /// steady sinusoid on a converter's steps.
        return_ratio: f64 = 4.0, source "1/(sqrt(2) - 1) = 2.4 for a sinusoid", moves "clipping warnings";
        /// Part of the largest amplitude from which on crests may be clipped.
        from_amplitude: f64 = 0.9, source "chosen by simulation", moves "window start";
        /// Blocks with round crests that end the clipped part.
        round_blocks: usize = 2, source "chosen by simulation", moves "window start";
        /// One in so many clipped blocks is left out behind the last flat one.
        margin_part: usize = 20, source "chosen by simulation", moves "bias after clipping";
        /// Standard deviations of the noise that keep crests behind the clipped ones off the ceiling.
        margin_errors: f64 = 3.0, source "one crest in 700 by chance", moves "bias after clipping";
        /// Converter steps in an amplitude whose crests can be distinguished from flat ones.
        least_steps: f64 = 8.0, source "chosen by simulation", moves "window start";
        /// Length of a flat crest over that of a sinusoid's on the converter's steps.
        plateau_ratio: f64 = 2.5, source "chosen by simulation", moves "window start";
        /// Samples of a flat crest at least.
        plateau_samples: usize = 4, source "chosen by simulation", moves "window start";
        /// Part of the amplitude above which a run of equal samples is a crest.
        plateau_height: f64 = 0.5, source "chosen by simulation", moves "window start";
        /// Flat crests in a clipped block at least.
        plateaus: usize = 2, source "chosen by simulation", moves "window start";
        /// One flat crest in so many cycles of a clipped block at least.
        plateau_cycles: f64 = 8.0, source "chosen by simulation", moves "window start";
        /// A block that touches the ceiling belongs to the clipped ones if it lies at most one in so
        /// many of them behind.
        straggler_part: usize = 5, source "chosen by simulation", moves "window start";
        /// Blocks that must remain after the clipped ones.
        least_after: usize = 8, source "chosen by simulation", moves "window start";
    }
}

criteria! {
    /// A short motion in a record that is quiet for most of its length.
    pub struct ActivePartCriteria in "active_part" {
        /// Variance of the strongest window over the median of all.
        strongest_ratio: f64 = 10.0, source "amplitude over noise of 4", moves "refusals of long records";
        /// Variance over the median from which on a window belongs to the motion.
        active_ratio: f64 = 3.0, source "amplitude over noise of 2", moves "refusals of long records";
        /// Quiet samples kept behind the motion, over its length.
        rest_kept: f64 = 2.0, source "the place of rest is known as well as the motion",
            moves "bias after a stop";
        /// Amplitude over the noise at the end of such a part from which on the motion goes on behind it.
        goes_on: f64 = 4.0, source "a sample in 1e4 by chance", moves "spread at low Q";
        /// Variance of stretches elsewhere, each as long as the part, over that of the part, at most, where the
        /// stretches are not as quiet as the windows.
        elsewhere_ratio: f64 = 0.05, source "a drift of a fifth of the amplitude", moves "refusals of long records";
        /// Most of the record that such a part may be.
        most_of_record: f64 = 0.5, source "chosen by simulation", moves "refusals of long records";
    }
}

criteria! {
    /// A baseline that wanders along a curve.
    pub struct BaselineCriteria in "baseline" {
        /// Cycles of a record at least: in fewer a baseline looks like the decay.
        least_cycles: f64 = 10.0, source "a polynomial and a decay of a cycle each hardly correlate", moves "coverage with drift";
        /// Degree of the polynomial at most.
        most_degree: usize = 16, source "two periods of a sine, to a thousandth", moves "coverage with drift";
        /// Levels for each degree at least.
        levels_per_degree: usize = 3, source "a bend takes three levels", moves "coverage with drift";
        /// Range over the first amplitude from which on a straight or parabolic one is subtracted as well.
        steep: f64 = 1.0, source "the record spans more by it than by the motion", moves "coverage with drift";
        /// Variance that is left over that with the baseline, from which on it is subtracted.
        gain: f64 = 0.5, source "chosen by simulation", moves "coverage with drift";
        /// Range over the first amplitude from which on a baseline is none that a wide swing of another frequency feigns.
        wide: f64 = 0.05, source "a pendulum from 75° feigns 2 %", moves "coverage with drift";
        /// Variance left over that with a wide baseline, from which on it is subtracted: noise that wanders hides what it adds to
        /// the first amplitudes.
        gain_of_wide: f64 = 2.0, source "chosen by simulation", moves "coverage with drift";
        /// Variance within single cycles without such a one over that before, at most.
        noise_of_wide: f64 = 1.1, source "at most 1.1 in 45 simulated drifts; steps, gaps and held frames raise it by more",
            moves "coverage with drift";
        /// Second harmonic in phase with the motion over the change of the level from which on the motion makes it.
        second_harmonic: f64 = 0.25, source "a reading that bends has 1, a spring harder to one side 1/3",
            moves "bias with bent readings";
        /// Standard errors of that harmonic.
        second_harmonic_errors: f64 = 5.0, source "a record in 2e6 by chance", moves "bias with bent readings";
        /// Samples at most.
        most_samples: usize = 300_000, source "the fit of the waveform takes no more", moves "time of analysis";
    }
}

criteria! {
    /// A reading that bends with the deflection.
    pub struct SensorCriteria in "sensor" {
        /// Strongest harmonic over the amplitude from which on a curve is looked for where no motion describes every sample.
        strong_line: f64 = 5e-4, source "bends the amplitude by a part in 700", moves "bias with bent readings";
        /// Samples of a cycle, at least, that show harmonics.
        samples_per_cycle: f64 = 8.0, source "of the third harmonic, more than two", moves "bias with bent readings";
        /// Saturation of a curve that flattens, over its cubic coefficient, where the samples do not determine it.
        saturation: f64 = 1.0, source "a sine has 0.3, a hyperbolic tangent 1.2, x/√(1 + x²) 1.5, an arc tangent 1.8",
            moves "bias with bent readings";
        /// Standard deviation of that.
        saturation_width: f64 = 1.0, source "the same curves, and a cubic, which has none", moves "coverage with bent readings";
        /// Cubic coefficient of a pendulum seen from the side from which on a hidden harmonic is taken for its own, over the one
        /// that its frequency tells; and the standard deviation by which it is held near that one.
        pendulum: f64 = 0.5, source "nearer to the one of a pendulum than to none", moves "bias of tracked pendulums";
        /// Rounds, at most, in which the curve is estimated from what the motion leaves and the motion fitted to the
        /// straightened reading.
        rounds: usize = 12, source "the first takes the amplitude as it is read: of a cubic part of a tenth it makes an eighth",
            moves "bias with bent readings";
        /// Halvings of an estimate, at most, by which the curve does not rise to the highest reading.
        halvings: usize = 5, source "less than a sixteenth is no step", moves "bias with bent readings";
        /// Part of their standard errors by which the odd coefficients move in the last of them, and of a strong line the
        /// quadratic one.
        settled: f64 = 0.1, source "small against the error that is reported", moves "bias with bent readings";
        /// Standard errors of the cubic coefficient of the curve, whose error the intervals count.
        significance: f64 = 3.0, source "a record in 400 by chance", moves "bias with bent readings";
        /// Standard errors of the quadratic one.
        quadratic_significance: f64 = 5.0, source "a record in 2e6 by chance", moves "bias with bent readings";
        /// Third harmonic in phase with the motion over that in quadrature, at least.
        in_phase: f64 = 2.0, source "losses make harmonics in quadrature", moves "bias with bent readings";
        /// Standard errors of the one in quadrature that it may have by chance.
        phase_errors: f64 = 4.0, source "twice two standard errors", moves "bias with bent readings";
        /// Third harmonic over the first amplitude, at most.
        most: f64 = 0.05, source "a cubic gives the sine of 60 degrees to 1 %; beyond it the wave is warned of",
            moves "bias with bent readings";
        /// Third harmonic over the first amplitude, at most, of a curve that saturates.
        most_saturated: f64 = 0.1, source "it gives the hyperbolic tangent of 1.5 to 0.4 %", moves "bias with bent readings";
        /// Third harmonic over the first amplitude from which on a reading that no curve straightens is warned of.
        unstraightened: f64 = 0.01, source "reads an amplitude too small by 3 %", moves "warnings of bent readings";
        /// Standard errors of that harmonic.
        unstraightened_errors: f64 = 5.0, source "a record in 2e6 by chance", moves "warnings of bent readings";
        /// Standard errors from which on friction is told beside a curve.
        friction_errors: f64 = 3.0, source "a side in 700 by chance", moves "false friction with bent readings";
    }
}

criteria! {
    /// A reading of the square of the deflection, whose level follows its amplitude.
    pub struct SquaredReadingCriteria in "squared_reading" {
        /// Levels along the decay at least.
        least_levels: usize = 8, source "four times the unknowns of a line", moves "squared readings unwarned";
        /// Part of the variance of the levels that the amplitudes must explain.
        explained: f64 = 0.8, source "0.88 to 1 in simulated squares at 30 to 50 dB, below 0.3 in displacements", moves "squared readings unwarned";
        /// Slope of the level over the amplitude less one, at most, of a square.
        square_within: f64 = 0.15, source "0.96 to 1.03 in simulated squares", moves "squared readings unwarned";
        /// Slope along a pendulum at least.
        pendulum_least: f64 = 0.1, source "a sensor at 0.61 of the length of the simple pendulum", moves "squared readings unwarned";
        /// Slope along a pendulum at most.
        pendulum_most: f64 = 0.5, source "a sensor at 1.5 times that length", moves "squared readings unwarned";
        /// Part by which the level at rest may differ from the acceleration of gravity.
        gravity_within: f64 = 0.03, source "offsets of accelerometers in telephones reach 2 %", moves "squared readings unwarned";
    }
}

criteria! {
    /// Another motion in the same record, apart from the one analysed.
    pub struct OtherMotionCriteria in "other_motion" {
        /// Root mean square of a cycle, over the first amplitude, from which on it is motion.
        least_amplitude: f64 = 0.1, source "more than hum and drift in a cycle", moves "coverage in records of several releases";
        /// Root mean square of a cycle over the noise from which on it is motion.
        least_noise: f64 = 4.0, source "a cycle of noise exceeds it never", moves "coverage in records of several releases";
        /// Part of that below which it rests.
        quiet: f64 = 0.5, source "a slow fall through the limit is no rest", moves "coverage in records of several releases";
        /// Cycles of rest between two motions.
        rest_cycles: usize = 2, source "beats rest for no longer at once", moves "coverage in records of several releases";
        /// Cycles of another motion, at least.
        least_cycles: usize = 3, source "a jolt is shorter", moves "coverage in records of several releases";
    }
}

criteria! {
    /// A steady line beside the decay, such as hum of the mains.
    pub struct SteadyLineCriteria in "steady_line" {
        /// The last one in so many samples show it.
        part: usize = 3, source "chosen by simulation", moves "refusals of records with hum";
        /// Most samples of a record in which it is looked for.
        most_samples: usize = 300_000, source "chosen by simulation", moves "time of analysis";
        /// Cycles of it that they must hold.
        cycles: f64 = 3.0, source "fewer are a drift of the offset", moves "refusals of records with hum";
        /// Part of their variance that it must explain.
        explained: f64 = 0.5, source "more than all noise", moves "refusals of records with hum";
        /// Part of itself that its amplitude may change by over them.
        change: f64 = 0.1, source "the motion itself falls by more where it was three times as large",
            moves "refusals of records with hum";
        /// Its amplitude over the largest deflection, at most.
        most_amplitude: f64 = 0.3, source "chosen by simulation", moves "refusals of records with hum";
        /// Variance about the motion over the noise of single cycles from which on one is looked for, and by which
        /// that about the motion must fall without it.
        noise: f64 = 4.0, source "twice the noise", moves "coverage of records with hum";
    }
}

criteria! {
    /// The rest after the motion, and where it begins.
    pub struct StopCriteria in "stop" {
        /// Periods without a sample that show a recorder at rest.
        silence_periods: f64 = 3.0, source "chosen by simulation", moves "stops reported";
        /// Periods' worth of samples that may follow the silence.
        samples_after: f64 = 0.5, source "chosen by simulation", moves "stops reported";
        /// Amplitudes of the last block, and errors of a sample, beyond which what follows is another motion.
        another_motion: f64 = 5.0, source "a decay does not grow, and noise lies beyond once in 2e6 samples",
            moves "stops reported";
        /// One in so many samples after the decay shows the place of rest.
        tail_part: usize = 4, source "chosen by simulation", moves "stops reported";
        /// Samples that show the place of rest at least.
        tail_samples: usize = 8, source "chosen by simulation", moves "stops reported";
        /// Periods that the record must go on after the decay.
        tail_periods: f64 = 2.0, source "chosen by simulation", moves "stops reported";
        /// Standard deviations about the place of rest within which the mass rests.
        rest_deviations: f64 = 4.0, source "one sample in 1e4 by chance", moves "time of the stop";
        /// Probability that one of all samples at rest lies further out than the deviations that this gives, if more.
        rest_chance: f64 = 0.01, source "one sample in 1e4 is one in three records of 3000", moves "stops reported";
        /// Deviations at rest that the noise of the motion may take the place of.
        most_deviation: f64 = 3.0, source "chosen by simulation", moves "time of the stop";
        /// Converter steps about the place of rest within which the mass rests.
        rest_steps: f64 = 2.0, source "chosen by simulation", moves "time of the stop";
        /// Periods that a rest must last.
        rest_periods: f64 = 1.5, source "chosen by simulation", moves "stops reported";
        /// Swing before the rest, over the width of the rest, of a motion that stops.
        last_swing: f64 = 3.0, source "chosen by simulation", moves "stops reported";
    }
}
