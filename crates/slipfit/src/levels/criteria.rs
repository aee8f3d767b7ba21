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
        /// Amplitude over that of the line below which a level above the threshold is stuck.
        stuck_of_expected: f64 = 0.25, source "a level that moves is read near the line",
            moves "breakaway and its warning";
        /// Standard errors above which the amplitude of the line lies there.
        expected_errors: f64 = 4.0, source "one level in 1e4 by chance", moves "breakaway and its warning";
        /// Odds before the data of a noise with a part in proportion to the amplitude, of levels without errors.
        proportional_odds: f64 = 0.2, source "chosen by simulation: few levels keep their threshold",
            moves "coverage of slope and threshold";
        /// Moving levels without which no bend is tested.
        bend_levels: usize = 5, source "two more than the parameters of a parabola", moves "warnings";
        /// p value of a straight line below which a warning names the bend.
        not_straight: f64 = 0.001, source "one record in a thousand on a line", moves "warnings";
    }
}
