//! Amplitude at one drive level as a function of the line: that of the line, or of the exact motion near it.

use crate::motion::steady::fundamental::{Point, Regime, fundamental};
use std::f64::consts::FRAC_PI_4;

/// Quality factor of critical damping.
pub(super) const LEAST_Q: f64 = 0.5;
/// Drive over threshold above which the motion equals the line to the last digit.
const STRAIGHT: f64 = 1e8;

/// Amplitude of the motion at one level as a function of intercept and slope of the line: that of the line itself, or
/// the exact one to first order about a line near it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LevelRow {
    /// Amplitude for a vanishing line.
    pub(super) offset: f64,
    /// Derivatives with respect to intercept and slope.
    pub(super) by: [f64; 2],
    /// Derivative with respect to the logarithm of Q for a given line.
    pub(super) by_log_q: f64,
}

impl LevelRow {
    /// A level on the line.
    pub(super) fn straight(drive: f64) -> Self {
        Self { offset: 0.0, by: [1.0, drive], by_log_q: 0.0 }
    }

    /// Amplitude for a line `[intercept, slope]`.
    pub(super) fn amplitude(&self, [intercept, slope]: [f64; 2]) -> f64 {
        self.offset + self.by[0] * intercept + self.by[1] * slope
    }
}

/// Amplitude of the exact motion at the undamped resonance (J. P. Den Hartog, Trans. ASME 53, 107 (1931), and motion
/// with stops) at a drive, to first order about a line `[intercept, slope]` for this Q; `None` if no oscillator has
/// this Q.
///
/// Drives are in units of the threshold `t = 4 x_F/pi` and amplitudes in those of `slope t/Q`:
///
/// ```text
/// amplitude = (slope t/Q) A(drive/t, Q)     A(u, Q) = Q (u - 1) on the line, zero for u < pi/4
/// ```
pub(super) fn exact_row([intercept, slope]: [f64; 2], q: f64, drive: f64) -> Option<LevelRow> {
    if !(q > LEAST_Q && slope > 0.0) {
        return None;
    }
    let u = -drive * slope / intercept;
    if !(intercept < 0.0 && u < STRAIGHT) {
        return Some(LevelRow::straight(drive));
    }
    let at = Point { omega: 1.0, omega_0: 1.0, detuning: 0.0, delta: 0.5 / q, x_0: u, x_f: FRAC_PI_4 };
    // Friction keeps the mass at rest.
    if u <= at.x_f {
        return Some(LevelRow { offset: 0.0, by: [0.0; 2], by_log_q: 0.0 });
    }
    let found = fundamental(&at)?;
    let amplitude = found.value.norm();
    if !(amplitude > 0.0 && amplitude.is_finite()) {
        return Some(LevelRow { offset: 0.0, by: [0.0; 2], by_log_q: 0.0 });
    }
    // Such a motion is smaller than x_F and has no closed form, so that its derivatives are not known.
    if found.regime == Regime::ManyTurns {
        return Some(LevelRow { offset: -intercept / q * amplitude, by: [0.0; 2], by_log_q: 0.0 });
    }
    let direction = found.value.conj() / amplitude;
    let by_drive = (direction * found.by_x_0).re;
    let by_log_q = -at.delta * (direction * found.by_delta).re;
    // The lost amplitude is the unit of A/Q.
    let by = [(u * by_drive - amplitude) / q, drive * by_drive / q];
    let unit = -intercept / q;
    let offset = unit * amplitude - by[0] * intercept - by[1] * slope;
    let row = LevelRow { offset, by, by_log_q: unit * (by_log_q - amplitude) };
    [row.offset, row.by[0], row.by[1], row.by_log_q].iter().all(|v| v.is_finite()).then_some(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Oscillator;
    use crate::motion::steady::scan;

    /// An oscillator of this Q with a threshold of one.
    fn oscillator(q: f64) -> Oscillator {
        let builder = Oscillator::builder().frequency_hz(2.0).q_factor(q);
        builder.friction_displacement(FRAC_PI_4).build().unwrap()
    }

    #[test]
    fn a_row_is_the_exact_motion_with_its_derivatives() {
        for q in [0.6, 1.0, 3.0, 30.0, 1e4] {
            for drive in [0.3, 0.79, 0.9, 1.0, 1.1, 1.5, 20.0] {
                let line = [-q, q];
                let exact = scan::reading(&oscillator(q), drive, 2.0).unwrap().amplitude();
                let row = exact_row(line, q, drive).unwrap();
                assert!((row.amplitude(line) - exact).abs() < 1e-7 * (1.0 + exact), "{q} {drive}: {row:?}");
                let at = |line: [f64; 2], q: f64| exact_row(line, q, drive).unwrap().amplitude(line);
                let h = 1e-5;
                let slopes = [
                    at([line[0] + h * q, q], q) - at([line[0] - h * q, q], q),
                    at([line[0], (1.0 + h) * q], q) - at([line[0], (1.0 - h) * q], q),
                    at(line, (1.0 + h) * q) - at(line, (1.0 - h) * q),
                ];
                if row.by == [0.0; 2] {
                    assert!(exact < 1.0, "{q} {drive}: {exact}");
                    continue;
                }
                for (slope, found) in slopes.into_iter().zip([row.by[0] * q, row.by[1] * q, row.by_log_q]) {
                    let slope = slope / (2.0 * h);
                    assert!((slope - found).abs() < 1e-4 * (q + exact), "{q} {drive}: {slope} {found}");
                }
            }
        }
    }
}
