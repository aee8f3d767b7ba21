//! The printed statements of the paper, what holds instead, and the exact motion, in numbers.
//!
//! Vitorino, Vieira and Rodrigues, "Effect of sliding friction in harmonic oscillators".
//! [`statements`] computes every statement of the printed text that does not hold.

use crate::error::Error;
use crate::inference::least_squares::{LeastSquares, Normal, minimise};
use crate::model::oscillator::Oscillator;
use crate::motion::decay::{FreeDecay, averaged};
use crate::motion::steady::exact::ClosedForm;
use crate::motion::steady::{HarmonicDrive, Method, Phasor, SteadyState, leading, lorentzian, series, solve};
use crate::numeric::GOLDEN_SECTION;
use std::f64::consts::{PI, TAU};

/// A statement of the paper that does not hold as printed.
#[derive(Debug, Clone, PartialEq)]
pub struct Statement {
    /// Location in the paper.
    pub place: &'static str,
    /// The printed statement.
    pub printed: &'static str,
    /// The corrected statement.
    pub holds: &'static str,
    /// The oscillator for which it was evaluated.
    pub case: &'static str,
    /// The resulting differences.
    pub measures: Vec<Measure>,
}

/// One quantity by the printed statement, by the corrected one, and exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// The quantity, with its unit if it has one.
    pub quantity: &'static str,
    /// Value by the printed statement.
    pub printed: f64,
    /// Value by the corrected statement.
    pub holds: f64,
    /// Value of the exact motion.
    pub exact: f64,
}

impl Measure {
    /// Relative error of the printed statement.
    pub fn printed_error(&self) -> f64 {
        relative(self.printed, self.exact)
    }

    /// Relative error of the corrected statement.
    pub fn holds_error(&self) -> f64 {
        relative(self.holds, self.exact)
    }
}

fn relative(value: f64, exact: f64) -> f64 {
    if value == exact { 0.0 } else { value / exact - 1.0 }
}

const STRONG: &str = "Q = 50, beta = 0.9, omega_0 = 1 rad/s, x_0 = 1";

/// Every statement of the paper that needs correction, evaluated now.
///
/// # Errors
/// None expected: the cases are fixed, and a test runs them.
///
/// ```
/// let all = slipfit::paper::statements()?;
/// assert!(all.iter().flat_map(|s| &s.measures).all(|m| m.printed_error().abs() > m.holds_error().abs()));
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn statements() -> Result<Vec<Statement>, Error> {
    Ok(vec![
        inversions()?,
        sign_of_friction()?,
        harmonic_phase()?,
        fundamental_phase()?,
        flanks()?,
        shift()?,
        proportionality()?,
        energy()?,
        offset()?,
    ])
}

fn strong() -> Result<Oscillator, Error> {
    driven(50.0, 0.9)
}

/// `omega_0 = 1`, for a drive of `x_0 = 1`.
fn driven(q_factor: f64, beta: f64) -> Result<Oscillator, Error> {
    let x_f = Oscillator::friction_displacement_for(beta, 1.0);
    Oscillator::builder().omega_0(1.0).q_factor(q_factor).friction_displacement(x_f).build()
}

fn closed(o: &Oscillator, omega: f64) -> Result<ClosedForm, Error> {
    ClosedForm::new(o, &HarmonicDrive::new(1.0, omega)?).filter(ClosedForm::holds).ok_or(Error::DoesNotHold {
        method: "the closed form with two turns per cycle",
        why: "the motion has stops",
    })
}

fn inversions() -> Result<Statement, Error> {
    let drive = HarmonicDrive::new(1.0, 0.97)?;
    let turns = SteadyState::new(&strong()?, &drive, Method::WithStops)?.turning_points();
    let between = match turns.as_slice() {
        [(a, _), (b, _), ..] => b - a,
        _ => f64::NAN,
    };
    Ok(Statement {
        place: "text before eq. (1)",
        printed: "the velocity inverts at multiples of the period T",
        holds: "at multiples of half the period",
        case: "Q = 50, beta = 0.9, omega = 0.97 omega_0",
        measures: vec![Measure {
            quantity: "time between inversions over T",
            printed: 1.0,
            holds: 0.5,
            exact: between / drive.period_s(),
        }],
    })
}

fn sign_of_friction() -> Result<Statement, Error> {
    let (o, drive) = (strong()?, HarmonicDrive::new(1.0, 0.97)?);
    let exact = closed(&o, 0.97)?;
    let turn = exact.turn_time_s();
    // Time is counted from the turning point, as in the paper: the crest of the drive lies before it.
    let t = 0.15 * drive.period_s();
    let (x, v) = exact.state(t + turn);
    let base = (drive.omega() * (t + turn)).cos();
    let truth = base - x - o.friction_displacement() * v.signum() - 2.0 * o.decay_rate_per_s() * v;
    let phase = -drive.omega() * turn;
    let holds = series::acceleration(&o, &drive, phase, (x, v), t, 20_000);
    let printed = holds - 2.0 * series::friction_force(&o, drive.omega(), t, 20_000);
    Ok(Statement {
        place: "eq. (2)",
        printed: "− (4F/nπ) sin(nωt)",
        holds: "+ (4F/nπ) sin(nωt): with x = R cos ωt friction opposes a velocity that goes as −sin",
        case: "Q = 50, beta = 0.9, omega = 0.97 omega_0, 0.15 T after the turn, 20 000 terms",
        measures: vec![Measure { quantity: "acceleration over omega_0² x_0", printed, holds, exact: truth }],
    })
}

fn harmonic_phase() -> Result<Statement, Error> {
    let (o, omega) = (strong()?, 0.97);
    let exact = closed(&o, omega)?;
    let from_turn = exact.harmonic(3) * Phasor::from_polar(1.0, 3.0 * omega * exact.turn_time_s());
    Ok(Statement {
        place: "eq. (5)",
        printed: "φ_n = arctan(nγω/(k − m n²ω²))",
        holds: "that angle on the quadrant of D(nω), plus π/2",
        case: "Q = 50, beta = 0.9, omega = 0.97 omega_0",
        measures: vec![Measure {
            quantity: "φ_3 (rad)",
            printed: series::harmonic_phase_as_printed(&o, omega, 3),
            holds: series::harmonic_phase(&o, omega, 3),
            exact: (-from_turn.arg()).rem_euclid(TAU),
        }],
    })
}

fn fundamental_phase() -> Result<Statement, Error> {
    let o = strong()?;
    let exact = closed(&o, 1.0)?;
    let r = exact.harmonic(1).norm();
    let short = o.friction_displacement() / (PI * r);
    let truth = exact.fundamental_phase();
    let printed = series::fundamental_phase_as_printed(&o, 1.0, r, 100_000);
    let holds = series::fundamental_phase(&o, 1.0, r, 100_000).unwrap_or(f64::NAN);
    Ok(Statement {
        place: "eq. (7)",
        printed: "sin φ_1 = Σ (4F nγω/πR)/Z_n², of order F/(kRQ)",
        holds: "sin φ_1 = Σ (4F/πR)(m n²ω² − k)/Z_n², near resonance F/(πkR)",
        case: STRONG,
        measures: vec![
            Measure { quantity: "φ_1 at resonance (rad)", printed, holds, exact: truth },
            Measure { quantity: "φ_1 by F/(πkR) (rad)", printed, holds: short, exact: truth },
        ],
    })
}

fn flanks() -> Result<Statement, Error> {
    let o = strong()?;
    let at = |quantity, omega: f64| {
        let drive = HarmonicDrive::new(1.0, omega)?;
        let series = SteadyState::new(&o, &drive, Method::Series { terms: 3000 })?;
        Ok::<_, Error>(Measure {
            quantity,
            printed: leading::leading_amplitude(&o, &drive),
            holds: series.amplitude(),
            exact: solve(&o, &drive)?.state.amplitude(),
        })
    };
    Ok(Statement {
        place: "eq. (8) off resonance",
        printed: "\"very effective at describing the system\", down to G = 1",
        holds: "at resonance; on the flanks the series with φ_1 of eq. (6), many terms",
        case: STRONG,
        measures: vec![
            at("amplitude at omega_0 / x_0", 1.0)?,
            at("amplitude at 0.97 omega_0 / x_0", 0.97)?,
            at("amplitude at 1.03 omega_0 / x_0", 1.03)?,
            at("amplitude at 1.06 omega_0 / x_0", 1.06)?,
        ],
    })
}

/// Maximum of a curve with a single maximum, by golden-section search.
fn top(mut f: impl FnMut(f64) -> Result<f64, Error>) -> Result<f64, Error> {
    let (mut a, mut b) = (0.98, 1.02);
    for _ in 0..60 {
        let (c, d) = (b - GOLDEN_SECTION * (b - a), a + GOLDEN_SECTION * (b - a));
        if f(c)? > f(d)? { b = d } else { a = c }
    }
    Ok(0.5 * (a + b))
}

fn shift() -> Result<Statement, Error> {
    let o = strong()?;
    let viscous = top(|w| Ok(leading::leading_amplitude(&o, &HarmonicDrive::new(1.0, w)?)))?;
    let exact = top(|w| Ok(closed(&o, w)?.harmonic(1).norm()))?;
    let r = closed(&o, 1.0)?.harmonic(1).norm();
    Ok(Statement {
        place: "\"the resonance frequency is not affected by pure sliding friction\"",
        printed: "no shift by friction",
        holds: "shifted down at second order, relative shift 2 (F/(πkR))²",
        case: STRONG,
        measures: vec![Measure {
            quantity: "shift of the maximum against eq. (8), relative",
            printed: 0.0,
            holds: -2.0 * (o.friction_displacement() / (PI * r)).powi(2),
            exact: exact / viscous - 1.0,
        }],
    })
}

/// Exact fundamentals over a window of `lines` half line widths on either side.
fn curve(o: &Oscillator, lines: f64) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let half = lines * o.decay_rate_per_s();
    (0..61)
        .map(|i| {
            let omega = 1.0 + half * (f64::from(i) / 30.0 - 1.0);
            Ok((omega, solve(o, &HarmonicDrive::new(1.0, omega)?)?.state.harmonic(1).norm()))
        })
        .collect::<Result<Vec<_>, Error>>()
        .map(|points| points.into_iter().unzip())
}

fn proportionality() -> Result<Statement, Error> {
    let mut measures = Vec::new();
    for (beta, lines, names) in [
        (0.05, 1.5, ["F found / F (β = 0.05, window ±1.5 half widths)", "Q found / Q (the same)"]),
        (0.9, 10.0, ["F found / F (β = 0.9, window ±10 half widths)", "Q found / Q (the same)"]),
    ] {
        let o = driven(50.0, beta)?;
        let (omega, amplitude) = curve(&o, lines)?;
        let line = lorentzian::fit(&omega, &amplitude)?;
        // For a very narrow window the fitted x_f may slightly exceed x_0.
        let x_f = line.effective_drive.min(1.0);
        let back = lorentzian::invert(x_f, line.effective_q_factor, 1.0, lorentzian::PAPER_A)?;
        let (q, x) = fit_series(&omega, &amplitude, &o)?;
        let truth = o.friction_displacement();
        let pairs = [(back.friction_displacement / truth, x / truth), (back.q_factor / 50.0, q / 50.0)];
        for (quantity, (printed, holds)) in names.into_iter().zip(pairs) {
            measures.push(Measure { quantity, printed, holds, exact: 1.0 });
        }
    }
    Ok(Statement {
        place: "eq. (14), a ≈ 4/3",
        printed: "a is the constant 4/3",
        holds: "a varies with β and with the window fitted; fit the series (or the exact curve) instead",
        case: "Q = 50; Lorentzian fitted to the exact curve and inverted; compared with the fitted series of 300 terms",
        measures,
    })
}

/// Fits `Q` and `x_F` of the series to a curve, with known `omega_0` and `x_0`.
fn fit_series(omega: &[f64], amplitude: &[f64], near: &Oscillator) -> Result<(f64, f64), Error> {
    struct Curve<'a>(&'a [f64], &'a [f64]);
    impl Curve<'_> {
        fn at(&self, p: &[f64]) -> Option<Vec<f64>> {
            let o = Oscillator::builder().omega_0(1.0).zeta(p[0]).friction_displacement(p[1]).build().ok()?;
            let r =
                |w: &f64| Some(series::solve(&o, &HarmonicDrive::new(1.0, *w).ok()?, 300)?.first()?.norm());
            self.0.iter().map(r).collect()
        }
    }
    impl LeastSquares for Curve<'_> {
        fn parameters(&self) -> usize {
            2
        }
        fn observations(&self) -> f64 {
            self.0.len() as f64
        }
        fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
            out.clear();
            let steps = [1e-5 * p[0], 1e-5 * p[1]];
            let beside = |i: usize, side: f64| {
                let mut q = [p[0], p[1]];
                q[i] += side * steps[i];
                self.at(&q)
            };
            let (Some(here), Some(a), Some(b), Some(c), Some(d)) =
                (self.at(p), beside(0, 1.0), beside(0, -1.0), beside(1, 1.0), beside(1, -1.0))
            else {
                return false;
            };
            for i in 0..here.len() {
                let row = [(a[i] - b[i]) / (2.0 * steps[0]), (c[i] - d[i]) / (2.0 * steps[1])];
                out.add_row(&row, self.1[i] - here[i], 1.0);
            }
            true
        }
    }
    // Start values off the true values, so that finding those is a real test.
    let start = [1.1 * near.zeta(), 0.9 * near.friction_displacement()];
    let fit = minimise(&Curve(omega, amplitude), &start, &[0, 1])
        .ok_or(Error::NoFit { reason: "the series has no motion there" })?;
    Ok((0.5 / fit.parameters[0], fit.parameters[1]))
}

fn energy() -> Result<Statement, Error> {
    let o = Oscillator::builder().omega_0(2.0).q_factor(500.0).friction_displacement(0.001).build()?;
    let decay = FreeDecay::from_rest(&o, 1.0)?;
    let loss = decay.loss(0);
    let exact = (loss.viscous + loss.sliding) * o.omega_0().powi(2);
    let v = 0.5 * (1.0 + decay.turning_point(1).position.abs()) * o.omega_0();
    Ok(Statement {
        place: "eq. (17)",
        printed: "(π/2) γ v²",
        holds: "(π/2) γ v²/ω_r, without which eq. (18) does not follow",
        case: "Q = 500, omega_0 = 2 rad/s, x_F = 0.001, first half cycle from A = 1",
        measures: vec![Measure {
            quantity: "energy lost over m",
            printed: averaged::half_cycle_energy_as_printed(&o, v),
            holds: averaged::half_cycle_energy(&o, v),
            exact,
        }],
    })
}

fn offset() -> Result<Statement, Error> {
    let at = |quantity, q: f64| {
        let o = Oscillator::builder().omega_0(1.0).q_factor(q).friction_displacement(0.01).build()?;
        let d = FreeDecay::from_rest(&o, 1.0)?;
        let [a, b, c] = [0, 1, 2].map(|n| d.turning_point(n).position.abs());
        // |X_n| + C falls by a constant factor: C follows from three turning points.
        let exact = (b * b - a * c) / (a + c - 2.0 * b);
        Ok::<_, Error>(Measure {
            quantity,
            printed: averaged::decay_offset(&o),
            holds: o.decay_offset(),
            exact,
        })
    };
    Ok(Statement {
        place: "eq. (16)",
        printed: "offset 4F/(πγω_0)",
        holds: "x_F coth(πδ/2ω_d); relative error (π²/48 − 1/8)/Q², and π²/(48 Q²) with ω_d for ω_0",
        case: "x_F = 0.01, A_i = 1; exact from three turning points",
        measures: vec![at("offset at Q = 2", 2.0)?, at("offset at Q = 10", 10.0)?],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_correction_is_nearer_to_the_exact_motion_than_the_print() {
        let all = statements().unwrap();
        assert_eq!(all.len(), 9);
        for s in &all {
            assert!(!s.measures.is_empty());
            for m in &s.measures {
                let (printed, holds) = (m.printed_error().abs(), m.holds_error().abs());
                assert!(holds < printed, "{}: {m:?} {printed} {holds}", s.place);
                assert!(holds < 0.03, "{}: {m:?} {printed} {holds}", s.place);
            }
        }
    }

    #[test]
    fn the_sizes_are_those_known() {
        let all = statements().unwrap();
        let of = |place: &str| &all.iter().find(|s| s.place.contains(place)).unwrap().measures;
        assert!((of("(8)")[1].printed_error() + 0.09).abs() < 0.01);
        assert!((of("(8)")[3].printed_error() - 0.2).abs() < 0.01);
        assert!((of("(7)")[0].exact - 0.04497).abs() < 1e-5);
        assert!(of("(14)")[0].printed > 1.3, "{:?}", of("(14)"));
    }
}
