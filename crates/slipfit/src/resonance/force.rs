//! Force balance at each point, without a model of the curve.

use super::answer::{ForceLine, ForcePoint};
use super::criteria::ForceCriteria;
use super::problem::Problem;
use super::response::{DELAY, OMEGA, PHASE, X_0};
use crate::Quantity;
use crate::inference::least_squares::linear;
use crate::motion::steady::Phasor;
use crate::motion::steady::fundamental::Regime;
use std::f64::consts::{FRAC_PI_4, TAU};

/// Dissipative and elastic force at each point, and the line through the dissipative forces:
///
/// ```text
/// x_0 sin(lag) = 4 x_F/pi + (2 delta/omega_0) |Z| omega/omega_0
/// x_0 cos(lag) + (omega/omega_0)² |Z| = |Z| for a linear spring
/// ```
///
/// The first equation is eq. (9) of Vitorino, Vieira and Rodrigues, extended to frequencies off resonance. It
/// approximates the friction by a square wave in phase with the fundamental, accurate to order `(x_F/|Z|)²`; points
/// with stops are not used for the line.
pub(super) fn balance(
    problem: &Problem,
    p: &[f64],
    sigma: f64,
    unit: &str,
    c: &ForceCriteria,
) -> (Vec<ForcePoint>, Option<ForceLine>) {
    let b = &problem.main;
    if !b.complex {
        return (Vec::new(), None);
    }
    let omega_0 = problem.centre + p[OMEGA];
    let at = problem.response(p, false);
    let mut points = Vec::with_capacity(b.len());
    let mut rows: Vec<(f64, f64, f64, f64)> = Vec::new();
    for (i, modelled) in problem.predict(p, false).into_iter().enumerate() {
        let turn = Phasor::from_polar(1.0, (b.omega[i] - problem.centre) * p[DELAY] - p[PHASE]);
        let z = (b.data[i] - at.background_at(b.omega[i])) * turn;
        let size = z.norm();
        if !(size > 0.0) {
            continue;
        }
        let x_0 = p[X_0] * b.drive[i];
        let (sin, cos) = (-z.im / size, z.re / size);
        let noise = sigma / b.precision[i].sqrt();
        let angle = noise / size;
        let r = b.omega[i] / omega_0;
        // At the peak the first order vanishes, but the second does not.
        let dissipative_std_error = x_0 * angle * cos.abs().max(angle);
        points.push(ForcePoint {
            frequency_hz: b.omega[i] / TAU,
            amplitude: size,
            dissipative: x_0 * sin,
            dissipative_std_error,
            elastic: x_0 * cos + r * r * size,
            elastic_std_error: (x_0 * angle * sin.abs().max(angle)).hypot(r * r * noise),
        });
        let slides = modelled.is_some_and(|m| m.regime == Regime::Sliding);
        if slides && b.weight[i] > 0.0 && angle < c.most_noise {
            rows.push((size * r, x_0 * sin, dissipative_std_error, noise * r));
        }
    }
    (points, line(&rows, omega_0, unit, c))
}

/// Line fitted with errors of both axes; the weights use the slope of the previous iteration.
fn line(
    rows: &[(f64, f64, f64, f64)],
    omega_0: f64,
    unit: &str,
    criteria: &ForceCriteria,
) -> Option<ForceLine> {
    const ROUNDS: usize = 4;
    if rows.len() < criteria.least_points {
        return None;
    }
    let mut slope = 0.0;
    let mut found = None;
    for _ in 0..ROUNDS {
        let weighted = rows.iter().map(|&(x, y, ey, ex)| {
            (vec![1.0, x], y, 1.0 / (ey * ey + slope * slope * ex * ex).max(f64::MIN_POSITIVE))
        });
        let (c, covariance, chi2) = linear(weighted, 2)?;
        slope = c[1];
        found = Some((c, covariance, chi2));
    }
    let (c, covariance, chi2) = found?;
    let reduced = chi2 / (rows.len() as f64 - 2.0);
    let error = |k: usize| (covariance[(k, k)] * reduced.max(1.0)).sqrt();
    Some(ForceLine {
        friction_displacement: Quantity::normal(FRAC_PI_4 * c[0], FRAC_PI_4 * error(0), unit),
        decay_rate_per_s: Quantity::normal(0.5 * omega_0 * c[1], 0.5 * omega_0 * error(1), "1/s"),
        reduced_chi_square: reduced,
        points: rows.len(),
    })
}
