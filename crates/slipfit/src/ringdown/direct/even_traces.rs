//! Amplitude traces of one length on an even clock, each summed up in sixteen numbers.

use super::amplitudes::{AmplitudeFit, Sampling, fit_amplitudes};
use super::nodes::{NODES, Nodes, PAIRS};
use super::reduced::{Reduced, TRACES, fit_reduced};
use crate::Error;
use pulp::Simd;

/// [`fit_amplitudes`] for many traces of one length at even intervals, several at a time.
///
/// A decay of up to eight decay times is a polynomial of degree 15 as far as any residual can tell.
/// Least squares against polynomials knows a trace by its weighted sums at the sixteen nodes of the
/// Gauss rule of its samples, which are exact for products up to degree 31:
///
/// ```text
/// sum (y_i - f_i)² = sum y_i² - sum w_m z_m² + sum w_m (z_m - f(s_m))²
/// ```
///
/// One look at the samples gives the `z_m`; the steps of the fit are taken on them, eight traces
/// side by side. What sixteen numbers do not tell (a faster decay, one that is not determined, residuals
/// next to rounding) is fitted by [`fit_amplitudes`], so that the answers are the same: parameters
/// agree within 1e-9 of themselves or 1e-7 of their standard errors, whichever is more.
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
    /// `None` for so few or so many samples that there is nothing to gain.
    nodes: Option<Nodes>,
}

/// Fewer samples than twice the nodes are not worth it; beyond the most, the table leaves the cache.
const FEWEST: usize = 2 * NODES;
const MOST: usize = 1 << 14;

impl EvenTraces {
    /// For traces of this many samples.
    pub fn new(samples: usize) -> Self {
        let nodes = (FEWEST..=MOST).contains(&samples).then(|| Nodes::new(samples));
        Self { samples, nodes }
    }

    /// Number of samples of the traces.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Fits each trace, given with its interval in s; the answers stand in the same order.
    ///
    /// # Errors
    /// Each trace has its own: those of [`fit_amplitudes`], and [`Error::Length`] for one that has not
    /// the number of samples.
    pub fn fit<T: Copy + Into<f64>>(&self, traces: &[(&[T], f64)]) -> Vec<Result<AmplitudeFit, Error>> {
        let alone = |&(trace, interval): &(&[T], f64)| {
            super::check_lengths("amplitude", self.samples, trace.len(), 4)?;
            let doubles: Vec<f64> = trace.iter().map(|v| (*v).into()).collect();
            fit_amplitudes(Sampling::Every(interval), &doubles)
        };
        let Some(nodes) = &self.nodes else { return traces.iter().map(alone).collect() };
        let half = self.samples.div_ceil(2);
        let size = GROUP * (half + APART);
        let mut folded = Folded { sums: vec![0.0; size], differences: vec![0.0; size], half };
        let mut doubles = vec![0.0; TRACES * self.samples];
        let mut all = Vec::with_capacity(traces.len());
        for eight in traces.chunks(TRACES) {
            let mut reduced = Reduced::default();
            for (lane, ((trace, interval), doubles)) in
                eight.iter().zip(doubles.chunks_exact_mut(self.samples)).enumerate()
            {
                // Without a duration a trace is not fitted here but alone, and found wanting there.
                if trace.len() == self.samples && *interval > 0.0 && interval.is_finite() {
                    reduced.duration[lane] = interval * (self.samples - 1) as f64;
                    pulp::Arch::new().dispatch(Copied { trace, doubles });
                }
            }
            for (group, traces) in doubles.chunks_exact(GROUP * self.samples).enumerate() {
                let first = group * GROUP;
                for (row, trace) in traces.chunks_exact(self.samples).enumerate() {
                    if reduced.duration[first + row] > 0.0 {
                        let fold = Fold { trace, row, folded: &mut folded };
                        reduced.power[first + row] = pulp::Arch::new().dispatch(fold);
                    }
                }
                let sum = Sum { nodes, folded: &folded, first, reduced: &mut reduced };
                pulp::Arch::new().dispatch(sum);
            }
            let found = pulp::Arch::new().dispatch(Steps { nodes, reduced: &reduced });
            all.extend(eight.iter().enumerate().map(|(lane, trace)| match found.lane(lane) {
                Some(fit) => Ok(fit),
                None => alone(trace),
            }));
        }
        all
    }
}

/// Traces whose sums are taken at a time: their running sums fill the registers.
const GROUP: usize = 4;

/// `y_i + y_(n-1-i)` and `y_i - y_(n-1-i)` of a group of traces: nodes lie symmetric, so that sums over
/// half of the samples serve two of them.
struct Folded {
    sums: Vec<f64>,
    differences: Vec<f64>,
    half: usize,
}

/// Numbers between one trace and the next: rows at distances of a power of two, read side by side, would
/// all lie in the same few places of the cache.
const APART: usize = 24;

impl Folded {
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        let first = row * (self.half + APART);
        first..first + self.half
    }

    fn row(&self, row: usize) -> (&[f64], &[f64]) {
        let range = self.range(row);
        (&self.sums[range.clone()], &self.differences[range])
    }
}

/// Copies a trace. Several are copied one after the other before anything is done with them: memory is
/// fast at long stretches in its own order.
struct Copied<'a, T> {
    trace: &'a [T],
    doubles: &'a mut [f64],
}

impl<T: Copy + Into<f64>> pulp::NullaryFnOnce for Copied<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (to, from) in self.doubles.iter_mut().zip(self.trace) {
            *to = (*from).into();
        }
    }
}

/// Folds one trace; gives the sum of its squares.
struct Fold<'a> {
    trace: &'a [f64],
    row: usize,
    folded: &'a mut Folded,
}

impl pulp::WithSimd for Fold<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { trace, row, folded } = self;
        let (half, range) = (folded.half, folded.range(row));
        let (sums, differences) = (&mut folded.sums[range.clone()], &mut folded.differences[range]);
        // Of an odd number the middle one stands in both.
        let (front, back) = (&trace[..half], &trace[trace.len() - half..]);
        for ((s, d), (a, b)) in
            sums.iter_mut().zip(&mut *differences).zip(front.iter().zip(back.iter().rev()))
        {
            *s = a + b;
            *d = a - b;
        }
        if trace.len() % 2 == 1 {
            sums[half - 1] = front[half - 1];
        }
        let (lanes, rest) = S::as_simd_f64s(trace);
        let mut power = [simd.splat_f64s(0.0); 4];
        let (fours, others) = lanes.as_chunks::<4>();
        for four in fours {
            for k in 0..4 {
                power[k] = simd.mul_add_e_f64s(four[k], four[k], power[k]);
            }
        }
        for v in others {
            power[0] = simd.mul_add_e_f64s(*v, *v, power[0]);
        }
        let all = simd.add_f64s(simd.add_f64s(power[0], power[1]), simd.add_f64s(power[2], power[3]));
        simd.reduce_sum_f64s(all) + rest.iter().map(|v| v * v).sum::<f64>()
    }
}

/// The sums at the nodes, of a group.
struct Sum<'a> {
    nodes: &'a Nodes,
    folded: &'a Folded,
    /// Lane of the group's first trace.
    first: usize,
    reduced: &'a mut Reduced,
}

impl pulp::WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let width = S::F64_LANES;
        let per_row = PAIRS / width;
        let (table, _) = S::as_simd_f64s(self.nodes.table.as_flattened());
        let [(s0, d0), (s1, d1), (s2, d2), (s3, d3)] = std::array::from_fn(|row| self.folded.row(row));
        for part in 0..per_row {
            let mut even = [simd.splat_f64s(0.0); GROUP];
            let mut odd = even;
            // Zipped, so that nothing is checked in the innermost loop.
            let sums = s0.iter().zip(s1).zip(s2).zip(s3);
            let differences = d0.iter().zip(d1).zip(d2).zip(d3);
            for ((row, s), d) in table.chunks_exact(2 * per_row).zip(sums).zip(differences) {
                let (e, o) = (row[part], row[per_row + part]);
                let (((s0, s1), s2), s3) = s;
                let (((d0, d1), d2), d3) = d;
                let (s, d) = ([*s0, *s1, *s2, *s3], [*d0, *d1, *d2, *d3]);
                for k in 0..GROUP {
                    even[k] = simd.mul_add_e_f64s(simd.splat_f64s(s[k]), e, even[k]);
                    odd[k] = simd.mul_add_e_f64s(simd.splat_f64s(d[k]), o, odd[k]);
                }
            }
            for k in 0..GROUP {
                let (mut near, mut far) = ([0.0; PAIRS], [0.0; PAIRS]);
                S::as_mut_simd_f64s(&mut near).0[0] = simd.add_f64s(even[k], odd[k]);
                S::as_mut_simd_f64s(&mut far).0[0] = simd.sub_f64s(even[k], odd[k]);
                for m in 0..width {
                    let node = part * width + m;
                    self.reduced.values[node][self.first + k] = near[m];
                    self.reduced.values[NODES - 1 - node][self.first + k] = far[m];
                }
            }
        }
    }
}

/// The steps of eight fits.
struct Steps<'a> {
    nodes: &'a Nodes,
    reduced: &'a Reduced,
}

impl pulp::NullaryFnOnce for Steps<'_> {
    type Output = super::reduced::Found;

    #[inline(always)]
    fn call(self) -> super::reduced::Found {
        fit_reduced(self.nodes, self.reduced)
    }
}

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
                // Errors are those before the last step, of 3e-6 of them at most in either.
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
            // Of few samples and much noise there are several minima: either fit may find another.
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

    /// One of these alone would be noticed by none: they are fitted among sound ones.
    #[test]
    fn what_sixteen_numbers_do_not_tell_is_fitted_alone() {
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
