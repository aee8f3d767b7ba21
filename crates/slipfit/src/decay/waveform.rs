//! Free decays at many times: the same closed form, several samples at once.

use super::exact::FreeDecay;
use crate::double_double::Dd;
use pulp::{Arch, Simd, WithSimd};

/// Samples worked on at a time: they stay in the first-level cache.
const BLOCK: usize = 256;

/// Half cycles up to which `(n + 1/2) T` is formed without rounding.
const COUNTABLE: f64 = 6e7;

/// Largest decrement of a half cycle for which the series below suffices.
const SLOW: f64 = 0.35;

struct Block {
    /// Times in; time from the middle of the half cycle out.
    time: [f64; BLOCK],
    half_cycle: [f64; BLOCK],
    amplitude: [f64; BLOCK],
    offset: [f64; BLOCK],
}

pub(super) fn fill(decay: &FreeDecay, time_s: &[f64], out: &mut [f64]) {
    if decay.lambda > SLOW {
        for (t, x) in time_s.iter().zip(out) {
            *x = decay.displacement(*t);
        }
        return;
    }
    let arch = Arch::new();
    let mut block =
        Block { time: [0.0; BLOCK], half_cycle: [0.0; BLOCK], amplitude: [0.0; BLOCK], offset: [0.0; BLOCK] };
    let mut known = Known::new(decay);
    for (times, xs) in time_s.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        block.time[..times.len()].copy_from_slice(times);
        arch.dispatch(Reduce { decay, block: &mut block });
        known.amplitudes(times, &mut block);
        arch.dispatch(Evaluate { decay, block: &mut block });
        xs.copy_from_slice(&block.offset[..times.len()]);
    }
}

/// The half cycle last looked up.
struct Known<'a> {
    decay: &'a FreeDecay,
    last: f64,
    amplitude: f64,
    offset: f64,
    end: f64,
    rest: f64,
    half_fall: f64,
}

impl<'a> Known<'a> {
    fn new(decay: &'a FreeDecay) -> Self {
        let (end, rest) = decay.stop().map_or((f64::INFINITY, 0.0), |s| (s.index as f64, s.position));
        let half_fall = (-0.5 * decay.lambda).exp();
        Self { decay, last: f64::NAN, amplitude: 0.0, offset: 0.0, end, rest, half_fall }
    }

    fn amplitudes(&mut self, times: &[f64], block: &mut Block) {
        for (i, t) in times.iter().enumerate() {
            let n = block.half_cycle[i];
            if n != self.last {
                if !(n >= 0.0 && n < self.end.min(COUNTABLE)) {
                    // Before the first turn, after the stop, or too far to count.
                    block.amplitude[i] = 0.0;
                    block.time[i] = 0.0;
                    block.offset[i] = if n >= self.end { self.rest } else { self.decay.displacement(*t) };
                    continue;
                }
                let sign = self.decay.sign(n);
                let x_f = self.decay.oscillator().friction_displacement();
                self.last = n;
                self.amplitude = sign * (self.decay.amplitude(n) - x_f) * self.half_fall;
                self.offset = sign * x_f;
            }
            block.amplitude[i] = self.amplitude;
            block.offset[i] = self.offset;
        }
    }
}

/// Time to half cycle and time from its middle.
struct Reduce<'a> {
    decay: &'a FreeDecay,
    block: &'a mut Block,
}

impl WithSimd for Reduce<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Dd { hi: first, lo: first_rest } = self.decay.first_time;
        let [t1, t2, t3] = thirds(self.decay.half_period);
        let v = |x: f64| s.splat_f64s(x);
        let (first, rest) = (v(first), v(first_rest));
        let (t1, t2, t3) = (v(t1), v(t2), v(t3));
        let per = v(1.0 / self.decay.half_period.hi);
        // Adding and taking away 3 * 2^51 rounds to a whole number.
        let (round, half) = (v(6_755_399_441_055_744.0), v(0.5));
        let (times, _) = S::as_mut_simd_f64s(&mut self.block.time);
        let (counts, _) = S::as_mut_simd_f64s(&mut self.block.half_cycle);
        for (time, count) in times.iter_mut().zip(counts) {
            let t = *time;
            // t - first in two parts (Knuth).
            let hi = s.sub_f64s(t, first);
            let back = s.sub_f64s(hi, t);
            let lo = s.sub_f64s(s.sub_f64s(t, s.sub_f64s(hi, back)), s.add_f64s(first, back));
            let lo = s.sub_f64s(lo, rest);
            let n = s.sub_f64s(s.add_f64s(s.sub_f64s(s.mul_f64s(hi, per), half), round), round);
            let h = s.add_f64s(n, half);
            let w = s.sub_f64s(s.sub_f64s(hi, s.mul_f64s(h, t1)), s.mul_f64s(h, t2));
            *time = s.add_f64s(w, s.sub_f64s(lo, s.mul_f64s(h, t3)));
            *count = n;
        }
    }
}

/// A doubled number in pieces of 26 bits, the last taking what is left: their products with
/// whole numbers below 2^27 are exact.
fn thirds(x: Dd) -> [f64; 3] {
    let cut = |x: f64| f64::from_bits(x.to_bits() & !((1 << 27) - 1));
    let a = cut(x.hi);
    let b = cut((x.hi - a) + x.lo);
    [a, b, ((x.hi - a) - b) + x.lo]
}

/// `offset + amplitude e^(-delta w) [(delta/omega_d) cos(omega_d w) - sin(omega_d w)]`, `w` from
/// the middle of the half cycle.
struct Evaluate<'a> {
    decay: &'a FreeDecay,
    block: &'a mut Block,
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let o = self.decay.oscillator();
        let v = |x: f64| s.splat_f64s(x);
        let (omega, rate) = (v(o.omega_d()), v(-o.decay_rate_per_s()));
        let ratio = v(o.decay_rate_per_s() / o.omega_d());
        let (times, _) = S::as_simd_f64s(&self.block.time);
        let (amplitudes, _) = S::as_simd_f64s(&self.block.amplitude);
        let (offsets, _) = S::as_mut_simd_f64s(&mut self.block.offset);
        for ((w, a), x) in times.iter().zip(amplitudes).zip(offsets) {
            let phase = s.mul_f64s(*w, omega);
            let square = s.mul_f64s(phase, phase);
            let decay = s.mul_f64s(*w, rate);
            let (mut sin, mut cos) = (v(SIN[10]), v(COS[10]));
            let mut e = v(EXP[11]);
            for k in (0..10).rev() {
                sin = s.mul_add_e_f64s(sin, square, v(SIN[k]));
                cos = s.mul_add_e_f64s(cos, square, v(COS[k]));
                e = s.mul_add_e_f64s(e, decay, v(EXP[k + 1]));
            }
            e = s.mul_add_e_f64s(e, decay, v(EXP[0]));
            let wave = s.sub_f64s(s.mul_f64s(ratio, cos), s.mul_f64s(sin, phase));
            *x = s.mul_add_e_f64s(s.mul_f64s(*a, e), wave, *x);
        }
    }
}

/// Taylor: up to `pi/2` the first term left out is below 2e-17 (cosine), and for the
/// exponential up to `SLOW/2` below 2e-18.
const SIN: [f64; 11] = factorials(1, 2, true);
const COS: [f64; 11] = factorials(0, 2, true);
const EXP: [f64; 12] = factorials(0, 1, false);

const fn factorials<const N: usize>(from: usize, step: usize, alternate: bool) -> [f64; N] {
    let mut table = [0.0; N];
    let mut k = 0;
    while k < N {
        let mut f = 1.0;
        let mut i = 2;
        while i <= from + step * k {
            f *= i as f64;
            i += 1;
        }
        table[k] = if alternate && k % 2 == 1 { -1.0 / f } else { 1.0 / f };
        k += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oscillator::Oscillator;
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
