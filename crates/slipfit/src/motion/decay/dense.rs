//! Dense output of an integrated amplitude law: long steps, with interpolation at the times within them.
//!
//! A law without a closed form is integrated in steps of a tenth of the time scale on which its loss changes, about
//! sixty in a whole decay, regardless of the number of amplitudes or half cycles requested. The amplitude between the
//! ends of a step is the quintic Hermite interpolant. Its derivatives with respect to the parameters obey
//! `d/dt A_k = -g'(A) A_k - g_k(A)`, which is linear once the amplitude is known: collocation at the four Lobatto
//! points is accurate to sixth order at the end of a step and to fifth order within it (Hairer, Nørsett and Wanner,
//! Solving Ordinary Differential Equations I, sections II.5 to II.7).

/// `sqrt(5)/4`.
const ROOT: f64 = 0.559_016_994_374_947_4;
/// Lobatto points of a step.
const POINTS: [f64; 4] = [0.0, 0.5 - 0.4 * ROOT, 0.5 + 0.4 * ROOT, 1.0];
/// Integrals of their Lagrange polynomials from 0 to `u`, as coefficients of the powers 1 to 4 of `u`.
const INTEGRALS: [[f64; 4]; 4] = [
    [1.0, -3.0, 10.0 / 3.0, -1.25],
    [0.0, 1.25 + 5.0 * ROOT, -5.0 / 6.0 - 10.0 * ROOT, 5.0 * ROOT],
    [0.0, 1.25 - 5.0 * ROOT, -5.0 / 6.0 + 10.0 * ROOT, -5.0 * ROOT],
    [0.0, 0.5, -5.0 / 3.0, 1.25],
];

/// The loss at an amplitude: `-dA/dt`, its derivative with respect to the amplitude, and those with respect to all
/// carried parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct LossAt<const N: usize> {
    pub(super) rate: f64,
    pub(super) slope: f64,
    pub(super) by: [f64; N],
}

/// The amplitude at one end of a step with its time derivatives.
#[derive(Debug, Clone, Copy)]
struct Knot {
    amplitude: f64,
    slope: f64,
    curvature: f64,
}

impl Knot {
    fn new<const N: usize>(amplitude: f64, loss: &LossAt<N>) -> Self {
        Self { amplitude, slope: -loss.rate, curvature: loss.rate * loss.slope }
    }
}

/// A step and the data for interpolation within it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LongStep<const N: usize> {
    pub(super) duration: f64,
    /// Time from the beginning of the step to the current position.
    pub(super) passed: f64,
    begin: Knot,
    end: Knot,
    /// Derivatives at the beginning, and their rates of change at the Lobatto points.
    by: [f64; N],
    slopes: [[f64; N]; 4],
}

impl<const N: usize> LongStep<N> {
    /// A step from an amplitude and the derivatives carried there.
    pub(super) fn new(
        amplitude: f64,
        by: [f64; N],
        duration: f64,
        rate: impl Fn(f64) -> f64,
        loss: impl Fn(f64) -> LossAt<N>,
    ) -> Self {
        let here = loss(amplitude);
        let slopes = std::array::from_fn(|k| -here.slope * by[k] - here.by[k]);
        Self::from(Knot::new(amplitude, &here), by, slopes, duration, rate, loss)
    }

    /// The step after this one.
    pub(super) fn next(
        &self,
        duration: f64,
        rate: impl Fn(f64) -> f64,
        loss: impl Fn(f64) -> LossAt<N>,
    ) -> Self {
        let [.., slopes] = self.slopes;
        Self::from(self.end, self.derivatives_at(1.0), slopes, duration, rate, loss)
    }

    fn from(
        begin: Knot,
        by: [f64; N],
        first: [f64; N],
        duration: f64,
        rate: impl Fn(f64) -> f64,
        loss: impl Fn(f64) -> LossAt<N>,
    ) -> Self {
        let after = dormand_prince(rate, begin, duration);
        let last = loss(after);
        let end = Knot::new(after, &last);
        let mut step = Self { duration, passed: 0.0, begin, end, by, slopes: [first; 4] };
        let [early, late] = [POINTS[1], POINTS[2]].map(|u| loss(step.amplitude_at(u)));
        let losses = [early, late, last];
        let weights = [POINTS[1], POINTS[2], POINTS[3]].map(|u| integrals(u).map(|w| w * duration));
        // by(u_i) + sum w_ij λ_j by(u_j) = by(0) + w_i0 by'(0) - sum w_ij g_k(u_j), j beyond the first point.
        let rows = std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from(u8::from(i == j)) + weights[i][j + 1] * losses[j].slope)
        });
        let inverse = inverse(rows);
        for k in 0..N {
            let right = weights.map(|[w, rest @ ..]| {
                by[k] + w * first[k] - rest.iter().zip(&losses).map(|(w, loss)| w * loss.by[k]).sum::<f64>()
            });
            for ((row, loss), slopes) in inverse.iter().zip(&losses).zip(&mut step.slopes[1..]) {
                let there: f64 = row.iter().zip(right).map(|(m, r)| m * r).sum();
                slopes[k] = -loss.slope * there - loss.by[k];
            }
        }
        step
    }

    pub(super) fn amplitude_at_end(&self) -> f64 {
        self.end.amplitude
    }

    pub(super) fn amplitude(&self) -> f64 {
        self.amplitude_at(self.passed / self.duration)
    }

    /// Quintic Hermite interpolation through values, slopes and curvatures.
    fn amplitude_at(&self, u: f64) -> f64 {
        let Self { begin, end, duration: h, .. } = self;
        let v = 1.0 - u;
        let rise = end.amplitude - begin.amplitude;
        let [early, late] = [begin, end].map(|knot| (h * knot.slope - rise, 0.5 * h * h * knot.curvature));
        let early = (1.0 + 3.0 * u) * early.0 + u * early.1;
        let late = (1.0 + 3.0 * v) * late.0 - v * late.1;
        begin.amplitude + u * rise + u * v * (v * v * early - u * u * late)
    }

    /// The carried derivatives at the current position.
    pub(super) fn derivatives(&self) -> [f64; N] {
        self.derivatives_at(self.passed / self.duration)
    }

    fn derivatives_at(&self, u: f64) -> [f64; N] {
        let weights = integrals(u).map(|w| w * self.duration);
        std::array::from_fn(|k| {
            self.by[k] + weights.iter().zip(&self.slopes).map(|(w, slopes)| w * slopes[k]).sum::<f64>()
        })
    }
}

/// The amplitude one step ahead by the fifth-order rule of Dormand and Prince (1980).
fn dormand_prince(rate: impl Fn(f64) -> f64, from: Knot, h: f64) -> f64 {
    const STAGES: [[f64; 6]; 5] = [
        [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
        [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
        [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    ];
    const LAST: [f64; 6] = [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
    let mut slopes = [from.slope, 0.0, 0.0, 0.0, 0.0, 0.0];
    let along = |weights: &[f64; 6], slopes: &[f64; 6]| {
        from.amplitude + h * weights.iter().zip(slopes).map(|(w, k)| w * k).sum::<f64>()
    };
    for (i, weights) in STAGES.iter().enumerate() {
        slopes[i + 1] = -rate(along(weights, &slopes));
    }
    along(&LAST, &slopes)
}

/// Integrals of the Lagrange polynomials of the Lobatto points from 0 to `u`.
fn integrals(u: f64) -> [f64; 4] {
    INTEGRALS.map(|[a, b, c, d]| u * (a + u * (b + u * (c + u * d))))
}

/// Inverse of a matrix near the identity, by its cofactors.
fn inverse(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |i: usize, j: usize| {
        let (r, s) = ((i + 1) % 3, (i + 2) % 3);
        let (p, q) = ((j + 1) % 3, (j + 2) % 3);
        m[r][p] * m[s][q] - m[r][q] * m[s][p]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * minor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fifth_power_is_interpolated_exactly() {
        let fifth = |t: f64| 1.0 + t * (2.0 - t * (0.5 + t * (1.0 - t * (0.3 + 0.2 * t))));
        let knot = |t: f64| Knot {
            amplitude: fifth(t),
            slope: 2.0 + t * (-1.0 + t * (-3.0 + t * (1.2 + t))),
            curvature: -1.0 + t * (-6.0 + t * (3.6 + 4.0 * t)),
        };
        let (begin, end) = (knot(0.2), knot(1.7));
        let mut step = LongStep { duration: 1.5, passed: 0.0, begin, end, by: [0.0; 1], slopes: [[0.0]; 4] };
        for part in [0.0, 0.1, 0.8, 1.3, 1.5] {
            step.passed = part;
            assert!((step.amplitude() - fifth(0.2 + part)).abs() < 1e-14);
        }
    }

    /// Loss `λ A + c`, with the derivatives of `A = (A0 + c/λ) e^(-λt) - c/λ` with respect to the initial amplitude,
    /// `c` and `λ`.
    #[test]
    fn steps_are_exact_to_their_order() {
        let (lambda, c, start) = (0.7, 0.2, 1.5);
        let rate = |a: f64| lambda * a + c;
        let loss = |a: f64| LossAt { rate: rate(a), slope: lambda, by: [0.0, 1.0, a] };
        let exact = |t: f64| {
            let (e, whole) = ((-lambda * t).exp(), start + c / lambda);
            let by_lambda = -whole * t * e + c / (lambda * lambda) * (1.0 - e);
            (whole * e - c / lambda, [e, (e - 1.0) / lambda, by_lambda])
        };
        for (h, at_end, within) in [(0.4, 5e-7, 2e-6), (0.2, 8e-9, 6e-8)] {
            let mut step = LongStep::new(start, [1.0, 0.0, 0.0], h, rate, loss);
            for i in 0..2 {
                for (part, bound) in [(0.0, at_end), (0.35, within), (0.6, within), (1.0, at_end)] {
                    step.passed = part * h;
                    let (amplitude, by) = exact(f64::from(i) * h + step.passed);
                    assert!(
                        (step.amplitude() - amplitude).abs() < at_end,
                        "{h} {part}: {:e}",
                        step.amplitude() - amplitude
                    );
                    for (found, by) in step.derivatives().iter().zip(by) {
                        assert!((found - by).abs() < bound, "{h} {part}: {:e}", found - by);
                    }
                }
                step = step.next(h, rate, loss);
            }
        }
    }
}
