//! The slow loss of amplitude under any odd friction law.

use crate::error::Error;
use crate::oscillator::above_zero;
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

/// Gauss and Kronrod, 7 and 15 points, halving where they differ.
fn integrate(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    if a == b {
        return 0.0;
    }
    let (whole, _) = kronrod(f, a, b);
    let mut open = vec![(a, b, 0_u32)];
    let mut sum = 0.0;
    let tolerance = 1e-13 * whole.abs();
    while let Some((a, b, depth)) = open.pop() {
        let (value, error) = kronrod(f, a, b);
        // The difference of the two rules is a gross overestimate, even of its square root.
        let good = error <= tolerance.max(1e-15 * value.abs()) || error.is_nan();
        if good || depth >= 40 {
            sum += value;
        } else {
            let m = 0.5 * (a + b);
            open.push((a, m, depth + 1));
            open.push((m, b, depth + 1));
        }
    }
    sum
}

fn kronrod(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> (f64, f64) {
    // Piessens and others, QUADPACK (1983).
    const X: [f64; 8] = [
        0.991_455_371_120_812_6,
        0.949_107_912_342_758_5,
        0.864_864_423_359_769_1,
        0.741_531_185_599_394_4,
        0.586_087_235_467_691_1,
        0.405_845_151_377_397_2,
        0.207_784_955_007_898_47,
        0.0,
    ];
    const K: [f64; 8] = [
        0.022_935_322_010_529_224,
        0.063_092_092_629_978_55,
        0.104_790_010_322_250_18,
        0.140_653_259_715_525_92,
        0.169_004_726_639_267_9,
        0.190_350_578_064_785_4,
        0.204_432_940_075_298_9,
        0.209_482_141_084_727_82,
    ];
    const G: [f64; 4] =
        [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];
    let (c, h) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut k, mut g) = (0.0, 0.0);
    for i in 0..8 {
        let y = if i == 7 { f(c) } else { f(c - h * X[i]) + f(c + h * X[i]) };
        k += K[i] * y;
        if i % 2 == 1 {
            g += G[i / 2] * y;
        }
    }
    (h * k, (h * (k - g)).abs())
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
