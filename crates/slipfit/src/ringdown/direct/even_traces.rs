//! Amplitude traces of equal length on an even clock, each summarised by a few moments.

use super::amplitudes::{AmplitudeFit, Sampling, fit_amplitudes};
use super::by_moments::{FEW, Known, Law, TRACES};
use super::moments::{DEGREES, Moments, Summed};
use crate::Error;

/// [`fit_amplitudes`] for many traces of equal length at even intervals, several in parallel.
///
/// To within any residual, a decay over the samples is a polynomial: of degree 9 if it lasts up to two decay
/// times, of degree 15 up to eight. For such a trace, least squares require only its moments with respect to
/// the polynomials that are orthonormal over the samples, and the fit of `A(t; p)` minimises
///
/// ```text
/// sum_i (y_i - A(t_i; p))² = sum_i y_i² - sum_k c_k² + sum_k (c_k - a_k(p))²     c_k = sum_i q_k(t_i) y_i
/// ```
///
/// One pass over the samples gives the `c_k` of the first ten degrees; the steps of the fit use only these,
/// for sixteen traces in parallel. A trace with more decay times is summed again for sixteen degrees. Traces
/// that these do not determine (a faster decay, an undetermined one, residuals near rounding) are fitted by
/// [`fit_amplitudes`]. The results therefore agree with it: parameters within 1e-9 relative or 1e-7 of their
/// standard errors, whichever is larger. The result for a trace does not depend on its neighbours.
///
/// ```
/// use slipfit::ringdown::{EvenTraces, Sampling, fit_amplitudes};
/// let shape = |sliding: f64, i: i32| 1.0 - 0.01 * sliding * f64::from(i) + 0.01 * f64::from(i * i % 7);
/// let traces: Vec<Vec<f32>> = (1..20)
///     .map(|k| (0..200).map(|i| shape(0.02 * f64::from(k), i) as f32).collect())
///     .collect();
/// let rows: Vec<(&[f32], f64)> = traces.iter().map(|trace| (trace.as_slice(), 0.01)).collect();
/// let fits = EvenTraces::new(200).fit(&rows);
///
/// let doubles: Vec<f64> = traces[3].iter().map(|v| f64::from(*v)).collect();
/// let one = fit_amplitudes(Sampling::Every(0.01), &doubles)?;
/// let [rate, error] = one.sliding_rate;
/// assert!((fits[3].clone()?.sliding_rate[0] - rate).abs() < 1e-7 * error);
/// # Ok::<(), slipfit::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct EvenTraces {
    samples: usize,
    /// `None` if there are so few or so many samples that moments bring no gain.
    sums: Option<Sums>,
}

#[derive(Debug, Clone)]
struct Sums {
    moments: Moments,
    slow: Law,
    fast: Law,
}

/// With fewer samples than twice the number of moments there is no gain; above `MOST` the table exceeds the
/// cache.
const FEWEST: usize = 2 * DEGREES;
const MOST: usize = 1 << 14;

/// Number of traces by which memory is prefetched: the latency of memory is about the time needed to sum two
/// traces.
const PREFETCH_DISTANCE: usize = 2;

impl EvenTraces {
    /// Prepares the fit of traces of this many samples.
    pub fn new(samples: usize) -> Self {
        let sums = (FEWEST..=MOST).contains(&samples).then(|| Sums {
            moments: Moments::new(samples),
            slow: Law::new(samples, true),
            fast: Law::new(samples, false),
        });
        Self { samples, sums }
    }

    /// Number of samples of the traces.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Fits each trace, given with its interval in s; the results are in the same order.
    ///
    /// # Errors
    /// Each trace has its own error: those of [`fit_amplitudes`], and [`Error::Length`] if its number of
    /// samples differs.
    pub fn fit<T: Copy + Into<f64>>(&self, traces: &[(&[T], f64)]) -> Vec<Result<AmplitudeFit, Error>> {
        let (fits, failed) = self.fit_with_failures(traces);
        let mut all: Vec<Result<AmplitudeFit, Error>> = fits.into_iter().map(Ok).collect();
        for (row, error) in failed {
            all[row] = Err(error);
        }
        all
    }

    /// [`fit`](Self::fit) with the failures listed separately: their index, in order, and the error. Their
    /// entries in the list of fits contain NaN.
    pub fn fit_with_failures<T: Copy + Into<f64>>(
        &self,
        traces: &[(&[T], f64)],
    ) -> (Vec<AmplitudeFit>, Vec<(usize, Error)>) {
        let mut fits = vec![NO_FIT; traces.len()];
        let mut left: Vec<usize> = Vec::new();
        match &self.sums {
            Some(Sums { moments, slow, fast }) => {
                self.by_moments::<T, FEW>(moments, slow, traces, 0..traces.len(), &mut fits, &mut left);
                if !left.is_empty() {
                    let longer = std::mem::take(&mut left);
                    self.by_moments::<T, DEGREES>(moments, fast, traces, longer, &mut fits, &mut left);
                }
            }
            None => left.extend(0..traces.len()),
        }
        // `left` lists traces without a clock or of another length first; sorting restores the original
        // order.
        left.sort_unstable();
        let mut failed = Vec::new();
        for row in left {
            match self.alone(traces[row]) {
                Ok(fit) => fits[row] = fit,
                Err(error) => failed.push((row, error)),
            }
        }
        (fits, failed)
    }

    fn alone<T: Copy + Into<f64>>(&self, (trace, interval): (&[T], f64)) -> Result<AmplitudeFit, Error> {
        super::check_lengths("amplitude", self.samples, trace.len(), 4)?;
        let doubles: Vec<f64> = trace.iter().map(|v| (*v).into()).collect();
        fit_amplitudes(Sampling::Every(interval), &doubles)
    }

    /// Fits some of the traces from their first `K` moments; those that are not determined are added to
    /// `left`.
    fn by_moments<T: Copy + Into<f64>, const K: usize>(
        &self,
        moments: &Moments,
        law: &Law,
        traces: &[(&[T], f64)],
        some: impl IntoIterator<Item = usize>,
        fits: &mut [AmplitudeFit],
        left: &mut Vec<usize>,
    ) {
        let mut known = Known::default();
        let mut rows = [0; TRACES];
        let mut some = some.into_iter();
        loop {
            let mut lanes = 0;
            for row in some.by_ref() {
                let (trace, interval) = traces[row];
                // A trace without a duration is fitted alone, which returns the error.
                if trace.len() != self.samples || !(interval > 0.0 && interval.is_finite()) {
                    left.push(row);
                    continue;
                }
                let ahead = traces.get(row + PREFETCH_DISTANCE).map_or(trace, |(trace, _)| trace);
                let sums = crate::numeric::dispatch(Summed::<T, K> { moments, trace, ahead });
                for (to, sum) in known.moments.iter_mut().zip(sums.moments) {
                    to[lanes] = sum;
                }
                known.power[lanes] = sums.power;
                known.duration[lanes] = interval * (self.samples - 1) as f64;
                rows[lanes] = row;
                lanes += 1;
                if lanes == TRACES {
                    break;
                }
            }
            if lanes == 0 {
                break;
            }
            known.power[lanes..].fill(0.0);
            let found = law.fit(&known);
            for (lane, &row) in rows[..lanes].iter().enumerate() {
                match found.lane(lane) {
                    Some(fit) => fits[row] = fit,
                    None => left.push(row),
                }
            }
        }
    }
}

/// Entry for a trace that cannot be fitted.
const NO_FIT: AmplitudeFit = AmplitudeFit {
    initial_amplitude: [f64::NAN; 2],
    sliding_rate: [f64::NAN; 2],
    decay_rate_per_s: [f64::NAN; 2],
    correlation: f64::NAN,
    residual_rms: f64::NAN,
    lack_of_fit: [0.0; 2],
    converged: false,
    steps: 0,
};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn trace(samples: usize, rate: f64, sliding: f64, noise: f64, seed: usize) -> Vec<f64> {
        let last = (samples - 1) as f64;
        let clean = |u: f64| {
            let gain = if rate.abs() < 1e-6 { u } else { -(-rate * u).exp_m1() / rate };
            (-rate * u).exp() - sliding * gain
        };
        let value = |i| clean(i as f64 / last) + noise * super::super::tests::noise(i + seed * samples);
        (0..samples).map(value).collect()
    }

    fn assert_same(fits: &[Result<AmplitudeFit, Error>], rows: &[(&[f64], f64)]) {
        assert_eq!(fits.len(), rows.len());
        for (fit, (trace, interval)) in fits.iter().zip(rows) {
            let alone = fit_amplitudes(Sampling::Every(*interval), trace);
            let (Ok(fit), Ok(alone)) = (fit, &alone) else {
                assert_eq!(fit, &alone);
                continue;
            };
            let pairs = |f: &AmplitudeFit| [f.initial_amplitude, f.sliding_rate, f.decay_rate_per_s];
            for ([value, error], [other, other_error]) in pairs(fit).into_iter().zip(pairs(alone)) {
                let most = (1e-9 * other.abs()).max(1e-7 * other_error);
                assert!((value - other).abs() <= most, "{fit:?} for {alone:?}");
                // Errors are evaluated before the last step, which changes them by a relative 3e-6 at most in
                // either fit.
                assert!((error / other_error - 1.0).abs() < 1e-5, "{fit:?} for {alone:?}");
            }
            assert!((fit.correlation - alone.correlation).abs() < 1e-6, "{fit:?} for {alone:?}");
            assert!((fit.residual_rms / alone.residual_rms - 1.0).abs() < 1e-5, "{fit:?} for {alone:?}");
        }
    }

    proptest! {
        #[test]
        fn many_traces_are_fitted_as_one_is(
            samples in 4usize..700,
            rates in prop::collection::vec(-0.5f64..6.0, 1..20),
            sliding in 0.0f64..0.5,
            noise in prop::sample::select(vec![0.0, 1e-5, 1e-3, 0.01, 0.1]),
            interval in prop::sample::select(vec![1e-7, 0.01, 30.0]),
        ) {
            let made = |(seed, rate): (usize, &f64)| trace(samples, *rate, sliding, noise, seed);
            let traces: Vec<Vec<f64>> = rates.iter().enumerate().map(made).collect();
            let rows: Vec<(&[f64], f64)> = traces.iter().map(|t| (t.as_slice(), interval)).collect();
            // With few samples and much noise there are several minima: the two fits may find different ones.
            prop_assume!(samples > 60 || noise < 1e-2);
            let fits = EvenTraces::new(samples).fit(&rows);
            if noise > 0.0 {
                assert_same(&fits, &rows);
            } else {
                for (fit, rate) in fits.into_iter().zip(&rates) {
                    let found = fit.unwrap().decay_rate_per_s[0] * interval * (samples - 1) as f64;
                    prop_assert!((found - rate).abs() < 1e-8, "{found} for {rate}");
                }
            }
        }
    }

    /// Neighbours determine only which traces are fitted in parallel.
    #[test]
    fn the_answer_to_a_trace_does_not_depend_on_its_neighbours() {
        let mut traces: Vec<Vec<f64>> =
            (0..70).map(|i| trace(300, f64::from(i % 9) * 0.7 - 0.2, 0.1, 0.01, i as usize)).collect();
        traces[5][8] = f64::NAN;
        let rows: Vec<(&[f64], f64)> = traces.iter().map(|t| (t.as_slice(), 0.01)).collect();
        let fitted = EvenTraces::new(300);
        let together = fitted.fit(&rows);
        let alone: Vec<_> = rows.iter().flat_map(|row| fitted.fit(std::slice::from_ref(row))).collect();
        let pieces: Vec<_> = rows.chunks(7).flat_map(|rows| fitted.fit(rows)).collect();
        let same = |other: &[Result<AmplitudeFit, Error>]| {
            together.iter().zip(other).enumerate().all(|(i, (a, b))| i == 5 || a == b)
        };
        assert!(same(&alone) && same(&pieces));
        assert!(together[5].is_err() && alone[5].is_err());
    }

    /// These traces are fitted among sound ones, since a defect would not show if each were fitted alone.
    #[test]
    fn what_moments_do_not_tell_is_fitted_alone() {
        let sound = trace(200, 1.0, 0.1, 0.01, 0);
        let mut hole = sound.clone();
        hole[7] = f64::NAN;
        let exact = trace(200, 1.0, 0.1, 0.0, 0);
        let fast = trace(200, 40.0, 0.0, 1e-3, 1);
        let noise: Vec<f64> = (0..200).map(super::super::tests::noise).collect();
        let huge: Vec<f64> = sound.iter().map(|v| v * 1e200).collect();
        let rows: Vec<(&[f64], f64)> = vec![
            (&sound, 0.01),
            (&hole, 0.01),
            (&[1.0; 200], 0.01),
            (&fast, 0.01),
            (&noise, 0.01),
            (&sound, 0.0),
            (&sound[..100], 0.01),
            (&huge, 0.01),
            (&sound, 0.02),
        ];
        let fits = EvenTraces::new(200).fit(&rows);
        assert!(matches!(fits[1], Err(Error::Parameter { name: "amplitude", .. })));
        assert!(matches!(fits[2], Err(Error::NoFit { .. })));
        assert!(matches!(fits[5], Err(Error::Parameter { name: "interval_s", .. })));
        assert!(matches!(fits[6], Err(Error::Length { found: 100, expected: 200, .. })));
        let same = [0, 1, 2, 3, 4, 5, 8];
        let (fits, rows): (Vec<_>, Vec<_>) = same.iter().map(|&i| (fits[i].clone(), rows[i])).unzip();
        assert_eq!(
            fits[1].as_ref().unwrap_err().to_string(),
            "amplitude = NaN is outside the finite numbers"
        );
        assert_same(&[fits[0].clone(), fits[3].clone(), fits[4].clone()], &[rows[0], rows[3], rows[4]]);
        assert_same(&fits[6..], &rows[6..]);
        let exact_fit = EvenTraces::new(200).fit(&[(exact.as_slice(), 0.01)]).remove(0).unwrap();
        assert!((exact_fit.sliding_rate[0] - 0.1 / 1.99).abs() < 1e-9, "{exact_fit:?}");
        assert!(EvenTraces::new(3).fit(&[([1.0, 0.9, 0.8].as_slice(), 0.01)])[0].is_err());
        assert!(EvenTraces::new(0).fit::<f64>(&[(&[], 0.01)])[0].is_err());
    }
}
