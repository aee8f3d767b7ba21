//! The slow loss of amplitude under any odd friction law.

use crate::error::Error;
use crate::oscillator::above_zero;
use crate::quadrature::integrate;
use std::f64::consts::{FRAC_PI_2, PI};

/// Rate at which a friction law eats amplitude, `-dA/dt`, averaged over a cycle.
///
/// For friction force `f(v)`, odd in `v` (given for `v > 0`), with `V = A omega`,
///
/// ```text
/// -dA/dt = (2/(pi m omega)) ∫_0^{pi/2} f(V sin th) sin th dth
/// ```
///
/// which is the energy balance of eqs. (17) and (18) of Vitorino, Vieira and
/// Rodrigues with any loss put in. Holds to first order in the loss per cycle.
///
/// - `mass`: kg; `omega`: rad/s; `amplitude`: displacement, at least zero
/// - `friction`: force in N at a speed
///
/// The quadrature is adaptive to 1e-12 of the result, kinks of `f` included.
///
/// # Errors
/// [`Error::Parameter`] for a bad argument, or where `friction` returned
/// something not finite.
///
/// ```
/// # use slipfit::decay::law::amplitude_loss_rate;
/// let drag = |v: f64| 0.3 * v * v;
/// let rate = amplitude_loss_rate(2.0, 5.0, 0.1, drag)?;
/// let closed = 4.0 * 0.3 * 5.0 / (3.0 * std::f64::consts::PI * 2.0) * 0.1f64.powi(2);
/// assert!((rate / closed - 1.0).abs() < 1e-12);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn amplitude_loss_rate(
    mass: f64,
    omega: f64,
    amplitude: f64,
    friction: impl Fn(f64) -> f64,
) -> Result<f64, Error> {
    above_zero("mass", mass)?;
    above_zero("omega", omega)?;
    crate::oscillator::at_least_zero("amplitude", amplitude)?;
    let v = amplitude * omega;
    let integral = integrate(&|th: f64| friction(v * th.sin()) * th.sin(), 0.0, FRAC_PI_2);
    let rate = 2.0 / (PI * mass * omega) * integral;
    crate::oscillator::finite("friction(v)", rate)?;
    Ok(rate)
}

/// Time for the amplitude to fall from `from` to `to` at a given loss rate `-dA/dt`, s:
/// `∫ dA / rate(A)`.
///
/// Infinite where the rate vanishes on the way.
///
/// # Errors
/// [`Error::Parameter`] unless `0 <= to <= from < infinity`.
pub fn time_to_fall(from: f64, to: f64, rate: impl Fn(f64) -> f64) -> Result<f64, Error> {
    crate::oscillator::at_least_zero("from", from)?;
    if !(0.0..=from).contains(&to) {
        return Err(Error::Parameter { name: "to", value: to, range: "0 <= to <= from" });
    }
    let time = integrate(&|a: f64| 1.0 / rate(a), to, from);
    Ok(if time.is_nan() { f64::INFINITY } else { time })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kinked_law_is_integrated_to_twelve_digits() {
        // Sliding above a threshold speed only: the integral is cos(th_0).
        let rate = amplitude_loss_rate(1.0, 1.0, 1.0, |v| if v > 0.6 { 1.0 } else { 0.0 }).unwrap();
        assert!((rate / (2.0 / PI * 0.8) - 1.0).abs() < 1e-10);
        let power = amplitude_loss_rate(1.0, 1.0, 1.0, f64::sqrt).unwrap();
        // ∫ sin^1.5 = sqrt(pi) Gamma(1.25) / (2 Gamma(1.75))
        assert!((power / (2.0 / PI * 0.874_019_184_764_037) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_constant_rate_takes_its_time() {
        assert!((time_to_fall(3.0, 1.0, |_| 0.5).unwrap() - 4.0).abs() < 1e-13);
        assert!(time_to_fall(1.0, 2.0, |_| 0.5).is_err());
    }

    #[test]
    fn a_law_that_is_not_a_number_is_refused() {
        assert!(amplitude_loss_rate(1.0, 1.0, 1.0, |_| f64::NAN).is_err());
    }
}
