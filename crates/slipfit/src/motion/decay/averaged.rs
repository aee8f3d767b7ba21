//! The ring-down of Vitorino, Vieira and Rodrigues, eqs. (15) to (18).
//!
//! Friction is replaced by the first term of its Fourier series, and its work is averaged over half a cycle. Each
//! function states what it approximates; the exact motion is [`FreeDecay`](super::FreeDecay).

use crate::model::oscillator::Oscillator;
use std::f64::consts::PI;

/// Leading Fourier term of the friction force over the stiffness, eq. (15):
/// `(4 x_F/pi) sin(omega_r t)` for a release from a positive position at `t = 0`.
///
/// The force itself is a square wave of height `x_F`; the term is 27 % too high at its crest, but its projection on
/// the motion is exact. `omega_r` is the frequency of the free motion, `omega_d`.
pub fn ring_down_forcing(oscillator: &Oscillator, time_s: f64) -> f64 {
    4.0 * oscillator.friction_displacement() / PI * (oscillator.omega_d() * time_s).sin()
}

/// The offset of eq. (16), `4F/(pi gamma omega_0) = (2/pi) x_F omega_0/delta`.
///
/// Leading order in `1/Q` of the exact offset `x_F coth(pi delta/2 omega_d)`, [`Oscillator::decay_offset`]: too small
/// by `(pi²/48 - 1/8)/Q²`, 2 % at `Q = 2` (with `omega_d` in place of `omega_0` it would be `pi²/(48 Q²)`, 5 %). It
/// is infinite without viscous damping.
pub fn decay_offset(oscillator: &Oscillator) -> f64 {
    if oscillator.friction_displacement() == 0.0 {
        return 0.0;
    }
    2.0 * oscillator.friction_displacement() * oscillator.omega_0() / (PI * oscillator.decay_rate_per_s())
}

/// The amplitude of eq. (16), `-C + (A_i + C) e^(-delta t)`, where `C` is the [`decay_offset`].
///
/// Without viscous damping it is the limit `A_i - (2/pi) x_F omega_0 t`. It is negative once the motion has stopped,
/// where the equation no longer holds.
pub fn ring_down_amplitude(oscillator: &Oscillator, initial_amplitude: f64, time_s: f64) -> f64 {
    let delta = oscillator.decay_rate_per_s();
    let fall = -(-delta * time_s).exp_m1();
    let loss = 2.0 * oscillator.friction_displacement() * oscillator.omega_0() / PI;
    // (1 - e^-dt)/d, which is t itself as d -> 0.
    let time = if delta * time_s.abs() < 1e-40 { time_s } else { fall / delta };
    initial_amplitude - initial_amplitude * fall - loss * time
}

/// Energy lost in half a cycle at velocity amplitude `v`, eq. (17), over the mass:
/// `2 (F/m) v/omega_r + (pi/2)(gamma/m) v²/omega_r`; `omega_r` is taken as `omega_0` here.
///
/// The printed equation lacks the `1/omega_r` of the viscous term; without it eq. (18) does not follow and the
/// dimensions do not match: see [`half_cycle_energy_as_printed`].
pub fn half_cycle_energy(oscillator: &Oscillator, velocity_amplitude: f64) -> f64 {
    let v = velocity_amplitude;
    (2.0 * force_over_mass(oscillator) * v + PI * oscillator.decay_rate_per_s() * v * v)
        / oscillator.omega_0()
}

/// Eq. (17) as printed, `2 (F/m) v/omega_r + (pi/2)(gamma/m) v²`, for comparison.
///
/// `omega_r` is taken as `omega_0` here.
pub fn half_cycle_energy_as_printed(oscillator: &Oscillator, velocity_amplitude: f64) -> f64 {
    let v = velocity_amplitude;
    2.0 * force_over_mass(oscillator) * v / oscillator.omega_0() + PI * oscillator.decay_rate_per_s() * v * v
}

/// Rate of change of the velocity amplitude, eq. (18):
/// `dv/dt = -(2F/pi + gamma v/2)/m`, per s².
///
/// Its solution from `v = A_i omega_r` is eq. (16); `omega_r` is taken as `omega_0` here.
pub fn velocity_amplitude_rate(oscillator: &Oscillator, velocity_amplitude: f64) -> f64 {
    -(2.0 * force_over_mass(oscillator) / PI + oscillator.decay_rate_per_s() * velocity_amplitude)
}

fn force_over_mass(oscillator: &Oscillator) -> f64 {
    oscillator.friction_displacement() * oscillator.omega_0() * oscillator.omega_0()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::decay::FreeDecay;

    fn at(q: f64) -> Oscillator {
        Oscillator::builder().omega_0(2.0).q_factor(q).friction_displacement(0.01).build().unwrap()
    }

    #[test]
    fn the_offset_errs_as_the_inverse_square_of_q() {
        let exact_at_two = 0.01 / (PI / (4.0 * 2.0) / (1.0f64 - 1.0 / 16.0).sqrt()).tanh();
        assert!((at(2.0).decay_offset() - exact_at_two).abs() < 1e-15);
        for (q, within) in [(2.0, 0.05), (20.0, 1e-3), (200.0, 1e-4)] {
            let o = at(q);
            let error = (1.0 - decay_offset(&o) / o.decay_offset()) * q * q;
            let with_omega_d =
                (1.0 - decay_offset(&o) * o.omega_d() / o.omega_0() / o.decay_offset()) * q * q;
            assert!((error / (PI * PI / 48.0 - 0.125) - 1.0).abs() < within, "{q} {error}");
            assert!((with_omega_d / (PI * PI / 48.0) - 1.0).abs() < within, "{q} {with_omega_d}");
        }
    }

    #[test]
    fn equation_18_integrates_to_equation_16() {
        let o = at(30.0);
        let v = |t: f64| ring_down_amplitude(&o, 1.0, t) * o.omega_0();
        let h = 1e-4;
        for t in [0.0, 3.0, 11.0] {
            let slope = (v(t + h) - v(t - h)) / (2.0 * h);
            assert!((slope - velocity_amplitude_rate(&o, v(t))).abs() < 1e-9);
        }
    }

    #[test]
    fn equation_17_holds_only_with_the_missing_frequency() {
        let o = at(500.0);
        let (a, w2) = (1.0, o.omega_0() * o.omega_0());
        let decay = FreeDecay::from_rest(&o, a).unwrap();
        let loss = decay.loss(0);
        let b = decay.turning_point(1).position.abs();
        let exact = (loss.viscous + loss.sliding) * w2;
        let v = 0.5 * (a + b) * o.omega_0();
        assert!((half_cycle_energy(&o, v) / exact - 1.0).abs() < 1e-4);
        assert!((half_cycle_energy_as_printed(&o, v) / exact - 1.0).abs() > 0.1);
    }

    #[test]
    fn the_averaged_ring_down_follows_the_exact_turning_points_at_high_q() {
        let o = at(1000.0);
        let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
        for p in decay.turning_points().take(40) {
            let a = ring_down_amplitude(&o, 1.0, p.time_s);
            assert!((a - p.position.abs()).abs() < 1e-5, "{} {a}", p.position);
        }
    }
}
