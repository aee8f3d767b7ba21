//! The Fourier series of the steady motion, eqs. (1) to (7) of Vitorino, Vieira and Rodrigues.
//!
//! The square wave of friction has its zeros at those of the velocity, at multiples of *half* the period (the text
//! before eq. (1) says: of the period). The origin of time is chosen there: friction is a sine series, the crest of
//! the motion is at `t = 0`, and the drive is `x_0 cos(omega t - phi_0)` with `phi_0` to be found.
//!
//! Amplitudes are displacements, forces are over the stiffness.

use super::{HarmonicDrive, PeriodicOrbit, Phasor, dynamic_stiffness};
use crate::model::oscillator::Oscillator;
use std::f64::consts::{FRAC_PI_2, PI};

/// Partial sum of the square wave of friction, eq. (1), over the stiffness:
/// `Σ (4 x_F/n pi) sin(n omega t)`, `n = 1, 3, 5 …`, `terms` of them.
///
/// It acts along the positive axis while the velocity is negative.
pub fn friction_force(oscillator: &Oscillator, omega: f64, time_s: f64, terms: u32) -> f64 {
    let unit: f64 = odd(terms).map(|n| (f64::from(n) * omega * time_s).sin() / f64::from(n)).rev().sum();
    4.0 / PI * oscillator.friction_displacement() * unit
}

/// Acceleration from the equation of motion, eq. (2), with friction summed up to `terms`:
///
/// ```text
/// m x'' = -k (x - x_0 cos(omega t - phi_0)) - gamma x' + Σ (4F/n pi) sin(n omega t)
/// ```
///
/// The printed equation has a minus before the sum. With `x = R cos(omega t)` the velocity varies as `-sin`, so
/// friction, which opposes it, varies as `+sin`, as in eqs. (8) and (15).
pub fn acceleration(
    oscillator: &Oscillator,
    drive: &HarmonicDrive,
    drive_phase: f64,
    state: (f64, f64),
    time_s: f64,
    terms: u32,
) -> f64 {
    let (x, v) = state;
    let omega = drive.omega();
    let base = drive.amplitude() * (omega * time_s - drive_phase).cos();
    let friction = friction_force(oscillator, omega, time_s, terms);
    oscillator.omega_0().powi(2) * (base - x + friction) - 2.0 * oscillator.decay_rate_per_s() * v
}

/// Amplitude of harmonic `n`, eq. (4): `R_n = (4 x_F/n pi) / |D(n omega)/k|`.
pub fn harmonic_amplitude(oscillator: &Oscillator, omega: f64, n: u32) -> f64 {
    harmonic(oscillator, omega, n).norm()
}

/// Phase of harmonic `n` in `R_n cos(n omega t - phi_n)`, eq. (5) corrected: the printed angle, taken in the quadrant
/// of `D(n omega)`, plus `pi/2`.
///
/// The forcing is a sine while eq. (3) is written in cosines; and above resonance, where every `n >= 3` usually lies,
/// `k - m n² omega²` is negative.
pub fn harmonic_phase(oscillator: &Oscillator, omega: f64, n: u32) -> f64 {
    dynamic_stiffness(oscillator, f64::from(n) * omega).arg() + FRAC_PI_2
}

/// Eq. (5) as printed, `arctan(n gamma omega/(k - m n² omega²))`, for comparison.
pub fn harmonic_phase_as_printed(oscillator: &Oscillator, omega: f64, n: u32) -> f64 {
    let d = dynamic_stiffness(oscillator, f64::from(n) * omega);
    (d.im / d.re).atan()
}

/// The condition that velocity and friction change sign together, eq. (6):
/// `R sin(phi_1) = -Σ n R_n sin(phi_n)`, `n = 3, 5 …`, `terms` counting `n = 1`.
///
/// Returns `R sin(phi_1)`. With `phi_n` of [`harmonic_phase`].
pub fn quadrature_of_fundamental(oscillator: &Oscillator, omega: f64, terms: u32) -> f64 {
    // n R_n sin(phi_n) = -n Im X_n, computed without using the angle.
    higher(terms).rev().map(|n| f64::from(n) * harmonic(oscillator, omega, n).im).sum()
}

/// Phase of the fundamental relative to friction, eq. (7) corrected:
///
/// ```text
/// sin(phi_1) = Σ (4F/pi R)(m n² omega² - k) / Z_n²,     n = 3, 5 …
/// ```
///
/// near resonance `F/(pi k R)`. `None` if the sum exceeds one: the motion is then far from sinusoidal.
pub fn fundamental_phase(
    oscillator: &Oscillator,
    omega: f64,
    fundamental_amplitude: f64,
    terms: u32,
) -> Option<f64> {
    let sine = quadrature_of_fundamental(oscillator, omega, terms) / fundamental_amplitude;
    (sine.abs() <= 1.0).then(|| sine.asin())
}

/// Eq. (7) as printed, `sin(phi_1) = Σ (4F n gamma omega/(pi R)) / Z_n²`: of order `F/(k R Q)`, hundreds of times too
/// small for `Q = 50`.
pub fn fundamental_phase_as_printed(
    oscillator: &Oscillator,
    omega: f64,
    fundamental_amplitude: f64,
    terms: u32,
) -> f64 {
    let sum: f64 = higher(terms)
        .rev()
        .map(|n| {
            let d = dynamic_stiffness(oscillator, f64::from(n) * omega);
            4.0 * oscillator.friction_displacement() / PI * d.im / d.norm_sqr()
        })
        .sum();
    (sum / fundamental_amplitude).asin()
}

/// Displacement by the series, eq. (3): `R cos(omega t - phi_1) + Σ R_n cos(n omega t - phi_n)`, with `t = 0` at the
/// turning point.
///
/// `fundamental` is `(R, phi_1)`.
pub fn displacement(
    oscillator: &Oscillator,
    omega: f64,
    fundamental: (f64, f64),
    time_s: f64,
    terms: u32,
) -> f64 {
    let (r, phi) = fundamental;
    let rest: f64 = higher(terms)
        .rev()
        .map(|n| {
            harmonic_amplitude(oscillator, omega, n)
                * (f64::from(n) * omega * time_s - harmonic_phase(oscillator, omega, n)).cos()
        })
        .sum();
    r * (omega * time_s - phi).cos() + rest
}

/// Solution of the series: phasors of `n = 1, 3 … 2 terms - 1`, with the drive's crest at `t = 0`.
///
/// Eqs. (2), (3) and (6) together leave one unknown, the in-phase part `p` of the fundamental;
/// `|D (p - i q)/k + 4 i x_F/pi| = x_0` is a quadratic equation for it, of which eq. (8) is the case `q = 0`. With
/// more terms it converges to the exact motion if that has no stops.
///
/// `None` if the drive is too weak for a motion of this kind.
pub fn solve(oscillator: &Oscillator, drive: &HarmonicDrive, terms: u32) -> Option<Vec<Phasor>> {
    let omega = drive.omega();
    let q = quadrature_of_fundamental(oscillator, omega, terms);
    let d = dynamic_stiffness(oscillator, omega);
    let b = 4.0 / PI * oscillator.friction_displacement();
    let square = d.norm_sqr();
    // (x_0² - |D|² q² + 2 Re D q b - b²) |D|² + (Im D b)², with the b² terms combined.
    let under =
        square * (drive.amplitude().powi(2) - square * q * q + 2.0 * d.re * q * b) - (d.re * b).powi(2);
    if under.is_nan() || under < 0.0 {
        return None;
    }
    let p = (under.sqrt() - d.im * b) / square;
    if !p.is_finite() || p <= 0.0 {
        return None;
    }
    let first = Phasor::new(p, -q);
    let base = d * first + Phasor::new(0.0, b);
    let shift = base.conj() / base.norm();
    let turn = |n: u32| Phasor::from_polar(1.0, f64::from(n) * shift.arg());
    let mut all = vec![first * shift];
    all.extend(higher(terms).map(|n| harmonic(oscillator, omega, n) * turn(n)));
    Some(all)
}

/// The motion by the Fourier series of friction with sticking: the mean and the harmonics up to `highest`,
/// `X_n = (U_n + f_n) k/D(n omega)`, with the drive's crest at `t = 0`.
///
/// Vitorino, Vieira and Rodrigues suggest this for static friction after their eq. (8). The force is that of the
/// exact motion, `f_n` of [`PeriodicOrbit::friction_harmonic`]; truncated after `highest` harmonics, the series still
/// moves slightly while the mass sticks. Its error falls as `highest^-2`, because the jumps of the force are
/// attenuated by `1/omega²` and summed.
pub fn sticking(orbit: &PeriodicOrbit, drive: &HarmonicDrive, highest: u32) -> Vec<Phasor> {
    (0..=highest)
        .map(|n| {
            let base = if n == 1 { drive.amplitude() } else { 0.0 };
            let force = orbit.friction_harmonic(n) + base;
            force / dynamic_stiffness(orbit.oscillator(), f64::from(n) * drive.omega())
        })
        .collect()
}

/// Phasor of harmonic `n >= 3` with the turning point at `t = 0`: `-i (4 x_F/n pi) k/D(n omega)`.
pub(super) fn harmonic(oscillator: &Oscillator, omega: f64, n: u32) -> Phasor {
    let n = f64::from(n);
    let force = 4.0 * oscillator.friction_displacement() / (n * PI);
    Phasor::new(0.0, -force) / dynamic_stiffness(oscillator, n * omega)
}

fn odd(terms: u32) -> impl DoubleEndedIterator<Item = u32> {
    (0..terms).map(|i| i.saturating_mul(2) | 1)
}

/// The odd numbers from three on; `terms` includes the omitted `n = 1`.
fn higher(terms: u32) -> impl DoubleEndedIterator<Item = u32> {
    (1..terms).map(|i| i.saturating_mul(2) | 1)
}
