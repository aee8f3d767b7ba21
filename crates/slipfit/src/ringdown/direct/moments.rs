//! Sums of evenly spaced samples with polynomials, which separate a slow decay from its noise.

use crate::numeric::trig::{fused, has_fused};
use pulp::Simd;

/// The sums `c_k = sum_i y_i q_k(s_i)` of samples at `s_i = (2 i - n + 1)/(n - 1)` with the polynomials of
/// degree `k` that are orthonormal over the samples.
///
/// A vector contains consecutive samples. The samples in any one lane are evenly spaced too, and a polynomial
/// of degree `k` in time is one of degree `k` in the index of the vector, so all lanes share the same
/// factors. The samples are summed with polynomials of that index, early and late vectors together by
/// symmetry, and the lanes are combined once per trace:
///
/// ```text
/// c_k = sum_lanes sum_(p <= k) M_p T_kp     M_p = sum_v y_v r_p(v)     T_kp = sum_v q_k r_p(v)
/// ```
#[derive(Debug, Clone)]
pub(super) struct Moments {
    vectors: usize,
    /// `r_p(v)` of each pair of vectors, from the outermost to the innermost; an unpaired middle vector comes
    /// last.
    by_vector: Vec<[f64; DEGREES]>,
    /// `T_kp`, lane by lane, in order of `k`.
    by_lane: Vec<f64>,
    /// `q_k` at the samples after the last whole vector.
    rest: Vec<[f64; DEGREES]>,
}

/// Number of vectors below which each sample uses its own factors.
const FEWEST_VECTORS: usize = 2 * DEGREES;

/// Maximum number of degrees that are summed.
pub(super) const DEGREES: usize = 16;

/// Number of doubles in the widest supported vectors.
const WIDEST: usize = 8;

/// Samples of one trace, and those of a later one to prefetch.
pub(super) struct Summed<'a, T, const K: usize> {
    pub(super) moments: &'a Moments,
    pub(super) trace: &'a [T],
    pub(super) ahead: &'a [T],
}

/// `c_k` of a trace, and the sum of its squares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums<const K: usize> {
    pub(super) moments: [f64; K],
    pub(super) power: f64,
}

impl Moments {
    /// Tables for this many samples, at least twice the degrees; they are valid only for code dispatched in
    /// the same way.
    pub(super) fn new(samples: usize) -> Self {
        crate::numeric::dispatch(Prepared { samples })
    }
}

struct Prepared {
    samples: usize,
}

impl pulp::WithSimd for Prepared {
    type Output = Moments;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Moments {
        prepared(self.samples, S::F64_LANES)
    }
}

fn prepared(samples: usize, width: usize) -> Moments {
    let whole = samples / width;
    let vectors = if whole < FEWEST_VECTORS { 0 } else { whole };
    let factors = recurrence(samples);
    let at = |count: usize, i: usize| (2.0 * i as f64 - count as f64 + 1.0) / (count as f64 - 1.0);
    let own: Vec<[f64; DEGREES]> =
        (0..samples).map(|i| orthonormal(at(samples, i), samples, &factors)).collect();
    let of_vectors = recurrence(vectors);
    let by_vector: Vec<[f64; DEGREES]> =
        (0..vectors).map(|v| orthonormal(at(vectors, v), vectors, &of_vectors)).collect();
    let mut by_lane = vec![0.0; DEGREES * (DEGREES + 1) / 2 * width];
    for (v, r) in by_vector.iter().enumerate() {
        for (lane, q) in own[v * width..(v + 1) * width].iter().enumerate() {
            let mut to = by_lane[lane..].iter_mut().step_by(width);
            for k in 0..DEGREES {
                for (r, to) in r[..=k].iter().zip(&mut to) {
                    *to += q[k] * r;
                }
            }
        }
    }
    Moments {
        vectors,
        by_lane,
        by_vector: by_vector[..vectors.div_ceil(2)].to_vec(),
        rest: own[vectors * width..].to_vec(),
    }
}

/// A vector of samples as doubles.
#[inline(always)]
fn loaded<S: Simd, T: Copy + Into<f64>>(simd: S, samples: &[T]) -> S::f64s {
    let mut doubles = [0.0; WIDEST];
    for (to, from) in doubles.iter_mut().zip(samples) {
        *to = (*from).into();
    }
    S::as_simd_f64s(&doubles).0.first().copied().unwrap_or(simd.splat_f64s(0.0))
}

impl<T: Copy + Into<f64>, const K: usize> pulp::WithSimd for Summed<'_, T, K> {
    type Output = Sums<K>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Sums<K> {
        if const { has_fused::<S>() } { self.sums::<S, true>(simd) } else { self.sums::<S, false>(simd) }
    }
}

impl<T: Copy + Into<f64>, const K: usize> Summed<'_, T, K> {
    #[inline(always)]
    fn sums<S: Simd, const FUSED: bool>(self, simd: S) -> Sums<K> {
        let Self { moments, trace, ahead } = self;
        let width = S::F64_LANES;
        let (body, rest) = trace.split_at(moments.vectors * width);
        let (front, back) = body.split_at(moments.vectors / 2 * width);
        let (middle, back) = back.split_at(moments.vectors % 2 * width);
        let mut by_vector = [simd.splat_f64s(0.0); K];
        let mut power = [simd.splat_f64s(0.0); 2];
        // A trace of another length is not prefetched.
        let ahead = if ahead.len() == trace.len() { ahead } else { trace };
        let pairs = front.chunks_exact(width).zip(back.rchunks_exact(width));
        let ahead = ahead.chunks_exact(2 * width);
        for (((early, late), r), ahead) in pairs.zip(&moments.by_vector).zip(ahead) {
            prefetch(&ahead[0]);
            if size_of::<T>() * width >= LINE {
                prefetch(&ahead[width]);
            }
            let (early, late) = (loaded(simd, early), loaded(simd, late));
            power[0] = simd.mul_add_e_f64s(early, early, power[0]);
            power[1] = simd.mul_add_e_f64s(late, late, power[1]);
            let pair = [simd.add_f64s(early, late), simd.sub_f64s(early, late)];
            for p in 0..K {
                by_vector[p] = simd.mul_add_e_f64s(pair[p % 2], simd.splat_f64s(r[p]), by_vector[p]);
            }
        }
        if let (false, Some(r)) = (middle.is_empty(), moments.by_vector.last()) {
            let middle = loaded(simd, middle);
            power[0] = simd.mul_add_e_f64s(middle, middle, power[0]);
            for p in (0..K).step_by(2) {
                by_vector[p] = simd.mul_add_e_f64s(middle, simd.splat_f64s(r[p]), by_vector[p]);
            }
        }
        let mut out = Sums { moments: [0.0; K], power: 0.0 };
        if moments.vectors > 0 {
            out.power = simd.reduce_sum_f64s(simd.add_f64s(power[0], power[1]));
            let (by_lane, _) = S::as_simd_f64s(&moments.by_lane);
            let mut first = 0;
            for k in 0..K {
                let mut sum = [simd.splat_f64s(0.0); 2];
                for (p, t) in by_lane[first..first + k + 1].iter().enumerate() {
                    sum[p % 2] = simd.mul_add_e_f64s(by_vector[p], *t, sum[p % 2]);
                }
                first += k + 1;
                out.moments[k] = simd.reduce_sum_f64s(simd.add_f64s(sum[0], sum[1]));
            }
        }
        for (y, q) in rest.iter().zip(&moments.rest) {
            let y: f64 = (*y).into();
            out.power = fused::<FUSED>(y, y, out.power);
            for k in 0..K {
                out.moments[k] = fused::<FUSED>(y, q[k], out.moments[k]);
            }
        }
        out
    }
}

/// Size of a cache line in bytes.
const LINE: usize = 64;

/// Prefetches memory that will be read.
#[inline(always)]
fn prefetch<T>(place: &T) {
    #[cfg(target_arch = "x86_64")]
    safe_arch::prefetch_t0(place);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}

/// `b_k` of `s q_(k-1) = b_k q_k + b_(k-1) q_(k-2)`, the Gram (discrete Chebyshev) polynomials:
/// `k²(n² - k²)/(4(4k² - 1))` in units of the sampling step.
pub(super) fn recurrence<const N: usize>(samples: usize) -> [f64; N] {
    let n = samples as f64;
    let scale = 2.0 / (n - 1.0);
    std::array::from_fn(|k| {
        let k = (k * k) as f64;
        // There are no more polynomials than samples.
        scale * (k * (n * n - k).max(0.0) / (4.0 * (4.0 * k - 1.0))).sqrt()
    })
}

/// The polynomials at `s`, computed by their recurrence.
fn orthonormal(s: f64, samples: usize, recurrence: &[f64; DEGREES]) -> [f64; DEGREES] {
    let mut q = [0.0; DEGREES];
    q[0] = 1.0 / (samples as f64).sqrt();
    q[1] = s * q[0] / recurrence[1];
    for k in 2..DEGREES {
        q[k] = (s * q[k - 1] - recurrence[k - 1] * q[k - 2]) / recurrence[k];
    }
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noisy(samples: usize) -> Vec<f64> {
        (0..samples).map(|i| 1.0 - 0.3 * i as f64 / samples as f64 + super::super::tests::noise(i)).collect()
    }

    #[test]
    fn polynomials_are_orthonormal_over_the_samples() {
        for n in [32, 33, 512] {
            let factors = recurrence(n);
            let at = |i: usize| orthonormal((2 * i) as f64 / (n as f64 - 1.0) - 1.0, n, &factors);
            let all: Vec<[f64; DEGREES]> = (0..n).map(at).collect();
            for j in 0..DEGREES {
                for k in 0..DEGREES {
                    let product: f64 = all.iter().map(|q| q[j] * q[k]).sum();
                    let expected = if j == k { 1.0 } else { 0.0 };
                    assert!((product - expected).abs() < 1e-12, "{n}, {j}, {k}: {product}");
                }
            }
        }
    }

    /// Covers whole vectors with symmetry, a middle vector, samples after the last vector, and summation
    /// sample by sample.
    #[test]
    fn vectors_and_samples_give_the_same_sums() {
        for n in [32, 47, 255, 256, 257, 264, 300, 511, 512, 1000, 4099] {
            let y = noisy(n);
            let moments = Moments::new(n);
            let found =
                crate::numeric::dispatch(Summed::<_, DEGREES> { moments: &moments, trace: &y, ahead: &[] });
            let singles: Vec<f32> = y.iter().map(|y| *y as f32).collect();
            let rounded: Vec<f64> = singles.iter().map(|y| f64::from(*y)).collect();
            let few = Summed::<_, 8> { moments: &moments, trace: &singles, ahead: &singles };
            let few = crate::numeric::dispatch(few);
            let factors = recurrence(n);
            let (mut sums, mut of_singles) = ([0.0; DEGREES], [0.0; DEGREES]);
            for i in 0..n {
                let q = orthonormal((2 * i) as f64 / (n as f64 - 1.0) - 1.0, n, &factors);
                for k in 0..DEGREES {
                    sums[k] += y[i] * q[k];
                    of_singles[k] += rounded[i] * q[k];
                }
            }
            let scale = found.power.sqrt();
            for k in 0..DEGREES {
                assert!((found.moments[k] - sums[k]).abs() < 1e-13 * scale, "{n}, {k}");
            }
            for k in 0..8 {
                assert!((few.moments[k] - of_singles[k]).abs() < 1e-13 * scale, "{n}, {k}");
            }
            let power: f64 = y.iter().map(|y| y * y).sum();
            assert!((found.power / power - 1.0).abs() < 1e-14, "{n}");
        }
    }

    #[test]
    fn every_width_of_vectors_has_the_same_factors() {
        let n = 700;
        let y = noisy(n);
        let sums = |width: usize| {
            let moments = prepared(n, width);
            let mut by_vector = vec![[0.0; DEGREES]; width];
            let half = moments.vectors.div_ceil(2);
            for v in 0..moments.vectors {
                let (row, mirrored) = if v < half { (v, 1.0) } else { (moments.vectors - 1 - v, -1.0) };
                for lane in 0..width {
                    for p in 0..DEGREES {
                        let sign = if p % 2 == 1 { mirrored } else { 1.0 };
                        by_vector[lane][p] += sign * moments.by_vector[row][p] * y[v * width + lane];
                    }
                }
            }
            let mut factors = moments.by_lane.chunks_exact(width);
            let mut sums = [0.0; DEGREES];
            for k in 0..DEGREES {
                for p in 0..=k {
                    let lanes = factors.next().unwrap();
                    sums[k] += lanes.iter().zip(&by_vector).map(|(t, m)| t * m[p]).sum::<f64>();
                }
            }
            for (y, q) in y[moments.vectors * width..].iter().zip(&moments.rest) {
                for k in 0..DEGREES {
                    sums[k] += y * q[k];
                }
            }
            sums
        };
        let one = sums(1);
        for width in [2, 4, 8] {
            let same = sums(width).iter().zip(&one).all(|(a, b)| (a - b).abs() < 1e-11);
            assert!(same, "{width}");
        }
    }
}
