//! Every threshold that decides how the clock of a record is read.

use crate::inference::criteria::criteria;

criteria! {
    /// The thresholds by which a record is put in order of time.
    pub struct ClockCriteria in "clock" {
        /// Median steps up to which a step back is disorder, above which the clock begins anew.
        disorder_steps: f64 = 10.0, source "far beyond jitter and far below the length of a run", moves "runs told apart, rows left out";
        /// Rows within which disorder is over.
        disorder_rows: usize = 8, source "packets that come late are over within some rows", moves "runs told apart, refusals";
        /// Part of all steps that go back from which on rows may be in no order at all.
        shuffled_share: f64 = 0.25, source "half of the steps of shuffled rows go back", moves "refusals";
        /// Part of stamps that repeat the one before above which a clock may be a rounded one, or one of bursts.
        repeated_share: f64 = 0.05, source "few stamps repeat where a clock resolves its steps", moves "clocks rebuilt";
        /// Significant digits up to which a clock counts as coarsely written.
        rounded_digits: usize = 7, source "single precision", moves "clocks rebuilt";
        /// Part of a step up to which jitter beyond the rounding is given up with it.
        rounded_jitter: f64 = 0.1, source "far below what repeated stamps resolve", moves "clocks rebuilt";
        /// Part of the rounding up to which the even clock behind rounded stamps may be off besides.
        rounded_line: f64 = 0.1, source "the error of the line through them", moves "clocks rebuilt";
        /// Bursts that make a clock.
        bursts: usize = 4, source "fewer show no rule", moves "clocks rebuilt";
        /// Part of the samples of bursts that repeat the stamp before.
        burst_repeated: f64 = 0.5, source "two samples a burst", moves "clocks rebuilt";
        /// Part of the bursts that have the usual length.
        burst_steady: f64 = 0.8, source "one burst in five may be cut or lost", moves "clocks rebuilt";
        /// What of its length the number of samples of such a burst may differ.
        burst_length: f64 = 0.1, source "a sample in ten more or less", moves "clocks rebuilt";
        /// Part of a burst by which a stamp may lie off an even clock.
        burst_off: f64 = 0.25, source "delivery may be late by part of a burst", moves "clocks rebuilt";
        /// Times the usual length of a burst from which on samples are missing before it.
        burst_lost: f64 = 1.5, source "half a burst", moves "times behind lost samples";
        /// Usual steps over the place where a counter begins again, at least.
        wrap_least_steps: f64 = 0.3, source "jitter of a microcontroller", moves "runs told apart";
        /// The same at most.
        wrap_most_steps: f64 = 2.5, source "one sample may be lost there", moves "runs told apart";
        /// Usual steps below which the first stamp of a run is zero.
        zero_steps: f64 = 1.5, source "half a step beside the first sample", moves "runs told apart";
        /// Part of the steps that lie near the usual one in a regular clock.
        regular_share: f64 = 0.8, source "most of the steps", moves "gaps reported";
        /// Relative difference from the usual step up to which a step lies near it.
        regular_spread: f64 = 0.2, source "jitter of a timer", moves "gaps reported";
        /// Usual steps of a regular clock from which on samples are missing.
        regular_gap: f64 = 1.5, source "half a sample", moves "gaps reported";
        /// Usual steps, of all and of its neighbours, from which on samples of another clock are missing.
        irregular_gap: f64 = 10.0, source "far beyond the scatter of such a clock", moves "gaps reported";
    }
}
