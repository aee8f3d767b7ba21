//! Decision thresholds of the analysis of drive levels.

use crate::inference::criteria::{InferenceCriteria, criteria, criteria_groups};

criteria_groups! {
    /// The thresholds of [`analyse_with`](super::analyse_with).
    ///
    /// ```
    /// let mut criteria = slipfit::levels::Criteria::default();
    /// criteria.levels.not_straight = 0.01;
    /// let table = criteria.table();
    /// let row = table.iter().find(|row| row.name == "levels.not_straight").expect("listed");
    /// assert_eq!(row.value, 0.01);
    /// ```
    pub struct Criteria {
        /// Thresholds shared with the other analyses, of which only `detected` and those of weak losses are used here.
        inference: InferenceCriteria,
        /// Classification and fit of stuck and moving levels.
        levels: LevelCriteria,
    }
}

criteria! {
    /// Classification and fit of stuck and moving levels.
    pub struct LevelCriteria in "levels" {
        /// Ratio of the residuals of a split into stuck and moving levels by amplitude to those of a split by drive,
        /// below which the split by amplitude is used.
        amplitude_split: f64 = 0.5, source "the noise chooses by amplitude as well, so that it must gain much",
            moves "threshold of levels raised and lowered";
        /// Lower limit of the ratio of the threshold of the line to the highest stuck level.
        stuck_reach: f64 = 0.5, source "the noise of a line may halve it", moves "which levels move";
        /// Relative difference of drives up to which readings belong to one level.
        same_level: f64 = 1e-3, source "what a source strays by", moves "which levels move, and plateaus";
        /// Ratio of the amplitude to that of the line below which a level above the threshold is stuck.
        stuck_of_expected: f64 = 0.25, source "a level that moves is read near the line",
            moves "breakaway and its warning";
        /// Number of standard errors above which the amplitude of the line is expected to be visible, and by which a
        /// level close to the threshold must exceed the noise.
        expected_errors: f64 = 4.0, source "one level in 1e4 by chance", moves "breakaway and its warning";
        /// Maximum number of rounds in which the levels are analysed with the exact motion to first order about its fit;
        /// in the second half of them no level changes between stuck and moving.
        exact_rounds: usize = 12, source "more than Newton steps need", moves "coverage at low Q and next to the threshold";
        /// Change of intercept and slope, as a fraction of their standard errors, below which the rounds end.
        exact_settled: f64 = 0.02, source "small against the error that is reported", moves "coverage at low Q";
        /// Number of standard errors by which the expected amplitude of a level must exceed the noise for it to be
        /// included in the line, if other levels stick, and by which a level that moves below a stuck one must exceed it.
        least_motion: f64 = 3.0, source "one stuck level in 100 reads as much", moves "threshold and slope of bent levels";
        /// Prior odds of noise with a part proportional to the amplitude, for levels without given errors.
        proportional_odds: f64 = 0.2, source "chosen by simulation: few levels keep their threshold",
            moves "coverage of slope and threshold";
        /// Ratio of the highest to the lowest moving amplitude above which these odds grow in proportion to it.
        narrow_span: f64 = 10.0, source "no instrument has one noise over decades; chosen by simulation",
            moves "coverage of the slope of levels over decades";
        /// Smallest ratio of the proportional variance to the floor variance at the highest amplitude.
        least_proportional: f64 = 0.01, source "less moves no weight", moves "coverage of slope and threshold";
        /// Largest ratio of the proportional variance to the floor variance at the highest amplitude.
        most_proportional: f64 = 1e6, source "a thousand times the floor: levels over five decades",
            moves "coverage of slope and threshold";
        /// Degrees of freedom required to distinguish one noise from the other.
        noise_residuals: usize = 1, source "one, and the odds", moves "coverage of slope and threshold";
        /// p value of chi square below which the given errors are too small and the scatter about the line is used.
        errors_too_small: f64 = 0.05, source "one line in twenty with right errors",
            moves "coverage of slope and threshold";
        /// Number of moving levels without given errors up to which a warning states that they are few.
        few_levels: usize = 5, source "three residuals give an error to 40 %", moves "warnings";
        /// Number of points in the upper half of a peak from which its height is fitted.
        peak_points: usize = 3, source "as many as height, place and width", moves "slope of levels that are curves";
        /// Largest residual of a fit of such a peak, over its largest amplitude, and largest amount by which the height
        /// may lie below that amplitude.
        peak_residual: f64 = 0.05, source "five times the noise of a usual curve", moves "slope of levels that are curves";
        /// Largest ratio of the fitted height to the largest amplitude.
        peak_rise: f64 = 1.5, source "the most between points of which three lie in the upper half",
            moves "slope of levels that are curves";
        /// Number of stuck levels required to determine the reading of the detector without motion.
        plateau_levels: usize = 2, source "one may be about to move", moves "threshold under a detector's zero or noise";
        /// Number of standard errors by which their reading must exceed that of noise alone.
        plateau_errors: f64 = 4.0, source "one record in 1e4 by chance",
            moves "threshold under a detector's zero or noise, and warnings";
        /// p value below which a warning names a line that is above zero at zero drive.
        above_zero: f64 = 0.001, source "one record in a thousand without friction", moves "warnings";
        /// Number of moving levels required for a test of a bend.
        bend_levels: usize = 5, source "two more than the parameters of a parabola", moves "warnings";
        /// Number of moving levels required for a comparison of a curve with the line.
        curve_levels: usize = 4, source "one more than the parameters of a parabola",
            moves "intervals of slope and threshold of few levels";
        /// Largest ratio of the loss by drag to the viscous loss, at the highest amplitude, that may go undetected in
        /// levels on a line.
        largest_bend: f64 = 1.0, source "as much as the viscous loss", moves "intervals of slope and threshold";
        /// Prior odds of a bend up to that size against a straight line.
        bend_odds: f64 = 0.3, source "chosen by simulation: errors with a drag of 10 % and without one",
            moves "slope and threshold with a bend that hides in the noise, and without one";
        /// Prior odds that bent levels lie on a curve of third power, against one of second power.
        cube_odds: f64 = 0.6, source "chosen by simulation, drag of 50 % and compression of 3 %",
            moves "slope and threshold of bent levels";
        /// Number of standard errors by which the slope must exceed zero; otherwise the levels are refused.
        least_slope: f64 = 0.1, source "an error of ten times the slope is no answer", moves "refusals";
        /// p value of a straight line below which slope and threshold are those of the curve in the limit of small
        /// amplitudes, with a warning.
        not_straight: f64 = 0.001, source "one record in a thousand on a line", moves "warnings";
    }
}
