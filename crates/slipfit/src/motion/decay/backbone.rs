//! Loss of an oscillator whose frequency depends on the amplitude (backbone).

use crate::model::loss::{FURTHER, LossTerm};

/// One number for each loss term: sliding, viscous, drag and the further terms.
pub(crate) type PerTerm = [f64; TERMS];

/// Number of loss terms.
pub(crate) const TERMS: usize = 3 + FURTHER;

/// Smallest and largest factor on a loss: outside this range the expansion is not valid.
const FACTORS: [f64; 2] = [0.3, 3.0];

/// Factors on the loss terms of an oscillator whose frequency is shifted by the relative amount
/// `shift[0] A² + shift[1] A⁴` at the amplitude `A` of its fundamental.
///
/// A loss reduces the action `J = ∮ m v dx/2π` per cycle by its work over `2π`, and the change of amplitude follows
/// from `dJ/dA`. In units where `m = 1` and `omega` is 1 at small amplitude, the motion
/// `x = A (cos p + e3 cos 3p + e5 cos 5p)` has `J = omega A²/2 (1 + 9 e3² + 25 e5²)`. For the spring
/// `x + alpha x³ + beta x⁵`, to second order,
///
/// ```text
/// shift[0] = 3/8 alpha        e3 = s/12 - 3/32 s² + q/8     s = shift[0] A²
/// shift[1] = 5/16 beta - 15/256 alpha²    e5 = s²/96 + q/120     q = shift[1] A⁴
/// ```
///
/// For a pendulum the viscous factor is accurate to 0.002 % at 60° and to 0.004 % at 75°. The factors of the further
/// terms are accurate to first order.
pub(crate) fn backbone_factors(amplitude: f64, shift: [f64; 2]) -> PerTerm {
    let square = amplitude * amplitude;
    let (s, q) = (shift[0] * square, shift[1] * square * square);
    let omega = 1.0 + s + q;
    let (e3, e5) = (s / 12.0 - 3.0 / 32.0 * s * s + q / 8.0, s * s / 96.0 + q / 120.0);
    let harmonics = 1.0 + 9.0 * e3 * e3 + 25.0 * e5 * e5;
    // Logarithmic derivatives with respect to the amplitude.
    let by_omega = (2.0 * s + 4.0 * q) / omega;
    let by_harmonics = (18.0 * e3 * (s / 6.0 - 3.0 / 8.0 * s * s + q / 2.0) + 200.0 * e5 * e5) / harmonics;
    // A dJ/dA over 2J, relative to small amplitude, and dJ/dA itself relative to small amplitude.
    let steepness = (1.0 + 0.5 * (by_omega + by_harmonics)).max(1.0 / FACTORS[1]);
    let by_amplitude = steepness * omega * harmonics;
    let within = |factor: f64| if factor.is_finite() { factor.clamp(FACTORS[0], FACTORS[1]) } else { 1.0 };
    let viscous = within(1.0 / steepness);
    // The work of friction is proportional to the path between turning points.
    let sliding = within((1.0 + e3 + e5) / by_amplitude);
    // The mean of |v|³ over the cycle.
    let cubed = 1.0 - 1.8 * e3 + 729.0 / 35.0 * e3 * e3 - 3.0 / 7.0 * e5;
    let drag = within(omega * omega * cubed / by_amplitude);
    std::array::from_fn(|k| match k {
        0 => sliding,
        1 => viscous,
        2 => drag,
        _ => within((1.0 - (LossTerm::further()[k - 3].backbone() - 2.0) * (s + q)) / by_amplitude),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// Arithmetic-geometric mean, which gives the elliptic integral K(k) = pi/(2 agm(1, k')).
    fn agm(mut a: f64, mut b: f64) -> f64 {
        for _ in 0..40 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        a
    }

    /// A pendulum with this maximum angle: amplitude of the fundamental, and frequency relative to small swings.
    fn pendulum(top: f64) -> (f64, f64) {
        let (k, other) = ((0.5 * top).sin(), (0.5 * top).cos());
        let (omega, complement) = (agm(1.0, other), agm(1.0, k));
        let nome = (-PI * omega / complement).exp();
        (8.0 * nome.sqrt() / (1.0 + nome), omega)
    }

    /// Action, path between turning points and mean |v|³ of a pendulum, by the midpoint rule along `x = top sin u`.
    fn of_a_cycle(top: f64) -> [f64; 3] {
        let n = 4000;
        let mut sums = [0.0; 3];
        for i in 0..n {
            let u = TAU * (i as f64 + 0.5) / n as f64;
            let x = top * u.sin();
            // cos x - cos top, without cancellation.
            let rise = 2.0 * (0.5 * (top + x)).sin() * (0.5 * (top - x)).sin();
            let v = (2.0 * rise).sqrt();
            let dx = top * u.cos().abs() * TAU / n as f64;
            sums = [sums[0] + v * dx, sums[1] + dx, sums[2] + v * v * dx];
        }
        [sums[0] / TAU, sums[1] / TAU, sums[2] / TAU]
    }

    #[test]
    fn a_pendulum_loses_as_its_action_does() {
        for (degrees, tolerance) in [(20.0, 2e-6), (45.0, 1e-5), (60.0, 5e-5), (75.0, 3e-4)] {
            let top = f64::to_radians(degrees);
            // The shift determined from two amplitudes, as a fit to a decay would find it.
            let [(a, omega), (b, omega_b)] = [top, 0.6 * top].map(pendulum);
            let (ya, yb) = ((omega - 1.0) / (a * a), (omega_b - 1.0) / (b * b));
            let quartic = (ya - yb) / (a * a - b * b);
            let shift = [ya - quartic * a * a, quartic];
            let step = 1e-4;
            let [less, more] = [top - step, top + step].map(|t| (pendulum(t).0, of_a_cycle(t)[0]));
            let by_amplitude = (more.1 - less.1) / (more.0 - less.0);
            let [action, way, drag] = of_a_cycle(top);
            let factors = backbone_factors(a, shift);
            // Relative to small swings: J = A²/2, a path of 2/pi A, 4/(3 pi) A³ for |v|³.
            let exact = [way / (2.0 / PI), 2.0 * action / a, drag / (4.0 / (3.0 * PI) * a * a)];
            for (k, exact) in exact.into_iter().enumerate() {
                let found = factors[k] * by_amplitude / exact;
                assert!((found - 1.0).abs() < tolerance, "{degrees} degrees, term {k}: {found}");
            }
        }
    }

    #[test]
    fn factors_are_the_terms_own_to_first_order() {
        let shift = 1e-5;
        let factors = backbone_factors(1.0, [shift, 0.0]);
        let terms = [LossTerm::Sliding, LossTerm::Viscous, LossTerm::Drag];
        for (k, term) in terms.into_iter().chain(LossTerm::further().iter().copied()).enumerate() {
            let found = (1.0 - factors[k]) / shift;
            assert!((found - term.backbone()).abs() < 1e-4, "{}: {found}", term.name());
        }
        assert_eq!(backbone_factors(0.7, [0.0; 2]), [1.0; TERMS]);
    }

    #[test]
    fn factors_stay_within_their_limits() {
        for shift in [-1e300, -40.0, -1.0, -0.5, 0.5, 40.0, 1e300, f64::INFINITY, f64::NAN] {
            for factor in
                backbone_factors(1.0, [shift, -shift]).into_iter().chain(backbone_factors(1.0, [shift, 0.0]))
            {
                assert!((FACTORS[0]..=FACTORS[1]).contains(&factor), "{shift}: {factor}");
            }
        }
    }
}
