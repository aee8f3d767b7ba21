//! Every threshold that decides how the phase of an oscillation is followed.

use crate::inference::criteria::criteria;

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
        /// Blocks without which no step is looked for.
        step_blocks: usize = 12, source "four on either side of a step, and as many more", moves "warnings";
        /// Standard errors by which a random walk of the phase stands out of its noise.
        walk_errors: f64 = 1.6, source "one phase without a walk in 20",
            moves "coverage beside a phase that wanders";
    }
}
