//! Quantities derived from fits, for many fits at a time.

use super::amplitudes::AmplitudeFit;
use crate::inference::evidence::one_sided_p_value;
use crate::motion::decay::amplitude::sliding_gain;
use crate::numeric::trig::{exp, fused, has_fused};
use std::f64::consts::{FRAC_PI_2, SQRT_2, TAU};

const LANES: usize = 8;
type Lanes = [f64; LANES];

/// Degrees of freedom above which the normal distribution is used: there the quantile of the F distribution at
/// p = 1e-3 differs from it by about 1 %, and its evaluation takes longer than the fit.
const NORMAL: f64 = 200.0;

impl AmplitudeFit {
    /// [`friction_displacement`](Self::friction_displacement) of each fit, at the frequency with the same
    /// index; NaN if there is no such frequency.
    pub fn friction_displacements(fits: &[Self], frequency_hz: &[f64]) -> Vec<[f64; 2]> {
        crate::numeric::dispatch(Displacements { fits, frequency_hz })
    }

    /// [`sliding_p_value`](Self::sliding_p_value) of each fit, for traces of `samples` samples each.
    pub fn sliding_p_values(fits: &[Self], samples: usize) -> Vec<f64> {
        let freedom = samples.saturating_sub(3) as f64;
        if freedom > NORMAL {
            return crate::numeric::dispatch(Tails { fits });
        }
        let value = |fit: &Self| {
            let [rate, error] = fit.sliding_rate;
            if rate > 0.0 { one_sided_p_value((rate / error).powi(2), freedom) } else { 1.0 }
        };
        fits.iter().map(value).collect()
    }
}

/// One number from each of up to eight fits; unused lanes are zero.
#[inline(always)]
fn gathered(fits: &[AmplitudeFit], of: impl Fn(&AmplitudeFit) -> f64) -> Lanes {
    let mut lanes = [0.0; LANES];
    for (lane, fit) in lanes.iter_mut().zip(fits) {
        *lane = of(fit);
    }
    lanes
}

struct Tails<'a> {
    fits: &'a [AmplitudeFit],
}

impl pulp::WithSimd for Tails<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Vec<f64> {
        if const { has_fused::<S>() } { self.values::<true>() } else { self.values::<false>() }
    }
}

impl Tails<'_> {
    #[inline(always)]
    fn values<const FUSED: bool>(self) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.fits.len());
        for fits in self.fits.chunks(LANES) {
            let rate = gathered(fits, |fit| fit.sliding_rate[0]);
            let error = gathered(fits, |fit| fit.sliding_rate[1]);
            let mut values = [1.0; LANES];
            for k in 0..LANES {
                let value = tail::<FUSED>(rate[k] / error[k]);
                values[k] = if rate[k] > 0.0 { value } else { 1.0 };
            }
            all.extend_from_slice(&values[..fits.len()]);
        }
        all
    }
}

/// `(1 + 2 v) e^(v²) erfc v` in powers of `t = (v - 3.75)/(v + 3.75)`, for `v >= 0`: Shepherd and Laframboise
/// (1981), Math. Comp. 36, 249. Chebyshev series, computed with 60 digits and truncated after degree 22,
/// where the coefficients fall below 1e-16.
#[rustfmt::skip]
const SCALED: [f64; 23] = [
    1.2375126308378275, -0.14024059858554525, 0.0035854154854790257, 0.08227673848999506,
    -0.10880393014244462, 0.09230432116428125, -0.05869339857664934, 0.02836227737211114,
    -0.009746579683265262, 0.0017556261651970652, 0.000293714378044958, -0.00029015535246077655,
    5.164652974177416e-05, 2.2387565714911816e-05, -1.1438048033346894e-05, -9.792625707303523e-07,
    1.7419821586224816e-06, -5.084465378687302e-08, -2.4857126248016745e-07, 1.879082322370048e-08,
    3.197926671666804e-08, -1.9551358868985616e-09, -2.623107347133476e-09,
];

/// Upper tail of the normal distribution beyond `z >= 0`, to a relative accuracy of 1e-15 plus the rounding
/// of `z²/2`; zero beyond 37, where it is below 1e-300.
#[inline(always)]
fn tail<const FUSED: bool>(z: f64) -> f64 {
    const BORDER: f64 = 3.75;
    let v = z / SQRT_2;
    let t = (v - BORDER) / (v + BORDER);
    let mut scaled = SCALED[SCALED.len() - 1];
    for c in SCALED[..SCALED.len() - 1].iter().rev() {
        scaled = fused::<FUSED>(scaled, t, *c);
    }
    let value = 0.5 * exp(-0.5 * z * z) * scaled / (1.0 + 2.0 * v);
    if z > 37.0 { 0.0 } else { value }
}

struct Displacements<'a> {
    fits: &'a [AmplitudeFit],
    frequency_hz: &'a [f64],
}

/// `y coth y` in powers of `y²`; up to [`GENTLE`] the first term omitted is below 1e-17.
const Y_COTH_Y: [f64; 8] = [
    1.0,
    1.0 / 3.0,
    -1.0 / 45.0,
    2.0 / 945.0,
    -1.0 / 4725.0,
    2.0 / 93_555.0,
    -1382.0 / 638_512_875.0,
    4.0 / 18_243_225.0,
];
const GENTLE: f64 = 0.25;

impl pulp::WithSimd for Displacements<'_> {
    type Output = Vec<[f64; 2]>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Vec<[f64; 2]> {
        if const { has_fused::<S>() } { self.values::<true>() } else { self.values::<false>() }
    }
}

impl Displacements<'_> {
    #[inline(always)]
    fn values<const FUSED: bool>(self) -> Vec<[f64; 2]> {
        let mut all = Vec::with_capacity(self.fits.len());
        for (k, fits) in self.fits.chunks(LANES).enumerate() {
            let frequency_hz = self.frequency_hz.get(k * LANES..).unwrap_or_default();
            let rate = gathered(fits, |fit| fit.sliding_rate[0]);
            let rate_error = gathered(fits, |fit| fit.sliding_rate[1]);
            let delta = gathered(fits, |fit| fit.decay_rate_per_s[0]);
            let delta_error = gathered(fits, |fit| fit.decay_rate_per_s[1]);
            let correlation = gathered(fits, |fit| fit.correlation);
            let mut hz = [f64::NAN; LANES];
            for (hz, frequency) in hz.iter_mut().zip(frequency_hz) {
                *hz = *frequency;
            }
            let (mut gain, mut by_delta) = ([0.0; LANES], [0.0; LANES]);
            let mut steep = false;
            for k in 0..LANES {
                let omega = TAU * hz[k];
                let y = FRAC_PI_2 * delta[k] / omega;
                let q = y * y;
                let (mut whole, mut slope) = (0.0, 0.0);
                for c in Y_COTH_Y.iter().rev() {
                    slope = fused::<FUSED>(slope, q, whole);
                    whole = fused::<FUSED>(whole, q, *c);
                }
                // delta coth y = (2 omega/pi) y coth y.
                gain[k] = omega / FRAC_PI_2 * whole;
                by_delta[k] = 2.0 * y * slope;
                steep |= y.abs() > GENTLE;
            }
            if steep {
                for k in 0..LANES {
                    let omega = TAU * hz[k];
                    if (FRAC_PI_2 * delta[k] / omega).abs() > GENTLE {
                        [gain[k], by_delta[k], _] = sliding_gain(delta[k], omega);
                    }
                }
            }
            let (mut value, mut error) = ([0.0; LANES], [0.0; LANES]);
            for k in 0..LANES {
                value[k] = rate[k] / gain[k];
                let own = rate_error[k] / gain[k];
                let other = -value[k] * by_delta[k] / gain[k] * delta_error[k];
                let variance = own * own + other * other + 2.0 * correlation[k] * own * other;
                error[k] = variance.max(0.0).sqrt();
            }
            all.extend(value.iter().zip(&error).map(|(v, e)| [*v, *e]).take(fits.len()));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(rate: f64, delta: f64) -> AmplitudeFit {
        AmplitudeFit {
            initial_amplitude: [1.0, 0.1],
            sliding_rate: [rate, 0.5],
            decay_rate_per_s: [delta, 0.25],
            correlation: -0.75,
            residual_rms: 1.0,
            lack_of_fit: [0.0; 2],
            converged: true,
            steps: 1,
        }
    }

    /// Half the complementary error function of `z/sqrt 2`, computed by mpmath 1.4 with 30 digits.
    #[test]
    fn the_tail_is_that_of_the_error_function() {
        let table = [
            (0.1, 0.460_172_162_722_971),
            (0.5, 0.308_537_538_725_986_9),
            (0.725, 0.234_226_015_212_694_9),
            (1.0, 0.158_655_253_931_457_05),
            (3.0, 1.349_898_031_630_094_5e-3),
            (5.0, 2.866_515_718_791_939e-7),
            (10.0, 7.619_853_024_160_526e-24),
            (20.0, 2.753_624_118_606_233_7e-89),
            (30.0, 4.906_713_927_148_187e-198),
            (36.0, 4.182_624_065_797_283e-284),
            (37.1, 0.0),
            (0.0, 1.0),
            (-1.0, 1.0),
        ];
        let fits: Vec<AmplitudeFit> = table.iter().map(|(z, _)| fit(0.5 * z, 0.0)).collect();
        let values = AmplitudeFit::sliding_p_values(&fits, 5000);
        for (((z, expected), value), fit) in table.iter().zip(&values).zip(&fits) {
            // The exponential amplifies the rounding of z²/2.
            assert!((value - expected).abs() <= (1e-15 + z.powi(2) * 2e-16) * expected, "{z}: {value}");
            assert_eq!(fit.sliding_p_value(5000), *value);
        }
    }

    #[test]
    fn friction_displacements_are_those_of_the_exact_gain() {
        let rates = [0.0, 1e-9, 1e-3, 0.1, 0.99, 1.01, 3.0, 20.0, -0.3, -5.0, 1e-12];
        let fits: Vec<AmplitudeFit> = rates.iter().map(|delta| fit(0.2, *delta)).collect();
        let frequency_hz: Vec<f64> = (0..rates.len()).map(|i| 1.0 + 0.1 * i as f64).collect();
        let found = AmplitudeFit::friction_displacements(&fits, &frequency_hz);
        let few = AmplitudeFit::friction_displacements(&fits, &frequency_hz[..2]);
        assert_eq!((few.len(), few[1], few[2][0].is_nan()), (fits.len(), found[1], true));
        for ((fit, hz), [value, error]) in fits.iter().zip(&frequency_hz).zip(&found) {
            let [delta, delta_error] = fit.decay_rate_per_s;
            let [gain, by_delta, _] = sliding_gain(delta, TAU * hz);
            assert!((value * gain / 0.2 - 1.0).abs() < 1e-14, "{fit:?}");
            let other = -0.2 * by_delta / (gain * gain) * delta_error;
            let variance = (0.5 / gain).powi(2) + other * other - 1.5 * 0.5 / gain * other;
            assert!((error / variance.sqrt() - 1.0).abs() < 1e-8, "{fit:?}");
            assert_eq!(fit.friction_displacement(*hz), [*value, *error]);
        }
    }
}
