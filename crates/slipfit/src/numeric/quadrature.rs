//! Integrals of functions that are smooth or have kinks.

/// Number of bisections that may leave the error unchanged: after that it is attributed to rounding, as in QUADPACK.
const MOST_ROUNDOFF_HALVINGS: u32 = 20;

/// Gauss-Kronrod rule with 7 and 15 points, bisecting where the two differ.
pub(crate) fn integrate(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    if a == b {
        return 0.0;
    }
    let whole = kronrod(f, a, b);
    let tolerance = 1e-13 * whole.0.abs();
    let mut open = vec![(a, b, whole, 0_u32)];
    let mut sum = 0.0;
    let (mut panels, mut roundoff) = (1, 0);
    while let Some((a, b, (value, error), depth)) = open.pop() {
        // The difference of the two rules greatly overestimates the error, and so does its square root.
        let good = error <= tolerance.max(1e-15 * value.abs()) || error.is_nan();
        // An integrand with noise would be bisected forever.
        if good || depth >= 40 || panels > 20_000 || roundoff >= MOST_ROUNDOFF_HALVINGS {
            sum += value;
            continue;
        }
        let m = 0.5 * (a + b);
        let (left, right) = (kronrod(f, a, m), kronrod(f, m, b));
        panels += 2;
        roundoff += u32::from(left.1 + right.1 >= 0.99 * error);
        open.push((a, m, left, depth + 1));
        open.push((m, b, right, depth + 1));
    }
    sum
}

fn kronrod(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> (f64, f64) {
    // Piessens and others, QUADPACK (1983).
    const X: [f64; 8] = [
        0.991_455_371_120_812_6,
        0.949_107_912_342_758_5,
        0.864_864_423_359_769_1,
        0.741_531_185_599_394_4,
        0.586_087_235_467_691_1,
        0.405_845_151_377_397_2,
        0.207_784_955_007_898_47,
        0.0,
    ];
    const K: [f64; 8] = [
        0.022_935_322_010_529_224,
        0.063_092_092_629_978_55,
        0.104_790_010_322_250_18,
        0.140_653_259_715_525_92,
        0.169_004_726_639_267_9,
        0.190_350_578_064_785_4,
        0.204_432_940_075_298_9,
        0.209_482_141_084_727_82,
    ];
    const G: [f64; 4] =
        [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];
    let (c, h) = (0.5 * (a + b), 0.5 * (b - a));
    let (mut k, mut g) = (0.0, 0.0);
    for i in 0..8 {
        let y = if i == 7 { f(c) } else { f(c - h * X[i]) + f(c + h * X[i]) };
        k += K[i] * y;
        if i % 2 == 1 {
            g += G[i / 2] * y;
        }
    }
    (h * k, (h * (k - g)).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn rounding_of_the_integrand_is_not_halved_for_long() {
        let calls = Cell::new(0);
        // Rounded to one part in 1e8 of its mean: the difference of two large numbers.
        let noisy = |x: f64| {
            calls.set(calls.get() + 1);
            ((1.0 + x.cos()) * 1e8).round() / 1e8 - 1.0
        };
        let sum = integrate(&noisy, 0.0, 3.0);
        assert!((sum - 3.0f64.sin()).abs() < 1e-8, "{sum}");
        assert!(calls.get() < 10_000, "{} values", calls.get());
    }

    #[test]
    fn kinks_and_jumps_are_halved_to_the_end() {
        let kink = |x: f64| (x - 0.3).abs();
        assert!((integrate(&kink, 0.0, 1.0) - 0.29).abs() < 1e-13);
        let jump = |x: f64| if x < 0.3 { 1.0 } else { 2.0 };
        assert!((integrate(&jump, 0.0, 1.0) - 1.7).abs() < 1e-9);
    }
}
