//! Amplitudes of sliding, viscous and drag loss and their derivatives at many instants at once.
//!
//! The [amplitude law](super::amplitude) is closed, so that no instant waits for the one before; what the losses did
//! until then is a running sum. With `R(A) = -dA/dt` the derivatives are, by Simpson's rule from instant to instant,
//!
//! ```text
//! dA/dA_0 = R/R_0     dA/da_k = -R ∫ A^k/R dt
//! ```

use super::amplitude::AmplitudeLaw;
use super::path::STEP;
use crate::numeric::trig;

/// Largest argument of the tangent, short of its pole.
const MOST_ANGLE: f64 = 1.5;
/// Part of the losses that their sum is at least where one is below zero.
const LEAST_LEFT: f64 = 1e-6;
/// Largest exponent.
const MOST_EXPONENT: f64 = 600.0;

/// An amplitude, and its derivatives by the start, sliding, viscous and drag loss.
pub(crate) type Point = (f64, [f64; 4]);

/// Amplitude and derivatives at ascending times after the start, the amplitude zero without derivatives behind the stop.
/// `None` where they have to be followed step by step: where the loss changes much from one time to the next, or is none.
pub(crate) fn at_times(law: &AmplitudeLaw, times: &[f64]) -> Option<Vec<Point>> {
    let &last = times.last()?;
    let stiffness = law.a1.abs() + 2.0 * law.a2.abs() * law.initial.abs();
    let mut longest = times[0];
    for pair in times.windows(2) {
        let step = pair[1] - pair[0];
        // A time before the last one counts as no step.
        longest = if step > longest { step } else { longest };
    }
    if !(law.is_closed() && times[0] >= 0.0 && longest * stiffness <= STEP) {
        return None;
    }
    let d = 4.0 * law.a0 * law.a2 - law.a1 * law.a1;
    let form =
        if d > 0.0 && law.a2 != 0.0 { Form::Tangent(d.sqrt()) } else { Form::Falling((-d).max(0.0).sqrt()) };
    let within = match form {
        Form::Tangent(root) => 0.5 * root * last < MOST_ANGLE,
        Form::Falling(r) => r * last < MOST_EXPONENT,
    };
    if !within {
        return None;
    }
    // The middle of each step, and its end.
    let mut before = 0.0;
    let mut amplitudes = Vec::with_capacity(2 * times.len());
    for &t in times {
        amplitudes.extend([0.5 * (before + t), t]);
        before = t;
    }
    let mut shares = vec![0.0; amplitudes.len()];
    crate::numeric::dispatch(Evaluate { law, form, amplitudes: &mut amplitudes, shares: &mut shares });
    let first = law.closed_rate(law.initial);
    let over_first = 1.0 / first;
    let powers = |a: f64, share: f64| [share, a * share, a * a * share];
    let mut sums = [0.0; 3];
    let (mut before, mut start) = (0.0, powers(law.initial, over_first));
    let mut points = Vec::with_capacity(times.len());
    for ((&t, a), share) in times.iter().zip(amplitudes.as_chunks::<2>().0).zip(shares.as_chunks::<2>().0) {
        let &[middle, after] = a;
        if after <= 0.0 {
            points.resize(times.len(), (0.0, [0.0; 4]));
            return Some(points);
        }
        let falls = share[0] * first > 0.0 && share[1] * first > 0.0 && after <= law.initial;
        if !falls || t < before {
            return None;
        }
        let rate = law.closed_rate(after);
        // Losses that cancel along the decay leave rounding alone.
        let size = law.a0.abs() + after * (law.a1.abs() + after * law.a2.abs());
        if !(rate.abs() > LEAST_LEFT * size) {
            return None;
        }
        let sixth = (t - before) / 6.0;
        let (half, end) = (powers(middle, share[0]), powers(after, share[1]));
        for k in 0..3 {
            sums[k] += sixth * (start[k] + 4.0 * half[k] + end[k]);
        }
        points.push((after, [rate * over_first, -rate * sums[0], -rate * sums[1], -rate * sums[2]]));
        (before, start) = (t, end);
    }
    Some(points)
}

/// The function of time that the law is, with `D = 4 a0 a2 - a1²`.
#[derive(Clone, Copy)]
enum Form {
    /// `D > 0`, and its root.
    Tangent(f64),
    /// `D <= 0`, and the root of `-D`.
    Falling(f64),
}

/// Amplitudes in the place of times, and `1/R` there.
struct Evaluate<'a> {
    law: &'a AmplitudeLaw,
    form: Form,
    amplitudes: &'a mut [f64],
    shares: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let AmplitudeLaw { initial: a, a0, a1, a2, .. } = *self.law;
        match self.form {
            Form::Tangent(root) => {
                for t in self.amplitudes.iter_mut() {
                    let half = 0.5 * *t * root;
                    let (sin_over, cos) = trig::sin_over_and_cos(half);
                    let s = 0.5 * *t * sin_over;
                    *t = (a * (cos - a1 * s) - 2.0 * a0 * s) / (cos + (2.0 * a2 * a + a1) * s);
                }
            }
            Form::Falling(r) => {
                let (less, more) = self.law.roots(r);
                let (over_r, near) = (1.0 / r.max(f64::MIN_POSITIVE), std::f64::consts::FRAC_PI_2);
                let (top, bottom) = (a0 + 0.5 * a * less, 0.5 * more + a2 * a);
                for t in self.amplitudes.iter_mut() {
                    let y = 0.5 * r * *t;
                    let half = trig::exp(-y);
                    let e = half * half;
                    // The series holds where it is taken.
                    let small = *t * half * trig::sinh_over(if y < near { y } else { 0.0 });
                    let s = if y < near { small } else { (1.0 - e) * over_r };
                    *t = (a * e - s * top) / (e + s * bottom);
                }
            }
        }
        for (share, &a) in self.shares.iter_mut().zip(&*self.amplitudes) {
            *share = 1.0 / (a0 + a * (a1 + a * a2));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::path::{AmplitudePath, Carried};
    use super::*;
    use proptest::prelude::*;

    /// Step by step.
    fn followed(law: AmplitudeLaw, times: &[f64]) -> Vec<Point> {
        let mut path = AmplitudePath::new(law, [0.0; 2]).carrying(Carried::Closed);
        let mut now = 0.0;
        let at = |&t: &f64| {
            path.advance(t - now);
            now = t;
            let by = std::array::from_fn(|k| path.by[k]);
            if path.amplitude > 0.0 { (path.amplitude, by) } else { (0.0, [0.0; 4]) }
        };
        times.iter().map(at).collect()
    }

    fn assert_alike(law: AmplitudeLaw, times: &[f64]) -> bool {
        let Some(found) = at_times(&law, times) else { return false };
        let expected = followed(law, times);
        let largest = |k: usize| expected.iter().map(|(_, by)| by[k].abs()).fold(0.0, f64::max);
        for (i, ((a, by), (b, expected))) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() < 1e-12 * law.initial, "{law:?}, {i}: {a} for {b}");
            for k in 0..4 {
                let miss = (by[k] - expected[k]).abs();
                assert!(miss <= 1e-9 * largest(k), "{law:?}, {i}, {k}: {} for {}", by[k], expected[k]);
            }
        }
        true
    }

    #[test]
    fn agrees_with_the_law_followed_step_by_step() {
        let times: Vec<f64> = (0..60).map(|i| 0.1 + 0.13 * f64::from(i) + 0.01 * f64::from(i % 3)).collect();
        for rates in [
            [0.0, 0.2, 0.0],
            [0.05, 0.0, 0.0],
            [0.02, 0.1, 0.0],
            [0.0, 0.0, 0.2],
            [0.02, 0.0, 0.1],
            [0.01, 0.3, 0.1],
            [0.05, 0.01, 0.1],
            [0.0, 1e-9, 0.0],
            [-0.01, 0.2, 0.0],
            [0.02, 0.3, -0.05],
            [0.3, 0.2, 0.1],
        ] {
            assert!(assert_alike(AmplitudeLaw::from_rates(1.3, rates), &times), "{rates:?}");
        }
    }

    proptest! {
        #[test]
        fn agrees_with_any_law(a0 in -0.1..0.3, a1 in -0.1..0.5, a2 in -0.1..0.3, n in 1usize..80, step in 0.01..0.5) {
            let times: Vec<f64> = (0..n).map(|i| step * (i as f64 + 0.5)).collect();
            assert_alike(AmplitudeLaw::from_rates(1.0, [a0, a1, a2]), &times);
        }
    }

    #[test]
    fn times_that_are_none_are_refused() {
        let law = AmplitudeLaw::from_rates(1.0, [0.01, 0.1, 0.0]);
        for times in [&[][..], &[f64::NAN], &[0.1, f64::INFINITY], &[0.1, f64::NAN, 0.3], &[0.3, 0.1]] {
            assert!(at_times(&law, times).is_none(), "{times:?}");
        }
    }
}
