//! Decision thresholds of the analysis of a resonance curve.

use crate::answer::ReportCriteria;
use crate::inference::criteria::{InferenceCriteria, criteria, criteria_groups};

/// Number of points in one direction of the frequency that form a run.
pub(super) const RUN_POINTS: usize = 5;

criteria_groups! {
    /// The thresholds of [`analyse_with`](super::analyse_with), by the step to which they apply.
    ///
    /// ```
    /// let mut criteria = slipfit::resonance::Criteria::default();
    /// criteria.peak.above_noise = 8.0;
    /// let table = criteria.table();
    /// let row = table.iter().find(|row| row.name == "peak.above_noise").expect("listed");
    /// assert_eq!(row.value, 8.0);
    /// ```
    pub struct Criteria {
        /// Shared with the other analyses.
        inference: InferenceCriteria,
        /// Points before any fit.
        preparation: PreparationCriteria,
        /// Peaks and jumps before any model.
        peak: PeakCriteria,
        /// Start values of background and delay.
        instrument: InstrumentCriteria,
        /// Search of the minimum from many start values.
        search: SearchCriteria,
        /// Residuals of a fit.
        residuals: ResidualCriteria,
        /// Noise that grows with the amplitude.
        noise: NoiseCriteria,
        /// Columns in addition to the response.
        columns: ColumnCriteria,
        /// The friction-free reference.
        reference: ReferenceCriteria,
        /// Terms added automatically.
        terms: TermCriteria,
        /// The choice among hypotheses.
        selection: SelectionCriteria,
        /// The loss models.
        models: LossModelCriteria,
        /// The force balance without a model.
        force: ForceCriteria,
        /// Lag of the points behind the frequency.
        lag: LagCriteria,
        /// The answer and its warnings.
        answer: AnswerCriteria,
        /// Report on the models compared.
        report: ReportCriteria,
    }
}

criteria! {
    /// Points before any fit.
    pub struct PreparationCriteria in "preparation" {
        /// Number of points required for a fit.
        least_points: usize = 4, source "one more than frequency, loss and height",
            moves "refusals";
        /// Number of points from which a curve may be fitted by means of neighbours.
        dense_points: usize = 1000, source "chosen by simulation", moves "time of analysis";
        /// Maximum width of such a group, over the half width of the peak.
        group_width: f64 = 0.03, source "curvature lost is below a thousandth of the height",
            moves "bias of dense curves";
        /// Largest change of a parameter, in standard errors, due to the curvature lost in such groups, above which the
        /// means are corrected for it.
        group_errors: f64 = 0.1, source "adds half a per cent to the root mean square error",
            moves "bias of dense curves";
        /// Maximum number of such corrections.
        group_rounds: usize = 4, source "of curves without noise two or three lead to rounding",
            moves "bias of dense curves without noise";
    }
}

criteria! {
    /// Peaks and jumps before any model.
    pub struct PeakCriteria in "peak" {
        /// p value below which a resonance describes the points better than a straight line by more than chance,
        /// multiplied by the number of possible positions of such a peak.
        chance: f64 = 1e-3, source "of 3600 curves of noise or a slope, 21 to 101 points, none is answered by it",
            moves "refusals";
        /// Distance of the farthest point from the mean of all, in standard deviations of the noise, above which there
        /// is a peak even if the p value does not show it.
        above_noise: f64 = 6.0, source "of some hundred normal numbers hardly one lies so far",
            moves "refusals";
        /// Distance of the farthest point from the mean, as a fraction of the mean, for a curve without noise.
        above_mean: f64 = 1e-6, source "chosen by simulation", moves "refusals";
        /// Rise of a second peak above the saddle, in standard deviations of the noise.
        second_above_noise: f64 = 8.0, source "chosen by simulation", moves "warnings of second peaks";
        /// Rise of a second peak above the saddle over the height of the main peak.
        second_of_height: f64 = 0.08, source "chosen by simulation", moves "warnings of second peaks";
        /// Rise of a second peak above the saddle over its own height.
        second_of_own: f64 = 0.25, source "chosen by simulation", moves "warnings of second peaks";
        /// Fraction of the rise that a neighbour of the second peak must share.
        second_neighbour: f64 = 0.4, source "chosen by simulation", moves "warnings of second peaks";
        /// Step between neighbours, over the height of the peak, that counts as a jump.
        jump_of_height: f64 = 0.35, source "chosen by simulation", moves "warnings of jumps";
        /// Step between neighbours, in standard deviations of the noise, that counts as a jump.
        jump_above_noise: f64 = 8.0, source "chosen by simulation", moves "warnings of jumps";
        /// Ratio of the slope of a jump to the steepest slope of the other flank.
        jump_steepness: f64 = 3.0, source "chosen by simulation", moves "warnings of jumps";
    }
}

criteria! {
    /// Start values of background and delay.
    pub struct InstrumentCriteria in "instrument" {
        /// Number of points from which a straight baseline is tried.
        baseline_points: usize = 20, source "chosen by simulation", moves "start values";
        /// The fraction of points at either end that determines the baseline is one over this number.
        baseline_part: usize = 50, source "chosen by simulation", moves "start values";
        /// Height of a peak above its baseline, in standard deviations of the noise.
        baseline_above_noise: f64 = 12.0, source "chosen by simulation", moves "start values";
        /// Number of points from which a pole with background and delay is tried.
        pole_points: usize = 10, source "chosen by simulation", moves "start values";
        /// Longest delay tried, in quarters of a turn across the sweep, for both signs.
        most_quarters: usize = 40, source "ten turns across a sweep", moves "delays found";
        /// Ratio of the sum of squares of a pole with a delay to that of one without at which they count as equal.
        delay_penalty: f64 = 1.1, source "chosen by simulation", moves "delays found";
        /// Maximum number of start values that are fitted.
        most_starts: usize = 4, source "chosen by simulation", moves "time of analysis";
        /// Ratio of the sum of squares to the smallest one above which a start is not fitted: a peak with friction is
        /// not exactly a pole, and a wrong delay may compensate for some of the difference.
        worth_a_fit: f64 = 10.0, source "chosen by simulation", moves "delays found";
    }
}

criteria! {
    /// Search of the minimum from many start values.
    pub struct SearchCriteria in "search" {
        /// Number of starts followed to their minimum.
        tries: usize = 3, source "chosen by simulation", moves "minima missed";
        /// Number of minima of thinned points followed with all points.
        last_tries: usize = 2, source "chosen by simulation", moves "minima missed";
        /// Number of points used to find where a start leads.
        few_points: usize = 200, source "chosen by simulation", moves "time of analysis";
        /// Number of these points that must lie on the peak, and off the peak.
        few_on_peak: usize = 20, source "chosen by simulation", moves "minima missed";
        /// Ratio of the sum of squares to the smallest one above which a start is not followed.
        hopeless: f64 = 30.0, source "chosen by simulation", moves "minima missed";
        /// Accuracy, in standard errors, of the fit of a starting point.
        rough_errors: f64 = 0.3, source "the fit goes the rest of the way", moves "time of analysis";
        /// Work after which the search for the fit ends with the best result so far. A point in closed form counts as
        /// 1, eight points with a stop as 40, others according to their time: a million takes about 25 ms on one core.
        most_work: usize = 11_500_000, source "0.4 s on one core", moves "time of analysis";
        /// Number of points above which more work is allowed.
        plain_points: usize = 401, source "what an instrument records by default", moves "time of analysis";
        /// Additional work for each point above that number.
        work_per_point: usize = 60_000, source "what curves of resonators take, with room to spare",
            moves "time of analysis";
        /// Maximum number of points for which additional work is allowed.
        most_working_points: usize = 850, source "1.6 s on one core in all",
            moves "time of analysis";
        /// Fraction of that work after which the search for the intervals ends.
        interval_part: f64 = 0.17, source "what curves of resonators take, with room to spare",
            moves "time of analysis";
        /// Fraction of the remaining work that one start, or one hypothesis about a curve with phases, may use.
        share: f64 = 0.5, source "the rest is for those after it", moves "minima missed";
        /// Fraction of that work that is reserved, once, for the loss models of the plain curve, whatever the search
        /// used.
        models_part: f64 = 0.15, source "a model from its neighbour takes few steps", moves "curves refused";
        /// Difference of two sums of squares, in variances of one observation, below which they belong to the same
        /// minimum.
        same_minimum: f64 = 1e-3, source "far below one standard error", moves "time of analysis";
    }
}

impl SearchCriteria {
    /// Work allowed for a curve with this number of points.
    pub(crate) fn work(&self, points: usize) -> u64 {
        let beyond = points.saturating_sub(self.plain_points).min(self.most_working_points);
        self.most_work.saturating_add(self.work_per_point.saturating_mul(beyond)) as u64
    }
}

criteria! {
    /// Residuals of a fit.
    pub struct ResidualCriteria in "residuals" {
        /// The lowest amplitudes, one in this number, bound the noise that adds to amplitudes (Rice).
        rice_part: usize = 10, source "chosen by simulation", moves "bias of amplitudes";
        /// Number of points from which outliers are left out.
        outlier_points: usize = 20, source "chosen by simulation", moves "outliers";
        /// Distance, in robust standard deviations, above which a single point is an outlier.
        outlier_deviations: f64 = 7.0, source "no normal number in 1e11", moves "outliers";
        /// Fraction of that distance above which a neighbour makes the point part of a feature.
        outlier_neighbour: f64 = 0.5, source "chosen by simulation", moves "outliers";
        /// At most one in this number of points is an outlier.
        outlier_part: usize = 20, source "chosen by simulation", moves "outliers";
        /// Standard errors above which an autocorrelation is taken into account.
        autocorrelation_errors: f64 = 2.8, source "one curve in 400 by chance", moves "coverage";
    }
}

criteria! {
    /// Noise that grows with the amplitude.
    pub struct NoiseCriteria in "noise" {
        /// Twice the logarithm of the odds of all proportional noise laws against constant noise above which the most
        /// probable of them is reported; below, the noise is constant and the intervals account for both.
        proportional_margin: f64 = 10.0, source "Kass and Raftery 1995: very strong evidence",
            moves "coverage of curves with proportional noise";
        /// Prior probability of a proportional part whose variance relative to the floor lies in a given decade,
        /// relative to that of no such part.
        proportional_odds: f64 = 1.0, source "no order of magnitude is preferred; chosen by simulation",
            moves "coverage of curves of few points with proportional noise, and width of intervals without it";
        /// Ratio of the noise to the amplitude above which such a part is improbable a priori.
        most_proportional: f64 = 0.01, source "ranges, gains and drives wander by less",
            moves "coverage of curves of few points with proportional noise, and width of intervals without it";
        /// Probability below which a noise law is neglected.
        least_weight: f64 = 0.005, source "far below a half of 2.5 %, several of them", moves "coverage";
        /// Number of observations required in excess of the parameters.
        spare_observations: f64 = 6.0, source "chosen by simulation",
            moves "coverage of curves with few points";
        /// Number of iterations of fit and noise.
        rounds: usize = 2, source "chosen by simulation", moves "time of analysis";
        /// Factor within which the ratio of the proportional part to the floor has converged.
        settled: f64 = 1.5, source "weights matter by their root", moves "time of analysis";
    }
}

criteria! {
    /// Columns in addition to the response: errors of points, drive.
    pub struct ColumnCriteria in "columns" {
        /// Standard deviation of the logarithm of the errors from point to point above which they may have been
        /// estimated from few repeats.
        error_scatter: f64 = 0.1, source "that of fifty repeats, 1/sqrt(2 (50 - 1))",
            moves "coverage of curves with errors of few repeats";
        /// Highest degree of the polynomial in the frequency used to smooth a measured drive.
        course_degree: usize = 3, source "an amplifier and its load are smooth across a line",
            moves "coverage of curves with a measured drive";
        /// Relative scatter of the drive about this polynomial above which it may be noise of the reading.
        drive_scatter: f64 = 1e-6, source "digits that are printed", moves "coverage of curves with a measured drive";
        /// BIC decrease by which a fit without a column must be better for the column not to be used.
        margin: f64 = 6.0, source "Kass and Raftery 1995: strong evidence",
            moves "coverage of curves with a measured drive, or with errors of few repeats";
    }
}

criteria! {
    /// The friction-free reference.
    pub struct ReferenceCriteria in "reference" {
        /// Change of the logarithm of its weight below which the weight has converged.
        weight_change: f64 = 0.2, source "chosen by simulation", moves "coverage";
        /// Maximum number of updates of the weight.
        weight_rounds: usize = 3, source "chosen by simulation", moves "coverage";
        /// Prior odds that a curve of amplitudes was measured with another gain or drive than its reference.
        other_gain_odds: f64 = 0.05, source "a setting is seldom changed unnoticed; chosen by simulation",
            moves "coverage beside a reference at another gain, and width of intervals beside one at the same";
    }
}

criteria! {
    /// Terms added automatically.
    pub struct TermCriteria in "terms" {
        /// BIC decrease required for each additional background or delay.
        instrument_margin: f64 = 4.0, source "of curves without one, one in 500 is given a background",
            moves "backgrounds and delays missed, and added for nothing";
        /// Amount by which the BIC decrease due to drag may be smaller than that due to another term for drag to be
        /// added instead.
        drag_preference: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "bias of friction under drag";
        /// Amount by which the BIC with drag must be lower than with a background instead, for amplitudes without
        /// phases: these hardly distinguish the two, and a background is more common.
        drag_over_background: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "drag chosen falsely, and missed, of amplitudes";
        /// Amount by which the BIC with a noise floor must be lower than with a constant in every amplitude.
        floor_over_constant: f64 = 2.0, source "a constant of 0.5 % named in 17 of 20 curves",
            moves "constants and noise floors taken for each other";
        /// Number of observations required in excess of the parameters.
        spare_observations: usize = 4, source "chosen by simulation", moves "terms added";
        /// Factor on the gain predicted by one linear step: several steps gain more.
        promise_factor: f64 = 3.0, source "chosen by simulation", moves "terms missed";
        /// Smallest predicted fraction of the sum of squares that remains.
        promise_rest: f64 = 0.05, source "chosen by simulation", moves "terms missed";
        /// Number of points used to find where a background in amplitudes leads.
        background_points: usize = 40, source "chosen by simulation", moves "time of analysis";
        /// Maximum number of minima with a background in amplitudes that are kept.
        kept_minima: usize = 8, source "chosen by simulation", moves "coverage under a background";
        /// Difference, in standard errors, by which two such minima are distinct.
        distinct_errors: f64 = 0.1, source "far below one standard error", moves "time of analysis";
        /// Number of standard errors by which a loss may be negative at a minimum of amplitudes with a background.
        negative_errors: f64 = 3.0, source "one curve in a thousand without that loss",
            moves "coverage of curves on a background";
    }
}

criteria! {
    /// The choice among hypotheses: the plain curve, background and delay from the start, amplitudes alone.
    pub struct SelectionCriteria in "selection" {
        /// Residuals of the plain curve over the height of the peak above which its phases are suspect.
        implausible_residual: f64 = 0.08, source "chosen by simulation", moves "phases ignored";
        /// Ratio of the variance of the residuals to that of the points about their mean above which the phases are
        /// suspect as well: for a narrow peak on a high background small residuals are most of the signal.
        implausible_part: f64 = 0.3, source "chosen by simulation", moves "background and delay";
        /// Ratio of the residual variance to that of the noise below which nothing remains to be explained.
        noise_variances: f64 = 2.0, source "chosen by simulation", moves "background and delay";
        /// Ratio of the variance of a hypothesis with instrument terms to the largest acceptable one, above which its
        /// loss models are not compared.
        hopeless: f64 = 30.0, source "loss models take away less", moves "time of analysis";
        /// Ratio of the variance with background and delay from the start to that of the plain curve with these terms
        /// added one by one, below which the former is taken.
        together: f64 = 0.8, source "chosen by simulation", moves "background and delay";
        /// Largest ratio of the variance with phases to that of the amplitudes alone: correct phases double the data
        /// and need not fit equally well.
        phases_over_amplitudes: f64 = 2.0, source "phases are half the data", moves "phases ignored";
        /// Largest ratio of the variance with phases to that of the plain curve with suspect phases.
        phases_over_plain: f64 = 0.5, source "chosen by simulation", moves "phases ignored";
        /// Largest ratio of the variance of amplitudes alone to that of the plain curve.
        amplitudes_over_plain: f64 = 0.06, source "chosen by simulation", moves "phases ignored";
    }
}

criteria! {
    /// The loss models.
    pub struct LossModelCriteria in "models" {
        /// Number of standard errors above zero from which no model without a viscous loss is fitted.
        surely_viscous: f64 = 10.0, source "no data prefer such a model", moves "time of analysis";
        /// Excess of the sum of squares over the smallest one, in variances, up to which a minimum explains the data
        /// equally well.
        equal_minima: f64 = 4.0, source "about the 95 % point of chi square", moves "coverage under a background";
    }
}

criteria! {
    /// The force balance without a model.
    pub struct ForceCriteria in "force" {
        /// Ratio of noise to amplitude above which a point is not used for the line.
        most_noise: f64 = 0.3, source "chosen by simulation", moves "the line through the forces";
        /// Number of points required for a line.
        least_points: usize = 4, source "two more than unknowns", moves "the line through the forces";
    }
}

criteria! {
    /// Lag of the points behind the frequency.
    pub struct LagCriteria in "lag" {
        /// Longest time between two points that is tried, in units of the relaxation time of the resonator or the
        /// instrument.
        longest_step: f64 = 2.0, source "what is kept then, a seventh, hardly shows but in the frequency",
            moves "warnings";
        /// Ratio of each time tried to the previous one.
        finer: f64 = 0.6, source "chosen by simulation", moves "time of analysis";
        /// Number of times tried.
        steps: usize = 10, source "to a fiftieth", moves "warnings";
        /// Fraction of a lag that must not be absorbed by the parameters.
        least_seen: f64 = 1e-6, source "far above rounding", moves "warnings";
        /// Decrease of the sum of squares, in variances, required for a lag.
        least_gain: f64 = 18.0, source "the most of 880 curves without a lag is 14", moves "warnings";
        /// Ratio of the variance to that of the noise to which a lag must reduce the residuals if these are more than
        /// noise.
        noise_variances: f64 = 1.5, source "chosen by simulation", moves "warnings";
        /// BIC decrease required for a lag in place of instrument terms or the Duffing term.
        margin: f64 = 10.0, source "Kass and Raftery 1995: very strong evidence", moves "warnings";
    }
}

criteria! {
    /// The answer and its warnings.
    pub struct AnswerCriteria in "answer" {
        /// Ratio of the standard error of the friction displacement to the drive above which the bias of least squares,
        /// which increases as its square, is corrected.
        vague_friction: f64 = 0.2, source "chosen by simulation", moves "bias of friction and drive";
        /// Largest correction of an estimate, in standard errors; beyond it the second-order approximation fails.
        most_correction: f64 = 0.5, source "chosen by simulation", moves "bias of friction and drive";
        /// Number of points required for a run up or down to be evaluated separately.
        run_points: usize = RUN_POINTS, source "as many as describe a line", moves "warnings, and the curve drawn";
        /// Ratio of the noise between neighbouring points to that between residuals below which the former is too small
        /// to be that of the curve.
        least_noise: f64 = 0.1, source "chosen by simulation", moves "warnings";
        /// Points within the line below which its shape is poorly sampled.
        points_in_line: usize = 4, source "as many as unknowns", moves "warnings";
        /// Ratio of the width of the interval of the friction ratio to the ratio above which the shape alone says
        /// little.
        shape_interval: f64 = 0.3, source "chosen by simulation", moves "warnings";
        /// Friction ratio below which that width is divided by this value instead.
        shape_ratio: f64 = 0.3, source "chosen by simulation", moves "warnings";
        /// Correlation above which the viscous and the sliding term are not separable.
        inseparable: f64 = 0.99, source "chosen by simulation", moves "warnings";
        /// Relative standard error of the decay rate above which such a correlation matters.
        inseparable_error: f64 = 0.5, source "chosen by simulation", moves "warnings";
        /// Largest distance of the reference in frequency, in half widths of the line.
        reference_widths: f64 = 5.0, source "one resonator keeps its frequency", moves "warnings";
        /// Largest ratio of the damping of the reference to that of the curve.
        reference_damping: f64 = 3.0, source "one resonator keeps its damping", moves "warnings";
        /// Probability above which another gain of the reference is named in a warning.
        other_gain: f64 = 0.5, source "more probable than not", moves "warnings";
        /// p value below which the reference itself has friction.
        reference_slides: f64 = 0.001, source "chosen by simulation", moves "warnings";
        /// Penalty on a parameter of another set of instrument terms, in units of twice the log-likelihood, when its
        /// fit is weighted against the reported one.
        alternative_penalty: f64 = 3.0, source "chosen by simulation, between Akaike's 2 and the BIC",
            moves "coverage under a background too weak to be seen, and width of intervals without one";
        /// Prior odds of an amplitude-dependent frequency, for the natural frequency.
        duffing_odds: f64 = 9.0, source "springs are linear by approximation only; chosen by simulation",
            moves "coverage of the natural frequency under a Duffing term, and width of its intervals";
        /// Weight relative to the reported fit below which another fit is neglected.
        least_weight: f64 = 0.001, source "far below a half of 2.5 %", moves "coverage";
        /// Number of standard errors below zero from which a delay is rejected: no instrument responds before its
        /// drive.
        negative_delay: f64 = 3.0, source "of 300 curves of a resonance none, whatever cables and filters",
            moves "warnings";
        /// Number of standard errors by which other instrument terms must change a loss to be named.
        rival_errors: f64 = 2.0, source "chosen by simulation", moves "warnings";
        /// Ratio of the noise of the residuals to that within one run above which the latter is used to compare the
        /// runs.
        runs_noise: f64 = 1.5, source "chosen by simulation", moves "warnings";
        /// Ratio of the distance of neighbouring points to the half width of the line above which runs are not compared
        /// between them.
        run_spacing: f64 = 0.3, source "a straight line is no curve", moves "warnings";
        /// Number of points required for a comparison of runs.
        runs_compared: f64 = 5.0, source "chosen by simulation", moves "warnings";
        /// Difference of the runs over the height of the peak above which it is a jump.
        hysteresis_height: f64 = 0.25, source "chosen by simulation", moves "warnings";
        /// The same difference over the noise.
        hysteresis_noise: f64 = 8.0, source "chosen by simulation", moves "warnings";
        /// Number of standard errors of chi square above which the runs differ.
        runs_differ: f64 = 4.0, source "one curve in some ten thousand", moves "warnings";
    }
}
