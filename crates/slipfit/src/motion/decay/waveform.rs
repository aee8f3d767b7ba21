//! Free decays at many times: the same closed form for several samples at once.

use super::exact::{COUNTABLE, FreeDecay};
use crate::error::Error;
use crate::numeric::double_double::Dd;
use pulp::{Simd, WithSimd};

/// Largest decrement per half cycle for which the series below suffice.
const SLOW: f64 = 0.05;

/// Largest decrement for which four terms of the exponential suffice.
const VERY_SLOW: f64 = 4e-4;

/// Number of samples above which a second thread is worthwhile.
#[cfg(feature = "threads")]
const SHARED: usize = 1 << 15;

/// Maximum number of SIMD lanes.
const MOST_LANES: usize = 16;

impl FreeDecay {
    /// Displacement at many times, in any order.
    ///
    /// # Errors
    /// [`Error::Length`] unless `out` is as long as `time_s`.
    pub fn fill(&self, time_s: &[f64], out: &mut [f64]) -> Result<(), Error> {
        if time_s.len() != out.len() {
            return Err(Error::Length { name: "out", found: out.len(), expected: time_s.len() });
        }
        fill(self, time_s, out);
        Ok(())
    }
}

fn fill(decay: &FreeDecay, time_s: &[f64], out: &mut [f64]) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        if time_s.len() >= SHARED {
            let pieces = out.par_chunks_mut(SHARED / 2).zip(time_s.par_chunks(SHARED / 2));
            pieces.for_each(|(out, time_s)| fill_here(decay, time_s, out));
            return;
        }
    }
    fill_here(decay, time_s, out);
}

fn fill_here(decay: &FreeDecay, time_s: &[f64], out: &mut [f64]) {
    if decay.lambda <= VERY_SLOW {
        crate::numeric::dispatch(Evaluate::<4>::new(decay, time_s, out));
    } else if decay.lambda <= SLOW {
        crate::numeric::dispatch(Evaluate::<8>::new(decay, time_s, out));
    } else {
        for (t, x) in time_s.iter().zip(out) {
            *x = decay.displacement(*t);
        }
    }
}

/// Quantities common to the samples of one half cycle.
#[derive(Clone, Copy)]
struct HalfCycle {
    index: f64,
    amplitude: f64,
    offset: f64,
}

/// `offset + amplitude e^(-delta w) sin(omega_d w - lag)`, with `w` from the middle of the half cycle:
/// `(delta/omega_d) cos - sin` combined into one sine, `tan(lag) = delta/omega_d`.
struct Evaluate<'a, const TERMS: usize> {
    decay: &'a FreeDecay,
    time_s: &'a [f64],
    out: &'a mut [f64],
    /// Number of the half cycle at which the motion ends, and the rest position.
    end: f64,
    rest: f64,
    /// `e^(-lambda/2) sqrt(1 + (delta/omega_d)²)`.
    scale: f64,
}

impl<'a, const TERMS: usize> Evaluate<'a, TERMS> {
    fn new(decay: &'a FreeDecay, time_s: &'a [f64], out: &'a mut [f64]) -> Self {
        let (end, rest) = decay.stop().map_or((f64::INFINITY, 0.0), |s| (s.index as f64, s.position));
        let o = decay.oscillator();
        let scale = (-0.5 * decay.lambda).exp() * (o.omega_0() / o.omega_d());
        Self { decay, time_s, out, end, rest, scale }
    }

    fn half_cycle(&self, index: f64) -> HalfCycle {
        let sign = self.decay.sign(index);
        let x_f = self.decay.oscillator().friction_displacement();
        let amplitude = -sign * (self.decay.amplitude(index) - x_f) * self.scale;
        HalfCycle { index, amplitude, offset: sign * x_f }
    }

    /// Lanes that lie in several half cycles, before the first turning point or after the stop: which times to keep,
    /// and the amplitude and offset of each lane.
    #[cold]
    fn lane_by_lane(&self, times: &[f64], counts: &[f64], known: &mut HalfCycle) -> [[f64; MOST_LANES]; 3] {
        let [mut keep, mut amplitude, mut offset] = [[0.0; MOST_LANES]; 3];
        for (i, (t, n)) in times.iter().zip(counts).enumerate() {
            if !(*n >= 0.0 && *n < self.end.min(COUNTABLE)) {
                // Times too late to be counted are rare enough for the slow path.
                offset[i] = if *n >= self.end { self.rest } else { self.decay.displacement(*t) };
                continue;
            }
            if *n != known.index {
                *known = self.half_cycle(*n);
            }
            (keep[i], amplitude[i], offset[i]) = (1.0, known.amplitude, known.offset);
        }
        [keep, amplitude, offset]
    }
}

impl<const TERMS: usize> WithSimd for Evaluate<'_, TERMS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, s: S) {
        let out = std::mem::take(&mut self.out);
        let (times, times_left) = S::as_simd_f64s(self.time_s);
        let (xs, xs_left) = S::as_mut_simd_f64s(out);
        let kernel = Kernel::new(s, self.decay);
        let mut known = HalfCycle { index: f64::MIN, amplitude: 0.0, offset: 0.0 };
        for (t, x) in times.iter().zip(xs) {
            *x = self.register(s, &kernel, *t, &mut known);
        }
        if !times_left.is_empty() {
            let x = self.register(s, &kernel, s.partial_load_f64s(times_left), &mut known);
            s.partial_store_f64s(xs_left, x);
        }
    }
}

impl<const TERMS: usize> Evaluate<'_, TERMS> {
    #[inline(always)]
    fn register<S: Simd>(&self, s: S, kernel: &Kernel<S>, t: S::f64s, known: &mut HalfCycle) -> S::f64s {
        let (w, n) = kernel.reduce(s, t);
        let far = s.reduce_max_f64s(s.abs_f64s(s.sub_f64s(n, s.splat_f64s(known.index))));
        if far == 0.0 {
            let (amplitude, offset) = (s.splat_f64s(known.amplitude), s.splat_f64s(known.offset));
            return kernel.wave::<TERMS>(s, w, amplitude, offset);
        }
        let (low, high) = (s.reduce_min_f64s(n), s.reduce_max_f64s(n));
        if low >= self.end {
            return s.splat_f64s(self.rest);
        }
        if low >= 0.0 && high < self.end.min(COUNTABLE) && high - low <= 1.0 {
            // The border between two half cycles, or the first register of one.
            let before = if low == known.index { *known } else { self.half_cycle(low) };
            *known = if high == low { before } else { self.half_cycle(high) };
            let late = s.greater_than_f64s(n, s.splat_f64s(low));
            let pick = |a: f64, b: f64| s.select_f64s(late, s.splat_f64s(b), s.splat_f64s(a));
            let amplitude = pick(before.amplitude, known.amplitude);
            return kernel.wave::<TERMS>(s, w, amplitude, pick(before.offset, known.offset));
        }
        let [mut at, mut counts] = [[0.0; MOST_LANES]; 2];
        s.partial_store_f64s(&mut at[..S::F64_LANES], t);
        s.partial_store_f64s(&mut counts[..S::F64_LANES], n);
        let [keep, amplitude, offset] =
            self.lane_by_lane(&at[..S::F64_LANES], &counts[..S::F64_LANES], known);
        let load = |lanes: &[f64; MOST_LANES]| s.partial_load_f64s(&lanes[..S::F64_LANES]);
        // An excluded lane may contain a time of any size: it is replaced by zero before the multiplication.
        let w = s.select_f64s(s.greater_than_f64s(load(&keep), s.splat_f64s(0.0)), w, s.splat_f64s(0.0));
        kernel.wave::<TERMS>(s, w, load(&amplitude), load(&offset))
    }
}

/// Constants in registers.
struct Kernel<S: Simd> {
    first: S::f64s,
    rest: S::f64s,
    thirds: [S::f64s; 3],
    per: S::f64s,
    omega: S::f64s,
    lag: S::f64s,
    rate: S::f64s,
}

impl<S: Simd> Kernel<S> {
    #[inline(always)]
    fn new(s: S, decay: &FreeDecay) -> Self {
        let Dd { hi: first, lo: rest } = decay.first_time;
        let o = decay.oscillator();
        let v = |x: f64| s.splat_f64s(x);
        Self {
            first: v(first),
            rest: v(rest),
            thirds: decay.half_period.thirds().map(v),
            per: v(1.0 / decay.half_period.hi),
            omega: v(o.omega_d()),
            lag: v((o.decay_rate_per_s() / o.omega_d()).atan()),
            rate: v(-o.decay_rate_per_s()),
        }
    }

    /// Time from the middle of the half cycle, and the number of the half cycle.
    #[inline(always)]
    fn reduce(&self, s: S, t: S::f64s) -> (S::f64s, S::f64s) {
        // Adding and subtracting 3 * 2^51 rounds to an integer.
        let (round, half) = (s.splat_f64s(6_755_399_441_055_744.0), s.splat_f64s(0.5));
        let [t1, t2, t3] = self.thirds;
        // t - first in two parts (Knuth).
        let hi = s.sub_f64s(t, self.first);
        let back = s.sub_f64s(hi, t);
        let lo = s.sub_f64s(s.sub_f64s(t, s.sub_f64s(hi, back)), s.add_f64s(self.first, back));
        let lo = s.sub_f64s(lo, self.rest);
        let n = s.sub_f64s(s.add_f64s(s.sub_f64s(s.mul_f64s(hi, self.per), half), round), round);
        let h = s.add_f64s(n, half);
        let w = s.sub_f64s(s.sub_f64s(hi, s.mul_f64s(h, t1)), s.mul_f64s(h, t2));
        (s.add_f64s(w, s.sub_f64s(lo, s.mul_f64s(h, t3))), n)
    }

    #[inline(always)]
    fn wave<const TERMS: usize>(&self, s: S, w: S::f64s, amplitude: S::f64s, offset: S::f64s) -> S::f64s {
        let phase = s.sub_f64s(s.mul_f64s(w, self.omega), self.lag);
        let square = s.mul_f64s(phase, phase);
        let decay = s.mul_f64s(w, self.rate);
        let mut sin = s.splat_f64s(SIN[SIN.len() - 1]);
        for k in (0..SIN.len() - 1).rev() {
            sin = s.mul_add_e_f64s(sin, square, s.splat_f64s(SIN[k]));
        }
        let mut e = s.splat_f64s(EXP[TERMS - 1]);
        for k in (0..TERMS - 1).rev() {
            e = s.mul_add_e_f64s(e, decay, s.splat_f64s(EXP[k]));
        }
        s.mul_add_e_f64s(s.mul_f64s(amplitude, e), s.mul_f64s(sin, phase), offset)
    }
}

/// `sin(r)/r` in powers of `r²` for `|r| <= 1.62`, Chebyshev approximation: error below 4e-19.
const SIN: [f64; 9] = [
    1.0,
    -0.166_666_666_666_666_66,
    0.008_333_333_333_333_108,
    -0.000_198_412_698_411_814_25,
    2.755_731_920_664_88e-6,
    -2.505_210_647_518_953_2e-8,
    1.605_892_012_884_201_3e-10,
    -7.642_489_408_040_863e-13,
    2.715_949_156_485_778e-15,
];

/// Taylor coefficients: the first omitted term is below 4e-18 at `SLOW/2` (eight terms) and below 7e-17 at
/// `VERY_SLOW/2` (four).
const EXP: [f64; 8] = [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::oscillator::Oscillator;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn many_samples_equal_one_at_a_time(
            q in prop_oneof![Just(f64::INFINITY), 0.6..20.0f64, 20.0..1e6f64],
            x_f in prop_oneof![Just(0.0), 1e-4..0.1f64],
            start in -1e4..1e4f64,
            v in prop_oneof![Just(0.0), -2.0..2.0f64],
            times in proptest::collection::vec(-50.0..4e4f64, 1..600),
        ) {
            let o = Oscillator::builder().omega_0(1.0).q_factor(q).friction_displacement(x_f).build().unwrap();
            let decay = FreeDecay::from_state(&o, start, 1.0, v).unwrap();
            let times: Vec<f64> = times.iter().map(|t| t + start).collect();
            let mut out = vec![f64::NAN; times.len()];
            decay.fill(&times, &mut out).unwrap();
            for (t, x) in times.iter().zip(&out) {
                let one = decay.displacement(*t);
                prop_assert!((x - one).abs() < 3e-15 * 3.0, "{t} {x} {one}");
            }
        }
    }

    #[test]
    fn lengths_must_agree() {
        let o = Oscillator::kinematic(1.0, 0.01, 0.01).unwrap();
        let decay = FreeDecay::from_rest(&o, 1.0).unwrap();
        assert!(decay.fill(&[0.0, 1.0], &mut [0.0]).is_err());
    }
}
