//! Amplitudes under sliding, viscous and drag loss and their derivatives at many times at once.
//!
//! The [amplitude law](super::amplitude) is in closed form, so that no time has to wait for the one before; the
//! accumulated effect of the losses is a running sum. With `R(A) = -dA/dt` the derivatives are, by Simpson's rule
//! between successive times,
//!
//! ```text
//! dA/dA_0 = R/R_0     dA/da_k = -R ∫ A^k/R dt
//! ```

use super::amplitude::AmplitudeLaw;
use super::path::STEP;
use crate::numeric::trig;

/// Largest argument of the tangent, below its pole.
const MOST_ANGLE: f64 = 1.5;
/// Minimum of the total loss rate, as a part of the sum of the magnitudes, if one of the losses is negative.
const LEAST_NET_LOSS: f64 = 1e-6;
/// Largest exponent.
const MOST_EXPONENT: f64 = 600.0;

/// Amplitudes at given times and their derivatives with respect to the initial amplitude, sliding, viscous and drag
/// loss, each in one row.
#[derive(Debug)]
pub(crate) struct Points {
    count: usize,
    rows: Vec<f64>,
}

/// Number of rows for an amplitude and its derivatives, and including the rows needed to compute them.
const FOUND: usize = 5;
const ROWS: usize = FOUND + 2;

impl Points {
    /// The amplitudes, followed by their derivatives.
    #[inline(always)]
    pub(crate) fn rows(&self) -> [&[f64]; FOUND] {
        std::array::from_fn(|k| &self.rows[k * self.count..][..self.count])
    }
}

/// Amplitude and derivatives at ascending times after the start; after the stop the amplitude and its derivatives are
/// zero. `None` if they have to be followed step by step: if the loss changes much from one time to the next, or is
/// not positive.
pub(crate) fn at_times(law: &AmplitudeLaw, times: &[f64]) -> Option<Points> {
    let &last = times.last()?;
    let stiffness = law.a1.abs() + 2.0 * law.a2.abs() * law.initial.abs();
    let (mut longest, mut shortest) = (times[0], f64::INFINITY);
    for pair in times.windows(2) {
        let step = pair[1] - pair[0];
        longest = if step > longest { step } else { longest };
        shortest = if step < shortest { step } else { shortest };
    }
    if !(law.is_closed() && times[0] >= 0.0 && longest * stiffness <= STEP && shortest >= 0.0) {
        return None;
    }
    let d = 4.0 * law.a0 * law.a2 - law.a1 * law.a1;
    let form =
        if d > 0.0 && law.a2 != 0.0 { Form::Tangent(d.sqrt()) } else { Form::Falling((-d).max(0.0).sqrt()) };
    let within = match form {
        Form::Tangent(root) => 0.5 * root * last < MOST_ANGLE,
        Form::Falling(r) => r * last < MOST_EXPONENT,
    };
    let mut rows = vec![0.0; ROWS * times.len()];
    let found = within && crate::numeric::dispatch(Evaluate { law, form, times, rows: &mut rows });
    found.then_some(Points { count: times.len(), rows })
}

/// Functional form of the law in time, with `D = 4 a0 a2 - a1²`.
#[derive(Clone, Copy)]
enum Form {
    /// `D > 0`, with its square root.
    Tangent(f64),
    /// `D <= 0`, with the square root of `-D`.
    Falling(f64),
}

impl Form {
    /// Replaces times by amplitudes.
    #[inline(always)]
    fn put(self, law: &AmplitudeLaw, row: &mut [f64]) {
        let AmplitudeLaw { initial: a, a0, a1, a2, .. } = *law;
        match self {
            Self::Tangent(root) => {
                for t in row {
                    let half = 0.5 * *t * root;
                    let (sin_over, cos) = trig::sin_over_and_cos(half);
                    let s = 0.5 * *t * sin_over;
                    *t = (a * (cos - a1 * s) - 2.0 * a0 * s) / (cos + (2.0 * a2 * a + a1) * s);
                }
            }
            Self::Falling(r) => {
                let (less, more) = law.roots(r);
                let (over_r, near) = (1.0 / r.max(f64::MIN_POSITIVE), std::f64::consts::FRAC_PI_2);
                let (top, bottom) = (a0 + 0.5 * a * less, 0.5 * more + a2 * a);
                for t in row {
                    let y = 0.5 * r * *t;
                    let half = trig::exp(-y);
                    let e = half * half;
                    // The series is accurate where it is used.
                    let small = *t * half * trig::sinh_over(if y < near { y } else { 0.0 });
                    let s = if y < near { small } else { (1.0 - e) * over_r };
                    *t = (a * e - s * top) / (e + s * bottom);
                }
            }
        }
    }
}

/// `A^k/R` for each loss.
#[inline(always)]
fn powers(amplitude: f64, share: f64) -> [f64; 3] {
    [share, amplitude * share, amplitude * amplitude * share]
}

/// Simpson's rule for each loss.
#[inline(always)]
fn simpson(passed: f64, begin: [f64; 3], halfway: [f64; 3], end: [f64; 3]) -> [f64; 3] {
    let sixth = passed / 6.0;
    [
        sixth * (begin[0] + 4.0 * halfway[0] + end[0]),
        sixth * (begin[1] + 4.0 * halfway[1] + end[1]),
        sixth * (begin[2] + 4.0 * halfway[2] + end[2]),
    ]
}

/// Fills the rows of [`Points`]; returns whether this was possible.
struct Evaluate<'a> {
    law: &'a AmplitudeLaw,
    form: Form,
    times: &'a [f64],
    rows: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Evaluate<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let Self { law, form, times, rows } = self;
        let count = times.len();
        let mut rows = rows.chunks_exact_mut(count);
        let [Some(amplitude), Some(share), Some(by_0), Some(by_1), Some(by_2), Some(middle), Some(half)] =
            std::array::from_fn(|_| rows.next())
        else {
            return false;
        };
        amplitude.copy_from_slice(times);
        middle[0] = 0.5 * times[0];
        for (middle, pair) in middle[1..].iter_mut().zip(times.windows(2)) {
            *middle = 0.5 * (pair[0] + pair[1]);
        }
        form.put(law, amplitude);
        form.put(law, middle);
        let moving = amplitude.iter().position(|a| *a <= 0.0).unwrap_or(count);
        for row in [&mut *amplitude, &mut *share, &mut *by_0, &mut *by_1, &mut *by_2] {
            row[moving..].fill(0.0);
        }
        let (amplitude, share, times) = (&amplitude[..moving], &mut share[..moving], &times[..moving]);
        let [by_0, by_1, by_2] = [by_0, by_1, by_2].map(|row| &mut row[..moving]);
        let (middle, half) = (&middle[..moving], &mut half[..moving]);
        // 1/R in the middle of each step and at its end.
        let first = law.closed_rate(law.initial);
        let over_first = 1.0 / first;
        let mut is_fall = true;
        for i in 0..moving {
            let (a, rate) = (amplitude[i], law.closed_rate(amplitude[i]));
            share[i] = 1.0 / rate;
            half[i] = 1.0 / law.closed_rate(middle[i]);
            // If the losses cancel along the decay, only rounding errors remain.
            let size = law.a0.abs() + a * (law.a1.abs() + a * law.a2.abs());
            is_fall &= (share[i] * first > 0.0)
                & (half[i] * first > 0.0)
                & (a <= law.initial)
                & (rate.abs() > LEAST_NET_LOSS * size);
        }
        if !is_fall {
            return false;
        }
        if moving > 0 {
            let begin = powers(law.initial, over_first);
            let (halfway, end) = (powers(middle[0], half[0]), powers(amplitude[0], share[0]));
            [by_0[0], by_1[0], by_2[0]] = simpson(times[0], begin, halfway, end);
        }
        for i in 1..moving {
            let begin = powers(amplitude[i - 1], share[i - 1]);
            let (halfway, end) = (powers(middle[i], half[i]), powers(amplitude[i], share[i]));
            [by_0[i], by_1[i], by_2[i]] = simpson(times[i] - times[i - 1], begin, halfway, end);
        }
        let mut sums = [0.0; 3];
        for ((by_0, by_1), by_2) in by_0.iter_mut().zip(&mut *by_1).zip(&mut *by_2) {
            for (sum, by) in sums.iter_mut().zip([by_0, by_1, by_2]) {
                *sum += *by;
                *by = *sum;
            }
        }
        for i in 0..moving {
            let rate = law.closed_rate(amplitude[i]);
            share[i] = rate * over_first;
            (by_0[i], by_1[i], by_2[i]) = (-rate * by_0[i], -rate * by_1[i], -rate * by_2[i]);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::path::{AmplitudePath, Carried};
    use super::*;
    use proptest::prelude::*;

    /// An amplitude, and its derivatives.
    type Point = (f64, [f64; 4]);

    /// Reference computed step by step.
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
        let [amplitude, by @ ..] = found.rows();
        let found: Vec<Point> = (0..times.len()).map(|i| (amplitude[i], by.map(|row| row[i]))).collect();
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
