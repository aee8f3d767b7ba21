//! Every threshold that decides something in the analysis of a resonance curve.

use crate::answer::ReportCriteria;
use crate::inference::criteria::{InferenceCriteria, criteria, criteria_groups};

/// Points in one direction of the frequency that make a run.
pub(super) const RUN_POINTS: usize = 5;

criteria_groups! {
    /// The thresholds of [`analyse_with`](super::analyse_with), by the step that they decide.
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
        /// The minimum among many start values.
        search: SearchCriteria,
        /// Residuals of a fit.
        residuals: ResidualCriteria,
        /// Noise that grows with the amplitude.
        noise: NoiseCriteria,
        /// Columns beside the response.
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
        /// Points that lag behind the frequency.
        lag: LagCriteria,
        /// The answer and its warnings.
        answer: AnswerCriteria,
        /// What is reported of the models compared.
        report: ReportCriteria,
    }
}

criteria! {
    /// Points before any fit.
    pub struct PreparationCriteria in "preparation" {
        /// Points without which no curve is fitted.
        least_points: usize = 4, source "one more than frequency, loss and height",
            moves "refusals";
        /// Points from which on a curve may be fitted by means of neighbours.
        dense_points: usize = 1000, source "chosen by simulation", moves "time of analysis";
        /// Most width of such a group, over the half width of the peak.
        group_width: f64 = 0.03, source "curvature lost is below a thousandth of the height",
            moves "bias of dense curves";
        /// Standard errors by which the curvature lost in such groups moves a parameter at most before it is taken out
        /// of their means.
        group_errors: f64 = 0.1, source "adds half a per cent to the root mean square error",
            moves "bias of dense curves";
        /// Times that it is.
        group_rounds: usize = 4, source "of curves without noise two or three lead to rounding",
            moves "bias of dense curves without noise";
    }
}

criteria! {
    /// Peaks and jumps before any model.
    pub struct PeakCriteria in "peak" {
        /// p value below which a resonance describes the points better than a straight line by more than chance,
        /// once for each place of such a peak.
        chance: f64 = 1e-3, source "of 3600 curves of noise or a slope, 21 to 101 points, none is answered by it",
            moves "refusals";
        /// Deviations of the noise by which the farthest point lies from the mean of all where there is a peak
        /// that the p value does not show.
        above_noise: f64 = 6.0, source "of some hundred normal numbers hardly one lies so far",
            moves "refusals";
        /// Part of the mean by which the farthest point lies from it, in a curve without noise.
        above_mean: f64 = 1e-6, source "chosen by simulation", moves "refusals";
        /// Deviations of the noise that a second peak rises above the saddle.
        second_above_noise: f64 = 8.0, source "chosen by simulation", moves "warnings of second peaks";
        /// Rise of a second peak above the saddle over the height of the main peak.
        second_of_height: f64 = 0.08, source "chosen by simulation", moves "warnings of second peaks";
        /// Rise of a second peak above the saddle over its own height.
        second_of_own: f64 = 0.25, source "chosen by simulation", moves "warnings of second peaks";
        /// Part of the rise that a neighbour of the second peak must share.
        second_neighbour: f64 = 0.4, source "chosen by simulation", moves "warnings of second peaks";
        /// Step between neighbours over the height of the peak that counts as a jump.
        jump_of_height: f64 = 0.35, source "chosen by simulation", moves "warnings of jumps";
        /// Step between neighbours in deviations of the noise that counts as a jump.
        jump_above_noise: f64 = 8.0, source "chosen by simulation", moves "warnings of jumps";
        /// Slope of a jump over the steepest of the other flank.
        jump_steepness: f64 = 3.0, source "chosen by simulation", moves "warnings of jumps";
    }
}

criteria! {
    /// Start values of background and delay.
    pub struct InstrumentCriteria in "instrument" {
        /// Points from which on a straight baseline is looked for.
        baseline_points: usize = 20, source "chosen by simulation", moves "start values";
        /// One in so many points at either end gives the baseline.
        baseline_part: usize = 50, source "chosen by simulation", moves "start values";
        /// Deviations of the noise by which a peak stands above its baseline.
        baseline_above_noise: f64 = 12.0, source "chosen by simulation", moves "start values";
        /// Points from which on a pole with background and delay is looked for.
        pole_points: usize = 10, source "chosen by simulation", moves "start values";
        /// Longest delay tried, in quarters of a turn across the sweep either way.
        most_quarters: usize = 40, source "ten turns across a sweep", moves "delays found";
        /// Sum of squares of a pole with a delay over one without, at which they count as equal.
        delay_penalty: f64 = 1.1, source "chosen by simulation", moves "delays found";
        /// Start values that are worth a fit.
        most_starts: usize = 4, source "chosen by simulation", moves "time of analysis";
        /// Sum of squares over the least, above which a start is not worth a fit: a peak with friction
        /// is not the pole it is taken for, and a wrong delay may hide some of that.
        worth_a_fit: f64 = 10.0, source "chosen by simulation", moves "delays found";
    }
}

criteria! {
    /// The minimum among many start values.
    pub struct SearchCriteria in "search" {
        /// Starts that are followed to their minimum.
        tries: usize = 3, source "chosen by simulation", moves "minima missed";
        /// Minima of thinned points that are followed with all points.
        last_tries: usize = 2, source "chosen by simulation", moves "minima missed";
        /// Points that show where a start leads.
        few_points: usize = 200, source "chosen by simulation", moves "time of analysis";
        /// Points of those that must lie on the peak, or beside it.
        few_on_peak: usize = 20, source "chosen by simulation", moves "minima missed";
        /// Sum of squares over the least, above which a start is not followed.
        hopeless: f64 = 30.0, source "chosen by simulation", moves "minima missed";
        /// Standard errors to within which a place to start from is fitted.
        rough_errors: f64 = 0.3, source "the fit goes the rest of the way", moves "time of analysis";
        /// Work after which the search for the fit ends with what it has. A point in closed form counts as 1,
        /// eight with a stop as 40, others by their time: a million takes about 25 ms on one core.
        most_work: usize = 11_500_000, source "0.4 s on one core", moves "time of analysis";
        /// Points from which on there is more.
        plain_points: usize = 401, source "what an instrument records by default", moves "time of analysis";
        /// Further work for each point beyond.
        work_per_point: usize = 60_000, source "what curves of resonators take, with room to spare",
            moves "time of analysis";
        /// Points beyond that count for it.
        most_working_points: usize = 850, source "1.6 s on one core in all",
            moves "time of analysis";
        /// Part of that work after which the search for the intervals ends.
        interval_part: f64 = 0.17, source "what curves of resonators take, with room to spare",
            moves "time of analysis";
        /// Part of the work left that one start, or one hypothesis about a curve with phases, may take.
        share: f64 = 0.5, source "the rest is for those after it", moves "minima missed";
        /// Part of that work that is left, once, for the loss models of the plain curve, whatever the search took.
        models_part: f64 = 0.15, source "a model from its neighbour takes few steps", moves "curves refused";
        /// Difference of two sums of squares, in variances of one observation, below which they are
        /// one minimum.
        same_minimum: f64 = 1e-3, source "far below one standard error", moves "time of analysis";
    }
}

impl SearchCriteria {
    /// Work allowed to a curve of so many points.
    pub(crate) fn work(&self, points: usize) -> u64 {
        let beyond = points.saturating_sub(self.plain_points).min(self.most_working_points);
        self.most_work.saturating_add(self.work_per_point.saturating_mul(beyond)) as u64
    }
}

criteria! {
    /// Residuals of a fit.
    pub struct ResidualCriteria in "residuals" {
        /// One in so many of the amplitudes, the lowest, bounds the noise that adds to amplitudes
        /// (Rice).
        rice_part: usize = 10, source "chosen by simulation", moves "bias of amplitudes";
        /// Points from which on outliers are left out.
        outlier_points: usize = 20, source "chosen by simulation", moves "outliers";
        /// Robust deviations from which on a single point is an outlier.
        outlier_deviations: f64 = 7.0, source "no normal number in 1e11", moves "outliers";
        /// Part of that from which on a neighbour makes a feature of it.
        outlier_neighbour: f64 = 0.5, source "chosen by simulation", moves "outliers";
        /// At most one in so many points is an outlier.
        outlier_part: usize = 20, source "chosen by simulation", moves "outliers";
        /// Standard errors from which on an autocorrelation counts.
        autocorrelation_errors: f64 = 2.8, source "one curve in 400 by chance", moves "coverage";
    }
}

criteria! {
    /// Noise that grows with the amplitude.
    pub struct NoiseCriteria in "noise" {
        /// Twice the logarithm of the odds of all noises with a part in proportion to the amplitude over a constant one, above
        /// which the most probable of them is reported; below, the noise is constant and the intervals count both.
        proportional_margin: f64 = 10.0, source "Kass and Raftery 1995: very strong evidence",
            moves "coverage of curves with proportional noise";
        /// Probability before the data of a proportional part whose variance over that of the floor lies in any one decade,
        /// over that of none.
        proportional_odds: f64 = 1.0, source "no order of magnitude is preferred; chosen by simulation",
            moves "coverage of curves of few points with proportional noise, and width of intervals without it";
        /// Noise over the amplitude above which such a part is improbable before the data.
        most_proportional: f64 = 0.01, source "ranges, gains and drives wander by less",
            moves "coverage of curves of few points with proportional noise, and width of intervals without it";
        /// Probability below which a law of the noise does not count.
        least_weight: f64 = 0.005, source "far below a half of 2.5 %, several of them", moves "coverage";
        /// Observations that must be left beside the parameters.
        spare_observations: f64 = 6.0, source "chosen by simulation",
            moves "coverage of curves with few points";
        /// Rounds of fit and noise.
        rounds: usize = 2, source "chosen by simulation", moves "time of analysis";
        /// Factor within which a ratio of proportional part to floor is settled.
        settled: f64 = 1.5, source "weights matter by their root", moves "time of analysis";
    }
}

criteria! {
    /// Columns beside the response: errors of points, drive.
    pub struct ColumnCriteria in "columns" {
        /// Standard deviation of the logarithm of the errors from point to point above which they may be those of few
        /// repeats.
        error_scatter: f64 = 0.1, source "that of fifty repeats, 1/sqrt(2 (50 - 1))",
            moves "coverage of curves with errors of few repeats";
        /// Highest degree of the polynomial in the frequency that a measured drive may follow.
        course_degree: usize = 3, source "an amplifier and its load are smooth across a line",
            moves "coverage of curves with a measured drive";
        /// Scatter of the drive about it, relative, from which on it may be noise of its reading.
        drive_scatter: f64 = 1e-6, source "digits that are printed", moves "coverage of curves with a measured drive";
        /// BIC by which a fit without a column must be better, for the column to be set aside.
        margin: f64 = 6.0, source "Kass and Raftery 1995: strong evidence",
            moves "coverage of curves with a measured drive, or with errors of few repeats";
    }
}

criteria! {
    /// The friction-free reference.
    pub struct ReferenceCriteria in "reference" {
        /// Change of the logarithm of its weight below which the weight is settled.
        weight_change: f64 = 0.2, source "chosen by simulation", moves "coverage";
        /// Times that the weight is renewed.
        weight_rounds: usize = 3, source "chosen by simulation", moves "coverage";
        /// Odds before the data of a curve of amplitudes read with another gain, or driven otherwise, than its reference.
        other_gain_odds: f64 = 0.05, source "a setting is seldom changed unnoticed; chosen by simulation",
            moves "coverage beside a reference at another gain, and width of intervals beside one at the same";
    }
}

criteria! {
    /// Terms added automatically.
    pub struct TermCriteria in "terms" {
        /// What the BIC of a fit must be better by for each of background and delay that it has more.
        instrument_margin: f64 = 4.0, source "of curves without one, one in 500 is given a background",
            moves "backgrounds and delays missed, and added for nothing";
        /// By how much less than another term drag may lower the BIC and is added instead.
        drag_preference: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "bias of friction under drag";
        /// By how much the BIC with drag must be lower than that with a background instead, of amplitudes without
        /// phases: they tell hardly one from the other, and a background is the rule.
        drag_over_background: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "drag chosen falsely, and missed, of amplitudes";
        /// By how much the BIC with a noise floor must be lower than that with a constant in every amplitude.
        floor_over_constant: f64 = 2.0, source "a constant of 0.5 % named in 17 of 20 curves",
            moves "constants and noise floors taken for each other";
        /// Observations that must be left beside the parameters.
        spare_observations: usize = 4, source "chosen by simulation", moves "terms added";
        /// Times its gain that one linear step may promise: several steps bring more.
        promise_factor: f64 = 3.0, source "chosen by simulation", moves "terms missed";
        /// Least part of the sum of squares that a promise leaves.
        promise_rest: f64 = 0.05, source "chosen by simulation", moves "terms missed";
        /// Points that show where a background under amplitudes leads.
        background_points: usize = 40, source "chosen by simulation", moves "time of analysis";
        /// Minima with a background under amplitudes that are kept.
        kept_minima: usize = 8, source "chosen by simulation", moves "coverage under a background";
        /// Standard errors by which two such minima differ.
        distinct_errors: f64 = 0.1, source "far below one standard error", moves "time of analysis";
        /// Standard errors by which a loss may lie below zero in a minimum of amplitudes on a background.
        negative_errors: f64 = 3.0, source "one curve in a thousand without that loss",
            moves "coverage of curves on a background";
    }
}

criteria! {
    /// The choice among hypotheses: the plain curve, background and delay from the start, amplitudes
    /// alone.
    pub struct SelectionCriteria in "selection" {
        /// Residual of the plain curve over the height of the peak, from which on its phases are
        /// suspect.
        implausible_residual: f64 = 0.08, source "chosen by simulation", moves "phases ignored";
        /// Its variance over that of the points about their mean, from which on they are as well: beside a narrow
        /// peak on a high background a small residual is most of what there is to explain.
        implausible_part: f64 = 0.3, source "chosen by simulation", moves "background and delay";
        /// Variance over that of the noise below which nothing is left to explain.
        noise_variances: f64 = 2.0, source "chosen by simulation", moves "background and delay";
        /// Variance of a hypothesis with instrument terms, over the most with which it may be taken, from which on
        /// its loss models are not compared.
        hopeless: f64 = 30.0, source "loss models take away less", moves "time of analysis";
        /// Variance with background and delay from the start, over the plain curve's with the terms
        /// added to it one by one, below which the former is taken.
        together: f64 = 0.8, source "chosen by simulation", moves "background and delay";
        /// Most variance with phases over that of the amplitudes alone: phases that were ever right
        /// double the data and need not do as well to the last digit.
        phases_over_amplitudes: f64 = 2.0, source "phases are half the data", moves "phases ignored";
        /// Most variance with phases over that of the plain curve whose phases are suspect.
        phases_over_plain: f64 = 0.5, source "chosen by simulation", moves "phases ignored";
        /// Most variance of amplitudes alone over that of the plain curve.
        amplitudes_over_plain: f64 = 0.06, source "chosen by simulation", moves "phases ignored";
    }
}

criteria! {
    /// The loss models.
    pub struct LossModelCriteria in "models" {
        /// Standard errors above zero from which on no model without a viscous loss is fitted.
        surely_viscous: f64 = 10.0, source "no data prefer such a model", moves "time of analysis";
        /// Sum of squares above the least, in variances, up to which a minimum explains the data as
        /// well.
        equal_minima: f64 = 4.0, source "about the 95 % point of chi square", moves "coverage under a background";
    }
}

criteria! {
    /// The force balance without a model.
    pub struct ForceCriteria in "force" {
        /// Noise over amplitude from which on a point takes no part in the line.
        most_noise: f64 = 0.3, source "chosen by simulation", moves "the line through the forces";
        /// Points without which there is no line.
        least_points: usize = 4, source "two more than unknowns", moves "the line through the forces";
    }
}

criteria! {
    /// Points that lag behind the frequency.
    pub struct LagCriteria in "lag" {
        /// Longest time between two points that is tried, in times in which the resonator or the instrument forgets.
        longest_step: f64 = 2.0, source "what is kept then, a seventh, hardly shows but in the frequency",
            moves "warnings";
        /// Each time tried over the one before.
        finer: f64 = 0.6, source "chosen by simulation", moves "time of analysis";
        /// Times tried.
        steps: usize = 10, source "to a fiftieth", moves "warnings";
        /// Part of a lag that the parameters must leave over.
        least_seen: f64 = 1e-6, source "far above rounding", moves "warnings";
        /// Sum of squares, in variances, by which a lag must lower that of the fit.
        least_gain: f64 = 18.0, source "the most of 880 curves without a lag is 14", moves "warnings";
        /// Variance over that of the noise below which a lag explains what is left where that is more than noise.
        noise_variances: f64 = 1.5, source "chosen by simulation", moves "warnings";
        /// BIC by which a lag in the place of terms of the instrument or the spring must be better.
        margin: f64 = 10.0, source "Kass and Raftery 1995: very strong evidence", moves "warnings";
    }
}

criteria! {
    /// The answer and its warnings.
    pub struct AnswerCriteria in "answer" {
        /// Standard error of the friction displacement over the drive from which on the bias of least
        /// squares, which goes with its square, is corrected.
        vague_friction: f64 = 0.2, source "chosen by simulation", moves "bias of friction and drive";
        /// Standard errors by which that correction may move an estimate: more is no second order.
        most_correction: f64 = 0.5, source "chosen by simulation", moves "bias of friction and drive";
        /// Points of a run up or down without which it is not taken by itself.
        run_points: usize = RUN_POINTS, source "as many as describe a line", moves "warnings, and the curve drawn";
        /// Noise between neighbouring points over that between residuals below which the former is too
        /// small to be that of the curve.
        least_noise: f64 = 0.1, source "chosen by simulation", moves "warnings";
        /// Points within the line below which its shape is poorly sampled.
        points_in_line: usize = 4, source "as many as unknowns", moves "warnings";
        /// Width of the interval of the friction ratio over the ratio above which the shape alone says
        /// little.
        shape_interval: f64 = 0.3, source "chosen by simulation", moves "warnings";
        /// Friction ratio below which that width is taken over this one.
        shape_ratio: f64 = 0.3, source "chosen by simulation", moves "warnings";
        /// Correlation above which the viscous and the sliding term are one number.
        inseparable: f64 = 0.99, source "chosen by simulation", moves "warnings";
        /// Standard error of the decay rate over the rate above which such a correlation matters.
        inseparable_error: f64 = 0.5, source "chosen by simulation", moves "warnings";
        /// Half widths of the line by which the reference may lie off.
        reference_widths: f64 = 5.0, source "one resonator keeps its frequency", moves "warnings";
        /// Factor by which the damping of the reference may differ.
        reference_damping: f64 = 3.0, source "one resonator keeps its damping", moves "warnings";
        /// Probability above which another gain of the reference is named.
        other_gain: f64 = 0.5, source "more probable than not", moves "warnings";
        /// p value below which the reference has friction of its own.
        reference_slides: f64 = 0.001, source "chosen by simulation", moves "warnings";
        /// What a parameter of another set of instrument terms costs, in the logarithm of the likelihood
        /// twice over, when its fit is weighed beside the one reported.
        alternative_penalty: f64 = 3.0, source "chosen by simulation, between Akaike's 2 and the BIC",
            moves "coverage under a background too weak to be seen, and width of intervals without one";
        /// Odds before the data of a frequency that moves with the amplitude, for the natural frequency.
        duffing_odds: f64 = 9.0, source "springs are linear by approximation only; chosen by simulation",
            moves "coverage of the natural frequency under a Duffing term, and width of its intervals";
        /// Weight over that of the fit reported below which another does not count.
        least_weight: f64 = 0.001, source "far below a half of 2.5 %", moves "coverage";
        /// Standard errors below zero from which on a delay is none: no instrument answers before its drive.
        negative_delay: f64 = 3.0, source "of 300 curves of a resonance none, whatever cables and filters",
            moves "warnings";
        /// Standard errors by which other terms of the instrument must move a loss to be named.
        rival_errors: f64 = 2.0, source "chosen by simulation", moves "warnings";
        /// Noise of the residuals over that within one run above which the runs are compared by the
        /// latter.
        runs_noise: f64 = 1.5, source "chosen by simulation", moves "warnings";
        /// Distance of neighbouring points over the half width of the line above which runs are not
        /// compared between them.
        run_spacing: f64 = 0.3, source "a straight line is no curve", moves "warnings";
        /// Points at which runs must be compared.
        runs_compared: f64 = 5.0, source "chosen by simulation", moves "warnings";
        /// Difference of the runs over the height of the peak above which it is a jump.
        hysteresis_height: f64 = 0.25, source "chosen by simulation", moves "warnings";
        /// The same over the noise.
        hysteresis_noise: f64 = 8.0, source "chosen by simulation", moves "warnings";
        /// Standard errors of chi square above which the runs differ.
        runs_differ: f64 = 4.0, source "one curve in some ten thousand", moves "warnings";
    }
}
