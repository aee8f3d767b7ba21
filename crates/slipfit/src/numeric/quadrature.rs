//! Integrals of smooth and of kinked functions.

/// Gauss and Kronrod, 7 and 15 points, halving where they differ.
pub(crate) fn integrate(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    if a == b {
        return 0.0;
    }
    let (whole, _) = kronrod(f, a, b);
    let mut open = vec![(a, b, 0_u32)];
    let mut sum = 0.0;
    let tolerance = 1e-13 * whole.abs();
    let mut panels = 0;
    while let Some((a, b, depth)) = open.pop() {
        panels += 1;
        let (value, error) = kronrod(f, a, b);
        // The difference of the two rules is a gross overestimate, even of its square root.
        let good = error <= tolerance.max(1e-15 * value.abs()) || error.is_nan();
        // Noise would be halved for ever.
        if good || depth >= 40 || panels > 20_000 {
            sum += value;
        } else {
            let m = 0.5 * (a + b);
            open.push((a, m, depth + 1));
            open.push((m, b, depth + 1));
        }
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
