//! Every threshold that decides something in the analysis of drive levels.

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
        /// Shared with the other analyses; of them `detected` decides something here.
        inference: InferenceCriteria,
        /// Stuck and moving levels.
        levels: LevelCriteria,
    }
}

criteria! {
    /// Stuck and moving levels.
    pub struct LevelCriteria in "levels" {
        /// What a split into stuck and moving levels by amplitude leaves, over what one by drive leaves,
        /// below which it is taken.
        amplitude_split: f64 = 0.5, source "the noise chooses by amplitude as well, so that it must gain much",
            moves "threshold of levels raised and lowered";
        /// Least threshold of the line over the highest stuck level.
        stuck_reach: f64 = 0.5, source "the noise of a line may halve it", moves "which levels move";
        /// Relative difference of drives up to which they are readings of one level.
        same_level: f64 = 1e-3, source "what a source strays by", moves "which levels move, and plateaus";
        /// Amplitude over that of the line below which a level above the threshold is stuck.
        stuck_of_expected: f64 = 0.25, source "a level that moves is read near the line",
            moves "breakaway and its warning";
        /// Standard errors above which the amplitude of the line lies there, and that of a level beside the threshold
        /// stands out of the noise.
        expected_errors: f64 = 4.0, source "one level in 1e4 by chance", moves "breakaway and its warning";
        /// Times, at most, that what the exact motion reads beside the line is taken off the levels.
        exact_rounds: usize = 12, source "what is left falls to a third and less each time", moves "coverage at low Q";
        /// Part of their standard errors by which Q and friction change in the last of them.
        exact_settled: f64 = 0.02, source "small against the error that is reported", moves "coverage at low Q";
        /// Standard errors by which the amplitude of a level must stand out of the noise, where others stick, to have a part
        /// in the line.
        least_motion: f64 = 3.0, source "one stuck level in 100 reads as much", moves "threshold and slope of bent levels";
        /// Odds before the data of a noise with a part in proportion to the amplitude, of levels without errors.
        proportional_odds: f64 = 0.2, source "chosen by simulation: few levels keep their threshold",
            moves "coverage of slope and threshold";
        /// Highest over lowest moving amplitude from which on these odds grow in proportion to it.
        narrow_span: f64 = 10.0, source "no instrument has one noise over decades; chosen by simulation",
            moves "coverage of the slope of levels over decades";
        /// Least part in proportion over the floor, at the highest amplitude and in squares, that the noise may have.
        least_proportional: f64 = 0.01, source "less moves no weight", moves "coverage of slope and threshold";
        /// Largest part in proportion over the floor, at the highest amplitude and in squares.
        most_proportional: f64 = 1e6, source "a thousand times the floor: levels over five decades",
            moves "coverage of slope and threshold";
        /// Residuals beside the parameters from which on they tell one noise from the other.
        noise_residuals: usize = 1, source "one, and the odds", moves "coverage of slope and threshold";
        /// p value of chi square below which errors given with the levels are too small, and what the line leaves counts.
        errors_too_small: f64 = 0.05, source "one line in twenty with right errors",
            moves "coverage of slope and threshold";
        /// Moving levels without errors up to which a warning says how few they are.
        few_levels: usize = 5, source "three residuals give an error to 40 %", moves "warnings";
        /// Points in the upper half of a peak from which on its height is fitted.
        peak_points: usize = 3, source "as many as height, place and width", moves "slope of levels that are curves";
        /// What a fit of such a peak may leave, over its largest amplitude, and by how much it may lie below that.
        peak_residual: f64 = 0.05, source "five times the noise of a usual curve", moves "slope of levels that are curves";
        /// The most that its height may be over the largest amplitude.
        peak_rise: f64 = 1.5, source "the most between points of which three lie in the upper half",
            moves "slope of levels that are curves";
        /// Stuck levels from which on they show what the detector reads without motion.
        plateau_levels: usize = 2, source "one may be about to move", moves "threshold under a detector's zero or noise";
        /// Standard errors by which they must read more than an amplitude of noise does.
        plateau_errors: f64 = 4.0, source "one record in 1e4 by chance",
            moves "threshold under a detector's zero or noise, and warnings";
        /// p value below which a warning names a line that lies above zero without a drive.
        above_zero: f64 = 0.001, source "one record in a thousand without friction", moves "warnings";
        /// Moving levels without which no bend is tested.
        bend_levels: usize = 5, source "two more than the parameters of a parabola", moves "warnings";
        /// Moving levels without which no curve is compared with the line.
        curve_levels: usize = 4, source "one more than the parameters of a parabola",
            moves "intervals of slope and threshold of few levels";
        /// Largest loss by drag over the viscous one, at the highest amplitude, that levels on a line may hide.
        largest_bend: f64 = 1.0, source "as much as the viscous loss", moves "intervals of slope and threshold";
        /// Odds before the data of a bend up to that over those of a line.
        bend_odds: f64 = 0.3, source "chosen by simulation: errors with a drag of 10 % and without one",
            moves "slope and threshold with a bend that hides in the noise, and without one";
        /// Odds before the data that bent levels lie on a curve of third power, over those of one of second power.
        cube_odds: f64 = 0.6, source "chosen by simulation, drag of 50 % and compression of 3 %",
            moves "slope and threshold of bent levels";
        /// p value of a straight line below which slope and threshold are those of the curve at small amplitudes, and a
        /// warning says so.
        not_straight: f64 = 0.001, source "one record in a thousand on a line", moves "warnings";
    }
}
