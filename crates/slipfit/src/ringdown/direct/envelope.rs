//! Fit of the averaged decay to an amplitude trace.

use super::minimise::{ROUNDING, Sums, minimise, spread};
use crate::Error;
use crate::numeric::trig;
use pulp::Simd;

/// Parameters of the envelope `A(t) = (A_0 + C) e^(-delta t) - C`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeStart {
    /// A_0, the amplitude at the first time, signal unit.
    pub initial_amplitude: f64,
    /// C, signal unit: `x_F coth(pi delta/2 omega_d)` for sliding friction.
    pub offset_amplitude: f64,
    /// delta = gamma/2m, 1/s.
    pub decay_rate_per_s: f64,
}

/// Result of [`fit_envelope`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeFit {
    /// The least-squares parameters.
    pub best: EnvelopeStart,
    /// Their standard errors, each in its parameter's unit.
    pub std_error: EnvelopeStart,
    /// Their correlations, in the order of the fields.
    pub correlation: [[f64; 3]; 3],
    /// Root mean square of amplitude minus model.
    pub residual_rms: f64,
    /// Whether a further step would change every parameter by less than a hundredth of its standard error.
    pub converged: bool,
    /// Number of passes over the samples.
    pub steps: usize,
}

/// Fits `A(t) = (A_0 + C) e^(-delta t) - C` to an amplitude trace.
///
/// This is the ring-down under viscous and sliding friction, eq. (15) and (16)
/// of Vitorino, Vieira and Rodrigues, *Effect of sliding friction in harmonic
/// oscillators*. The paper gives `C = 4F/(pi gamma omega_0)`, the leading order of the exact
/// `C = x_F coth(pi delta/2 omega_d)`, `x_F = F/k`; with `C` as an independent parameter the fit holds for
/// both.
///
/// - `time_s`: s, in non-decreasing order; `t` counts from the first of them
/// - `amplitude`: any unit, one per time; none may have been rectified by noise
/// - `start`: start values of the search, used unless the clock is even and the sums over the three thirds of
///   the trace already provide them
///
/// Standard errors assume white noise with the variance of the residuals. No parameter is constrained to be
/// positive, so that averages over many traces remain unbiased. The trace must be curved: as `delta` goes to
/// zero, `C` grows without limit and becomes fully correlated with it.
///
/// # Errors
/// - [`Error::Length`] if the two differ in length
/// - [`Error::TooFewSamples`] for fewer than four
/// - [`Error::Parameter`] for a value that is not finite
/// - [`Error::TimeBackwards`] for a time earlier than the preceding one
/// - [`Error::NoFit`] if the data do not determine three parameters, e.g. for a constant trace
///
/// ```
/// use slipfit::ringdown::{EnvelopeStart, fit_envelope};
/// let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
/// let trace: Vec<f64> = time.iter().map(|t| 1.4 * (-0.8 * t).exp() - 0.3).collect();
/// let start = EnvelopeStart { initial_amplitude: 1.0, offset_amplitude: 0.0, decay_rate_per_s: 1.0 };
/// let fit = fit_envelope(&time, &trace, &start)?;
/// assert!((fit.best.decay_rate_per_s - 0.8).abs() < 1e-9);
/// assert!((fit.best.offset_amplitude - 0.3).abs() < 1e-9);
/// # Ok::<(), slipfit::Error>(())
/// ```
pub fn fit_envelope(time_s: &[f64], amplitude: &[f64], start: &EnvelopeStart) -> Result<EnvelopeFit, Error> {
    let n = time_s.len();
    super::check_lengths("amplitude", n, amplitude.len(), 4)?;
    let EnvelopeStart { initial_amplitude, offset_amplitude, decay_rate_per_s } = *start;
    super::check_start(&[
        ("initial_amplitude", initial_amplitude),
        ("offset_amplitude", offset_amplitude),
        ("decay_rate_per_s", decay_rate_per_s),
    ])?;
    let first = time_s[0];
    let interval = (time_s[n - 1] - first) / (n - 1) as f64;
    let (power, uneven, thirds) =
        crate::numeric::dispatch(PowerAndClock { time: time_s, amplitude, first, interval });
    if !(power.is_finite() && uneven.is_finite()) {
        super::check_finite("time_s", time_s)?;
        super::check_finite("amplitude", amplitude)?;
    }
    // Stamps within four rounding errors of an even clock count as even.
    let even = uneven <= 4.0 * f64::EPSILON * first.abs().max(time_s[n - 1].abs());
    let interval = (even && interval > 0.0).then_some(interval);
    if interval.is_none() {
        super::check_order(time_s)?;
    }
    let data = Trace { time: Some(time_s), amplitude, first, interval };
    let fit = |at| {
        minimise(
            at,
            n as f64,
            power,
            |&[height, level, rate]| {
                Some(crate::numeric::dispatch(Pass { data: &data, height, level, rate }))
            },
            |p, step| {
                // The step of the rate was computed for the old height; it is rescaled to the new one.
                let height = p[0] + step[0];
                let ratio = if (0.5..2.0).contains(&(height / p[0])) { p[0] / height } else { 1.0 };
                [height, p[1] + step[1], p[2] + ratio * step[2]]
            },
        )
    };
    // Height b = A_0 + C, level c = -C: the model is linear in both.
    let at = [initial_amplitude + offset_amplitude, -offset_amplitude, decay_rate_per_s];
    let found = interval
        .and_then(|interval| by_thirds(thirds, n / 3, interval))
        .and_then(fit)
        .filter(|f| f.converged)
        .or_else(|| fit(at))
        // For a trace without curvature the height is at rounding level, and the rate stays at its start
        // value.
        .filter(|f| f.best[0].powi(2) > f.inverse[0][0] * ROUNDING * power / n as f64)
        .ok_or(Error::NoFit { reason: "the trace does not distinguish a decay rate from an offset" })?;
    let [height, level, rate] = found.best;
    // A_0 = b + c, C = -c.
    let v = &found.inverse;
    let covariance = [
        [v[0][0] + 2.0 * v[0][1] + v[1][1], -v[0][1] - v[1][1], v[0][2] + v[1][2]],
        [-v[0][1] - v[1][1], v[1][1], -v[1][2]],
        [v[0][2] + v[1][2], -v[1][2], v[2][2]],
    ];
    let (error, correlation) = spread(&covariance, found.rss / (n - 3) as f64);
    let named = |[a, c, d]: [f64; 3]| EnvelopeStart {
        initial_amplitude: a,
        offset_amplitude: c,
        decay_rate_per_s: d,
    };
    Ok(EnvelopeFit {
        best: named([height + level, -level, rate]),
        std_error: named(error),
        correlation,
        residual_rms: (found.rss / n as f64).sqrt(),
        converged: found.converged,
        steps: found.passes,
    })
}

/// Height, level and rate from the sums over the thirds of a trace with an even clock, whose differences fall
/// by `e^(-delta T/3)`. `None` if noise hides the curvature.
pub(super) fn by_thirds([a, b, c]: [f64; 3], third: usize, interval: f64) -> Option<[f64; 3]> {
    let fall = (b - c) / (a - b);
    if !(fall > 0.02 && fall < 0.98) {
        return None;
    }
    let span = third as f64 * interval;
    let rate = -fall.ln() / span;
    // Sum of the exponential over the first third, for unit height.
    let whole = (1.0 - fall) / -(-rate * interval).exp_m1();
    let height = (a - b) / ((1.0 - fall) * whole);
    Some([height, (a - height * whole) / third as f64, rate])
}

/// Preliminary sums: sum of squares of the amplitudes, the largest deviation of a time stamp from an even
/// clock, and the sums of the amplitudes over the first, second and last third.
struct PowerAndClock<'a> {
    time: &'a [f64],
    amplitude: &'a [f64],
    first: f64,
    interval: f64,
}

pub(super) const LANES: usize = 8;

impl pulp::NullaryFnOnce for PowerAndClock<'_> {
    type Output = (f64, f64, [f64; 3]);

    #[inline(always)]
    fn call(self) -> (f64, f64, [f64; 3]) {
        let (mut power, mut far, mut index) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for k in 0..LANES {
            index[k] = k as f64;
        }
        let mut times = self.time.chunks_exact(LANES);
        let mut values = self.amplitude.chunks_exact(LANES);
        for (t, a) in (&mut times).zip(&mut values) {
            for k in 0..LANES {
                let d = (t[k] - (self.first + index[k] * self.interval)).abs();
                // Written such that NaN propagates.
                far[k] = if d <= far[k] { far[k] } else { d };
                power[k] += a[k] * a[k];
                index[k] += LANES as f64;
            }
        }
        let (mut sum, mut most) = (0.0, 0.0);
        for k in 0..LANES {
            sum += power[k];
            most = if far[k] <= most { most } else { far[k] };
        }
        for (k, (t, a)) in times.remainder().iter().zip(values.remainder()).enumerate() {
            let d = (t - (self.first + index[k] * self.interval)).abs();
            most = if d <= most { most } else { d };
            sum += a * a;
        }
        (sum, most, thirds(self.amplitude))
    }
}

/// Sums of the amplitudes over the first, second and last third.
#[inline(always)]
pub(super) fn thirds(amplitude: &[f64]) -> [f64; 3] {
    let mut thirds = [0.0; 3];
    for (total, part) in thirds.iter_mut().zip(amplitude.chunks_exact(amplitude.len() / 3)) {
        let mut lanes = [0.0; 2 * LANES];
        let mut chunks = part.chunks_exact(2 * LANES);
        for values in &mut chunks {
            for k in 0..2 * LANES {
                lanes[k] += values[k];
            }
        }
        for v in lanes.iter().chain(chunks.remainder()) {
            *total += v;
        }
    }
    thirds
}

pub(super) struct Trace<'a> {
    /// Not needed if the clock is even and starts at `first`.
    pub(super) time: Option<&'a [f64]>,
    pub(super) amplitude: &'a [f64],
    pub(super) first: f64,
    /// Sampling interval of an even clock.
    pub(super) interval: Option<f64>,
}

impl Trace<'_> {
    /// Times since `first` of the `count` samples from `index` on, at most eight; the remaining lanes are
    /// arbitrary but finite.
    #[inline(always)]
    pub(super) fn elapsed(&self, index: usize, count: usize) -> [f64; LANES] {
        let mut u = [0.0; LANES];
        match (self.time, self.interval) {
            (Some(time), _) => {
                for (u, t) in u.iter_mut().zip(&time[index..index + count]) {
                    *u = t - self.first;
                }
            }
            (None, interval) => {
                let (begin, interval) = (index as f64, interval.unwrap_or(0.0));
                for k in 0..LANES {
                    u[k] = (begin + k as f64) * interval;
                }
            }
        }
        u
    }
}

pub(super) struct Pass<'a> {
    pub(super) data: &'a Trace<'a>,
    pub(super) height: f64,
    pub(super) level: f64,
    pub(super) rate: f64,
}

/// Number of samples for which the exponentials are tabulated: `e^(-delta (64 j + k) h) = E_j F_k`.
const TABLE: usize = 64;
/// Number of blocks after which `E_j`, a running product, is recomputed.
const FRESH: usize = 16;

/// Sums of e, ue, ee, uee, uuee and, with the residual r, of r, rr, er, uer.
#[derive(Default)]
struct Moments {
    e: f64,
    ue: f64,
    ee: f64,
    uee: f64,
    uuee: f64,
    r: f64,
    rr: f64,
    er: f64,
    uer: f64,
}

impl pulp::WithSimd for Pass<'_> {
    type Output = Sums<3>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums<3> {
        let (data, b) = (self.data, self.height);
        let mut m = Moments::default();
        let mut done = 0;
        if let Some(interval) = data.interval {
            done = data.amplitude.len() / TABLE * TABLE;
            self.even(simd, interval, done, &mut m);
        }
        if done < data.amplitude.len() {
            self.any(done, &mut m);
        }
        let n = data.amplitude.len() as f64;
        Sums {
            jtj: [[m.ee, m.e, -b * m.uee], [m.e, n, -b * m.ue], [-b * m.uee, -b * m.ue, b * b * m.uuee]],
            jtr: [m.er, m.r, -b * m.uer],
            rss: m.rr,
        }
    }
}

impl Pass<'_> {
    /// The first `count` samples of an even clock, a multiple of the table length.
    #[inline(always)]
    fn even<S: Simd>(&self, simd: S, interval: f64, count: usize, m: &mut Moments) {
        // Eight exponentials and those of 8, 16, 32 and 64 steps generate the whole table.
        const STEPS: [f64; 16] = [0., 1., 2., 3., 4., 5., 6., 7., 8., 16., 32., 64., 0., 0., 0., 0.];
        let mut seed = [0.0; 16];
        for k in 0..16 {
            seed[k] = trig::exp(-self.rate * (STEPS[k] * interval));
        }
        let (mut table, mut delay) = ([0.0; TABLE], [0.0; TABLE]);
        table[..8].copy_from_slice(&seed[..8]);
        for (half, factor) in [(8, seed[8]), (16, seed[9]), (32, seed[10])] {
            let (done, open) = table.split_at_mut(half);
            for (to, from) in open.iter_mut().zip(done) {
                *to = *from * factor;
            }
        }
        for k in 0..TABLE {
            delay[k] = k as f64 * interval;
        }
        let ratio = seed[11];
        let (tables, _) = S::as_simd_f64s(&table);
        let (delays, _) = S::as_simd_f64s(&delay);
        let zero = simd.splat_f64s(0.0);
        let mut own = [zero; 5];
        for (&f, &k) in tables.iter().zip(delays) {
            let kf = simd.mul_f64s(k, f);
            own[0] = simd.add_f64s(own[0], f);
            own[1] = simd.add_f64s(own[1], kf);
            own[2] = simd.mul_add_e_f64s(f, f, own[2]);
            own[3] = simd.mul_add_e_f64s(kf, f, own[3]);
            own[4] = simd.mul_add_e_f64s(kf, kf, own[4]);
        }
        let mut sum = [0.0; 5];
        for k in 0..5 {
            sum[k] = simd.reduce_sum_f64s(own[k]);
        }
        let span = TABLE as f64 * interval;
        let (level, minus_height) = (simd.splat_f64s(self.level), simd.splat_f64s(-self.height));
        let (mut r_sum, mut rr_sum, mut er_sum, mut uer_sum) = (zero, zero, zero, zero);
        let mut e = 1.0;
        for (j, block) in self.data.amplitude[..count].chunks_exact(TABLE).enumerate() {
            let begin = j as f64 * span;
            if j > 0 && j % FRESH == 0 {
                e = trig::exp(-self.rate * begin);
            }
            m.e += e * sum[0];
            m.ue += e * (begin * sum[0] + sum[1]);
            m.ee += e * e * sum[2];
            m.uee += e * e * (begin * sum[2] + sum[3]);
            m.uuee += e * e * (begin * begin * sum[2] + 2.0 * begin * sum[3] + sum[4]);
            let (values, _) = S::as_simd_f64s(block);
            let (factor, begin) = (simd.splat_f64s(e), simd.splat_f64s(begin));
            let mut here = zero;
            for ((&y, &f), &k) in values.iter().zip(tables).zip(delays) {
                let ef = simd.mul_f64s(factor, f);
                let r = simd.mul_add_e_f64s(minus_height, ef, simd.sub_f64s(y, level));
                let er = simd.mul_f64s(ef, r);
                r_sum = simd.add_f64s(r_sum, r);
                rr_sum = simd.mul_add_e_f64s(r, r, rr_sum);
                here = simd.add_f64s(here, er);
                uer_sum = simd.mul_add_e_f64s(k, er, uer_sum);
            }
            er_sum = simd.add_f64s(er_sum, here);
            uer_sum = simd.mul_add_e_f64s(begin, here, uer_sum);
            e *= ratio;
        }
        m.r += simd.reduce_sum_f64s(r_sum);
        m.rr += simd.reduce_sum_f64s(rr_sum);
        m.er += simd.reduce_sum_f64s(er_sum);
        m.uer += simd.reduce_sum_f64s(uer_sum);
    }

    /// The samples from `done` on, for any clock.
    #[inline(always)]
    fn any(&self, done: usize, m: &mut Moments) {
        let mut lanes = [[0.0; LANES]; 9];
        for (i, y) in self.data.amplitude[done..].chunks(LANES).enumerate() {
            let u = self.data.elapsed(done + i * LANES, y.len());
            let (mut v, mut w) = ([self.level; LANES], [0.0; LANES]);
            for k in 0..y.len() {
                v[k] = y[k];
                w[k] = 1.0;
            }
            for k in 0..LANES {
                let e = w[k] * trig::exp(-self.rate * u[k]);
                let r = v[k] - self.level - self.height * e;
                let ue = u[k] * e;
                lanes[0][k] += e;
                lanes[1][k] += ue;
                lanes[2][k] += e * e;
                lanes[3][k] += ue * e;
                lanes[4][k] += ue * ue;
                lanes[5][k] += r;
                lanes[6][k] += r * r;
                lanes[7][k] += e * r;
                lanes[8][k] += ue * r;
            }
        }
        let mut sums = [0.0; 9];
        for (sum, lane) in sums.iter_mut().zip(&lanes) {
            for v in lane {
                *sum += v;
            }
        }
        m.e += sums[0];
        m.ue += sums[1];
        m.ee += sums[2];
        m.uee += sums[3];
        m.uuee += sums[4];
        m.r += sums[5];
        m.rr += sums[6];
        m.er += sums[7];
        m.uer += sums[8];
    }
}
