//! The thresholds used in the analysis of a ring-down.

mod record;

pub use record::{
    ActivePartCriteria, BandCriteria, BaselineCriteria, ClippingCriteria, HeldCriteria, OtherMotionCriteria,
    ResolutionCriteria, SensorCriteria, SpikeCriteria, SquaredReadingCriteria, SteadyLineCriteria,
    StopCriteria,
};

pub use crate::signal::criteria::{PhaseCriteria, SpectrumCriteria};

use super::free_law::criteria::FreeLawCriteria;
use crate::answer::ReportCriteria;
use crate::inference::criteria::{InferenceCriteria, criteria, criteria_groups};

criteria_groups! {
    /// The thresholds of [`analyse_with`](super::analyse_with), grouped by the step in which they are used.
    ///
    /// ```
    /// let mut criteria = slipfit::ringdown::Criteria::default();
    /// criteria.window.rise_ratio = 1.2;
    /// let table = criteria.table();
    /// let row = table.iter().find(|row| row.name == "window.rise_ratio").expect("listed");
    /// assert_eq!(row.value, 1.2);
    /// ```
    pub struct Criteria {
        /// Thresholds shared with the other analyses.
        inference: InferenceCriteria,
        /// The lines of a spectrum.
        spectrum: SpectrumCriteria,
        /// Amplitudes of blocks.
        blocks: BlockCriteria,
        /// The phase of the oscillation.
        phase: PhaseCriteria,
        /// Single samples far from their neighbours.
        spikes: SpikeCriteria,
        /// A rest that the converter does not resolve.
        resolution: ResolutionCriteria,
        /// Blocks with clipped samples.
        clipping: ClippingCriteria,
        /// A requested frequency band.
        band: BandCriteria,
        /// The free decay among the blocks.
        window: WindowCriteria,
        /// The start of the decay.
        lead_in: LeadInCriteria,
        /// Agreement of the waveform with the samples.
        agreement: AgreementCriteria,
        /// The fit of the amplitudes.
        amplitude: AmplitudeCriteria,
        /// The fit of the waveform.
        waveform: WaveformCriteria,
        /// Records of few cycles.
        few_cycles: FewCyclesCriteria,
        /// A displacement held at a deflection before the release.
        held: HeldCriteria,
        /// A curved baseline.
        baseline: BaselineCriteria,
        /// A reading that is a nonlinear function of the deflection.
        sensor: SensorCriteria,
        /// A reading of the square of the deflection.
        squared_reading: SquaredReadingCriteria,
        /// A short motion in a long quiet record.
        active_part: ActivePartCriteria,
        /// Two viscous modes as an alternative to every law of one mode.
        two_modes: TwoModesCriteria,
        /// A steady line in addition to the decay.
        steady_line: SteadyLineCriteria,
        /// Residuals of the amplitudes.
        misfit: MisfitCriteria,
        /// Noise near the frequency of the motion.
        coloured_noise: ColouredNoiseCriteria,
        /// The model-free law.
        free_law: FreeLawCriteria,
        /// The rest after the motion.
        stop: StopCriteria,
        /// Another motion in the same record.
        other_motion: OtherMotionCriteria,
        /// Contents and warnings of the answer.
        answer: AnswerCriteria,
        /// Reported results of the model comparison.
        report: ReportCriteria,
    }
}

criteria! {
    /// Amplitudes of blocks of several cycles along the record.
    pub struct BlockCriteria in "blocks" {
        /// Minimum number of cycles of the free decay.
        least_cycles: f64 = 2.0, source "two loss terms and an amplitude are three unknowns",
            moves "refusals";
        /// Minimum number of blocks for following a decay.
        least_blocks: usize = 3, source "as many amplitudes as unknowns", moves "refusals";
        /// Lowest frequency followed, relative to the dominant one.
        tracking_low: f64 = 0.4, source "chosen by simulation", moves "refusals";
        /// Highest frequency followed, relative to the dominant one.
        tracking_high: f64 = 2.5, source "chosen by simulation", moves "refusals";
        /// Blocks are chosen again for the decay and its surroundings alone if this makes them shorter by at
        /// least this factor.
        recut_factor: f64 = 2.0, source "chosen by simulation", moves "bias in long records";
        /// Relative error of the first amplitude above which longer blocks are used.
        relative_error: f64 = 0.015, source "chosen by simulation", moves "window start and end";
        /// Minimum number of blocks above the noise that longer blocks must leave.
        least_visible: usize = 30, source "chosen by simulation", moves "window start and end";
        /// Standard errors below which the amplitude of a block counts as noise.
        floor_errors: f64 = 4.0, source "one block in 3000 by chance", moves "window end";
        /// Steps of the converter below which an amplitude is not resolved.
        floor_steps: f64 = 1.5, source "chosen by simulation", moves "window end";
        /// Fraction of the largest amplitude below which amplitudes are ignored.
        floor_of_top: f64 = 1e-5, source "chosen by simulation", moves "window end";
        /// Standard errors above which the fall of the amplitude inside a block is measured.
        loss_errors: f64 = 10.0, source "chosen by simulation", moves "bias of late amplitudes";
        /// Number of parts of a record whose medians must fall successively for its samples to be possible
        /// amplitudes.
        recorded_parts: usize = 8, source "chosen by simulation", moves "hints in refusals";
        /// Rise between successive medians that is attributed to noise, relative to the first median.
        recorded_rise: f64 = 0.05, source "noise at the end", moves "hints in refusals";
        /// Maximum ratio of the last median to the first.
        recorded_fall: f64 = 0.5, source "chosen by simulation", moves "hints in refusals";
        /// Maximum number of blocks of a record of amplitudes.
        recorded_blocks: usize = 500, source "chosen by simulation", moves "time of analysis";
        /// The noise floor of an envelope is the amplitude below which 1/this number of its amplitudes lie.
        envelope_floor_fraction: usize = 50, source "chosen by simulation", moves "window end";
        /// Maximum noise floor of an envelope, relative to its largest amplitude.
        envelope_floor_of_top: f64 = 0.2, source "chosen by simulation", moves "window end";
        /// Standard errors by which an envelope must exceed its noise floor.
        envelope_floor_errors: f64 = 2.0, source "chosen by simulation", moves "window end";
        /// Maximum fraction of distinct values among the samples for which the steps of a converter are
        /// recognised.
        distinct_values: f64 = 2.0 / 3.0, source "chosen by simulation",
            moves "window end of coarse records";
        /// Ratio of the mean amplitude of the last third to that of the first third above which a record is
        /// growing.
        growth_ratio: f64 = 1.2, source "chosen by simulation", moves "the reason of a refusal";
    }
}

criteria! {
    /// The free decay among the blocks: a run of falling amplitude, a seed fit inside it, and how far the law
    /// of the seed is extended.
    pub struct WindowCriteria in "window" {
        /// Ratio of the amplitude to the smallest one so far above which a run ends.
        rise_ratio: f64 = 1.1, source "chosen by simulation", moves "window end";
        /// Standard errors that such a rise must exceed in addition.
        rise_errors: f64 = 4.0, source "one block in 1e4 by chance", moves "window end";
        /// Fraction of the largest amplitude above which a block belongs to the top of a run.
        top_ratio: f64 = 0.98, source "chosen by simulation", moves "window start";
        /// Standard errors below that limit within which a block still belongs to the top.
        top_errors: f64 = 3.0, source "chosen by simulation", moves "window start";
        /// Fraction of the top amplitude at which the seed begins.
        seed_from: f64 = 0.9, source "chosen by simulation", moves "window start";
        /// Fraction of its first amplitude at which the seed ends.
        seed_to: f64 = 0.15, source "chosen by simulation", moves "window end";
        /// Minimum number of blocks of a seed.
        seed_least: usize = 5, source "as many amplitudes as fit viscous and sliding loss",
            moves "window end";
        /// Number of blocks of a seed if the amplitude falls fast.
        seed_blocks: usize = 8, source "chosen by simulation", moves "window end";
        /// Minimum number of amplitudes for sliding friction in the law of the seed.
        sliding_from: usize = 5, source "chosen by simulation", moves "window end";
        /// Minimum number of amplitudes for drag in the law of the seed.
        drag_from: usize = 8, source "chosen by simulation", moves "window end";
        /// Assumed error of the law, as a fraction of the amplitude.
        law_error: f64 = 0.01, source "chosen by simulation", moves "window end";
        /// Minimum logarithmic loss between two blocks that indicates that a drive leaking into the signal
        /// was switched off.
        step: f64 = 0.1, source "chosen by simulation", moves "window start";
        /// Minimum ratio of that loss to the median loss of the following blocks.
        step_factor: f64 = 8.0, source "chosen by simulation", moves "window start";
        /// Standard errors by which a block may deviate from the law.
        miss_errors: f64 = 5.0, source "chosen by simulation", moves "window end";
        /// Standard deviations about the law by which a block may deviate from it in addition.
        miss_deviations: f64 = 2.0, source "chosen by simulation", moves "window end";
        /// Maximum ratio of the scatter about the law to its errors that enters the tolerance.
        most_scatter: f64 = 20.0, source "chosen by simulation", moves "window end";
        /// Fraction of the amplitude by which later blocks may deviate from the law.
        later_tolerance: f64 = 0.3, source "chosen by simulation", moves "window end";
        /// Fraction of the amplitude by which the last blocks before the end of the law may deviate from it.
        last_tolerance: f64 = 0.08, source "chosen by simulation", moves "window end";
        /// Fraction of the amplitude by which earlier blocks may deviate from the law.
        earlier_tolerance: f64 = 0.02, source "chosen by simulation", moves "window start";
        /// Number of consecutive deviating blocks that end the law.
        misses: usize = 3, source "chosen by simulation", moves "window end";
        /// Number of blocks of a decay above which two blocks instead of one are left out next to a lead-in.
        lead_in_margin: usize = 20, source "chosen by simulation", moves "window start";
        /// Ratio of the amplitude some blocks before the end to the noise floor above which a motion counts
        /// as stopped.
        stop_ratio: f64 = 4.0, source "chosen by simulation", moves "end reason";
        /// Number of blocks within which the amplitude falls to zero at a stop.
        stop_blocks: usize = 3, source "chosen by simulation", moves "end reason";
        /// Standard errors that the predicted amplitude of a block inside the noise must reach.
        noise_prediction: f64 = 0.3, source "chosen by simulation", moves "window end";
        /// Standard errors by which a block inside the noise may deviate from the law.
        noise_errors: f64 = 4.0, source "one block in 1e4 by chance", moves "window end";
        /// Minimum number of blocks on each side of a change of law.
        kink_blocks: usize = 30, source "chosen by simulation", moves "window end";
        /// Ratio of residual to noise variance above which a change of law is searched for.
        kink_excess: f64 = 100.0, source "ten times the noise", moves "window end";
        /// Maximum ratio of residual to noise variance of the earlier law.
        kink_earlier: f64 = 4.0, source "twice the noise", moves "window end";
        /// Factor by which a change of law must lower the residual variance.
        kink_gain: f64 = 5.0, source "chosen by simulation", moves "window end";
    }
}

criteria! {
    /// First blocks that still belong to a drive.
    pub struct LeadInCriteria in "lead_in" {
        /// Minimum number of blocks of a decay whose law is extrapolated to its start.
        least_blocks: usize = 60, source "chosen by simulation", moves "window start";
        /// The first 1/this number of the blocks are left out of the extrapolated law and tested.
        tested_part: usize = 3, source "chosen by simulation", moves "window start";
        /// Ratio of residual to noise variance above which the law gives no evidence of a drive.
        most_excess: f64 = 4.0, source "twice the noise", moves "window start";
        /// Number of consecutive blocks that are tested together.
        run: usize = 8, source "chosen by simulation", moves "window start";
        /// Standard errors by which the mean of a run may deviate from the law.
        run_errors: f64 = 4.0, source "one run in 1e4 by chance", moves "window start";
        /// Standard errors by which a block may deviate from the law.
        block_errors: f64 = 4.5, source "one block in 1e5 by chance", moves "window start";
        /// At most 1/this number of the blocks may belong to a drive.
        most_part: usize = 6, source "chosen by simulation", moves "window start";
        /// 1/this number of the blocks, and at least two, are left out after the deviating run.
        margin_part: usize = 60, source "chosen by simulation", moves "window start";
        /// Minimum number of blocks of a decay of which the first may be left out to fit the waveform.
        spare_blocks: usize = 40, source "chosen by simulation", moves "window start";
    }
}

criteria! {
    /// Whether the residuals of a motion are noise.
    pub struct AgreementCriteria in "agreement" {
        /// Standard errors by which the residual variance may exceed that of the noise.
        scatter_errors: f64 = 4.0, source "one record in 1e4 by chance", moves "window start and end";
        /// Standard errors of the residual fundamental allowed in a block or in a run of blocks.
        fundamental_errors: f64 = 4.5, source "one block in 1e5 by chance",
            moves "window start and end";
        /// Number of consecutive blocks that are tested together.
        run: usize = 8, source "chosen by simulation", moves "window start and end";
        /// Fraction of the first amplitude below which the decay is not followed further.
        least_amplitude: f64 = 2e-3, source "smaller amplitudes carry no information",
            moves "window end";
        /// Friction displacements below which the decay is not followed further.
        least_frictions: f64 = 1.2, source "the last swing before a stop", moves "window end";
    }
}

criteria! {
    /// The fit of the amplitudes.
    pub struct AmplitudeCriteria in "amplitude" {
        /// Ratio of the last to the first amplitude below which the noise floor of an envelope is fitted.
        floor_visible: f64 = 0.2, source "chosen by simulation", moves "bias of envelopes";
        /// Ratio of residual to noise variance above which the scatter between clusters of amplitudes is
        /// attributed to a missing law rather than to unequal errors.
        most_cluster_excess: f64 = 30.0, source "chosen by simulation: noise thirty times as loud at the start leaves 20",
            moves "coverage where noise changes along the decay, loss terms chosen";
        /// Minimum amplitude to which the relative error of the law refers, as a fraction of the first one.
        law_error_base: f64 = 0.05, source "chosen by simulation", moves "bias where the law is off";
        /// Robust standard deviations beyond which a block is an outlier.
        outlier_deviations: f64 = 8.0, source "chosen by simulation", moves "spread with glitches";
        /// At most 1/this number of the blocks may be outliers.
        outlier_part: usize = 10, source "chosen by simulation", moves "spread with glitches";
        /// Number of blocks in addition to the number of parameters required for outlier rejection.
        outlier_spare: usize = 6, source "chosen by simulation", moves "spread with glitches";
        /// Friction displacements below which the averaged law does not hold.
        least_frictions: f64 = 2.0, source "below two x_F the motion is no ellipse",
            moves "bias of x_F";
        /// Minimum number of amplitudes for finding the end of the law.
        rest_blocks: usize = 8, source "chosen by simulation", moves "bias of x_F";
        /// Minimum number of amplitudes kept before the end of the law.
        rest_kept: usize = 6, source "chosen by simulation", moves "bias of x_F";
    }
}

criteria! {
    /// The fit of the waveform.
    pub struct WaveformCriteria in "waveform" {
        /// Phase before and after a turning point, rad, within which samples of an acceleration are excluded,
        /// since friction makes it jump there.
        turn_guard: f64 = 0.05, source "x_F off by up to 2 standard errors without, by none with it, in simulated accelerations",
            moves "bias of friction in accelerations";
        /// Standard errors of an amplitude, computed from all samples shared by six parameters, that `x_F`
        /// must exceed for the rest position to determine the last half cycle: half cycles end `2 x_F` apart.
        rest_errors: f64 = 8.0, source "chosen by simulation", moves "bias after a stop";
        /// Maximum number of samples of a window; beyond it the blocks contain the same information.
        most_samples: usize = 300_000, source "chosen by simulation", moves "time of analysis";
        /// Maximum number of samples if a further law, which holds for the cycle average, is requested.
        most_samples_further: usize = 50_000, source "an analysis within two seconds", moves "time of analysis";
        /// Minimum loss per cycle, as a fraction of the amplitude.
        least_loss: f64 = 1e-3, source "with less the motion is an ellipse to 1e-4",
            moves "time of analysis";
        /// Ratio of residual to noise variance above which the phase counts as wandering.
        most_excess: f64 = 4.0, source "twice the noise", moves "the method chosen";
        /// Maximum ratio of residual to noise variance for the waveform to describe the samples.
        variance_ratio: f64 = 1.3, source "chosen by simulation", moves "the method chosen";
        /// Maximum number of samples for which a motion that may stop in the window is fitted from several
        /// starts even if the residuals of the first fit are noise.
        multi_start_samples: usize = 20_000, source "0 of 20 000 simulated records in another minimum",
            moves "coverage, time of analysis";
        /// Noise variances by which the sum of squares of every motion with another last half cycle must
        /// exceed the lowest one for the last half cycle to be known.
        last_swing_variances: f64 = 12.0, source "a likelihood ratio of 400", moves "coverage after a stop";
        /// Standard errors of the friction displacement, from the motion before the rest, within which
        /// another last half cycle is searched for.
        last_swing_errors: f64 = 4.0, source "a side in 3e4 by chance", moves "coverage after a stop";
        /// Factor on the significance of an excess above which the phase is taken to wander.
        wandering_significance: f64 = 2.0, source "chosen by simulation",
            moves "coverage where the phase walks";
        /// Maximum common rounding error of the samples of a rest, relative to the standard error of their
        /// level, for the level to be used.
        rounding_of_rest: f64 = 0.5, source "adds 6 % to the standard error", moves "coverage after a stop";
        /// Predicted rise above a larger model, in noise variances, beyond which a model is not fitted at all
        /// in a window that only serves to find the end of the motion.
        not_fitted: f64 = 1000.0, source "chosen by simulation", moves "time of analysis";
    }
}

criteria! {
    /// Records of few cycles: too short for amplitudes of whole cycles, or with a decay of fewer than
    /// `most_cycles` cycles that the waveform fit started from its amplitudes does not describe.
    pub struct FewCyclesCriteria in "few_cycles" {
        /// Maximum number of samples of such a record.
        most_samples: usize = 20_000, source "chosen by simulation", moves "time of analysis";
        /// The last 1/this number of the samples give the rest position.
        tail_part: usize = 10, source "chosen by simulation", moves "refusals";
        /// Minimum number of samples from the release on.
        least_samples: usize = 12, source "as many as a waveform has parameters", moves "refusals";
        /// Noise deviations by which the largest sample may be increased by noise.
        release_noise: f64 = 2.0, source "95 % of normal noise", moves "bias of short records";
        /// Maximum ratio of the residual rms of the fit to the noise.
        most_residual: f64 = 2.0, source "chosen by simulation", moves "refusals";
        /// Minimum amplitude of the first half cycle back, as a fraction of the release amplitude.
        least_return: f64 = 0.2, source "chosen by simulation", moves "refusals";
        /// Standard errors of an amplitude that the half cycle back must reach.
        return_errors: f64 = 3.0, source "chosen by simulation", moves "refusals";
        /// Minimum number of samples of a half cycle whose amplitude is shown.
        half_cycle_samples: usize = 3, source "chosen by simulation", moves "the amplitudes shown";
        /// Number of cycles of a decay followed by its amplitudes below which the search over the whole
        /// motion is also tried.
        most_cycles: f64 = 8.0, source "chosen by simulation", moves "coverage of records of few cycles";
        /// Fraction of the noise below which no amplitude is shown.
        half_cycle_noise: f64 = 0.3, source "chosen by simulation", moves "the amplitudes shown";
    }
}

criteria! {
    /// Two viscous modes as an alternative to every law of one mode.
    pub struct TwoModesCriteria in "two_modes" {
        /// Ratio of residual to noise variance of one mode above which a second one is searched for.
        least_excess: f64 = 4.0, source "twice the noise", moves "modes reported, false friction in beats";
        /// Fraction of the residual variance of one mode above the noise that the second must explain.
        explained: f64 = 0.75, source "half the root mean square", moves "modes reported";
        /// Maximum ratio of the residual variance above the noise of two viscous modes to that of one law for
        /// which a pair is tried.
        most_left: f64 = 0.5, source "what friction leaves of viscous modes is less", moves "modes reported";
        /// Fraction of the samples below which the window of one mode is too short for this comparison.
        small_window: f64 = 0.5, source "chosen by simulation", moves "modes reported";
        /// Maximum fraction of the power of all samples in the residuals of two viscous modes in that case.
        most_power_left: f64 = 0.05, source "what friction leaves of viscous modes is less",
            moves "modes reported";
        /// Minimum fraction of the samples described by one mode that two modes must describe as well.
        common_part: f64 = 0.5, source "chosen by simulation", moves "modes reported";
        /// Ratio of the time described by two modes to that by one above which one mode is not sufficient.
        longer_window: f64 = 1.5, source "chosen by simulation", moves "modes reported";
        /// Minimum product of the frequency difference and the lifetime of the shorter-lived mode.
        separation: f64 = 0.7, source "below it two modes are a law of one amplitude",
            moves "modes reported";
        /// Standard errors by which the second mode must be significant.
        errors: f64 = 5.0, source "one pair in 1e6 by chance", moves "modes reported";
        /// Minimum ratio of the amplitude of the second mode to that of the first.
        least_amplitude: f64 = 2e-3, source "chosen by simulation", moves "modes reported";
    }
}

criteria! {
    /// Residuals of the amplitudes.
    pub struct MisfitCriteria in "misfit" {
        /// Minimum number of amplitudes for determining the shape of their residuals.
        least_points: usize = 12, source "three times the unknowns of a shape", moves "warnings";
        /// Fraction of the sum of squared residuals that a shape must explain.
        explained: f64 = 0.6, source "chosen by simulation", moves "warnings";
        /// Maximum ratio of the sums of squares left by a broken line and by a cubic for a kink.
        kink: f64 = 0.6, source "chosen by simulation", moves "warnings";
        /// The end of a decay is the last 1/this number of its amplitudes.
        end_part: usize = 7, source "chosen by simulation", moves "warnings";
        /// Ratio of the residual variance of a law with a fitted shape to that of the laws compared below
        /// which it is reported to describe the decay better.
        further_law_left: f64 = 0.5, source "chosen by simulation", moves "warnings";
        /// Relative misfit up to which a further law is tried.
        further_law_misfit: f64 = 0.1, source "beyond, the motion is disturbed rather than under another law",
            moves "warnings";
        /// Number of cycles above which a further law is tried.
        further_law_cycles: f64 = 20.0, source "fewer amplitudes tell no four parameters of a loss apart",
            moves "warnings";
        /// Number of samples up to which a further law is tried, since it requires another analysis.
        further_law_samples: usize = 300_000, source "a trial within half a second", moves "warnings";
        /// Difference of BIC above which a further law is preferred.
        further_law_bic: f64 = 10.0, source "very strong evidence on the scale of Kass and Raftery (1995)",
            moves "warnings";
        /// Minimum length of the decay that a further law must describe, relative to that described by the
        /// laws compared.
        further_law_window: f64 = 0.9, source "a shorter decay is easier to describe", moves "warnings";
        /// The same if the decay was cut because the amplitudes depart from the laws compared.
        further_law_longer: f64 = 1.2, source "chosen by simulation", moves "warnings";
    }
}

criteria! {
    /// Noise near the frequency of the motion that exceeds the noise inside single cycles.
    pub struct ColouredNoiseCriteria in "coloured_noise" {
        /// Standard errors by which the scatter of the amplitudes must exceed the noise inside single cycles,
        /// and square root of the log-likelihood ratio by which noise must explain it better than a law in
        /// error by a fraction of the amplitude.
        significance: f64 = 2.6, source "two-sided 1 % point of the normal distribution", moves "coverage";
        /// Minimum number of amplitudes for distinguishing the two.
        least_points: usize = 12, source "chosen by simulation", moves "coverage";
        /// Ratio of the amplitude of the motion to the error of an amplitude below which only noise remains.
        hidden: f64 = 0.3, source "a twentieth of the variance of the noise", moves "coverage";
        /// Ratio of the spectral density of the residuals at low frequencies to that of white noise above
        /// which the level of the rest carries no information about the last half cycle.
        low_frequency: f64 = 4.0, source "twice the error of a level", moves "bias of x_F";
    }
}

criteria! {
    /// Contents and warnings of the answer.
    pub struct AnswerCriteria in "answer" {
        /// Sliding share of the loss above which sliding friction dominates.
        dominating_share: f64 = 0.95, source "a convention", moves "the instant reported";
        /// Number of cycles below which the loss terms cannot be separated.
        few_cycles: f64 = 5.0, source "chosen by simulation", moves "warnings";
        /// Standard errors that the first amplitude must exceed for an answer.
        least_amplitude: f64 = 2.0, source "95 % of normal noise", moves "refusals of noise";
        /// Relative error of decay rate and friction below which both are determined in spite of few cycles.
        determined: f64 = 0.25, source "four standard errors from zero", moves "warnings";
        /// Recorded decay times below which the amplitude does not fall at all.
        least_decay: f64 = 0.01, source "far below what any kind of loss shows in",
            moves "the sentence of the answer";
        /// Correlation above which the viscous and the sliding term cannot be separated.
        inseparable: f64 = 0.99, source "chosen by simulation",
            moves "warnings, and the model reported";
        /// p value below which sliding friction is certain in spite of such a correlation, or of few cycles
        /// before it stops the motion.
        certain_sliding: f64 = 1e-4, source "chosen by simulation",
            moves "warnings, and the model reported";
        /// Relative amplitude above which another mode is reported.
        other_mode: f64 = 0.05, source "chosen by simulation", moves "modes reported";
        /// Relative amplitude above which another mode causes a warning.
        strong_mode: f64 = 0.12, source "chosen by simulation", moves "warnings";
        /// Relative frequency difference within which a line belongs to the main one.
        line_width: f64 = 0.02, source "chosen by simulation", moves "modes reported";
        /// Multiple of the change of the main frequency along the decay within which a line belongs to it.
        line_changes: f64 = 2.0, source "chosen by simulation", moves "modes reported";
        /// Probability of an equally strong line in white noise below which a line counts as another mode or
        /// a harmonic.
        line_of_noise: f64 = 0.01, source "one record in a hundred by chance", moves "modes reported, and warnings";
        /// Relative amplitude above which a harmonic causes a warning.
        strong_harmonic: f64 = 0.05, source "chosen by simulation", moves "warnings";
        /// Ratio of residual to noise variance above which a warning is given.
        misfit: f64 = 4.0, source "twice the noise", moves "warnings";
        /// Probability of such a residual variance in white noise below which a warning is given, since few
        /// blocks often leave much by chance.
        misfit_by_chance: f64 = 1e-3, source "one record in a thousand", moves "warnings of records of few cycles";
        /// Standard errors by which the residuals of the blocks must exceed their noise for a warning of
        /// misfit.
        misfit_errors: f64 = 6.0, source "0 of 600 simulated decays at 20 to 60 dB, one in 1e4 of ten blocks by chance",
            moves "outliers unwarned";
        /// Standard errors above which a third harmonic in quadrature that stays constant while the amplitude
        /// falls causes a warning.
        play_errors: f64 = 5.0, source "a record in 2e6 by chance", moves "outliers unwarned";
        /// Quality factor, from all losses at the first amplitude, below which velocities and accelerations
        /// cause a warning.
        derivative_quality_factor: f64 = 30.0, source "x_F off by 1 % in simulated velocities",
            moves "outliers unwarned";
        /// Number of samples per cycle below which the frequency may be an alias.
        samples_per_cycle: f64 = 3.0, source "chosen by simulation", moves "warnings";
    }
}

criteria! {
    /// Warnings of fits of amplitudes in batches and maps.
    pub struct TraceCriteria in "trace" {
        /// Correlation above which a trace does not separate the two losses.
        inseparable: f64 = 0.999, source "chosen by simulation", moves "warnings";
        /// Standard errors by which a negative loss must differ from zero to be significant.
        unlikely: f64 = 4.0, source "one trace in 30 000 by chance", moves "warnings";
        /// p value of the residuals in the slow part of a trace below which the trace is not such a decay.
        misfit: f64 = 3e-5, source "one trace in 30 000 by chance",
            moves "motions that stop within a trace, and noise floors, unwarned";
        /// Ratio of the last amplitude to the noise below which non-negative amplitudes are biased by the
        /// noise.
        noise_floor: f64 = 4.0, source "intervals of friction hold 90 % down to 3.4 in simulated traces of 400 samples",
            moves "friction hidden by a noise floor, unwarned";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_table_is_complete_and_named_once() {
        let table = Criteria::default().table();
        let mut names: Vec<&str> = table.iter().map(|row| row.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), table.len());
        for row in table {
            assert!(row.value.is_finite(), "{}", row.name);
            assert!(row.meaning.ends_with('.'), "{}: {}", row.name, row.meaning);
            assert!(!row.source.is_empty(), "{}", row.name);
            assert!(!row.statistic.is_empty(), "{}", row.name);
        }
    }
}
