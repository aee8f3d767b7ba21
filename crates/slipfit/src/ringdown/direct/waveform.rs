//! The exact motion through every sample.

use super::minimise::{Sums, minimise, spread};
use crate::Error;
use crate::ringdown::envelope::sliding_gain;
use crate::ringdown::law::phi;
use crate::signal::wide;
use pulp::Simd;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Parameters of a free decay with viscous and sliding friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decay {
    /// A_0: where the law of the turning points stands at the first time, signal unit.
    pub initial_amplitude: f64,
    /// x_F = F/k, signal unit.
    pub friction_displacement: f64,
    /// delta = gamma/2m, 1/s.
    pub decay_rate_per_s: f64,
    /// Phase at the first time, rad; a turning point at the top has phase zero.
    pub phase_rad: f64,
    /// omega_d/2 pi, Hz.
    pub frequency_hz: f64,
    /// Rest position of the spring, signal unit.
    pub offset: f64,
}

impl Decay {
    fn from_parameters([a, x_f, delta, phase, omega, offset]: [f64; 6]) -> Self {
        Self {
            initial_amplitude: a,
            friction_displacement: x_f,
            decay_rate_per_s: delta,
            phase_rad: phase,
            frequency_hz: omega / TAU,
            offset,
        }
    }
}

/// Result of [`fit_waveform`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecayFit {
    /// The parameters of least squares.
    pub best: Decay,
    /// Their standard errors, each in its parameter's unit.
    pub std_error: Decay,
    /// Their correlations, in the order of the fields.
    pub correlation: [[f64; 6]; 6],
    /// Root mean square of signal less model.
    pub residual_rms: f64,
    /// Whether no step would have changed a parameter by a hundredth of its standard error.
    pub converged: bool,
    /// Passes over all samples.
    pub steps: usize,
}

/// Fits the exact free decay under viscous and sliding friction to every sample.
///
/// With `t` counted from the first time, `Phi = omega_d t + phase`, the turning
/// points `t_n` where `Phi = n pi`, and `s = (-1)^n`, the motion is
///
/// ```text
/// x = offset + s x_F + s (X_n - x_F) e^(-delta (t - t_n)) [cos(Phi - n pi) + (delta/omega_d) sin(Phi - n pi)]
/// X_n + C = (A_0 + C) e^(-delta t_n),   C = x_F coth(pi delta/2 omega_d)
/// ```
///
/// and stands still from the first turning point on where `X_n <= x_F`. Eq.
/// (15) and (16) of Vitorino, Vieira and Rodrigues, *Effect of sliding friction
/// in harmonic oscillators*, are its average over a cycle at high Q, with
/// `C = 4F/(pi gamma omega_0)`.
///
/// - `time_s`: s, never decreasing, in steps as they come
/// - `signal`: displacement in any unit, as many
/// - `start`: where the search begins. Its frequency must be right to about
///   half a cycle over the record, its phase to about a radian
///
/// Standard errors are those of white noise of the residuals' size. Losses may
/// come out negative, so that averages over many records stay unbiased.
///
/// # Errors
/// - [`Error::Length`] if the two differ in length
/// - [`Error::TooFewSamples`] for fewer than seven
/// - [`Error::TimeBackwards`] for a time less than the one before
/// - [`Error::Parameter`] for a value that is not finite, a start frequency not above zero
/// - [`Error::NoFit`] where the data do not determine six parameters, or the
///   start's decay rate exceeds its frequency many times
///
/// ```
/// use slipfit::ringdown::{Decay, fit_waveform};
/// use slipfit::{Oscillator, decay::FreeDecay};
///
/// let oscillator = Oscillator::kinematic(40.0, 0.1, 0.002)?;
/// let decay = FreeDecay::from_rest(&oscillator, 1.0)?;
/// let time: Vec<f64> = (0..3000).map(|i| 0.002 * f64::from(i)).collect();
/// let signal: Vec<f64> = time.iter().map(|&t| decay.displacement(t)).collect();
/// let start = Decay {
///     initial_amplitude: 0.9,
///     friction_displacement: 0.0,
///     decay_rate_per_s: 0.2,
///     phase_rad: 0.1,
///     frequency_hz: 6.35,
///     offset: 0.0,
/// };
/// let fit = fit_waveform(&time, &signal, &start)?;
/// assert!((fit.best.friction_displacement - 0.002).abs() < 1e-9);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn fit_waveform(time_s: &[f64], signal: &[f64], start: &Decay) -> Result<DecayFit, Error> {
    let n = time_s.len();
    super::check_lengths("signal", n, signal.len(), 7)?;
    super::check_start(&[
        ("initial_amplitude", start.initial_amplitude),
        ("friction_displacement", start.friction_displacement),
        ("decay_rate_per_s", start.decay_rate_per_s),
        ("phase_rad", start.phase_rad),
        ("offset", start.offset),
    ])?;
    if !(start.frequency_hz > 0.0 && start.frequency_hz.is_finite()) {
        return Err(Error::Parameter {
            name: "frequency_hz",
            value: start.frequency_hz,
            range: "positive finite frequencies",
        });
    }
    let (power, ordered) = pulp::Arch::new().dispatch(Look { time: time_s, signal });
    if !(ordered && power.is_finite()) {
        super::check_finite("time_s", time_s)?;
        super::check_finite("signal", signal)?;
        if let Some(i) = time_s.windows(2).position(|w| w[1] < w[0]) {
            return Err(Error::TimeBackwards { index: i + 1, previous: time_s[i], next: time_s[i + 1] });
        }
    }
    let origin = time_s[0];
    let at = [
        start.initial_amplitude,
        start.friction_displacement,
        start.decay_rate_per_s,
        start.phase_rad,
        TAU * start.frequency_hz,
        start.offset,
    ];
    let sums = |time: &[f64], signal: &[f64], p: &[f64; 6]| {
        pulp::Arch::new().dispatch(Pass { time, signal, origin, p })
    };
    let moved = |p: &[f64; 6], step: &[f64; 6]| {
        let mut q = *p;
        for k in 0..6 {
            q[k] += step[k];
        }
        q
    };
    // A thinned record leads most of the way at a fraction of the cost.
    let cycles = start.frequency_hz * (time_s[n - 1] - origin);
    let stride = ((n as f64 / cycles.max(1.0) / 8.0) as usize).min(n / 400).min(16);
    let mut from = at;
    if stride > 1 {
        let thin = |v: &[f64]| -> Vec<f64> { v.iter().step_by(stride).copied().collect() };
        let (time, signal) = (thin(time_s), thin(signal));
        let power = power / stride as f64;
        let found = minimise(at, time.len() as f64, power, |p| sums(&time, &signal, p), moved);
        from = found.filter(|f| f.converged).map_or(at, |f| f.best);
    }
    let found = minimise(from, n as f64, power, |p| sums(time_s, signal, p), moved)
        .ok_or(Error::NoFit { reason: "the samples do not tell six parameters apart" })?;
    let (mut error, correlation) = spread(&found.inverse, found.rss / (n - 6) as f64);
    error[4] = error[4].abs();
    Ok(DecayFit {
        best: Decay::from_parameters(found.best),
        std_error: Decay::from_parameters(error),
        correlation,
        residual_rms: (found.rss / n as f64).sqrt(),
        converged: found.converged,
        steps: found.passes,
    })
}

/// Sum of squares of the samples, and whether the times are finite and never decrease.
struct Look<'a> {
    time: &'a [f64],
    signal: &'a [f64],
}

impl pulp::NullaryFnOnce for Look<'_> {
    type Output = (f64, bool);

    #[inline(always)]
    fn call(self) -> (f64, bool) {
        const LANES: usize = 8;
        let mut power = [0.0; LANES];
        let mut values = self.signal.chunks_exact(LANES);
        for y in &mut values {
            for k in 0..LANES {
                power[k] += y[k] * y[k];
            }
        }
        let mut sum = 0.0;
        for p in power {
            sum += p;
        }
        for y in values.remainder() {
            sum += y * y;
        }
        let mut falls = 0_u64;
        let n = self.time.len();
        for (a, b) in self.time[..n - 1].iter().zip(&self.time[1..]) {
            falls += u64::from(!(a <= b));
        }
        // In order, infinity can stand only at the ends.
        (sum, falls == 0 && self.time[0].is_finite() && self.time[n - 1].is_finite())
    }
}

pub(super) struct Pass<'a> {
    pub(super) time: &'a [f64],
    pub(super) signal: &'a [f64],
    pub(super) origin: f64,
    pub(super) p: &'a [f64; 6],
}

/// Columns of the parameters, padded to whole registers.
const WIDE: usize = 8;

/// `e^(-delta t)`, `G = (1 - e^(-delta t))/delta` and `dG/d delta`.
#[derive(Clone, Copy)]
struct Fall {
    e: f64,
    g: f64,
    g_by_delta: f64,
}

impl Fall {
    fn after(delta: f64, t: f64) -> Self {
        let x = delta * t;
        let share = phi(x);
        let e = (-x).exp();
        let slope = if x.abs() < 0.02 {
            -0.5 + x * (1.0 / 3.0 + x * (-0.125 + x * (1.0 / 30.0 + x * (-1.0 / 144.0 + x / 840.0))))
        } else {
            (e - share) / x
        };
        Self { e, g: t * share, g_by_delta: t * t * slope }
    }

    /// One more stretch `of` length `t`: integrals of an exponential add up so.
    #[inline(always)]
    fn and(self, of: Self, t: f64) -> Self {
        Self {
            e: self.e * of.e,
            g: self.g * of.e + of.g,
            g_by_delta: self.g_by_delta * of.e - t * of.e * self.g + of.g_by_delta,
        }
    }
}

/// Half cycles after which the running products are computed afresh.
const FRESH: usize = 32;
/// `1/k!`: the terms of `e^x` that count for `|x| <= 1/16`.
const EXPONENTIAL: [f64; 10] = {
    let mut out = [1.0; 10];
    let mut k = 1;
    while k < 10 {
        out[k] = out[k - 1] / k as f64;
        k += 1;
    }
    out
};

impl pulp::WithSimd for Pass<'_> {
    type Output = Option<Sums<6>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Sums<6>> {
        let Self { time, signal, origin, p } = self;
        let &[a0, x_f, delta, phase, omega, offset] = p;
        if !(omega > 0.0 && omega.is_finite()) {
            return None;
        }
        let period = PI / omega;
        let mut squarings = 0;
        let mut reach = (delta * period).abs();
        while reach > 0.0625 {
            reach *= 0.5;
            squarings += 1;
            if squarings > 10 || !reach.is_finite() {
                return None;
            }
        }
        let exponent = simd.splat_f64s(-delta * 0.5f64.powi(squarings));
        let (gain, gain_by_delta) = sliding_gain(delta, omega);
        // delta coth(pi delta/2 omega) is homogeneous of degree one in both.
        let gain_by_omega = (gain - delta * gain_by_delta) / omega;
        let tilt = delta / omega;
        let half = Fall::after(delta, period);

        let mut jtj = [[0.0; WIDE]; 6];
        let mut jtr = [0.0; WIDE];
        let mut rss = 0.0;
        let mut n = (phase / PI).floor();
        let mut fall = Fall { e: 1.0, g: 0.0, g_by_delta: 0.0 };
        let mut stale = FRESH;
        let mut index = 0;
        while index < time.len() {
            let turn = (n * PI - phase) / omega;
            if stale >= FRESH {
                fall = Fall::after(delta, turn);
                stale = 0;
            }
            let amplitude = a0 * fall.e - x_f * gain * fall.g;
            let swing = amplitude - x_f;
            if !swing.is_finite() {
                return None;
            }
            // The spring no longer overcomes the friction: at rest for good.
            let rests = swing <= 0.0;
            let limit = origin + ((n + 1.0) * PI - phase) / omega;
            let end = if rests { time.len() } else { end_before(time, index, limit) };
            if end == index {
                // Nothing was sampled in this half cycle; a gap is crossed at once.
                let next = ((time[index] - origin) * omega + phase) / PI;
                if next > n + 2.0 {
                    n = next.floor() - 1.0;
                    stale = FRESH;
                } else {
                    n += 1.0;
                    stale += 1;
                    fall = fall.and(half, period);
                }
                continue;
            }
            let sign = if (0.5 * n).fract() == 0.0 { 1.0 } else { -1.0 };
            // Sums of f1 = e^(-delta u) [cos + tilt sin], f2 = u f1, f3 = e^(-delta u) sin, f4 = u f3.
            let zero = simd.splat_f64s(0.0);
            let (mut s1, mut s2, mut s3, mut s4) = (zero, zero, zero, zero);
            let (mut s11, mut s12, mut s13, mut s14, mut s22) = (zero, zero, zero, zero, zero);
            let (mut s24, mut s33, mut s34, mut s44) = (zero, zero, zero, zero);
            let (mut r0, mut rr, mut r1, mut r2, mut r3, mut r4) = (zero, zero, zero, zero, zero, zero);
            let begin = simd.splat_f64s(origin + turn);
            let level = simd.splat_f64s(offset + sign * if rests { amplitude } else { x_f });
            let height = simd.splat_f64s(if rests { 0.0 } else { -sign * swing });
            let (wide_omega, wide_tilt) = (simd.splat_f64s(omega), simd.splat_f64s(tilt));
            let quarter = simd.splat_f64s(-FRAC_PI_2);
            if rests {
                for (_, y, weight) in wide::Pairs::new(simd, &time[index..end], &signal[index..end]) {
                    let r = simd.mul_f64s(weight, simd.sub_f64s(y, level));
                    r0 = simd.add_f64s(r0, r);
                    rr = simd.mul_add_e_f64s(r, r, rr);
                }
            } else {
                for (t, y, weight) in wide::Pairs::new(simd, &time[index..end], &signal[index..end]) {
                    let u = simd.mul_f64s(weight, simd.sub_f64s(t, begin));
                    // cos = -sin(theta - pi/2), sin = cos(theta - pi/2)
                    let (s, c) = wide::half_turn(simd, simd.mul_add_e_f64s(u, wide_omega, quarter));
                    let mut e = wide::horner(simd, simd.mul_f64s(u, exponent), &EXPONENTIAL);
                    for _ in 0..squarings {
                        e = simd.mul_f64s(e, e);
                    }
                    let e = simd.mul_f64s(weight, e);
                    let f3 = simd.mul_f64s(e, c);
                    let f1 = simd.negate_mul_add_e_f64s(e, s, simd.mul_f64s(wide_tilt, f3));
                    let (f2, f4) = (simd.mul_f64s(u, f1), simd.mul_f64s(u, f3));
                    let above = simd.mul_f64s(weight, simd.sub_f64s(y, level));
                    let r = simd.mul_add_e_f64s(height, f1, above);
                    s1 = simd.add_f64s(s1, f1);
                    s2 = simd.add_f64s(s2, f2);
                    s3 = simd.add_f64s(s3, f3);
                    s4 = simd.add_f64s(s4, f4);
                    s11 = simd.mul_add_e_f64s(f1, f1, s11);
                    s12 = simd.mul_add_e_f64s(f1, f2, s12);
                    s13 = simd.mul_add_e_f64s(f1, f3, s13);
                    s14 = simd.mul_add_e_f64s(f1, f4, s14);
                    s22 = simd.mul_add_e_f64s(f2, f2, s22);
                    s24 = simd.mul_add_e_f64s(f2, f4, s24);
                    s33 = simd.mul_add_e_f64s(f3, f3, s33);
                    s34 = simd.mul_add_e_f64s(f3, f4, s34);
                    s44 = simd.mul_add_e_f64s(f4, f4, s44);
                    r0 = simd.add_f64s(r0, r);
                    rr = simd.mul_add_e_f64s(r, r, rr);
                    r1 = simd.mul_add_e_f64s(r, f1, r1);
                    r2 = simd.mul_add_e_f64s(r, f2, r2);
                    r3 = simd.mul_add_e_f64s(r, f3, r3);
                    r4 = simd.mul_add_e_f64s(r, f4, r4);
                }
            }
            let wide_sums =
                [s1, s2, s3, s4, s11, s12, s13, s14, s22, s24, s33, s34, s44, r0, rr, r1, r2, r3, r4];
            let mut sums = [0.0; 19];
            for (sum, wide) in sums.iter_mut().zip(wide_sums) {
                *sum = simd.reduce_sum_f64s(wide);
            }
            let [s1, s2, s3, s4, s11, s12, s13, s14, s22, s24, s33, s34, s44, r0, r_r, r1, r2, r3, r4] = sums;
            let count = (end - index) as f64;
            rss += r_r;
            #[rustfmt::skip]
            let gram = [
                [s11, s12, s13, s14, s1],
                [s12, s22, s14, s24, s2],
                [s13, s14, s33, s34, s3],
                [s14, s24, s34, s44, s4],
                [s1,  s2,  s3,  s4,  count],
            ];
            // Derivatives by the parameters as combinations of f1 … f4 and 1.
            let by_delta = -turn * a0 * fall.e - x_f * (gain_by_delta * fall.g + gain * fall.g_by_delta);
            let by_phase = (delta * a0 + x_f * gain) * fall.e / omega;
            let by_omega = turn * by_phase - x_f * gain_by_omega * fall.g;
            let row = [fall.e, -gain * fall.g, by_delta, by_phase, by_omega];
            let mut m = [[0.0; WIDE]; 5];
            let into = if rests { 4 } else { 0 };
            for k in 0..5 {
                m[into][k] = sign * row[k];
            }
            if !rests {
                m[0][1] -= sign;
                m[4][1] = sign;
                let p = sign * swing;
                let spin = p * (1.0 + tilt * tilt);
                m[1][2] = -p;
                m[2][2] = p / omega;
                m[2][3] = -spin;
                m[1][4] = p * tilt;
                m[2][4] = -turn * spin - p * tilt / omega;
                m[3][4] = -spin;
            }
            m[4][5] = 1.0;
            let residual = [r1, r2, r3, r4, r0];
            for k in 0..5 {
                let mut y = [0.0; WIDE];
                for l in 0..5 {
                    for q in 0..WIDE {
                        y[q] += gram[k][l] * m[l][q];
                    }
                }
                for i in 0..6 {
                    for q in 0..WIDE {
                        jtj[i][q] += m[k][i] * y[q];
                    }
                }
                for q in 0..WIDE {
                    jtr[q] += m[k][q] * residual[k];
                }
            }
            index = end;
            n += 1.0;
            stale += 1;
            fall = fall.and(half, period);
        }
        let mut out = Sums::zero();
        for i in 0..6 {
            out.jtj[i].copy_from_slice(&jtj[i][..6]);
        }
        out.jtr.copy_from_slice(&jtr[..6]);
        out.rss = rss;
        Some(out)
    }
}

/// First index from `index` on whose time is not below `limit`.
#[inline(always)]
fn end_before(time: &[f64], index: usize, limit: f64) -> usize {
    let mut step = 16;
    while index + step < time.len() && time[index + step] < limit {
        step *= 2;
    }
    let (mut a, mut b) = (index + if step > 16 { step / 2 } else { 0 }, (index + step).min(time.len()));
    while a < b {
        let middle = usize::midpoint(a, b);
        if time[middle] < limit { a = middle + 1 } else { b = middle }
    }
    a
}
