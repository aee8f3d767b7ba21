//! Start values of the oscillator.

use super::block::Block;
use super::peak::Peak;
use super::response::{COUNT, DELTA, OMEGA, PHASE, X_0, X_F};
use crate::numeric::products::{Products, WIDTH};
use nalgebra::{SMatrix, SVector};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

/// Start values of the oscillator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Start {
    /// Natural frequency minus that of the peak, rad/s.
    pub(crate) shift: f64,
    pub(crate) delta: f64,
    pub(crate) x_0: f64,
    pub(crate) x_f: f64,
    pub(crate) phase: f64,
}

/// The balance of the fundamental, which is linear in all unknowns if phases are known:
///
/// ```text
/// (omega_0² - omega²) Z + 2 i delta omega Z + i (4/pi) x_F omega_0² Z/|Z| = omega_0² x_0 e^(i phase)
/// ```
///
/// It is solved twice, with weights according to the information of the points, the second time with the peak of the
/// first solution. If the total loss is negative, the phases have the opposite sign: then it is solved for their
/// complex conjugates, and the second value is true.
pub(crate) fn linear(b: &Block, peak: &Peak, friction: bool) -> Option<(Start, bool)> {
    if !b.complex || b.len() < 4 {
        return None;
    }
    let unit = 2.0 * peak.half_width / peak.omega;
    let mut solution = SVector::<f64, 5>::zeros();
    let (mut centre, mut width) = (0.0, 1.0);
    for _ in 0..2 {
        let sums = crate::numeric::dispatch(Balance { b, peak, friction, unit, centre, width });
        let mut m = SMatrix::<f64, 5, 5>::from_fn(|a, c| sums.total(a, c));
        let v = SVector::<f64, 5>::from_fn(|a, _| sums.total(5, a));
        if !friction {
            m[(2, 2)] = 1.0;
        }
        // A small ridge term keeps the equations of curves without friction solvable.
        for a in 0..5 {
            m[(a, a)] *= 1.0 + 1e-12;
        }
        solution = m.cholesky()?.solve(&v);
        centre = solution[0];
        width = (solution[1] + solution[2]).abs().clamp(0.05, 20.0);
    }
    let [a, delta, f, re, im] = solution.data.0[0];
    let conjugated = delta + f < 0.0;
    let (delta, f, im) = if conjugated { (-delta, -f, -im) } else { (delta, f, im) };
    // omega_0²/omega_c².
    let square = 1.0 + a * unit;
    if !(square > 0.0) {
        return None;
    }
    let omega_0 = peak.omega * square.sqrt();
    let shift = peak.omega * a * unit / (1.0 + square.sqrt());
    let back = unit * peak.height / square;
    let start = Start {
        shift,
        delta: (delta * peak.half_width).max(1e-3 * peak.half_width).min(0.7 * omega_0),
        x_0: re.hypot(im) * back,
        x_f: (f * FRAC_PI_4 * back).max(0.0),
        phase: im.atan2(re),
    };
    (start.x_0 > 0.0 && start.shift.is_finite()).then_some((start, conjugated))
}

/// The parameters of the minimiser; for a `known` drive `x_0 - (4/pi) x_F` is kept, which leaves the height unchanged.
pub(crate) fn parameters(start: &Start, known: Option<f64>) -> Vec<f64> {
    let mut s = *start;
    if let Some(x_0) = known {
        s.x_f = (s.x_f + FRAC_PI_4 * (x_0 - s.x_0)).min(0.76 * x_0).max(0.0);
        s.x_0 = x_0;
    }
    let mut p = vec![0.0; COUNT];
    (p[OMEGA], p[DELTA], p[X_0], p[X_F], p[PHASE]) = (s.shift, s.delta, s.x_0, s.x_f, s.phase);
    p
}

/// The balance at every point, with rows weighted by a peak of given centre and width.
struct Balance<'a> {
    b: &'a Block,
    peak: &'a Peak,
    friction: bool,
    unit: f64,
    centre: f64,
    width: f64,
}

impl pulp::WithSimd for Balance<'_> {
    type Output = Products;

    /// Five unknowns and the right-hand side.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Products {
        const PIECE: usize = WIDTH / 2;
        let Balance { b, peak, friction, unit, centre, width } = self;
        let mut products = Products::new(6);
        let over_height = 1.0 / peak.height;
        let over_omega = 1.0 / peak.omega;
        let over_unit = over_omega * over_omega / unit;
        for first in (0..b.len()).step_by(PIECE) {
            let m = (b.len() - first).min(PIECE);
            let (mut re, mut im, mut level, mut weight, mut omega) =
                ([0.0; PIECE], [0.0; PIECE], [0.0; PIECE], [0.0; PIECE], [peak.omega; PIECE]);
            for k in 0..m {
                (re[k], im[k]) = (b.data[first + k].re * over_height, b.data[first + k].im * over_height);
            }
            level[..m].copy_from_slice(&b.drive[first..first + m]);
            weight[..m].copy_from_slice(&b.weight[first..first + m]);
            omega[..m].copy_from_slice(&b.omega[first..first + m]);
            for k in 0..PIECE {
                let s = (omega[k] - peak.omega) * (omega[k] + peak.omega) * over_unit;
                let square = re[k] * re[k] + im[k] * im[k];
                let apart = s - centre;
                let root = (weight[k] / (apart * apart + width * width)).sqrt();
                let root = if square > 0.0 { root } else { 0.0 };
                let over = if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 };
                let f = if friction { over * root } else { 0.0 };
                let rate = omega[k] * over_omega * root;
                let (x, y) = (re[k], im[k]);
                let columns = [x * root, -y * rate, -y * f, -level[k] * root, 0.0, s * x * root];
                let others = [y * root, x * rate, x * f, 0.0, -level[k] * root, s * y * root];
                for j in 0..6 {
                    products.rows[j][k] = columns[j];
                    products.rows[j][PIECE + k] = others[j];
                }
            }
            products.add(simd);
        }
        products
    }
}

/// Friction ratios tried if nothing better is known.
const RATIOS: [f64; 7] = [0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.97];

/// Starts from height and width of the peak, from the leading term: at 1/√2 of the height
///
/// ```text
/// delta_e = half width / sqrt(2 [1 - ((1 - beta)/√2 + beta)²]),   x_0 = 2 delta_e height/omega_0
/// ```
///
/// with `delta_e = delta/(1 - beta)`, the total loss at the peak.
pub(crate) fn grid(peak: &Peak, phase: f64, known: Option<f64>) -> Vec<Start> {
    RATIOS
        .iter()
        .map(|&beta| {
            let at_cut: f64 = (1.0 - beta) * FRAC_1_SQRT_2 + beta;
            let from_width = peak.half_width / (2.0 * (1.0 - at_cut * at_cut)).sqrt();
            let whole = match known {
                Some(x_0) => x_0 * peak.omega / (2.0 * peak.height),
                None => from_width,
            }
            .min(0.7 * peak.omega);
            let x_0 = known.unwrap_or(2.0 * whole * peak.height / peak.omega);
            let delta = (1.0 - beta) * whole;
            // The peak of the displacement is below omega_0.
            let shift = peak.omega.hypot(std::f64::consts::SQRT_2 * delta) - peak.omega;
            Start { shift, delta, x_0, x_f: FRAC_PI_4 * beta * x_0, phase }
        })
        .collect()
}

/// Phase offset that gives the response at the peak a lag of a quarter cycle.
pub(crate) fn phase_at_peak(b: &Block, peak: &Peak) -> f64 {
    if b.complex { wrapped(b.data[peak.index].arg() + 0.5 * PI) } else { 0.0 }
}

pub(crate) fn wrapped(angle: f64) -> f64 {
    let a = (angle + PI).rem_euclid(2.0 * PI) - PI;
    if a == -PI { PI } else { a }
}

#[cfg(test)]
mod tests {
    use super::super::{Curve, peak};
    use super::*;
    use crate::motion::steady::Phasor;
    use crate::motion::steady::fundamental::{Point, fundamental};

    #[test]
    fn the_linear_balance_finds_the_oscillator_and_the_sign_of_the_phase() {
        for sign in [1.0, -1.0] {
            let f: Vec<f64> = (0..201).map(|i| 0.97 + 0.0003 * f64::from(i)).collect();
            let z = f
                .iter()
                .map(|f| {
                    let omega = f * 6.0;
                    let at = Point {
                        omega,
                        omega_0: 6.0,
                        detuning: omega - 6.0,
                        delta: 0.03,
                        x_0: 0.2,
                        x_f: 0.06,
                    };
                    let z = fundamental(&at).unwrap().value * Phasor::from_polar(1.0, 0.4);
                    Phasor::new(z.re, sign * z.im)
                })
                .collect();
            let hz = f.iter().map(|f| f * 6.0 / (2.0 * PI)).collect();
            let b = Block::new(&Curve::complex(hz, z).build().unwrap());
            let peak = peak::find(&b).unwrap();
            let (s, conjugated) = linear(&b, &peak, true).unwrap();
            assert_eq!(conjugated, sign < 0.0);
            // The leading balance is accurate to a few per cent.
            assert!((s.delta / 0.03 - 1.0).abs() < 0.1, "{s:?}");
            assert!((s.x_f / 0.06 - 1.0).abs() < 0.1, "{s:?}");
            assert!((peak.omega + s.shift - 6.0).abs() < 1e-3, "{s:?}");
            assert!((s.phase - 0.4).abs() < 0.05, "{s:?}");
            // A width beyond the frequency, as for extreme input: a start or none, but no panic.
            for half_width in [1e4 * peak.omega, 1e300] {
                let wide = Peak { half_width, ..peak };
                let start = linear(&b, &wide, true);
                assert!(start.is_none_or(|(s, _)| !(s.delta > peak.omega * 1e6)), "{start:?}");
            }
        }
    }
}
