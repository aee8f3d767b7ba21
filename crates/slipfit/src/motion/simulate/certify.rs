//! Finds the first zero of a smooth function without stepping over one.

/// First zero after `start`, up to `reach`, of a function `g` that is not negative at `start`.
///
/// `eval` gives `g`, `g'`, `g''` and the noise of `g`, below which a decreasing value counts as zero; `m3` bounds
/// `|g'''|`.
///
/// Over the next `H`, `-g''` is at most `m = max(0, -g'') + m3 H`, so no zero lies before the `h` that solves
/// `g + g' h - m h²/2 = 0`, as long as `h <= H`. Steps of this length cannot skip a pair of zeros, however close, and
/// become Newton's method at a simple zero.
pub(super) fn first_zero(
    start: f64,
    trust: f64,
    reach: f64,
    m3: f64,
    mut eval: impl FnMut(f64) -> [f64; 4],
) -> Option<f64> {
    let (mut u, mut trust) = (start, trust);
    let mut steps = 0;
    while u < reach {
        let [g, g1, g2, noise] = eval(u);
        if g <= noise {
            if g1 < 0.0 {
                return Some(polish(u, g, g1, reach));
            }
            if g1 == 0.0 && g2 <= 0.0 {
                return Some(u);
            }
        }
        let g = g.max(0.0);
        let m = (-g2).max(0.0) + m3 * trust;
        let root = (g1 * g1 + 2.0 * m * g).sqrt();
        let mut h = if g1 >= 0.0 { (g1 + root) / m } else { 2.0 * g / (root - g1) };
        if g1 >= 0.0 && g2 > 0.0 {
            // g + g' h + g'' h²/2 - m3 h³/6 stays positive at least this far.
            h = h.max(3.0 * g2 / m3);
        }
        let h = if h.is_nan() { trust } else { h.min(trust) };
        steps += 1;
        // A step of one ulp, or thousands of steps: the zero is found to full precision.
        if u + h <= u * (1.0 + 2e-16) || steps > 20_000 {
            return Some(polish(u, g, g1, reach));
        }
        trust = 2.0 * h;
        u += h;
    }
    None
}

/// One Newton step towards the zero, limited to the interval.
fn polish(u: f64, g: f64, g1: f64, reach: f64) -> f64 {
    let step = g / g1;
    if g1 < 0.0 && step.abs() < 1e-6 * reach { (u - step).clamp(0.0, reach) } else { u }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// (u - a)(u - b) + lift: a pair of zeros that may be closer than any step.
    fn pair(a: f64, b: f64, lift: f64) -> Option<f64> {
        let eval = |u: f64| [(u - a) * (u - b) + lift, 2.0 * u - a - b, 2.0, 0.0];
        first_zero(0.0, 1.0, 10.0, 1e-9, eval)
    }

    #[test]
    fn a_pair_of_zeros_an_ulp_apart_is_found() {
        let found = pair(3.0, 3.0 + 1e-7, 0.0).unwrap();
        assert!((found - 3.0).abs() < 1e-9, "{found}");
        assert!((pair(3.0, 3.0, 0.0).unwrap() - 3.0).abs() < 1e-7);
        assert_eq!(pair(3.0, 3.0, 1e-12), None);
    }

    proptest! {
        #[test]
        fn the_first_zero_of_a_sine_on_a_slope_is_the_first(w in 0.5..20.0f64, c in 0.0..1.2f64, d in -0.3..0.3f64) {
            let f = |u: f64| [c + d * u + (w * u).cos(), d - w * (w * u).sin(), -w * w * (w * u).cos(), 1e-16];
            let found = first_zero(0.0, 1.0, 10.0, w * w * w, f);
            // A fine grid finds the first sign change, or none.
            let grid = (1..200_000).map(|i| f64::from(i) * 5e-5).find(|u| f(*u)[0] < 0.0);
            match (found, grid) {
                (Some(u), Some(v)) => {
                    prop_assert!(u <= v, "{u} {v}");
                    prop_assert!(f(u)[0].abs() < 1e-12, "{u} {v}");
                    if v - u > 1e-4 {
                        prop_assert!(f(u)[1].abs() < 1e-3 * w);
                    }
                }
                (None, Some(v)) => prop_assert!(false, "missed {v}"),
                (Some(u), None) => prop_assert!(f(u)[0].abs() < 1e-9),
                (None, None) => {}
            }
        }
    }
}
