//! Roots between two bounds.

/// Two neighbouring numbers between `inside`, where `holds` is true, and `outside`, where it is false: the last that
/// holds and the first that does not. Found by bisection; neither end is evaluated.
pub(crate) fn border(mut inside: f64, mut outside: f64, mut holds: impl FnMut(f64) -> bool) -> (f64, f64) {
    // A hundred bisections reduce any interval that does not contain zero to neighbouring numbers.
    for _ in 0..100 {
        let middle = 0.5 * (inside + outside);
        if middle == inside || middle == outside {
            break;
        }
        if holds(middle) { inside = middle } else { outside = middle }
    }
    (inside, outside)
}

/// The root of a continuous function between `a` and `b`, where its signs differ, accurate to rounding.
///
/// Inverse quadratic interpolation if three points allow it, bisection otherwise: T. R. Chandrupatla, Adv. Eng.
/// Softw. 28, 145 (1997). If the signs do not differ, the end with the smaller absolute value is returned.
pub(crate) fn root(a: f64, b: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut a, mut b) = (a, b);
    let (mut fa, mut fb) = (f(a), f(b));
    if !(fa <= 0.0 && fb >= 0.0 || fa >= 0.0 && fb <= 0.0) {
        return if fa.abs() < fb.abs() { a } else { b };
    }
    let mut t = 0.5f64;
    for _ in 0..200 {
        let best = if fa.abs() < fb.abs() { a } else { b };
        let tolerance = 2.0 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE;
        let least = tolerance / (b - a).abs();
        if least > 0.5 || fa == 0.0 || fb == 0.0 {
            return best;
        }
        let x = a + t.clamp(least, 1.0 - least) * (b - a);
        let fx = f(x);
        // c is the point that leaves the bracket, or the one that would have left it.
        let (c, fc);
        if (fx > 0.0) == (fa > 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (x, fx);
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        t = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_border_is_found_between_two_neighbours() {
        let (inside, outside) = border(0.0, 3.0, |x| x * x <= 2.0);
        assert!(inside * inside <= 2.0);
        assert!(outside * outside > 2.0);
        assert_eq!(inside.next_up(), outside);
        // Downwards, with a border close to zero.
        let (inside, outside) = border(1.0, 0.0, |x| x > 1e-200);
        assert!(inside < 1e-29, "{inside}");
        assert!(outside < 1e-30, "{outside}");
    }

    #[test]
    fn roots_of_hard_functions_take_few_steps() {
        type Case<'a> = (&'a dyn Fn(f64) -> f64, f64, f64, f64);
        let cases: [Case<'_>; 6] = [
            (&|x| x * x - 2.0, 0.0, 2.0, 2f64.sqrt()),
            (&|x| (x - 1.0).powi(9), -1.0, 4.0, 1.0),
            (&|x| x.exp() - 1e-8, -30.0, 10.0, 1e-8f64.ln()),
            (&|x| if x < 0.3 { -1.0 } else { 1.0 }, 0.0, 1.0, 0.3),
            (&|x| 1.0 / (x - 0.7), 0.2, 3.0, 0.7),
            (&|x| x, -1.0, 0.5, 0.0),
        ];
        for (i, (f, a, b, expected)) in cases.into_iter().enumerate() {
            let mut calls = 0;
            let found = root(a, b, |x| {
                calls += 1;
                f(x)
            });
            // A ninth power is zero to rounding in a wide interval around its root.
            let tolerance = if i == 1 { 1e-3 } else { 1e-14 };
            assert!((found - expected).abs() <= tolerance, "case {i}: {found} for {expected}");
            assert!(calls < 130, "case {i}: {calls} calls");
        }
    }

    #[test]
    fn without_a_change_of_sign_the_better_end_is_given() {
        assert_eq!(root(1.0, 2.0, |x| x), 1.0);
        assert_eq!(root(1.0, 2.0, |x| -1.0 / x), 2.0);
    }

    proptest! {
        #[test]
        fn a_cubic_is_solved_whichever_way_it_is_bracketed(r in -5.0..5.0f64, s in 0.1..3.0f64, down in any::<bool>()) {
            let f = |x: f64| (x - r) * ((x - r) * (x - r) + s);
            let (a, b) = if down { (7.0, -6.0) } else { (-6.0, 7.0) };
            prop_assert!((root(a, b, f) - r).abs() < 1e-14 * (1.0 + r.abs()));
        }
    }
}
