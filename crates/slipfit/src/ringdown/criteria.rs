//! Every threshold that decides something in the analysis of a ring-down.

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
    /// The thresholds of [`analyse_with`](super::analyse_with), by the step that they decide.
    ///
    /// ```
    /// let mut criteria = slipfit::ringdown::Criteria::default();
    /// criteria.window.rise_ratio = 1.2;
    /// let table = criteria.table();
    /// let row = table.iter().find(|row| row.name == "window.rise_ratio").expect("listed");
    /// assert_eq!(row.value, 1.2);
    /// ```
    pub struct Criteria {
        /// Shared with the other analyses.
        inference: InferenceCriteria,
        /// The lines of a spectrum.
        spectrum: SpectrumCriteria,
        /// Amplitudes of blocks.
        blocks: BlockCriteria,
        /// The phase of the oscillation.
        phase: PhaseCriteria,
        /// Single samples far off their neighbours.
        spikes: SpikeCriteria,
        /// A rest that the converter does not resolve.
        resolution: ResolutionCriteria,
        /// Blocks with clipped samples.
        clipping: ClippingCriteria,
        /// A band of frequencies that is asked for.
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
        /// A displacement held before the release.
        held: HeldCriteria,
        /// A baseline along a curve.
        baseline: BaselineCriteria,
        /// A reading that bends with the deflection.
        sensor: SensorCriteria,
        /// A reading of the square of the deflection.
        squared_reading: SquaredReadingCriteria,
        /// A short motion in a long quiet record.
        active_part: ActivePartCriteria,
        /// Two viscous modes as a rival of every law of one.
        two_modes: TwoModesCriteria,
        /// A steady line beside the decay.
        steady_line: SteadyLineCriteria,
        /// What the law leaves of the amplitudes.
        misfit: MisfitCriteria,
        /// Noise about the frequency of the motion.
        coloured_noise: ColouredNoiseCriteria,
        /// The law without a model.
        free_law: FreeLawCriteria,
        /// The rest after the motion.
        stop: StopCriteria,
        /// Another motion in the same record.
        other_motion: OtherMotionCriteria,
        /// What the answer states and warns of.
        answer: AnswerCriteria,
        /// What is reported of the models compared.
        report: ReportCriteria,
    }
}

criteria! {
    /// Amplitudes of blocks of some cycles along the record.
    pub struct BlockCriteria in "blocks" {
        /// Cycles that the free decay must hold.
        least_cycles: f64 = 2.0, source "two loss terms and an amplitude are three unknowns",
            moves "refusals";
        /// Blocks without which no decay is followed.
        least_blocks: usize = 3, source "as many amplitudes as unknowns", moves "refusals";
        /// Lowest frequency followed, over the dominant one.
        tracking_low: f64 = 0.4, source "chosen by simulation", moves "refusals";
        /// Highest frequency followed, over the dominant one.
        tracking_high: f64 = 2.5, source "chosen by simulation", moves "refusals";
        /// Where blocks cut for the decay and its surroundings alone are shorter by this factor,
        /// they are cut anew.
        recut_factor: f64 = 2.0, source "chosen by simulation", moves "bias in long records";
        /// Relative error of the first amplitude above which longer blocks are taken.
        relative_error: f64 = 0.015, source "chosen by simulation", moves "window start and end";
        /// Blocks above the noise that longer blocks must leave.
        least_visible: usize = 30, source "chosen by simulation", moves "window start and end";
        /// Standard errors below which the amplitude of a block is noise.
        floor_errors: f64 = 4.0, source "one block in 3000 by chance", moves "window end";
        /// Steps of the converter below which an amplitude is not resolved.
        floor_steps: f64 = 1.5, source "chosen by simulation", moves "window end";
        /// Part of the largest amplitude below which no amplitude counts.
        floor_of_top: f64 = 1e-5, source "chosen by simulation", moves "window end";
        /// Standard errors above which the fall of the amplitude inside a block is measured.
        loss_errors: f64 = 10.0, source "chosen by simulation", moves "bias of late amplitudes";
        /// Parts of a record whose medians fall one after another where its samples may be amplitudes.
        recorded_parts: usize = 8, source "chosen by simulation", moves "hints in refusals";
        /// Rise from one part to the next that noise may make, over the first median.
        recorded_rise: f64 = 0.05, source "noise at the end", moves "hints in refusals";
        /// Last median over the first, at most.
        recorded_fall: f64 = 0.5, source "chosen by simulation", moves "hints in refusals";
        /// Most blocks of a record of amplitudes.
        recorded_blocks: usize = 500, source "chosen by simulation", moves "time of analysis";
        /// One in so many amplitudes of an envelope lies below its noise floor.
        envelope_floor_fraction: usize = 50, source "chosen by simulation", moves "window end";
        /// Most that the noise floor of an envelope takes of its largest amplitude.
        envelope_floor_of_top: f64 = 0.2, source "chosen by simulation", moves "window end";
        /// Standard errors above its noise floor that an envelope must lie.
        envelope_floor_errors: f64 = 2.0, source "chosen by simulation", moves "window end";
        /// Most different values among the samples, as a part of them, that show the steps of a
        /// converter.
        distinct_values: f64 = 2.0 / 3.0, source "chosen by simulation",
            moves "window end of coarse records";
        /// Mean amplitude of the last third over the first third of a record that grows.
        growth_ratio: f64 = 1.2, source "chosen by simulation", moves "the reason of a refusal";
    }
}

criteria! {
    /// The free decay among the blocks: a run of falling amplitude, a seed fit inside it, and how
    /// far the law of the seed is extended.
    pub struct WindowCriteria in "window" {
        /// Rise of the amplitude over the least one so far that ends a run.
        rise_ratio: f64 = 1.1, source "chosen by simulation", moves "window end";
        /// Standard errors that a rise must exceed besides.
        rise_errors: f64 = 4.0, source "one block in 1e4 by chance", moves "window end";
        /// Part of the largest amplitude from which on a block belongs to the top of a run.
        top_ratio: f64 = 0.98, source "chosen by simulation", moves "window start";
        /// Standard errors below the largest amplitude that belong to the top as well.
        top_errors: f64 = 3.0, source "chosen by simulation", moves "window start";
        /// Part of the top at which the seed begins.
        seed_from: f64 = 0.9, source "chosen by simulation", moves "window start";
        /// Part of its first amplitude at which the seed ends.
        seed_to: f64 = 0.15, source "chosen by simulation", moves "window end";
        /// Blocks without which there is no seed.
        seed_least: usize = 5, source "as many amplitudes as fit viscous and sliding loss",
            moves "window end";
        /// Blocks of a seed where the amplitude falls fast.
        seed_blocks: usize = 8, source "chosen by simulation", moves "window end";
        /// Amplitudes above which the seed's law has sliding friction.
        sliding_from: usize = 5, source "chosen by simulation", moves "window end";
        /// Amplitudes above which the seed's law has drag.
        drag_from: usize = 8, source "chosen by simulation", moves "window end";
        /// Error of the law, as a part of the amplitude.
        law_error: f64 = 0.01, source "chosen by simulation", moves "window end";
        /// Logarithmic loss between two blocks of a drive that leaks into the signal and is
        /// switched off.
        step: f64 = 0.1, source "chosen by simulation", moves "window start";
        /// That loss over the median loss of the blocks that follow.
        step_factor: f64 = 8.0, source "chosen by simulation", moves "window start";
        /// Standard errors that a block may lie off the law.
        miss_errors: f64 = 5.0, source "chosen by simulation", moves "window end";
        /// Standard deviations about the law that a block may lie off it.
        miss_deviations: f64 = 2.0, source "chosen by simulation", moves "window end";
        /// Most scatter about the law over its errors that is tolerated as such.
        most_scatter: f64 = 20.0, source "chosen by simulation", moves "window end";
        /// Part of the amplitude that later blocks may lie off the law.
        later_tolerance: f64 = 0.3, source "chosen by simulation", moves "window end";
        /// Part of the amplitude that the last blocks may lie off where the law is left.
        last_tolerance: f64 = 0.08, source "chosen by simulation", moves "window end";
        /// Part of the amplitude that earlier blocks may lie off the law.
        earlier_tolerance: f64 = 0.02, source "chosen by simulation", moves "window start";
        /// Blocks off the law in a row that leave it.
        misses: usize = 3, source "chosen by simulation", moves "window end";
        /// Blocks above which two instead of one are left out beside a lead-in.
        lead_in_margin: usize = 20, source "chosen by simulation", moves "window start";
        /// Amplitude over the noise, some blocks before the end, of a motion that stops.
        stop_ratio: f64 = 4.0, source "chosen by simulation", moves "end reason";
        /// Blocks within which a stop takes the amplitude away.
        stop_blocks: usize = 3, source "chosen by simulation", moves "end reason";
        /// Standard errors that the law must predict for a block inside the noise.
        noise_prediction: f64 = 0.3, source "chosen by simulation", moves "window end";
        /// Standard errors that a block inside the noise may lie off the law.
        noise_errors: f64 = 4.0, source "one block in 1e4 by chance", moves "window end";
        /// Blocks on each side of a change of law.
        kink_blocks: usize = 30, source "chosen by simulation", moves "window end";
        /// Residual variance over the noise from which on a change of law is looked for.
        kink_excess: f64 = 100.0, source "ten times the noise", moves "window end";
        /// Residual variance over the noise that the earlier law may leave.
        kink_earlier: f64 = 4.0, source "twice the noise", moves "window end";
        /// Factor by which a change of law must lower the residual variance.
        kink_gain: f64 = 5.0, source "chosen by simulation", moves "window end";
    }
}

criteria! {
    /// First blocks that still belong to a drive.
    pub struct LeadInCriteria in "lead_in" {
        /// Blocks of a decay whose law is extrapolated to its start.
        least_blocks: usize = 60, source "chosen by simulation", moves "window start";
        /// One in so many blocks is left out of the law that is extrapolated.
        tested_part: usize = 3, source "chosen by simulation", moves "window start";
        /// Residual variance over the noise above which the law says nothing of a drive.
        most_excess: f64 = 4.0, source "twice the noise", moves "window start";
        /// Blocks in a run that are tested together.
        run: usize = 8, source "chosen by simulation", moves "window start";
        /// Standard errors that the mean of a run may lie off the law.
        run_errors: f64 = 4.0, source "one run in 1e4 by chance", moves "window start";
        /// Standard errors that a block may lie off the law.
        block_errors: f64 = 4.5, source "one block in 1e5 by chance", moves "window start";
        /// One in so many blocks at most belongs to a drive.
        most_part: usize = 6, source "chosen by simulation", moves "window start";
        /// One in so many blocks, and two at least, is left out behind the run that lies off.
        margin_part: usize = 60, source "chosen by simulation", moves "window start";
        /// Blocks of a decay of which the first may be left out for the waveform's sake.
        spare_blocks: usize = 40, source "chosen by simulation", moves "window start";
    }
}

criteria! {
    /// Whether a motion leaves nothing but noise of the samples.
    pub struct AgreementCriteria in "agreement" {
        /// Standard errors of the residual variance that noise may show.
        scatter_errors: f64 = 4.0, source "one record in 1e4 by chance", moves "window start and end";
        /// Standard errors of the fundamental left in a block, or in a run of blocks.
        fundamental_errors: f64 = 4.5, source "one block in 1e5 by chance",
            moves "window start and end";
        /// Blocks in a run that are tested together.
        run: usize = 8, source "chosen by simulation", moves "window start and end";
        /// Part of the first amplitude below which the decay is not followed on.
        least_amplitude: f64 = 2e-3, source "smaller amplitudes carry no information",
            moves "window end";
        /// Friction displacements below which the decay is not followed on.
        least_frictions: f64 = 1.2, source "the last swing before a stop", moves "window end";
    }
}

criteria! {
    /// The fit of the amplitudes.
    pub struct AmplitudeCriteria in "amplitude" {
        /// Part of the first amplitude below which an envelope's noise floor is fitted.
        floor_visible: f64 = 0.2, source "chosen by simulation", moves "bias of envelopes";
        /// Residual variance over the noise from which on what moves clusters of amplitudes is a law that is missing rather
        /// than errors that are not alike.
        most_cluster_excess: f64 = 30.0, source "chosen by simulation: noise thirty times as loud at the start leaves 20",
            moves "coverage where noise changes along the decay, loss terms chosen";
        /// Least amplitude that the error of the law refers to, as a part of the first one.
        law_error_base: f64 = 0.05, source "chosen by simulation", moves "bias where the law is off";
        /// Robust standard deviations beyond which a block is an outlier.
        outlier_deviations: f64 = 8.0, source "chosen by simulation", moves "spread with glitches";
        /// One in so many blocks at most is an outlier.
        outlier_part: usize = 10, source "chosen by simulation", moves "spread with glitches";
        /// Blocks beyond the number of parameters without which none is an outlier.
        outlier_spare: usize = 6, source "chosen by simulation", moves "spread with glitches";
        /// Friction displacements below which the averaged law does not hold.
        least_frictions: f64 = 2.0, source "below two x_F the motion is no ellipse",
            moves "bias of x_F";
        /// Amplitudes without which the end of the law is not looked for.
        rest_blocks: usize = 8, source "chosen by simulation", moves "bias of x_F";
        /// Amplitudes kept before the end of the law.
        rest_kept: usize = 6, source "chosen by simulation", moves "bias of x_F";
    }
}

criteria! {
    /// The fit of the waveform.
    pub struct WaveformCriteria in "waveform" {
        /// Phase before and behind a turning point, rad, within which samples of an acceleration do not count: friction
        /// makes it jump there.
        turn_guard: f64 = 0.05, source "x_F off by up to 2 standard errors without, by none with it, in simulated accelerations",
            moves "bias of friction in accelerations";
        /// Standard errors of an amplitude, of all samples shared by six parameters, that `x_F` exceeds where the place of
        /// rest tells which swing was the last: swings end `2 x_F` apart.
        rest_errors: f64 = 8.0, source "chosen by simulation", moves "bias after a stop";
        /// Most samples of a window; beyond it the blocks hold the same information.
        most_samples: usize = 300_000, source "chosen by simulation", moves "time of analysis";
        /// Most samples of a record where a further law is named, which holds on the average of a cycle.
        most_samples_further: usize = 50_000, source "an analysis within two seconds", moves "time of analysis";
        /// Least loss per cycle, as a part of the amplitude.
        least_loss: f64 = 1e-3, source "with less the motion is an ellipse to 1e-4",
            moves "time of analysis";
        /// Residual variance over the noise above which the phase wanders.
        most_excess: f64 = 4.0, source "twice the noise", moves "the method chosen";
        /// Residual variance over the noise down to which the waveform must describe the samples.
        variance_ratio: f64 = 1.3, source "chosen by simulation", moves "the method chosen";
        /// Samples of a window up to which a motion that may stop in it is fitted from several starts, also where
        /// the first fit leaves no more than noise.
        multi_start_samples: usize = 20_000, source "0 of 20 000 simulated records in another minimum",
            moves "coverage, time of analysis";
        /// Variances by which a motion that ends with another swing must lie above the one of the lowest sum of
        /// squares for the last swing to be known.
        last_swing_variances: f64 = 12.0, source "a likelihood ratio of 400", moves "coverage after a stop";
        /// Standard errors of the friction displacement, as the motion before the rest tells it, in which
        /// another last swing is looked for.
        last_swing_errors: f64 = 4.0, source "a side in 3e4 by chance", moves "coverage after a stop";
        /// Times the significance of an excess at which the phase is taken to wander.
        wandering_significance: f64 = 2.0, source "chosen by simulation",
            moves "coverage where the phase walks";
        /// Part of the standard error of the level of a rest that the error which rounding gives all its samples may be
        /// for the level to count.
        rounding_of_rest: f64 = 0.5, source "adds 6 % to the standard error", moves "coverage after a stop";
        /// Variances of the noise by which a model is foreseen to lie above a larger one where it is not fitted at
        /// all, in a window that only shows how far the motion goes on.
        not_fitted: f64 = 1000.0, source "chosen by simulation", moves "time of analysis";
    }
}

criteria! {
    /// Records of few cycles: too short for amplitudes of whole cycles, or with a decay of fewer than
    /// `most_cycles` cycles that the fit of the waveform begun at its amplitudes does not describe.
    pub struct FewCyclesCriteria in "few_cycles" {
        /// Most samples of such a record.
        most_samples: usize = 20_000, source "chosen by simulation", moves "time of analysis";
        /// The last one in so many samples show the place of rest.
        tail_part: usize = 10, source "chosen by simulation", moves "refusals";
        /// Samples from the release on.
        least_samples: usize = 12, source "as many as a waveform has parameters", moves "refusals";
        /// Noise that the largest sample may owe part of its size to.
        release_noise: f64 = 2.0, source "95 % of normal noise", moves "bias of short records";
        /// Residual over the noise that the fit may leave.
        most_residual: f64 = 2.0, source "chosen by simulation", moves "refusals";
        /// Part of the first swing that the swing back must reach.
        least_return: f64 = 0.2, source "chosen by simulation", moves "refusals";
        /// Standard errors of an amplitude that the swing back must reach.
        return_errors: f64 = 3.0, source "chosen by simulation", moves "refusals";
        /// Samples in a half cycle whose amplitude is shown.
        half_cycle_samples: usize = 3, source "chosen by simulation", moves "the amplitudes shown";
        /// Cycles of a decay followed by its amplitudes up to which the search over the whole motion is
        /// tried as well.
        most_cycles: f64 = 8.0, source "chosen by simulation", moves "coverage of records of few cycles";
        /// Part of the noise below which no amplitude is shown.
        half_cycle_noise: f64 = 0.3, source "chosen by simulation", moves "the amplitudes shown";
    }
}

criteria! {
    /// Two viscous modes as a rival of every law of one mode.
    pub struct TwoModesCriteria in "two_modes" {
        /// Residual variance of one mode over the noise from which on a second is looked for.
        least_excess: f64 = 4.0, source "twice the noise", moves "modes reported, false friction in beats";
        /// Part of what one mode leaves, noise excepted, that the second must explain.
        explained: f64 = 0.75, source "half the root mean square", moves "modes reported";
        /// Residual variance, noise excepted, of two viscous modes over that of one law above which no
        /// pair is tried.
        most_left: f64 = 0.5, source "what friction leaves of viscous modes is less", moves "modes reported";
        /// Part of the samples below which the window of one mode is too short to judge by.
        small_window: f64 = 0.5, source "chosen by simulation", moves "modes reported";
        /// Part of the power of all samples that two viscous modes may leave in that case.
        most_power_left: f64 = 0.05, source "what friction leaves of viscous modes is less",
            moves "modes reported";
        /// Part of the samples described by one mode that two modes must describe as well.
        common_part: f64 = 0.5, source "chosen by simulation", moves "modes reported";
        /// Time described by two modes over that by one from which on one mode is not enough.
        longer_window: f64 = 1.5, source "chosen by simulation", moves "modes reported";
        /// Distance of the frequencies times the life of the shorter mode.
        separation: f64 = 0.7, source "below it two modes are a law of one amplitude",
            moves "modes reported";
        /// Standard errors by which the second mode must stand out.
        errors: f64 = 5.0, source "one pair in 1e6 by chance", moves "modes reported";
        /// Amplitude of the second mode over that of the first, at least.
        least_amplitude: f64 = 2e-3, source "chosen by simulation", moves "modes reported";
    }
}

criteria! {
    /// What the law leaves of the amplitudes.
    pub struct MisfitCriteria in "misfit" {
        /// Amplitudes whose residuals have a shape.
        least_points: usize = 12, source "three times the unknowns of a shape", moves "warnings";
        /// Part of the squared residuals that a shape must explain.
        explained: f64 = 0.6, source "chosen by simulation", moves "warnings";
        /// Squared residuals that a broken line leaves, over those that a cubic leaves, of a kink.
        kink: f64 = 0.6, source "chosen by simulation", moves "warnings";
        /// The end of a decay is one in so many of its amplitudes.
        end_part: usize = 7, source "chosen by simulation", moves "warnings";
        /// Residual variance that a law with a fitted shape leaves, over that of the laws compared, below which
        /// it is said to describe the decay better.
        further_law_left: f64 = 0.5, source "chosen by simulation", moves "warnings";
        /// Relative misfit up to which a further law is tried.
        further_law_misfit: f64 = 0.1, source "beyond, the motion is disturbed rather than under another law",
            moves "warnings";
        /// Cycles above which a further law is tried.
        further_law_cycles: f64 = 20.0, source "fewer amplitudes tell no four parameters of a loss apart",
            moves "warnings";
        /// Samples up to which a further law is tried: it takes another analysis.
        further_law_samples: usize = 300_000, source "a trial within half a second", moves "warnings";
        /// Difference of BIC above which it is.
        further_law_bic: f64 = 10.0, source "very strong evidence on the scale of Kass and Raftery (1995)",
            moves "warnings";
        /// Part of the decay that it must describe at least.
        further_law_window: f64 = 0.9, source "a shorter decay is easier to describe", moves "warnings";
        /// And where the decay was cut because the amplitudes leave the laws compared, over what those describe.
        further_law_longer: f64 = 1.2, source "chosen by simulation", moves "warnings";
    }
}

criteria! {
    /// Noise about the frequency of the motion that exceeds the noise inside single cycles.
    pub struct ColouredNoiseCriteria in "coloured_noise" {
        /// Standard errors by which the scatter of the amplitudes must exceed the noise inside single
        /// cycles, and root of the log-likelihood ratio by which noise must explain it better than a
        /// law that is wrong by a part of the amplitude.
        significance: f64 = 2.6, source "two-sided 1 % point of the normal distribution", moves "coverage";
        /// Amplitudes without which the two are not told apart.
        least_points: usize = 12, source "chosen by simulation", moves "coverage";
        /// Amplitude of the motion over the error of an amplitude below which only noise is left.
        hidden: f64 = 0.3, source "a twentieth of the variance of the noise", moves "coverage";
        /// Density of the residuals at low frequencies over that of white noise from which on the
        /// level of the rest says nothing of the last swing.
        low_frequency: f64 = 4.0, source "twice the error of a level", moves "bias of x_F";
    }
}

criteria! {
    /// What the answer states and warns of.
    pub struct AnswerCriteria in "answer" {
        /// Sliding share of the loss above which sliding friction dominates.
        dominating_share: f64 = 0.95, source "a convention", moves "the instant reported";
        /// Cycles below which the loss terms cannot be separated.
        few_cycles: f64 = 5.0, source "chosen by simulation", moves "warnings";
        /// Standard errors that the first amplitude must exceed for an answer.
        least_amplitude: f64 = 2.0, source "95 % of normal noise", moves "refusals of noise";
        /// Relative error of decay rate and friction below which so few cycles determine both.
        determined: f64 = 0.25, source "four standard errors from zero", moves "warnings";
        /// Decay times recorded below which the amplitude does not fall at all.
        least_decay: f64 = 0.01, source "far below what any kind of loss shows in",
            moves "the sentence of the answer";
        /// Correlation above which the viscous and the sliding term are one number.
        inseparable: f64 = 0.99, source "chosen by simulation",
            moves "warnings, and the model reported";
        /// p value below which sliding friction is certain in spite of such a correlation, or of few cycles before it stops the motion.
        certain_sliding: f64 = 1e-4, source "chosen by simulation",
            moves "warnings, and the model reported";
        /// Relative amplitude of another mode that is reported.
        other_mode: f64 = 0.05, source "chosen by simulation", moves "modes reported";
        /// Relative amplitude of another mode that is warned of.
        strong_mode: f64 = 0.12, source "chosen by simulation", moves "warnings";
        /// Relative distance within which a line belongs to the main one.
        line_width: f64 = 0.02, source "chosen by simulation", moves "modes reported";
        /// Changes of the main frequency along the decay within which a line belongs to it.
        line_changes: f64 = 2.0, source "chosen by simulation", moves "modes reported";
        /// Probability of a line as strong in white noise, below which it is another mode or a harmonic.
        line_of_noise: f64 = 0.01, source "one record in a hundred by chance", moves "modes reported, and warnings";
        /// Relative amplitude of a harmonic that is warned of.
        strong_harmonic: f64 = 0.05, source "chosen by simulation", moves "warnings";
        /// Residual variance over the noise that is warned of.
        misfit: f64 = 4.0, source "twice the noise", moves "warnings";
        /// Probability of as much residual variance in white noise below which it is warned of: few blocks leave much by chance.
        misfit_by_chance: f64 = 1e-3, source "one record in a thousand", moves "warnings of records of few cycles";
        /// Standard errors by which what a motion leaves of the blocks exceeds their noise, of a misfit that is warned of.
        misfit_errors: f64 = 6.0, source "0 of 600 simulated decays at 20 to 60 dB, one in 1e4 of ten blocks by chance",
            moves "outliers unwarned";
        /// Standard errors of a third harmonic in quadrature that stays while the amplitude falls.
        play_errors: f64 = 5.0, source "a record in 2e6 by chance", moves "outliers unwarned";
        /// Quality factor, of all losses at the first amplitude, below which velocities and accelerations are warned of.
        derivative_quality_factor: f64 = 30.0, source "x_F off by 1 % in simulated velocities",
            moves "outliers unwarned";
        /// Samples in a cycle below which the frequency may be an alias.
        samples_per_cycle: f64 = 3.0, source "chosen by simulation", moves "warnings";
    }
}

criteria! {
    /// What a fit of amplitudes is warned of in batches and maps.
    pub struct TraceCriteria in "trace" {
        /// Correlation of the two losses beyond which a trace does not tell them apart.
        inseparable: f64 = 0.999, source "chosen by simulation", moves "warnings";
        /// Standard errors below zero of a loss that is none.
        unlikely: f64 = 4.0, source "one trace in 30 000 by chance", moves "warnings";
        /// p value of what the law leaves of the slow part of a trace, below which it is no such decay.
        misfit: f64 = 3e-5, source "one trace in 30 000 by chance",
            moves "motions that stop within a trace, and noise floors, unwarned";
        /// Last amplitude over the noise below which amplitudes that are never negative are raised by it.
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
