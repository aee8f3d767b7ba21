//! The method of the paper: an effective Lorentzian, inverted with `a = 4/3`.

use super::answer::PaperEstimate;
use super::block::Block;
use super::criteria::{ResidualCriteria, SearchCriteria};
use super::peak;
use super::problem::Problem;
use super::residuals::{Autocorrelation, autocorrelation};
use super::response::{COUNT, DELAY, DELTA, OMEGA, PHASE, X_0};
use super::search::best;
use super::start;
use crate::inference::least_squares::Fit;
use crate::motion::steady::Phasor;
use crate::motion::steady::lorentzian::PAPER_A;
use std::f64::consts::{FRAC_PI_4, TAU};

/// Eq. (14) fitted to the amplitudes, with equal weights of all points.
pub(super) struct Lorentzian {
    fit: Fit,
    problem: Problem,
    centre: f64,
    variance: f64,
}

/// Result of the inversion by eqs. (12) and (13): Q, x_F, beta.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inverted {
    pub(super) q: f64,
    pub(super) x_f: f64,
    pub(super) beta: f64,
}

impl Lorentzian {
    /// From points and their amplitudes.
    pub(super) fn of(block: &Block, amplitudes: &[f64], c: &SearchCriteria) -> Option<Self> {
        let own = Block {
            data: amplitudes.iter().map(|a| Phasor::new(*a, 0.0)).collect(),
            complex: false,
            rice: 0.0,
            weight: block.precision.clone(),
            ..block.clone()
        };
        let peak = peak::find(&own)?;
        let free = vec![OMEGA, DELTA, X_0];
        let problem = Problem::new(own, peak.omega, free.clone());
        let starts: Vec<Vec<f64>> = start::grid(&peak, 0.0, None)
            .into_iter()
            .take(3)
            .map(|s| {
                let mut p = vec![0.0; COUNT];
                (p[OMEGA], p[DELTA], p[X_0]) = (s.shift, s.delta, s.x_0);
                p
            })
            .collect();
        let fit = best(&problem, &starts, &free, c)?;
        let dof = (problem.main.len() as f64 - 3.0).max(1.0);
        let good = fit.parameters[DELTA] > 0.0;
        good.then(|| Self { variance: fit.rss / dof, fit, problem, centre: peak.omega })
    }

    /// Root mean square of the residuals of the amplitudes.
    pub(super) fn residual_rms(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Autocorrelation of the residuals.
    pub(super) fn autocorrelation(&self, c: &ResidualCriteria) -> Autocorrelation {
        autocorrelation(&self.problem, &self.fit, c)
    }

    /// Effective decay rate, and the effective drive of the paper.
    pub(super) fn effective(&self) -> [f64; 2] {
        [self.fit.parameters[DELTA], self.fit.parameters[X_0]]
    }

    /// A linear oscillator at its frequency, as parameters of a problem, with the phases of the fit `p` of that
    /// problem; for the [effective](Self::effective) loss and drive its amplitudes are those of eq. (14).
    pub(super) fn linear(&self, problem: &Problem, p: &[f64], [delta, x_0]: [f64; 2]) -> Vec<f64> {
        let mut linear = vec![0.0; p.len()];
        (linear[OMEGA], linear[DELTA], linear[X_0]) = (self.omega_0() - problem.centre, delta, x_0);
        (linear[PHASE], linear[DELAY]) = (p[PHASE], p[DELAY]);
        linear
    }

    pub(super) fn omega_0(&self) -> f64 {
        self.centre + self.fit.parameters[OMEGA]
    }

    pub(super) fn omega_0_std(&self) -> f64 {
        self.fit.unit_std(OMEGA) * self.variance.sqrt()
    }

    /// Inverts the fit for a drive amplitude.
    pub(super) fn invert(&self, x_0: f64) -> Inverted {
        let p = &self.fit.parameters;
        inverted(self.omega_0() / (2.0 * p[DELTA]), p[X_0] / x_0, x_0)
    }

    /// Standard errors of Q, x_F and beta, including that of the drive.
    pub(super) fn std_errors(&self, x_0: f64, x_0_std: f64) -> [f64; 3] {
        let p = &self.fit.parameters;
        let of = |delta: f64, x_f: f64, x_0: f64| {
            let i = inverted(self.omega_0() / (2.0 * delta), x_f / x_0, x_0);
            [i.q, i.x_f, i.beta]
        };
        let (delta, drive) = (p[DELTA], p[X_0]);
        let step = 1e-5;
        let slope = |up: [f64; 3], down: [f64; 3], h: f64| {
            std::array::from_fn::<f64, 3, _>(|k| (up[k] - down[k]) / (2.0 * h))
        };
        let d =
            slope(of(delta * (1.0 + step), drive, x_0), of(delta * (1.0 - step), drive, x_0), step * delta);
        let f =
            slope(of(delta, drive * (1.0 + step), x_0), of(delta, drive * (1.0 - step), x_0), step * drive);
        let x = slope(of(delta, drive, x_0 * (1.0 + step)), of(delta, drive, x_0 * (1.0 - step)), step * x_0);
        let c = |a: usize, b: usize| self.fit.unit_covariance[(a, b)] * self.variance;
        std::array::from_fn(|k| {
            let v = d[k] * d[k] * c(DELTA, DELTA)
                + f[k] * f[k] * c(X_0, X_0)
                + 2.0 * d[k] * f[k] * c(DELTA, X_0)
                + (x[k] * x_0_std).powi(2);
            v.max(0.0).sqrt()
        })
    }
}

/// Eqs. (12) and (13) solved for Q and beta: with `rho = x_f/x_0`, `beta = (1 - rho)/(1 - rho/a)`.
fn inverted(q_f: f64, rho: f64, x_0: f64) -> Inverted {
    let beta = (1.0 - rho) / (1.0 - rho / PAPER_A);
    Inverted { q: q_f / (1.0 - beta / PAPER_A), x_f: FRAC_PI_4 * beta * x_0, beta }
}

/// The results of the method of the paper for a curve, and their bias, from the same fit to the exact curve for the
/// parameters of the answer.
pub(super) fn estimate(
    problem: &Problem,
    p: &[f64],
    drive_known: bool,
    c: &SearchCriteria,
) -> Option<PaperEstimate> {
    let b = &problem.main;
    let at = problem.response(p, false);
    let seen = |i: usize| b.data[i] - at.background_at(b.omega[i]);
    let amplitude =
        |i: usize| if b.complex { seen(i).norm() } else { at.amplitude_from_reading(b.data[i].re) };
    let measured: Vec<f64> = (0..b.len()).map(amplitude).collect();
    let found = Lorentzian::of(b, &measured, c)?;
    let x_0 = p[X_0];
    let inverse = drive_known.then(|| found.invert(x_0));
    let exact: Option<Vec<f64>> =
        problem.predict(p, false).into_iter().map(|m| m.map(|m| m.oscillator.norm())).collect();
    let truth_x_f = p[super::response::X_F];
    let truth_q = (problem.centre + p[OMEGA]) / (2.0 * p[DELTA]);
    let ideal = exact.and_then(|e| Lorentzian::of(b, &e, c)).map(|l| l.invert(x_0));
    let parameters = &found.fit.parameters;
    Some(PaperEstimate {
        effective_q_factor: found.omega_0() / (2.0 * parameters[DELTA]),
        effective_drive: parameters[X_0],
        natural_frequency_hz: found.omega_0() / TAU,
        q_factor: inverse.map(|i| i.q),
        friction_displacement: inverse.map(|i| i.x_f),
        friction_ratio: inverse.map(|i| i.beta),
        q_factor_bias: ideal.filter(|_| p[DELTA] > 0.0).map(|i| i.q / truth_q - 1.0),
        friction_bias: ideal.filter(|_| truth_x_f > 1e-3 * x_0).map(|i| i.x_f / truth_x_f - 1.0),
    })
}
