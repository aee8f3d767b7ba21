//! The exact steady motion with two turning points per cycle and no stop (Den Hartog 1931), in closed form.

use super::{HarmonicDrive, Phasor, dynamic_stiffness};
use crate::model::oscillator::Oscillator;
use crate::numeric::double_double::{Dd, two_sum};
use crate::numeric::quadrature::integrate;
use std::f64::consts::PI;

/// The periodic motion that turns twice per cycle and never stops.
///
/// With `y = pi delta/omega`, `theta = pi omega_d/omega`, `D = k - m omega² + i gamma omega`,
///
/// ```text
/// N = 2 [sinh²(y/2) + cos²(theta/2)]
/// G = [sinh y - (delta/omega_d) sin theta]/N,   H = (omega_0²/(omega omega_d)) sin theta / N
/// X = sqrt((k x_0/|D|)² - (H x_F)²) - G x_F                  turning-point amplitude
/// p = X + G x_F,  q = H x_F                                  steady part p - i q
/// X_1 = p - i q - i (4F/pi)/D,   X_n = -i (4F/n pi)/D(n omega)
/// ```
///
/// with time counted from the turning point. Eq. (3) of Vitorino, Vieira and Rodrigues converges to this motion, and
/// eq. (8) approximates it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedForm {
    oscillator: Oscillator,
    drive: HarmonicDrive,
    /// Turning-point amplitude `X`.
    amplitude: f64,
    p: f64,
    q: f64,
    /// The drive is `x_0 cos(omega t + drive_phase)`, with time counted from the turning point.
    drive_phase: f64,
    a: f64,
    b: f64,
}

impl ClosedForm {
    /// Evaluates the formulas.
    ///
    /// `None` if they have no solution with `X > 0`: the drive is too weak, or there is no damping at resonance. A
    /// solution does not imply that the motion exists: see [`ClosedForm::holds`].
    pub fn new(oscillator: &Oscillator, drive: &HarmonicDrive) -> Option<Self> {
        let (omega_0, delta, x_f) =
            (oscillator.omega_0(), oscillator.decay_rate_per_s(), oscillator.friction_displacement());
        let omega = drive.omega();
        let omega_d = Dd::root_of_difference_of_squares(omega_0, delta);
        // theta = pi (1 - e); e is small at resonance, where N depends on its square.
        let e = two_sum(omega, -omega_d.hi).sub(Dd { hi: omega_d.lo, lo: 0.0 }).value() / omega;
        let (y, sin_theta, half) = (PI * delta / omega, (PI * e).sin(), (0.5 * PI * e).sin());
        // Beyond y = 20 the hyperbolic functions are divided out to avoid overflow.
        let (sinh_over_n, one_over_n) = if y > 20.0 {
            (1.0, 2.0 * (-y).exp())
        } else {
            let n = 2.0 * ((0.5 * y).sinh().powi(2) + half * half);
            (y.sinh() / n, 1.0 / n)
        };
        let g = sinh_over_n - delta / omega_d.hi * sin_theta * one_over_n;
        let h = omega_0 / omega * (omega_0 / omega_d.hi) * sin_theta * one_over_n;
        let (g_x, q) = if x_f == 0.0 { (0.0, 0.0) } else { (g * x_f, h * x_f) };
        let d = dynamic_stiffness(oscillator, omega);
        let reach = drive.amplitude() / d.norm();
        let p = ((reach - q) * (reach + q)).sqrt();
        let amplitude = p - g_x;
        if amplitude.is_nan() || amplitude <= 0.0 || amplitude.is_infinite() {
            return None;
        }
        let a = -x_f - g_x;
        Some(Self {
            oscillator: *oscillator,
            drive: *drive,
            amplitude,
            p,
            q,
            drive_phase: (Phasor::new(p, -q) * d).arg(),
            a,
            b: (delta * a - omega * q) / omega_d.hi,
        })
    }

    /// Whether the mass really moves this way: at the turning point it must start at once against static friction,
    /// and its velocity must keep its sign for half a cycle.
    ///
    /// This is decided by the event machine, started at the turning point: the next event must be the opposite
    /// turning point, half a period later.
    pub fn holds(&self) -> bool {
        use crate::motion::simulate::{EventKind, Harmonic, Motion};
        let omega = self.drive.omega();
        let tone = Harmonic { amplitude: self.drive.amplitude(), omega, phase: self.drive_phase };
        let half = PI / omega;
        let motion = crate::motion::simulate::Drive::harmonics(0.0, &[tone])
            .and_then(|drive| Motion::new(&self.oscillator, drive, 0.0, self.amplitude, 0.0));
        let Ok(mut motion) = motion else { return false };
        if motion.direction() != -1.0 && self.oscillator.friction_displacement() > 0.0 {
            return false;
        }
        match motion.next_event(1.5 * half) {
            Some(e) => {
                e.kind == EventKind::Turn
                    && (e.time_s / half - 1.0).abs() < 1e-6
                    && (e.position + self.amplitude).abs() < 1e-6 * self.amplitude
            }
            None => false,
        }
    }

    /// Turning-point amplitude `X`.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Phase lag of the fundamental relative to the turning point, rad: `phi_1` of eq. (7).
    pub fn fundamental_phase(&self) -> f64 {
        -self.counted_from_turn(1).arg()
    }

    /// Time of the positive turning point after the drive's crest, s (lag of the response).
    pub fn turn_time_s(&self) -> f64 {
        self.drive_phase.rem_euclid(2.0 * PI) / self.drive.omega()
    }

    fn counted_from_turn(&self, n: u32) -> Phasor {
        let omega = self.drive.omega();
        match n {
            1 => Phasor::new(self.p, -self.q) + super::series::harmonic(&self.oscillator, omega, 1),
            n if n % 2 == 1 => super::series::harmonic(&self.oscillator, omega, n),
            _ => Phasor::new(0.0, 0.0),
        }
    }

    /// Phasor of harmonic `n`, with time counted from the drive's crest; zero for even `n`.
    pub fn harmonic(&self, n: u32) -> Phasor {
        self.counted_from_turn(n) * Phasor::from_polar(1.0, -f64::from(n) * self.drive_phase)
    }

    /// Displacement and velocity at the time `u` after the positive turning point, `0 <= u <= pi/omega`.
    fn half_cycle(&self, u: f64) -> (f64, f64) {
        let o = &self.oscillator;
        let (w, delta) = (o.omega_d(), o.decay_rate_per_s());
        let (sin, cos) = (w * u).sin_cos();
        let e = (-delta * u).exp();
        let omega = self.drive.omega();
        let (s, c) = (omega * u).sin_cos();
        let x = o.friction_displacement() + self.p * c + self.q * s + e * (self.a * cos + self.b * sin);
        let v = omega * (self.q * c - self.p * s)
            + e * ((w * self.b - delta * self.a) * cos - (w * self.a + delta * self.b) * sin);
        (x, v)
    }

    /// Displacement and velocity, with time counted from the drive's crest.
    pub fn state(&self, time_s: f64) -> (f64, f64) {
        let half = PI / self.drive.omega();
        let u = (time_s - self.turn_time_s()).rem_euclid(2.0 * half);
        if u < half {
            self.half_cycle(u)
        } else {
            let (x, v) = self.half_cycle(u - half);
            (-x, -v)
        }
    }

    /// `∮ v² dt` over a cycle.
    pub(super) fn velocity_square(&self) -> f64 {
        let half = PI / self.drive.omega();
        2.0 * integrate(&|u: f64| self.half_cycle(u).1.powi(2), 0.0, half)
    }
}
