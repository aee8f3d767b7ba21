//! Two viscous modes: fit of beats and of a weak second mode to the samples.

use super::criteria::{Criteria, SpectrumCriteria, TwoModesCriteria};
use crate::inference::least_squares::{Fit, LeastSquares, Normal, minimise};
use crate::inference::noise::{autocorrelation, significant_inflation};
use crate::numeric::products::{Products, WIDTH};
use crate::numeric::{GOLDEN_SECTION, trig};
use crate::signal::spectrum;
use std::f64::consts::TAU;

/// Parameters of one mode: angular frequency, decay rate, cosine and sine part at the origin.
const OMEGA: usize = 0;
const DELTA: usize = 1;
const COSINE: usize = 2;
const SINE: usize = 3;
const PER_MODE: usize = 4;
/// Offset at the origin and its change over the record.
const OFFSET: usize = 2 * PER_MODE;
const COUNT: usize = OFFSET + 2;
/// Parameters of the first mode and the straight line: those that enter linearly, and all.
const LINEAR: [usize; 4] = [COSINE, SINE, OFFSET, OFFSET + 1];
const ONE_MODE: [usize; 6] = [OMEGA, DELTA, COSINE, SINE, OFFSET, OFFSET + 1];
/// The same for a steady mode.
const STEADY: [usize; 5] = [OMEGA, COSINE, SINE, OFFSET, OFFSET + 1];
/// Number of samples per cycle kept by averaging, and number of samples above which averages are used.
const SAMPLES_PER_CYCLE: f64 = 12.0;
const MOST_SAMPLES: usize = 20_000;
/// Number of samples, distributed over the record, used in the search.
const SEARCH_SAMPLES: usize = 1_500;

/// A viscous mode, `x = Re[(a - ib) e^((i omega - delta)(t - t0))]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ViscousMode {
    pub(crate) origin_s: f64,
    pub(crate) omega: f64,
    pub(crate) decay_rate: f64,
    cosine: f64,
    sine: f64,
    /// Standard errors of frequency (rad/s), decay rate and amplitude.
    pub(crate) std_errors: [f64; 3],
}

impl ViscousMode {
    /// Amplitude at the origin, signal unit.
    pub(crate) fn amplitude(&self) -> f64 {
        self.cosine.hypot(self.sine)
    }

    /// Displacement, signal unit.
    pub(crate) fn at(&self, time_s: f64) -> f64 {
        let t = time_s - self.origin_s;
        let (sin, cos) = (self.omega * t).sin_cos();
        (-self.decay_rate * t).exp() * (self.cosine * cos + self.sine * sin)
    }
}

/// Residuals of one mode in its window.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OneMode {
    pub(crate) window_s: [f64; 2],
    /// Mean square of the residuals, and of the noise in them.
    pub(crate) mean_square: f64,
    pub(crate) noise: f64,
}

/// The weaker of two viscous modes, from a fit of
/// `x = Σ e^(-delta_k t) (a_k cos omega_k t + b_k sin omega_k t) + c + d t` to the samples, started from the
/// frequency and decay rate of the motion as a single mode.
///
/// `None` if the second mode is not resolved from the first, or if the residuals of both are too large: in
/// the window of the single mode or, if that window is a small part of the samples, in all of them.
pub(crate) fn weaker_of_two(
    time_s: &[f64],
    signal: &[f64],
    [omega, decay_rate]: [f64; 2],
    one_mode: &OneMode,
    criteria: &Criteria,
) -> Option<ViscousMode> {
    let (lines, criteria) = (&criteria.spectrum, &criteria.two_modes);
    let problem = Modes::thinned(time_s, signal, omega)?;
    let some = problem.spread(SEARCH_SAMPLES);
    let found = fit_pair(&problem, &some, [omega, decay_rate], lines)?;
    let noise = one_mode.noise.min(one_mode.mean_square);
    let most = noise + criteria.most_left * (one_mode.mean_square - noise);
    let [from_s, to_s] = one_mode.window_s;
    let small = to_s - from_s < criteria.small_window * problem.duration;
    let describes = some.mean_square_residual(&found.parameters, one_mode.window_s) < most
        || small && found.rss < criteria.most_power_left * some.power();
    if !describes {
        return None;
    }
    let best = minimise(&problem, &found.parameters, &found.free)?;
    let mut modes = [0, PER_MODE].map(|first| problem.mode(&best, first, criteria));
    if modes[1].amplitude() > modes[0].amplitude() {
        modes.swap(0, 1);
    }
    let [first, second] = modes;
    let falls = first.decay_rate > -criteria.errors * first.std_errors[1];
    let main = MainMode { omega: first.omega, decay_rate: first.decay_rate, amplitude: first.amplitude() };
    (falls && resolved(&main, &second, problem.duration, criteria)).then_some(second)
}

/// A viscous mode in the residuals of a motion, started from its last estimate or, without one, from the
/// strongest line in the residuals.
pub(crate) fn mode_in_residuals(
    time_s: &[f64],
    left: &[f64],
    main: &MainMode,
    last: Option<ViscousMode>,
    criteria: &Criteria,
) -> Option<ViscousMode> {
    let (lines, criteria) = (&criteria.spectrum, &criteria.two_modes);
    let problem = Modes::thinned(time_s, left, main.omega)?;
    let mut start = vec![0.0; COUNT];
    (start[OMEGA], start[DELTA]) = match last {
        Some(mode) => (mode.omega, mode.decay_rate),
        None => {
            let line = spectrum::dominant(&problem.time, &problem.signal, None, lines)?;
            (TAU * line.frequency_hz, main.decay_rate)
        }
    };
    let amplitude = minimise(&problem, &start, &LINEAR)?;
    let fit = minimise(&problem, &amplitude.parameters, &ONE_MODE)?;
    let mode = problem.mode(&fit, 0, criteria);
    resolved(main, &mode, problem.duration, criteria).then_some(mode)
}

/// The strongest line of the given samples, if it explains most of them and its amplitude neither falls nor
/// grows.
pub(crate) fn steady_mode(time_s: &[f64], signal: &[f64], criteria: &Criteria) -> Option<ViscousMode> {
    let Criteria { spectrum: lines, two_modes: criteria, steady_line: steady, .. } = criteria;
    let omega = TAU * spectrum::dominant(time_s, signal, None, lines)?.frequency_hz;
    let problem = Modes::thinned(time_s, signal, omega)?;
    if problem.duration * omega < TAU * steady.cycles {
        return None;
    }
    let mut start = vec![0.0; COUNT];
    start[OMEGA] = omega;
    let line = minimise(&problem, &start, &LINEAR)?;
    let line = minimise(&problem, &line.parameters, &STEADY)?;
    let falling = minimise(&problem, &line.parameters, &ONE_MODE)?;
    let (mode, change) = (problem.mode(&line, 0, criteria), problem.mode(&falling, 0, criteria));
    let is_steady = (change.decay_rate * problem.duration).abs() < steady.change
        || change.decay_rate.abs() < criteria.errors * change.std_errors[1];
    let explains = line.rss < (1.0 - steady.explained) * problem.power();
    (is_steady && explains && mode.amplitude() > criteria.errors * mode.std_errors[2]).then_some(mode)
}

/// The main mode, for comparison with a second one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MainMode {
    pub(crate) omega: f64,
    pub(crate) decay_rate: f64,
    pub(crate) amplitude: f64,
}

/// Whether these are two modes rather than one whose amplitude follows another law: their frequencies differ
/// by more than the width of the shorter-lived one, and the second one is significant and does not grow.
fn resolved(main: &MainMode, second: &ViscousMode, duration_s: f64, criteria: &TwoModesCriteria) -> bool {
    let life_s = |rate: f64| if rate * duration_s > 1.0 { 1.0 / rate } else { duration_s };
    let life_s = life_s(main.decay_rate).min(life_s(second.decay_rate));
    let separation = (main.omega - second.omega).abs() / TAU * life_s;
    separation > criteria.separation
        && second.amplitude() > criteria.errors * second.std_errors[2]
        && second.amplitude() > criteria.least_amplitude * main.amplitude
        && second.omega > 0.0
        && second.decay_rate > -criteria.errors * second.std_errors[1]
}

/// The lowest minimum reached from several starts: the strongest line in the residuals of one mode combined
/// with that mode, and that line combined with its mirror image about the mode, which is the residual of
/// beats of equal modes.
///
/// `problem` contains a selection of the samples of `all`.
fn fit_pair(
    all: &Modes,
    problem: &Modes,
    [omega, decay_rate]: [f64; 2],
    lines: &SpectrumCriteria,
) -> Option<Fit> {
    let mut start = vec![0.0; COUNT];
    start[OMEGA] = omega;
    start[DELTA] = decay_rate;
    let one = minimise(problem, &start, &LINEAR)?;
    let one = minimise(problem, &one.parameters, &ONE_MODE).unwrap_or(one);
    let left = all.residuals(&one.parameters);
    let other = TAU * spectrum::dominant(&all.time, &left, None, lines)?.frequency_hz;
    let (main, rate) = (one.parameters[OMEGA], one.parameters[DELTA].max(0.0));
    let pairs = [[main, other], [omega, other], [2.0 * main - other, other]];
    let both: Vec<usize> = (COSINE..=SINE).chain(PER_MODE + COSINE..COUNT).collect();
    let all: Vec<usize> = (0..COUNT).collect();
    let fits = pairs.into_iter().filter(|pair| pair[0] > 0.0).filter_map(|pair| {
        let mut start = vec![0.0; COUNT];
        for (k, omega) in pair.into_iter().enumerate() {
            start[k * PER_MODE + OMEGA] = omega;
            start[k * PER_MODE + DELTA] = rate;
        }
        let amplitudes = minimise(problem, &start, &both)?;
        minimise(problem, &amplitudes.parameters, &all)
    });
    fits.min_by(|a, b| a.rss.total_cmp(&b.rss))
}

/// Least-squares problem of two viscous modes about a straight line.
struct Modes {
    time: Vec<f64>,
    signal: Vec<f64>,
    origin: f64,
    duration: f64,
}

impl Modes {
    /// The samples, or means of neighbouring ones if there are many per cycle.
    fn thinned(time_s: &[f64], signal: &[f64], omega: f64) -> Option<Self> {
        let n = time_s.len();
        if n < 2 * COUNT {
            return None;
        }
        let per_cycle = n as f64 / (time_s[n - 1] - time_s[0]) * TAU / omega;
        let width = (n / MOST_SAMPLES).min((per_cycle / SAMPLES_PER_CYCLE) as usize).max(1);
        let (time, signal) = spectrum::averaged(time_s, signal, width);
        Some(Self { origin: time[0], duration: time[time.len() - 1] - time[0], time, signal })
    }

    /// A mode of a fit; `first` is the index of its first parameter.
    fn mode(&self, fit: &Fit, first: usize, criteria: &TwoModesCriteria) -> ViscousMode {
        let n = self.time.len();
        let residuals = self.residuals(&fit.parameters);
        let white = fit.rss / (n as f64 - fit.free.len() as f64).max(1.0);
        let inflation = significant_inflation(autocorrelation(&residuals), n, criteria.errors);
        let scale = (white * inflation).sqrt();
        let p = &fit.parameters[first..];
        let (cosine, sine) = (p[COSINE], p[SINE]);
        let amplitude = cosine.hypot(sine).max(f64::MIN_POSITIVE);
        let covariance = |i: usize, j: usize| fit.unit_covariance[(first + i, first + j)];
        let amplitude_variance = (cosine * cosine * covariance(COSINE, COSINE)
            + sine * sine * covariance(SINE, SINE)
            + 2.0 * cosine * sine * covariance(COSINE, SINE))
            / (amplitude * amplitude);
        let std_errors = [
            fit.unit_std(first + OMEGA) * scale,
            fit.unit_std(first + DELTA) * scale,
            amplitude_variance.max(0.0).sqrt() * scale,
        ];
        ViscousMode { origin_s: self.origin, omega: p[OMEGA], decay_rate: p[DELTA], cosine, sine, std_errors }
    }

    /// Sum of squares of the samples about their mean.
    fn power(&self) -> f64 {
        let mean = self.signal.iter().sum::<f64>() / self.signal.len() as f64;
        self.signal.iter().map(|x| (x - mean).powi(2)).sum()
    }

    /// Value of the model at one time.
    fn value(&self, p: &[f64], time: f64) -> f64 {
        let t = time - self.origin;
        let mode = |first: usize| {
            let q = &p[first..first + PER_MODE];
            let (sin, cos) = (q[OMEGA] * t).sin_cos();
            (-q[DELTA] * t).exp() * (q[COSINE] * cos + q[SINE] * sin)
        };
        mode(0) + mode(PER_MODE) + p[OFFSET] + t / self.duration * p[OFFSET + 1]
    }

    /// A selection of the samples, unevenly distributed so that no frequency is an alias of another.
    fn spread(&self, count: usize) -> Self {
        let step = self.time.len() as f64 / count as f64;
        let picked: Vec<usize> = if step <= 1.0 {
            (0..self.time.len()).collect()
        } else {
            (0..count).map(|i| ((i as f64 + (GOLDEN_SECTION * i as f64).fract()) * step) as usize).collect()
        };
        let of = |column: &[f64]| picked.iter().map(|&i| column[i.min(column.len() - 1)]).collect();
        Self { time: of(&self.time), signal: of(&self.signal), ..*self }
    }

    fn mean_square_residual(&self, p: &[f64], [from_s, to_s]: [f64; 2]) -> f64 {
        let residuals = self.residuals(p);
        let inside = self.time.iter().zip(&residuals).filter(|(t, _)| (from_s..=to_s).contains(*t));
        let (sum, count) = inside.fold((0.0, 0.0), |(sum, count), (_, r)| (sum + r * r, count + 1.0));
        sum / count
    }

    fn residuals(&self, p: &[f64]) -> Vec<f64> {
        self.time.iter().zip(&self.signal).map(|(t, x)| x - self.value(p, *t)).collect()
    }
}

impl LeastSquares for Modes {
    fn parameters(&self) -> usize {
        COUNT
    }

    fn observations(&self) -> f64 {
        self.time.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        let sums = crate::numeric::dispatch(Pass { modes: self, p });
        let sum = |i: usize, j: usize| sums[i * (i + 1) / 2 + j];
        for i in 0..COUNT {
            out.jtr[i] = sum(COUNT, i);
            for j in 0..=i {
                out.jtj[(i, j)] = sum(i, j);
            }
        }
        out.rss = sum(COUNT, COUNT);
        out.rss.is_finite()
    }
}

/// Sums of products of derivatives and residuals, for many samples at a time.
struct Pass<'a> {
    modes: &'a Modes,
    p: &'a [f64],
}

impl pulp::WithSimd for Pass<'_> {
    /// The lower triangle row by row, with the residual as the last row.
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> Vec<f64> {
        let mut products = Products::new(COUNT + 1);
        let modes = self.modes;
        for (time, signal) in modes.time.chunks(WIDTH).zip(modes.signal.chunks(WIDTH)) {
            let (mut t, mut left) = ([0.0; WIDTH], [0.0; WIDTH]);
            for (k, (time, x)) in time.iter().zip(signal).enumerate() {
                (t[k], left[k]) = (time - modes.origin, *x);
            }
            self.rows(&t, &mut left, &mut products);
            if time.len() < WIDTH {
                products.rows.iter_mut().for_each(|row| row[time.len()..].fill(0.0));
            }
            products.add(simd);
        }
        products.taken(simd)
    }
}

impl Pass<'_> {
    /// The derivatives at times relative to the origin, and the residuals of the samples there.
    #[inline(always)]
    fn rows(&self, t: &[f64; WIDTH], samples: &mut [f64; WIDTH], products: &mut Products) {
        let p = self.p;
        for first in [0, PER_MODE] {
            let [omega, delta, cosine, sine] = [OMEGA, DELTA, COSINE, SINE].map(|k| p[first + k]);
            let slots = [OMEGA, DELTA, COSINE, SINE].map(|k| first + k);
            let Ok([by_omega, by_delta, by_cosine, by_sine]) = products.rows.get_disjoint_mut(slots) else {
                return;
            };
            for k in 0..WIDTH {
                let (sin, cos) = trig::sin_cos(omega * t[k]);
                let decay = trig::exp(-delta * t[k]);
                let (along, across) = (decay * cos, decay * sin);
                let x = cosine * along + sine * across;
                by_omega[k] = t[k] * (sine * along - cosine * across);
                by_delta[k] = -t[k] * x;
                by_cosine[k] = along;
                by_sine[k] = across;
                samples[k] -= x;
            }
        }
        let per_duration = 1.0 / self.modes.duration;
        let slots = [OFFSET, OFFSET + 1, COUNT];
        let Ok([constant, slope, residual]) = products.rows.get_disjoint_mut(slots) else { return };
        for k in 0..WIDTH {
            let v = t[k] * per_duration;
            constant[k] = 1.0;
            slope[k] = v;
            residual[k] = samples[k] - p[OFFSET] - v * p[OFFSET + 1];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::jitter;

    const ANYTHING: OneMode = OneMode { window_s: [0.0, 120.0], mean_square: 1.0, noise: 0.0 };

    fn record(second: f64, ratio: f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..2400).map(|i| 0.05 * f64::from(i)).collect();
        let mode = |t: f64, f: f64, a: f64, phase: f64| a * (-0.012 * t).exp() * (TAU * f * t + phase).cos();
        let signal = time
            .iter()
            .enumerate()
            .map(|(i, &t)| mode(t, 0.7, 1.0, 0.3) + mode(t, second, ratio, 1.1) + noise * jitter(i, 5))
            .collect();
        (time, signal)
    }

    fn assert_second(found: &ViscousMode, frequency_hz: f64, amplitude: f64) {
        let [omega_error, rate_error, amplitude_error] = found.std_errors;
        assert!((found.omega - TAU * frequency_hz).abs() < 4.0 * omega_error, "{frequency_hz}: {found:?}");
        assert!((found.decay_rate - 0.012).abs() < 4.0 * rate_error, "{frequency_hz}: {found:?}");
        assert!((found.amplitude() - amplitude).abs() < 4.0 * amplitude_error, "{frequency_hz}: {found:?}");
    }

    #[test]
    fn a_second_mode_is_found_from_a_strong_to_a_weak_one() {
        let criteria = Criteria::default();
        for (second, ratio) in [(0.7224, 0.9), (0.805, 0.2), (0.721, 0.02)] {
            let (time, signal) = record(second, ratio, 0.002);
            let found = weaker_of_two(&time, &signal, [TAU * 0.7, 0.012], &ANYTHING, &criteria);
            assert_second(&found.expect("two modes"), second, ratio);
        }
    }

    #[test]
    fn one_mode_is_no_pair() {
        let (time, signal) = record(0.7, 0.0, 0.01);
        let criteria = Criteria::default();
        assert_eq!(weaker_of_two(&time, &signal, [TAU * 0.7, 0.012], &ANYTHING, &criteria), None);
    }

    #[test]
    fn a_mode_beside_a_motion_is_the_strongest_line_it_leaves() {
        let (time, signal) = record(0.805, 0.2, 0.002);
        let left: Vec<f64> = time
            .iter()
            .zip(&signal)
            .map(|(t, x)| x - (-0.012 * t).exp() * (TAU * 0.7 * t + 0.3).cos())
            .collect();
        let main = MainMode { omega: TAU * 0.7, decay_rate: 0.012, amplitude: 1.0 };
        let criteria = Criteria::default();
        let first = mode_in_residuals(&time, &left, &main, None, &criteria).expect("a line is left");
        assert_second(&first, 0.805, 0.2);
        let again = mode_in_residuals(&time, &left, &main, Some(first), &criteria).expect("still there");
        assert!((again.omega - first.omega).abs() < 0.1 * first.std_errors[0]);
    }

    #[test]
    fn the_sums_are_those_of_values_and_their_differences() {
        let (time, signal) = record(0.8, 0.3, 0.01);
        let problem = Modes { origin: 0.0, duration: 120.0, time, signal };
        let p = [4.4, 0.012, 1.0, -0.3, 5.0, -0.02, 0.1, 0.2, 0.01, -0.02];
        let (mut found, mut expected) = (Normal::zeros(COUNT), Normal::zeros(COUNT));
        assert!(problem.normal(&p, &mut found));
        for (&t, x) in problem.time.iter().zip(&problem.signal) {
            let beside = |k: usize, step: f64| {
                let mut q = p;
                q[k] += step;
                problem.value(&q, t)
            };
            let row: [f64; COUNT] = std::array::from_fn(|k| (beside(k, 1e-6) - beside(k, -1e-6)) / 2e-6);
            expected.add_row(&row, x - problem.value(&p, t), 1.0);
        }
        assert!((found.rss / expected.rss - 1.0).abs() < 1e-12);
        for i in 0..COUNT {
            let scale = (expected.jtj[(i, i)] * expected.rss).sqrt();
            assert!((found.jtr[i] - expected.jtr[i]).abs() < 1e-7 * scale, "{i}");
            for j in 0..=i {
                let scale = (expected.jtj[(i, i)] * expected.jtj[(j, j)]).sqrt();
                assert!((found.jtj[(i, j)] - expected.jtj[(i, j)]).abs() < 1e-7 * scale, "{i} {j}");
            }
        }
    }
}
