//! The slow loss of amplitude under any odd friction law.

use crate::error::Error;
use crate::model::oscillator::above_zero;
use crate::numeric::quadrature::integrate;
use std::f64::consts::{FRAC_PI_2, PI};

/// Rate at which a friction law reduces the amplitude, `-dA/dt`, averaged over a cycle.
///
/// For friction force `f(v)`, odd in `v` (given for `v > 0`), with `V = A omega`,
///
/// ```text
/// -dA/dt = (2/(pi m omega)) ∫_0^{pi/2} f(V sin th) sin th dth
/// ```
///
/// This is the energy balance of eqs. (17) and (18) of Vitorino, Vieira and Rodrigues for an arbitrary loss. It holds
/// to first order in the loss per cycle.
///
/// - `mass`: kg; `omega`: rad/s; `amplitude`: displacement, at least zero
/// - `friction`: force in N as a function of the speed
///
/// The quadrature is adaptive to 1e-12 of the result, also for kinks of `f`.
///
/// # Errors
/// [`Error::Parameter`] for an invalid argument, or if `friction` returned a non-finite value.
///
/// ```
/// # use slipfit::motion::decay::law::amplitude_loss_rate;
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
    crate::model::oscillator::at_least_zero("amplitude", amplitude)?;
    let v = amplitude * omega;
    let integral = integrate(&|th: f64| friction(v * th.sin()) * th.sin(), 0.0, FRAC_PI_2);
    let rate = 2.0 / (PI * mass * omega) * integral;
    crate::model::oscillator::finite("friction(v)", rate)?;
    Ok(rate)
}

/// Time for the amplitude to fall from `from` to `to` at a given loss rate `-dA/dt`, s:
/// `∫ dA / rate(A)`.
///
/// Infinite if the rate vanishes in between, or at an end unless the time to that end is finite, as for a rate
/// proportional to the square root of the amplitude.
///
/// # Errors
/// [`Error::Parameter`] unless `0 <= to <= from < infinity`.
pub fn time_to_fall(from: f64, to: f64, rate: impl Fn(f64) -> f64) -> Result<f64, Error> {
    crate::model::oscillator::at_least_zero("from", from)?;
    if !(0.0..=from).contains(&to) {
        return Err(Error::Parameter { name: "to", value: to, range: "0 <= to <= from" });
    }
    let inverse = |a: f64| 1.0 / rate(a);
    // On approaching the point where the rate vanishes, each tenth of the remaining way must take less time than the
    // one before.
    let endless = |end: f64, other: f64| {
        let at = |part: i32| end + (other - end) * 10f64.powi(-part);
        let tenth = |part: i32| integrate(&inverse, at(part + 1), at(part)).abs();
        from > to && !(rate(end) > 0.0) && !(tenth(6) < 0.9 * tenth(5))
    };
    let time = if endless(to, from) || endless(from, to) { f64::NAN } else { integrate(&inverse, to, from) };
    Ok(if time.is_nan() { f64::INFINITY } else { time })
}

/// The friction law that causes a loss of amplitude, without assuming a model: the inverse of [`amplitude_loss_rate`]
/// (Abel's integral equation).
///
/// With `g(V) = (pi/2) m omega (-dA/dt)` at the velocity amplitude `V = A omega`,
///
/// ```text
/// g(V) = ∫_0^{pi/2} f(V sin th) sin th dth
/// f(u) = 1/(pi u) d/du ∫_0^u 2 V² g(V)/sqrt(u² - V²) dV
/// ```
///
/// - `mass`: kg; `omega`: rad/s; `speed`: speed at which the law is evaluated, above zero
/// - `loss_rate`: `-dA/dt` as a function of the amplitude, smooth between zero and `speed/omega`
///
/// Returns the force in N at that speed. The derivative is taken over a hundredth of `speed`, accurate to 1e-9 for a
/// law smooth on that scale; a kink is smoothed over it.
///
/// # Errors
/// [`Error::Parameter`] for an invalid argument, or if `loss_rate` returned a non-finite value.
///
/// ```
/// # use slipfit::motion::decay::law::friction_from_loss_rate;
/// // Sliding takes a constant amount of amplitude per second: the law is a constant force.
/// let (m, omega, force) = (2.0, 5.0, 0.3);
/// let loss = |_: f64| 2.0 * force / (std::f64::consts::PI * m * omega);
/// assert!((friction_from_loss_rate(m, omega, 0.7, loss)? - force).abs() < 1e-9);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn friction_from_loss_rate(
    mass: f64,
    omega: f64,
    speed: f64,
    loss_rate: impl Fn(f64) -> f64,
) -> Result<f64, Error> {
    above_zero("mass", mass)?;
    above_zero("omega", omega)?;
    above_zero("speed", speed)?;
    let g = |v: f64| 0.5 * PI * mass * omega * loss_rate(v / omega);
    // V = u sin th.
    let inner =
        |u: f64| 2.0 * u * u * integrate(&|th: f64| th.sin().powi(2) * g(u * th.sin()), 0.0, FRAC_PI_2);
    let h = 2.5e-3 * speed;
    let side = |k: f64| inner(speed + k * h) - inner(speed - k * h);
    let slope = (45.0 * side(1.0) - 9.0 * side(2.0) + side(3.0)) / (60.0 * h);
    let force = slope / (PI * speed);
    crate::model::oscillator::finite("loss_rate(A)", force)?;
    Ok(force)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kinked_law_is_integrated_to_twelve_digits() {
        // Friction only above a threshold speed: the integral is cos(th_0).
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
    fn a_rate_that_vanishes_takes_for_ever_unless_it_falls_with_a_root() {
        assert_eq!(time_to_fall(1.0, 0.0, |a| a).unwrap(), f64::INFINITY);
        assert_eq!(time_to_fall(1.0, 0.5, |a| (a - 0.5).powi(2)).unwrap(), f64::INFINITY);
        assert_eq!(time_to_fall(1.0, 0.5, |a| 1.0 - a).unwrap(), f64::INFINITY);
        assert!((time_to_fall(1.0, 0.0, f64::sqrt).unwrap() - 2.0).abs() < 1e-6);
        assert_eq!(time_to_fall(1.0, 1.0, |_| 0.0).unwrap(), 0.0);
    }

    #[test]
    fn the_law_behind_a_loss_is_the_law_that_made_it() {
        let (m, omega) = (0.7, 3.0);
        let laws: [&dyn Fn(f64) -> f64; 4] = [
            &|v| 0.2 + 0.05 * v,
            &|v| 0.3 * v * v,
            &|v| 0.1 * v.powf(1.5),
            // Stribeck curve: falling, then rising.
            &|v| 0.2 * (-(v * v)).exp() + 0.1 + 0.02 * v,
        ];
        for (i, law) in laws.iter().enumerate() {
            for u in [0.3, 1.0, 2.5] {
                let loss = |a: f64| amplitude_loss_rate(m, omega, a, law).unwrap_or(f64::NAN);
                let found = friction_from_loss_rate(m, omega, u, loss).unwrap();
                assert!((found / law(u) - 1.0).abs() < 1e-8, "{i} {u}: {found} {}", law(u));
            }
        }
        assert!(friction_from_loss_rate(m, omega, 0.0, |_| 1.0).is_err());
        assert!(friction_from_loss_rate(m, omega, 1.0, |_| f64::NAN).is_err());
    }

    #[test]
    fn a_law_that_is_not_a_number_is_refused() {
        assert!(amplitude_loss_rate(1.0, 1.0, 1.0, |_| f64::NAN).is_err());
    }
}
