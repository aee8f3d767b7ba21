//! Every threshold that decides how an oscillation is found in a spectrum and how its phase is followed.

use crate::inference::criteria::criteria;

criteria! {
    /// The lines of a spectrum: which of them is the motion.
    pub struct SpectrumCriteria in "spectrum" {
        /// Cycles in a record at least: a line of fewer is drift.
        least_cycles: f64 = 0.7, source "the lowest bin of a spectrum has one", moves "refusals";
        /// Cycles in a record, or a part of it, that tell a frequency apart from its neighbours and from its harmonics.
        many_cycles: f64 = 8.0, source "the main lobe of a Hann window is four bins wide", moves "refusals";
        /// Amplitude over the largest deflection below which the strongest line of a record may be noise.
        weak_line: f64 = 0.1, source "chosen by simulation", moves "refusals of long records";
        /// Ratio of two frequencies within which one of them is no news of the other.
        same_frequency: f64 = 1.5, source "chosen by simulation", moves "refusals of long records";
        /// Cycles in a part of a record, at least, of an oscillation that is brief.
        brief_cycles: f64 = 3.0, source "chosen by simulation", moves "refusals of long records";
        /// Its amplitude there over that of the line found over all.
        brief_wider: f64 = 2.0, source "chosen by simulation", moves "refusals of long records";
        /// What its line leaves of the variance of the part over what that of all leaves, at most.
        brief_left: f64 = 0.75, source "the strongest line of noise in a hundred samples explains a seventh of them",
            moves "refusals of long records";
        /// Median steps that a gap in the stamps is longer than.
        gap_steps: f64 = 8.0, source "chosen by simulation", moves "several modes reported in records with gaps";
    }
}

criteria! {
    /// The phase of the oscillation: its law, and its random walk.
    pub struct PhaseCriteria in "phase" {
        /// Inverse variance (1/rad²) below which a phase may have slipped a turn and takes no part.
        least_weight: f64 = 16.0, source "a quarter of a radian", moves "refusals, window end";
        /// Inverse variance (1/rad²) above which no phase has slipped a turn.
        sure_weight: f64 = 100.0, source "ten standard errors are a radian", moves "refusals, window end";
        /// Inverse variance (1/rad²) of the neighbours through which a phase that follows no law is smoothed.
        smoothed_weight: f64 = 400.0, source "0.05 rad", moves "bias where the frequency wanders";
        /// Added to the BIC of every law with terms beyond a line.
        bic_price: f64 = 6.0, source "strong evidence (Kass and Raftery 1995)", moves "bias of late amplitudes";
        /// Scatter of the phases about a law over their errors, squared, up to which they follow it.
        most_excess: f64 = 3.0, source "noise alone leaves one", moves "method chosen, error of the frequency";
        /// Part of the noise of an amplitude that a phase off the law may cost it where the scatter is larger.
        amplitude_cost: f64 = 0.1, source "far below the noise", moves "method chosen";
        /// Relative difference of a law's frequency from the mean of the blocks from which on it is none.
        off_frequency: f64 = 0.5, source "no weakly nonlinear oscillator shifts by half of its frequency",
            moves "refusals";
        /// Weighted sum of squared relative errors that the amplitudes may have from a phase off the law.
        most_lost: f64 = 1.0,
            source "at one, no combination of the amplitudes is off by more than its standard error",
            moves "bias of amplitudes";
        /// Drift or walk over the shift by the amplitude up to which the shift is that of the amplitude.
        most_other: f64 = 0.1, source "the shift is then that of the amplitude to a tenth", moves "frequency at rest, damping of pendulums";
        /// Errors by which a step of the phase, as a knock leaves it, stands out.
        step_errors: f64 = 8.0, source "none in 8400 decays without a knock", moves "warnings";
        /// Times the largest change of the phase beside it that such a step is.
        step_isolated: f64 = 2.5, source "a phase that walks or beats changes everywhere", moves "warnings";
        /// Changes of the phase on either side whose median is the rate beside such a step.
        step_beside: usize = 4, source "half of eight may lie off it", moves "warnings";
        /// Blocks without which no step is looked for.
        step_blocks: usize = 12, source "four on either side of a step, and as many more", moves "warnings";
        /// Standard errors by which a random walk of the phase stands out of its noise.
        walk_errors: f64 = 1.6, source "one phase without a walk in 20",
            moves "coverage beside a phase that wanders";
    }
}
