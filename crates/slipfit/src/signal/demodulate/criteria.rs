//! Thresholds that decide in the demodulation of a driven record.

use crate::inference::criteria::criteria;

criteria! {
    /// Thresholds of [`demodulate_with`](super::demodulate_with).
    pub struct Criteria in "demodulation" {
        /// Minimum number of cycles of the steady motion.
        least_cycles: f64 = 3.0, source "amplitude, phase, frequency, offset and drift are five unknowns",
            moves "refusals";
        /// Minimum number of samples for fitting a sine.
        least_samples: usize = 16, source "twice as many as a sine with two harmonics, offset and drift has unknowns",
            moves "refusals";
        /// Minimum number of samples in a block of whole cycles.
        block_samples: usize = 8, source "more than twice the three unknowns of a sine about a level",
            moves "instant from which the motion is steady";
        /// Maximum number of blocks of a record.
        most_blocks: usize = 400, source "chosen by simulation", moves "time of analysis";
        /// Minimum number of blocks for settling detection; with fewer, the second half of the record is used.
        settling_blocks: usize = 6, source "two in each third of the record",
            moves "instant from which the motion is steady";
        /// Standard deviations from the mean of the blocks after it beyond which a block is part of the transient.
        far: f64 = 3.5, source "one steady block in 2e5", moves "transient left in, or too much left out";
        /// Standard deviations from the steady motion beyond which a block is used to estimate the decay of the
        /// transient.
        seen: f64 = 2.0, source "one steady block in 55", moves "transient left in, or too much left out";
        /// Decay times of the transient excluded after the last block that shows it.
        guard: f64 = 2.0, source "what it adds to the mean is below the noise of the mean",
            moves "bias of the amplitude";
        /// Standard errors by which the two halves of a steady motion may differ.
        halves_differ: f64 = 4.0, source "one steady motion in 1e7", moves "warnings of motions not settled";
        /// Difference of the halves over the amplitude that is ignored, however small the noise.
        halves_relative: f64 = 1e-3, source "below the accuracy of a drive", moves "warnings of motions not settled";
        /// p value of a constant drive frequency below which the frequency is taken to change along the record.
        frequency_changes: f64 = 1e-3, source "one drive of constant frequency in a thousand",
            moves "phase and amplitude under exciters whose speed changes";
        /// Minimum number of blocks for estimating the autocorrelation of the noise at the drive frequency; with
        /// fewer it is taken as white.
        noise_blocks: usize = 5, source "a variance of fewer is known to no better than a half",
            moves "standard errors of short records";
    }
}
