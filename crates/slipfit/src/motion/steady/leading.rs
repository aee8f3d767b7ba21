//! The leading term, eq. (8) of Vitorino, Vieira and Rodrigues, and its extension by drag.

use super::{HarmonicDrive, Phasor, dynamic_stiffness};
use crate::model::oscillator::Oscillator;
use crate::numeric::roots::root;
use std::f64::consts::PI;

/// Leading amplitude, eq. (8):
///
/// ```text
/// R = [-4F gamma omega + sqrt(pi² k² x_0² Z² - 16 F² (k - m omega²)²)] / (pi Z²)
/// Z² = (k - m omega²)² + gamma² omega²
/// ```
///
/// It is the series truncated after its first term, with `phi_1 = 0`. At resonance the turning points agree to 2e-4
/// and the fundamental to 1e-3 at a gain of 5 (`Q = 50`, `beta = 0.9`); on the flanks it is 9 % too low at
/// `0.97 omega_0` and 20 % too high at `1.06 omega_0`, which the paper does not mention. Apart from the shift due to
/// viscous damping it has no shift of the resonance; the exact resonance is lower by about `2 (F/(pi k R))²`.
///
/// It is zero if the drive is too weak for a motion: `x_0 <= 4F/(pi k)` at resonance.
pub fn leading_amplitude(oscillator: &Oscillator, drive: &HarmonicDrive) -> f64 {
    super::series::solve(oscillator, drive, 1).map_or(0.0, |x| x[0].norm())
}

/// The leading term with additional drag `c v|v|`: the phasor of the fundamental, with the drive's crest at `t = 0`.
///
/// Balance of the fundamental, with `a2` the drag rate ([`drag_rate`](crate::motion::decay::drag_rate)):
///
/// ```text
/// |D(omega)/k R + i (4 x_F/pi + 2 a2 omega R²/omega_0²)| = x_0,    a2 = 4 c omega/(3 pi m)
/// ```
///
/// The left side grows with `R`, so the root is unique. `None` if the drive is too weak.
pub(crate) fn with_drag(oscillator: &Oscillator, drive: &HarmonicDrive, drag_rate: f64) -> Option<Phasor> {
    let omega = drive.omega();
    let d = dynamic_stiffness(oscillator, omega);
    let b = 4.0 / PI * oscillator.friction_displacement();
    let c = 2.0 * drag_rate * omega / oscillator.omega_0().powi(2);
    let balance = |r: f64| Phasor::new(d.re * r, d.im * r + b + c * r * r);
    let x_0 = drive.amplitude();
    if b >= x_0 {
        return None;
    }
    // |balance| grows from b < x_0; the root without drag is the start of the search.
    let mut high = match super::series::solve(oscillator, drive, 1) {
        Some(x) => x[0].norm(),
        None if c > 0.0 => (x_0 / c).sqrt(),
        None => return None,
    };
    while balance(high).norm() < x_0 {
        high *= 2.0;
        if !high.is_finite() {
            return None;
        }
    }
    let r = root(0.0, high, |r| balance(r).norm() - x_0);
    let base = balance(r);
    (r > 0.0).then(|| base.conj() * (r / base.norm()))
}
