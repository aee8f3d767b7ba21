//! F tests, also at a boundary, and the Bayesian information criterion.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

/// Upper tail of the F distribution.
pub(crate) fn f_tail(f: f64, numerator: f64, denominator: f64) -> f64 {
    if !(f > 0.0) {
        return 1.0;
    }
    match FisherSnedecor::new(numerator, denominator.clamp(1.0, 1e7)) {
        Ok(d) => d.sf(f),
        Err(_) => f64::NAN,
    }
}

/// Upper tail of the chi-square distribution.
pub(crate) fn chi_square_tail(chi_square: f64, dof: f64) -> f64 {
    if !(chi_square > 0.0) {
        return 1.0;
    }
    match ChiSquared::new(dof) {
        Ok(d) => d.sf(chi_square),
        Err(_) => f64::NAN,
    }
}

/// Upper tail of a chi square if its variances were estimated with `freedom` degrees of freedom; `freedom` is infinite
/// if they are known.
pub(crate) fn scaled_tail(chi_square: f64, dof: f64, freedom: f64) -> f64 {
    if freedom.is_finite() {
        f_tail(chi_square / dof, dof, freedom)
    } else {
        chi_square_tail(chi_square, dof)
    }
}

/// p value of one additional loss term that cannot be negative.
///
/// Under the null hypothesis the likelihood ratio is zero half of the time (the estimate lies at the limit), so the
/// tail of F(1, dof) has the weight one half (Chernoff 1954).
///
/// `gain` is the decrease of the sum of squares over the variance of one observation.
pub(crate) fn one_sided_p_value(gain: f64, dof: f64) -> f64 {
    if gain > 0.0 { 0.5 * f_tail(gain, 1.0, dof) } else { 1.0 }
}

/// Degrees of freedom above which the quantile of Student's t is taken from its expansion.
const EXPANDED_DOF: f64 = 100.0;

/// Half width of the central 95 % of Student's t over that of the normal distribution.
pub(crate) fn student_factor(dof: f64) -> f64 {
    if dof > 1e4 {
        return 1.0;
    }
    if dof > EXPANDED_DOF {
        // Abramowitz and Stegun 26.7.5, accurate to 1e-10 in this range.
        let z = super::Z_95;
        let z2 = z * z;
        let terms = [
            (z2 + 1.0) / 4.0,
            ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0,
            (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0,
            ((((79.0 * z2 + 776.0) * z2 + 1482.0) * z2 - 1920.0) * z2 - 945.0) / 92160.0,
        ];
        return terms.iter().rev().fold(0.0, |sum, term| (sum + term) / dof) + 1.0;
    }
    match StudentsT::new(0.0, 1.0, dof.max(1.0)) {
        Ok(d) => d.inverse_cdf(0.975) / super::Z_95,
        Err(_) => f64::NAN,
    }
}

/// Bayesian information criterion of Gaussian residuals; `effective` is the number of independent observations.
pub(crate) fn bic(rss: f64, observations: f64, effective: f64, parameters: usize) -> f64 {
    effective * (rss / observations).max(f64::MIN_POSITIVE).ln() + parameters as f64 * effective.max(2.0).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_match_tables() {
        // F(1, 10): 5 % point 4.965; t(10): 97.5 % point 2.228.
        assert!((f_tail(4.9646, 1.0, 10.0) - 0.05).abs() < 1e-4);
        assert!((student_factor(10.0) * super::super::Z_95 - 2.2281).abs() < 1e-3);
        // Chi square with 2 degrees: 5 % point 5.991.
        assert!((chi_square_tail(5.9915, 2.0) - 0.05).abs() < 1e-4);
        assert!((one_sided_p_value(0.0, 10.0) - 1.0).abs() < 1e-12);
        assert!((one_sided_p_value(4.9646, 10.0) - 0.025).abs() < 1e-4);
    }

    /// The expansion agrees with the numerical inverse to within the accuracy of the latter.
    #[test]
    fn the_quantile_of_students_t_is_that_of_its_expansion() {
        for dof in [100.5, 130.0, 400.0, 9000.0] {
            let exact = StudentsT::new(0.0, 1.0, dof).unwrap().inverse_cdf(0.975) / super::super::Z_95;
            assert!((student_factor(dof) - exact).abs() < 1e-8, "{dof}: {} for {exact}", student_factor(dof));
        }
    }

    #[test]
    fn far_tails_do_not_round_to_zero_too_soon() {
        let p = f_tail(60.0, 1.0, 1e6);
        assert!(p > 0.0 && p < 1e-13, "{p:e}");
    }
}
