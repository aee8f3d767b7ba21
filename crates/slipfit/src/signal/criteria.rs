//! Thresholds that decide how an oscillation is found in a spectrum and how its phase is tracked.

use crate::inference::criteria::criteria;

criteria! {
    /// The lines of a spectrum: which of them is the motion.
    pub struct SpectrumCriteria in "spectrum" {
        /// Minimum number of cycles in a record: a line with fewer is drift.
        least_cycles: f64 = 0.7, source "the lowest bin of a spectrum has one", moves "refusals";
        /// Number of cycles in a record, or a part of it, that separates a frequency from its neighbours and its
        /// harmonics.
        many_cycles: f64 = 8.0, source "the main lobe of a Hann window is four bins wide", moves "refusals";
        /// Amplitude over the largest deflection below which the strongest line of a record may be noise.
        weak_line: f64 = 0.1, source "chosen by simulation", moves "refusals of long records";
        /// Ratio of two frequencies within which they count as the same.
        same_frequency: f64 = 1.5, source "chosen by simulation", moves "refusals of long records";
        /// Minimum number of cycles of a brief oscillation within a part of a record.
        brief_cycles: f64 = 3.0, source "chosen by simulation", moves "refusals of long records";
        /// Minimum ratio of its amplitude there to that of the line found over the whole record.
        brief_wider: f64 = 2.0, source "chosen by simulation", moves "refusals of long records";
        /// Maximum ratio of the residual variance of the part for its own line to that for the line of the whole
        /// record.
        brief_left: f64 = 0.75, source "the strongest line of noise in a hundred samples explains a seventh of them",
            moves "refusals of long records";
        /// Minimum length of a gap in the stamps, in median steps.
        gap_steps: f64 = 8.0, source "chosen by simulation", moves "several modes reported in records with gaps";
    }
}

criteria! {
    /// The phase of the oscillation: its law, and its random walk.
    pub struct PhaseCriteria in "phase" {
        /// Inverse variance (1/rad²) below which a phase may be wrong by a turn and is not used.
        least_weight: f64 = 16.0, source "a quarter of a radian", moves "refusals, window end";
        /// Inverse variance (1/rad²) above which a phase cannot be wrong by a turn.
        sure_weight: f64 = 100.0, source "ten standard errors are a radian", moves "refusals, window end";
        /// Inverse variance (1/rad²) of the neighbours over which a phase that follows no law is smoothed.
        smoothed_weight: f64 = 400.0, source "0.05 rad", moves "bias where the frequency wanders";
        /// Added to the BIC of every law with terms beyond a straight line.
        bic_price: f64 = 6.0, source "strong evidence (Kass and Raftery 1995)", moves "bias of late amplitudes";
        /// Maximum ratio of the squared scatter of the phases about a law to their squared errors for which they
        /// follow it.
        most_excess: f64 = 3.0, source "noise alone leaves one", moves "method chosen, error of the frequency";
        /// Amplitude error due to a phase off the law, as a part of its noise, that is allowed if the scatter is
        /// larger.
        amplitude_cost: f64 = 0.1, source "far below the noise", moves "method chosen";
        /// Relative difference of a law's frequency from the mean of the blocks above which the law is rejected.
        off_frequency: f64 = 0.5, source "no weakly nonlinear oscillator shifts by half of its frequency",
            moves "refusals";
        /// Maximum weighted sum of squared relative errors of the amplitudes due to a phase off the law.
        most_lost: f64 = 1.0,
            source "at one, no combination of the amplitudes is off by more than its standard error",
            moves "bias of amplitudes";
        /// Maximum ratio of drift or walk to the shift by the amplitude for which the shift is attributed to the
        /// amplitude.
        most_other: f64 = 0.1, source "the shift is then that of the amplitude to a tenth", moves "frequency at rest, damping of pendulums";
        /// Minimum size of a phase step, as left by a knock, in standard errors.
        step_errors: f64 = 8.0, source "none in 8400 decays without a knock", moves "warnings";
        /// Minimum ratio of such a step to the largest change of the phase next to it.
        step_isolated: f64 = 2.5, source "a phase that walks or beats changes everywhere", moves "warnings";
        /// Number of changes of the phase on either side whose median is the rate next to such a step.
        step_beside: usize = 4, source "half of eight may lie off it", moves "warnings";
        /// Minimum number of blocks for the search for a step.
        step_blocks: usize = 12, source "four on either side of a step, and as many more", moves "warnings";
        /// Standard errors by which a random walk of the phase must exceed its noise.
        walk_errors: f64 = 1.6, source "one phase without a walk in 20",
            moves "coverage beside a phase that wanders";
    }
}
