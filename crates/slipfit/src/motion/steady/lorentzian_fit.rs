//! Least-squares fit of the effective Lorentzian, eq. (14).

use crate::error::Error;
use crate::inference::least_squares::{LeastSquares, Normal, minimise};

/// A Lorentzian fitted to a resonance curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LorentzianFit {
    /// Effective drive amplitude, the paper's `x_f` (not a friction displacement).
    pub effective_drive: f64,
    /// Effective quality factor `Q_f`.
    pub effective_q_factor: f64,
    /// Centre `omega_0`, rad/s.
    pub omega_0: f64,
    /// Root mean square of the residuals, in the unit of the amplitudes.
    pub residual_rms: f64,
}

impl LorentzianFit {
    /// The fitted amplitude at an angular frequency:
    /// `x_f omega_0² / sqrt((omega_0² - omega²)² + (omega omega_0/Q_f)²)`.
    pub fn amplitude(&self, omega: f64) -> f64 {
        let r = omega / self.omega_0;
        self.effective_drive / ((1.0 - r) * (1.0 + r)).hypot(r / self.effective_q_factor)
    }
}

/// Fits eq. (14) of Vitorino, Vieira and Rodrigues to amplitudes over frequency, with all three parameters free and
/// equal weights.
///
/// Pass the result to [`invert`](super::lorentzian::invert) to reproduce the paper's analysis, including its bias.
///
/// - `omega`: angular frequencies, rad/s, above zero
/// - `amplitude`: steady amplitudes, at least zero, all in the same unit
///
/// # Errors
/// [`Error::Length`] if the two differ; [`Error::TooFewSamples`] below four points; [`Error::Parameter`] for a value
/// out of range or not finite; [`Error::NoFit`] if the points have no peak to which a Lorentzian can be fitted.
///
/// ```
/// # use slipfit::motion::steady::lorentzian::{LorentzianFit, fit};
/// let truth = LorentzianFit { effective_drive: 0.2, effective_q_factor: 50.0, omega_0: 3.0, residual_rms: 0.0 };
/// let omega: Vec<f64> = (0..41).map(|i| 2.8 + 0.01 * f64::from(i)).collect();
/// let amplitude: Vec<f64> = omega.iter().map(|w| truth.amplitude(*w)).collect();
/// let found = fit(&omega, &amplitude)?;
/// assert!((found.effective_q_factor - 50.0).abs() < 1e-6);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn fit(omega: &[f64], amplitude: &[f64]) -> Result<LorentzianFit, Error> {
    if omega.len() != amplitude.len() {
        return Err(Error::Length { name: "amplitude", found: amplitude.len(), expected: omega.len() });
    }
    if omega.len() < 4 {
        return Err(Error::TooFewSamples { found: omega.len(), needed: 4 });
    }
    for &w in omega {
        crate::model::oscillator::above_zero("omega", w)?;
    }
    for &r in amplitude {
        crate::model::oscillator::at_least_zero("amplitude", r)?;
    }
    let no_fit = |reason| Error::NoFit { reason };
    let (top, peak) = amplitude
        .iter()
        .copied()
        .enumerate()
        .fold((0, 0.0), |best, here| if here.1 > best.1 { here } else { best });
    if peak == 0.0 {
        return Err(no_fit("every amplitude is zero"));
    }
    let centre = omega[top];
    // The curve lies above 0.7 of its peak over about one line width.
    let inside = omega.iter().zip(amplitude).filter(|(_, r)| **r > 0.5f64.sqrt() * peak).map(|(w, _)| *w);
    let (low, high) = inside.fold((centre, centre), |(l, h), w| (l.min(w), h.max(w)));
    let step =
        omega.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0).fold(f64::INFINITY, f64::min);
    let width = ((high - low).max(step) / centre).clamp(1e-12, 1.9);
    let curve = Curve { omega, amplitude, centre, peak, width };
    let found = minimise(&curve, &[1.0, 1.0, 0.0], &[0, 1, 2])
        // On a curve without noise the steps end in rounding, not at a tolerance.
        .filter(|f| f.converged || f.rss < 1e-18 * omega.len() as f64)
        .ok_or(no_fit("no Lorentzian could be fitted"))?;
    let (g, h, omega_0) = curve.plain(&found.parameters);
    Ok(LorentzianFit {
        effective_drive: g * h,
        effective_q_factor: 1.0 / h,
        omega_0,
        residual_rms: peak * (found.rss / omega.len() as f64).sqrt(),
    })
}

/// Parameters: peak over the highest point, width and shift over the first guess of the width.
struct Curve<'a> {
    omega: &'a [f64],
    amplitude: &'a [f64],
    centre: f64,
    peak: f64,
    width: f64,
}

impl Curve<'_> {
    /// Peak `R_0`, width `1/Q_f`, centre.
    fn plain(&self, p: &[f64]) -> (f64, f64, f64) {
        (self.peak * p[0], self.width * p[1], self.centre * (1.0 + self.width * p[2]))
    }
}

impl LeastSquares for Curve<'_> {
    fn parameters(&self) -> usize {
        3
    }

    fn observations(&self) -> f64 {
        self.omega.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        out.clear();
        let (_, h, w_0) = self.plain(p);
        if !(p[0] > 0.0 && h > 0.0 && w_0 > 0.0) {
            return false;
        }
        for (&w, &y) in self.omega.iter().zip(self.amplitude) {
            // R/peak = p0 h / S,  S² = (1 - r²)² + r² h².
            let r = w / w_0;
            let detune = (1.0 - r) * (1.0 + r);
            let s = detune.hypot(r * h);
            let value = p[0] * h / s;
            let by_h = p[0] / s * (1.0 - (r * h / s).powi(2));
            let by_r = value / (s * s) * r * (2.0 * detune - h * h);
            let by_w_0 = -by_r * r / w_0;
            let row = [h / s, by_h * self.width, by_w_0 * self.centre * self.width];
            out.add_row(&row, y / self.peak - value, 1.0);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_curve() {
        let omega = [0.9, 0.97, 1.0, 1.01, 1.05];
        let zero = [0.0; 5];
        let curve = Curve { omega: &omega, amplitude: &zero, centre: 1.0, peak: 2.0, width: 0.03 };
        let p = [1.1, 0.8, 0.3];
        // With data zero, rss is the sum of squares and jtr minus half its gradient.
        let sums = |p: &[f64]| {
            let mut n = Normal::zeros(3);
            assert!(curve.normal(p, &mut n));
            n
        };
        for i in 0..3 {
            let (mut up, mut down) = (p, p);
            up[i] += 1e-6;
            down[i] -= 1e-6;
            let slope = (sums(&up).rss - sums(&down).rss) / 2e-6;
            assert!((slope + 2.0 * sums(&p).jtr[i]).abs() < 1e-6, "{i}");
        }
    }

    #[test]
    fn lines_of_every_width_are_found() {
        for q in [2.0, 10.0, 1e3, 1e6] {
            let truth = LorentzianFit {
                effective_drive: 3e-12,
                effective_q_factor: q,
                omega_0: 2e5,
                residual_rms: 0.0,
            };
            let omega: Vec<f64> =
                (0..61).map(|i| 2e5 * (1.0 + (f64::from(i) / 30.0 - 1.03) * 0.9 / q)).collect();
            let amplitude: Vec<f64> = omega.iter().map(|w| truth.amplitude(*w)).collect();
            let found = fit(&omega, &amplitude).unwrap();
            assert!((found.effective_q_factor / q - 1.0).abs() < 1e-6, "{q} {found:?}");
            assert!((found.effective_drive / 3e-12 - 1.0).abs() < 1e-6, "{q} {found:?}");
        }
    }

    #[test]
    fn what_is_no_curve_is_refused() {
        assert!(matches!(fit(&[1.0; 3], &[1.0; 3]), Err(Error::TooFewSamples { .. })));
        assert!(matches!(fit(&[1.0; 5], &[1.0; 4]), Err(Error::Length { .. })));
        assert!(matches!(fit(&[1.0, 2.0, 3.0, 4.0], &[0.0; 4]), Err(Error::NoFit { .. })));
        assert!(fit(&[1.0, 2.0, 3.0, f64::NAN], &[1.0; 4]).is_err());
        assert!(fit(&[1.0; 6], &[1.0; 6]).is_err());
    }
}
