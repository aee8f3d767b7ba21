//! Quantities from the line through the levels: slope, threshold, and with a calibrated drive Q and friction.

use super::bend::{CurvedFit, LineFunction};
use super::branch::MovingBranch;
use super::criteria::Criteria;
use super::level_row::LEAST_Q;
use super::noise::AveragedFit;
use super::{Levels, Options};
use crate::Quantity;
use crate::answer::averaged::widened;
use crate::inference::Z_95;
use crate::inference::coefficient::WeightedEstimate;
use crate::inference::evidence::{one_sided_p_value, student_factor};
use crate::inference::interval::bounded_interval;
use crate::model::displacement::DisplacementUnit;
use std::f64::consts::FRAC_PI_4;

/// Unit of the ratio of two quantities.
pub(super) fn ratio_unit(of: &str, by: &str) -> String {
    match (of, by) {
        (a, b) if a == b => String::new(),
        (a, "") => a.to_owned(),
        ("", b) => format!("1/{b}"),
        (a, b) => format!("{a}/{b}"),
    }
}

/// A non-negative quantity from an estimate that may be negative; `factor` is the ratio of Student's t to the normal
/// quantile.
pub(super) fn not_negative(estimate: f64, std_error: f64, factor: f64, unit: &str) -> Quantity {
    let wide = std_error * factor;
    // Points on a line to the last digit have no uncertainty.
    let interval_95 =
        if wide > 0.0 { bounded_interval(estimate / wide).map(|v| v * wide) } else { [estimate.max(0.0); 2] };
    Quantity {
        value: estimate.max(0.0),
        std_error,
        interval_95,
        unbounded_value: estimate,
        unit: unit.to_owned(),
    }
}

/// Quantities determined by the line.
pub(super) struct LineQuantities {
    pub(super) slope: Quantity,
    pub(super) threshold: Quantity,
    /// The loss of amplitude by friction, `slope threshold`: minus the intercept.
    pub(super) lost_amplitude: Quantity,
    /// Correlation of slope and threshold.
    pub(super) correlation: f64,
    /// Relative change of slope and threshold per relative change of the Q that shapes the exact motion.
    by_log_q: [f64; 2],
    /// p value of no sliding friction; one-sided.
    pub(super) p_value: f64,
    /// The same for a line that is above zero at zero drive.
    pub(super) p_above_zero: f64,
}

impl LineQuantities {
    /// Slope and threshold of the branch, including curves that the levels do not exclude.
    pub(super) fn of(branch: &MovingBranch, levels: &Levels, criteria: &Criteria) -> Self {
        let AveragedFit { parameters, covariance: v, dof, .. } = &branch.fit;
        let (intercept, slope) = (parameters[0], parameters[1]);
        let factor = student_factor(*dof);
        let threshold = -intercept / slope;
        // Threshold t = -a/b by the delta method; for the test of t = 0 the line through zero.
        let gradient = [-1.0 / slope, -threshold / slope];
        let [slope_std, lost_std] = [v[(1, 1)], v[(0, 0)]].map(f64::sqrt);
        let along = |k: usize| gradient[0] * v[(0, k)] + gradient[1] * v[(1, k)];
        let threshold_std = (gradient[0] * along(0) + gradient[1] * along(1)).max(0.0).sqrt();
        let correlation = if threshold_std > 0.0 {
            // If a variance nearly cancels, rounding may give a negative result.
            (along(1) / slope_std / threshold_std).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let curves = |straight: f64, gradient: [f64; 2]| -> Vec<WeightedEstimate> {
            let estimates = |rival: &CurvedFit| {
                rival.estimates(straight, gradient, &criteria.levels, &criteria.inference)
            };
            branch.rival.as_ref().map_or_else(Vec::new, estimates)
        };
        // The value is the average over line and curve; the interval contains those of both.
        let counted = |straight: Quantity, others: &[WeightedEstimate], of: LineFunction| {
            let own = straight.interval_95;
            let mut q = widened(straight, others);
            if let Some((limit, upwards)) = branch.rival.as_ref().and_then(|r| r.limit(of, &criteria.levels))
            {
                let least = if q.interval_95[0] >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
                let [low, high] = &mut q.interval_95;
                if upwards {
                    *high = high.max(limit);
                } else {
                    *low = low.min(limit.max(least));
                }
            }
            let moved: f64 = others.iter().map(|o| o.weight * (o.value - q.unbounded_value)).sum();
            q.unbounded_value += moved;
            q.value = if q.interval_95[0] >= 0.0 { q.unbounded_value.max(0.0) } else { q.unbounded_value };
            // The value lies at one end of the possible range of a bend.
            if q.interval_95 != own {
                let [low, high] = q.interval_95;
                q.std_error = q.std_error.max((high - q.value).max(q.value - low) / Z_95);
            }
            q
        };
        let lost = curves(-intercept, [-1.0, 0.0]);
        let evidence = |side: f64| {
            let p = |lost: f64, std_error: f64, dof: f64| {
                if side * lost > 0.0 { one_sided_p_value((lost / std_error).powi(2), dof) } else { 1.0 }
            };
            let others: f64 = lost.iter().map(|o| o.weight * p(o.value, o.std_error, f64::INFINITY)).sum();
            let straight = 1.0 - lost.iter().map(|o| o.weight).sum::<f64>();
            straight * p(-intercept, lost_std.max(f64::MIN_POSITIVE), *dof) + others
        };
        let [p_value, p_above_zero] = [1.0, -1.0].map(evidence);
        let drive_unit = levels.drive_unit();
        let wide = |mut q: Quantity| {
            q.interval_95 = [-1.0, 1.0].map(|s| q.value + s * Z_95 * factor * q.std_error);
            q
        };
        let relative = |shift: f64, value: f64| if shift == 0.0 { 0.0 } else { shift / value };
        let [lost_by_q, slope_by_q] = [0, 1].map(|k| relative(branch.by_log_q[k], parameters[k]));
        let of_slope = wide(Quantity::normal(slope, slope_std, ratio_unit(levels.unit(), drive_unit)));
        Self {
            slope: counted(of_slope, &curves(slope, [0.0, 1.0]), &|[_, b]| (b, [0.0, 1.0])),
            threshold: counted(
                not_negative(threshold, threshold_std, factor, drive_unit),
                &curves(threshold, gradient),
                &|[a, b]| (-a / b, [-1.0 / b, a / (b * b)]),
            ),
            lost_amplitude: counted(
                not_negative(-intercept, lost_std, factor, levels.unit()),
                &lost,
                &|[a, _]| (-a, [-1.0, 0.0]),
            ),
            correlation,
            by_log_q: [slope_by_q, lost_by_q - slope_by_q],
            p_value,
            p_above_zero,
        }
    }
}

/// Quantities available if the drive is calibrated.
pub(super) struct Calibrated {
    pub(super) q: Quantity,
    pub(super) x_f: Quantity,
    /// Correlation of decay rate and friction.
    pub(super) loss_correlation: f64,
}

impl LineQuantities {
    /// `Q = slope/gain`, `x_F = (pi/4) gain threshold`; with a given Q, `x_F = (pi/4) slope threshold/Q`. `None` if the
    /// gain is not known, or gives a Q that no oscillator has.
    ///
    /// A relative error of Q or of the gain changes them directly, and by the shape of the exact motion.
    pub(super) fn calibrated(&self, levels: &Levels, options: &Options) -> Option<Calibrated> {
        let [slope_by_q, threshold_by_q] = self.by_log_q;
        if let Some([q, q_std]) = options.q_factor {
            let relative = q_std / q;
            let common = [relative, relative * (1.0 - slope_by_q - threshold_by_q)];
            let x_f = self.lost_amplitude.scaled(FRAC_PI_4 / q, levels.unit());
            let loss_correlation = loss_correlation(common, 0.0, &x_f, 0.0);
            let q = Quantity::normal(q, q_std, "");
            return Some(Calibrated { q, x_f: x_f.widened(common[1].abs()), loss_correlation });
        }
        let of_units = || Some([DisplacementUnit::gain(levels.drive_unit(), levels.unit())?, 0.0]);
        let [gain, gain_std] = options.drive_gain.or_else(of_units)?;
        let common = [1.0 + slope_by_q, 1.0 - threshold_by_q].map(|by| by * gain_std / gain);
        let x_f = self.threshold.scaled(FRAC_PI_4 * gain, levels.unit());
        let of_slope = self.slope.std_error / self.slope.value;
        let loss_correlation = loss_correlation(common, of_slope, &x_f, self.correlation);
        let q = self.slope.scaled(1.0 / gain, "").widened(common[0].abs());
        // Below this Q there is no resonance: the gain is not that of a drive at the base.
        if q.value < LEAST_Q && q.value > 0.0 {
            return None;
        }
        Some(Calibrated { q, x_f: x_f.widened(common[1].abs()), loss_correlation })
    }

    /// Slope and threshold with the error of a given Q or gain, by which it shapes the exact motion.
    pub(super) fn with_error_of_q(self, options: &Options) -> Self {
        let relative = options.q_factor.or(options.drive_gain).map_or(0.0, |[value, error]| error / value);
        let [slope_by_q, threshold_by_q] = self.by_log_q.map(|by| (by * relative).abs());
        Self {
            slope: self.slope.widened(slope_by_q),
            threshold: self.threshold.widened(threshold_by_q),
            ..self
        }
    }
}

/// Correlation of decay rate and friction: both contain a relative error of the scale, `common`; the decay rate
/// decreases with increasing slope, whose relative error is `of_slope`.
fn loss_correlation(common: [f64; 2], of_slope: f64, x_f: &Quantity, correlation: f64) -> f64 {
    let of_scale = common[1] * x_f.value;
    let covariance = common[0] * of_scale - correlation * of_slope * x_f.std_error;
    let errors = common[0].hypot(of_slope) * of_scale.hypot(x_f.std_error);
    if errors > 0.0 { (covariance / errors).clamp(-1.0, 1.0) } else { 0.0 }
}

/// `factor/q`; without an upper limit if the lower limit of `q` is not positive.
pub(super) fn inverse(q: &Quantity, factor: f64, unit: &str) -> Quantity {
    let value = factor / q.value;
    let [low, high] = q.interval_95;
    let highest = if low > 0.0 { factor / low } else { f64::INFINITY };
    Quantity {
        value,
        std_error: value * q.std_error / q.value,
        interval_95: [factor / high, highest],
        unbounded_value: value,
        unit: unit.to_owned(),
    }
}
