//! Thresholds that decide how the clock of a record is interpreted.

use crate::inference::criteria::criteria;

criteria! {
    /// Thresholds for putting a record in order of time.
    pub struct ClockCriteria in "clock" {
        /// Largest backward step, in median steps, that counts as disorder; a larger one begins a new run.
        disorder_steps: f64 = 10.0, source "far beyond jitter and far below the length of a run", moves "runs told apart, rows left out";
        /// Number of rows within which disorder must end.
        disorder_rows: usize = 8, source "packets that come late are over within some rows", moves "runs told apart, refusals";
        /// Share of backward steps above which the rows may be shuffled.
        shuffled_share: f64 = 0.25, source "half of the steps of shuffled rows go back", moves "refusals";
        /// Share of repeated stamps above which a clock may be rounded or consist of bursts.
        repeated_share: f64 = 0.05, source "few stamps repeat where a clock resolves its steps", moves "clocks rebuilt";
        /// Number of significant digits up to which a clock counts as coarsely written.
        rounded_digits: usize = 7, source "single precision", moves "clocks rebuilt";
        /// Part of a step up to which jitter beyond the rounding is discarded when the clock is rebuilt.
        rounded_jitter: f64 = 0.1, source "far below what repeated stamps resolve", moves "clocks rebuilt";
        /// Part of the rounding by which the uniform clock behind rounded stamps may be off in addition.
        rounded_line: f64 = 0.1, source "the error of the line through them", moves "clocks rebuilt";
        /// Minimum number of bursts for a clock of bursts.
        bursts: usize = 4, source "fewer show no rule", moves "clocks rebuilt";
        /// Minimum share of the samples of bursts that repeat the previous stamp.
        burst_repeated: f64 = 0.5, source "two samples a burst", moves "clocks rebuilt";
        /// Minimum share of the bursts that have the usual length.
        burst_steady: f64 = 0.8, source "one burst in five may be cut or lost", moves "clocks rebuilt";
        /// Relative deviation up to which a burst has the usual length.
        burst_length: f64 = 0.1, source "a sample in ten more or less", moves "clocks rebuilt";
        /// Part of a burst by which a stamp may deviate from a uniform clock.
        burst_off: f64 = 0.25, source "delivery may be late by part of a burst", moves "clocks rebuilt";
        /// Duration of a burst over the usual one above which samples before it are missing.
        burst_lost: f64 = 1.5, source "half a burst", moves "times behind lost samples";
        /// Minimum step across the restart of a counter, in usual steps.
        wrap_least_steps: f64 = 0.3, source "jitter of a microcontroller", moves "runs told apart";
        /// Maximum step across the restart of a counter, in usual steps.
        wrap_most_steps: f64 = 2.5, source "one sample may be lost there", moves "runs told apart";
        /// Usual steps below which the first stamp of a run counts as zero.
        zero_steps: f64 = 1.5, source "half a step beside the first sample", moves "runs told apart";
        /// Minimum share of the steps that are close to the usual one in a regular clock.
        regular_share: f64 = 0.8, source "most of the steps", moves "gaps reported";
        /// Relative deviation from the usual step up to which a step is close to it.
        regular_spread: f64 = 0.2, source "jitter of a timer", moves "gaps reported";
        /// Step of a regular clock, in usual steps, above which samples are missing.
        regular_gap: f64 = 1.5, source "half a sample", moves "gaps reported";
        /// Step of an irregular clock, in usual steps of the record and of its neighbours, above which samples are
        /// missing.
        irregular_gap: f64 = 10.0, source "far beyond the scatter of such a clock", moves "gaps reported";
    }
}
