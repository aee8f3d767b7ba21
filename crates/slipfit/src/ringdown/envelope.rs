//! The amplitude law against the amplitudes of the blocks.

use super::law::LossLaw;
use crate::inference::least_squares::{Fit, LeastSquares, Normal};
use std::f64::consts::PI;

/// Positions of the parameters in every fit of a decay.
pub(crate) const A0: usize = 0;
pub(crate) const X_F: usize = 1;
pub(crate) const DELTA: usize = 2;
pub(crate) const DRAG: usize = 3;
pub(crate) const FLOOR: usize = 4;

/// Amplitudes with their weights, and what is known of frequency and detector.
#[derive(Debug, Clone)]
pub(crate) struct EnvelopeProblem {
    /// Time since the start, s, ascending.
    pub(crate) elapsed: Vec<f64>,
    /// Signed amplitude, or mean squared amplitude where `squared`.
    pub(crate) value: Vec<f64>,
    /// Inverse variance up to a common factor.
    pub(crate) weight: Vec<f64>,
    /// Angular frequency at vanishing amplitude, rad/s.
    pub(crate) omega: f64,
    /// Relative shift of frequency per A² and A⁴.
    pub(crate) backbone: [f64; 2],
    /// The values are `A² + floor`, the floor a parameter.
    pub(crate) squared: bool,
    pub(crate) lowpass: Option<super::lowpass::Kernel>,
}

/// `K` of `a0 = K x_F` and its derivative by delta: `K = delta coth(pi delta/2 omega)`.
pub(crate) fn sliding_gain(delta: f64, omega: f64) -> (f64, f64) {
    let y = PI * delta / (2.0 * omega);
    if y.abs() < 1e-4 {
        (2.0 * omega / PI * (1.0 + y * y / 3.0), 2.0 * y / 3.0)
    } else {
        let coth = 1.0 / y.tanh();
        (delta * coth, coth - y / y.sinh().powi(2))
    }
}

/// Loss terms of a parameter vector, before the backbone changes them.
pub(crate) fn law_of(p: &[f64], omega: f64) -> LossLaw {
    LossLaw { amplitude_0: p[A0], a0: sliding_gain(p[DELTA], omega).0 * p[X_F], a1: p[DELTA], a2: p[DRAG] }
}

/// Factors on the sliding, viscous and drag terms of an oscillator whose
/// frequency differs by the relative `shift` at the present amplitude.
///
/// For a spring `k (x + alpha x³)`, shift = 3/8 alpha A². Energy lost per cycle,
/// over dE/dA, both for the fundamental amplitude A and to first order in
/// alpha: sliding `1 - 23/32 alpha A²`, viscous `1 - 3/8 alpha A²`, drag
/// `1 - 9/160 alpha A²`.
pub(crate) fn backbone_factors(shift: f64) -> [f64; 3] {
    [1.0 - 23.0 / 12.0 * shift, 1.0 - shift, 1.0 - 0.15 * shift].map(|f| f.clamp(0.3, 3.0))
}

/// The amplitude carried from point to point with its derivatives.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Walker {
    pub(crate) amplitude: f64,
    /// By A0, a0, a1, a2.
    pub(crate) by: [f64; 4],
    law: LossLaw,
    backbone: [f64; 2],
}

/// The propagator of `dA/dt = -(a0 + a1 A)` over a step and over half of it.
#[derive(Clone, Copy)]
struct Linear {
    carry: f64,
    half: f64,
    loss: f64,
    half_loss: f64,
}

impl Linear {
    fn over(law: &LossLaw, step: f64) -> Self {
        let x = 0.5 * law.a1 * step;
        // expm1 twice over: e^(-2x) - 1 = m (2 + m).
        let m = (-x).exp_m1();
        let share = if x.abs() < 1e-5 { super::law::phi(x) } else { -m / x };
        let half_loss = 0.5 * law.a0 * step * share;
        Self { carry: (1.0 + m) * (1.0 + m), half: 1.0 + m, loss: half_loss * (2.0 + m), half_loss }
    }

    fn middle(&self, amplitude: f64) -> f64 {
        amplitude * self.half - self.half_loss
    }

    fn after(&self, amplitude: f64) -> f64 {
        amplitude * self.carry - self.loss
    }
}

impl Walker {
    pub(crate) fn new(law: LossLaw, backbone: [f64; 2]) -> Self {
        Self { amplitude: law.amplitude_0, by: [1.0, 0.0, 0.0, 0.0], law, backbone }
    }

    /// Loss terms in force at an amplitude.
    fn local(&self, amplitude: f64) -> (LossLaw, [f64; 3]) {
        let s = amplitude * amplitude;
        let shift = s * (self.backbone[0] + s * self.backbone[1]);
        let f = if shift == 0.0 { [1.0; 3] } else { backbone_factors(shift) };
        let law = LossLaw {
            amplitude_0: self.amplitude,
            a0: self.law.a0 * f[0],
            a1: self.law.a1 * f[1],
            a2: self.law.a2 * f[2],
        };
        (law, f)
    }

    pub(crate) fn rate(&self) -> f64 {
        self.local(self.amplitude).0.rate(self.amplitude)
    }

    /// Moves on by `h` seconds (negative: back).
    pub(crate) fn advance(&mut self, h: f64) {
        if h == 0.0 {
            return;
        }
        let stiff = (self.law.a1.abs() + 2.0 * self.law.a2.abs() * self.amplitude.abs()) * h.abs();
        let changes = self.backbone != [0.0; 2];
        let parts = if stiff > 0.3 { (stiff / 0.3).ceil().min(64.0) } else { 1.0 };
        // Each part is exact where the frequency is constant, so parts only serve the derivatives.
        let part = h / parts;
        // Viscous and sliding loss alone: one exponential serves every step alike.
        let linear = (!changes && self.law.a2 == 0.0).then(|| Linear::over(&self.law, part));
        for _ in 0..parts as usize {
            let before = self.amplitude;
            let (f, middle, after, carry, half) = if let Some(l) = linear {
                ([1.0; 3], l.middle(before), l.after(before), l.carry, l.half)
            } else {
                let (law, f) = if changes {
                    let (here, _) = self.local(before);
                    self.local(here.amplitude_extended(0.5 * part))
                } else {
                    self.local(before)
                };
                let after = law.amplitude_extended(part);
                let middle = law.amplitude_extended(0.5 * part);
                (f, middle, after, law.carry(before, after, part), law.carry(middle, after, 0.5 * part))
            };
            for v in &mut self.by {
                *v *= carry;
            }
            let simpson = |f0: f64, f1: f64, f2: f64| part / 6.0 * (carry * f0 + 4.0 * half * f1 + f2);
            self.by[1] -= f[0] * simpson(1.0, 1.0, 1.0);
            self.by[2] -= f[1] * simpson(before, middle, after);
            self.by[3] -= f[2] * simpson(before * before, middle * middle, after * after);
            self.amplitude = after;
        }
    }
}

/// Derivatives by A0, x_F, delta, drag from those by A0, a0, a1, a2.
pub(crate) fn by_parameters(by: [f64; 4], p: &[f64], omega: f64) -> [f64; 4] {
    let (gain, gain_by_delta) = sliding_gain(p[DELTA], omega);
    [by[0], by[1] * gain, by[2] + by[1] * p[X_F] * gain_by_delta, by[3]]
}

impl EnvelopeProblem {
    /// Amplitude of the model at every point.
    pub(crate) fn amplitudes(&self, p: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.elapsed.len());
        self.walk(p, |_, amplitude, _| out.push(amplitude));
        out
    }

    /// Weighted residuals.
    pub(crate) fn residuals(&self, p: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.value.len());
        self.walk(p, |j, amplitude, _| {
            out.push((self.value[j] - self.model(amplitude, p)) * self.weight[j].sqrt());
        });
        out
    }

    /// Residuals and derivatives of the model at every point.
    pub(crate) fn predictions(&self, fit: &Fit) -> Vec<(f64, [f64; 5])> {
        let p = &fit.parameters;
        let mut out = Vec::with_capacity(self.value.len());
        self.walk(p, |j, amplitude, by| {
            let factor = if self.squared { 2.0 * amplitude.max(0.0) } else { 1.0 };
            let row = [by[0] * factor, by[1] * factor, by[2] * factor, by[3] * factor, 1.0];
            out.push((self.value[j] - self.model(amplitude, p), row));
        });
        out
    }

    /// Root mean square of amplitude less model.
    pub(crate) fn unweighted_rms(&self, p: &[f64]) -> f64 {
        let mut sum = 0.0;
        self.walk(p, |j, amplitude, _| {
            let (data, model) = (self.value[j], self.model(amplitude, p));
            let miss = if self.squared { data.max(0.0).sqrt() - model.max(0.0).sqrt() } else { data - model };
            sum += miss * miss;
        });
        (sum / self.value.len() as f64).sqrt()
    }

    fn model(&self, amplitude: f64, p: &[f64]) -> f64 {
        if self.squared { amplitude.max(0.0).powi(2) + p[FLOOR] } else { amplitude }
    }

    fn walk(&self, p: &[f64], mut visit: impl FnMut(usize, f64, [f64; 4])) {
        let law = law_of(p, self.omega);
        match &self.lowpass {
            None => {
                let mut walker = Walker::new(law, self.backbone);
                let mut now = 0.0;
                for (j, &t) in self.elapsed.iter().enumerate() {
                    walker.advance(t - now);
                    now = t;
                    visit(j, walker.amplitude, by_parameters(walker.by, p, self.omega));
                }
            }
            Some(kernel) => {
                for (j, &t) in self.elapsed.iter().enumerate() {
                    let mut amplitude = 0.0;
                    let mut by = [0.0; 4];
                    for &(delay, share) in &kernel.nodes {
                        let mut walker = Walker::new(law, self.backbone);
                        walker.advance(t - delay);
                        // At rest there is no oscillation for the lock-in to see.
                        if walker.amplitude > 0.0 {
                            amplitude += share * walker.amplitude;
                            let d = by_parameters(walker.by, p, self.omega);
                            for k in 0..4 {
                                by[k] += share * d[k];
                            }
                        }
                    }
                    visit(j, amplitude, by);
                }
            }
        }
    }
}

impl LeastSquares for EnvelopeProblem {
    fn parameters(&self) -> usize {
        5
    }

    fn observations(&self) -> f64 {
        self.value.len() as f64
    }

    fn normal(&self, p: &[f64], out: &mut Normal) -> bool {
        out.clear();
        if !(p[A0] > 0.0) {
            return false;
        }
        self.walk(p, |j, amplitude, by| {
            let model = self.model(amplitude, p);
            let factor = if self.squared { 2.0 * amplitude.max(0.0) } else { 1.0 };
            let row = [by[0] * factor, by[1] * factor, by[2] * factor, by[3] * factor, 1.0];
            out.add_row(&row, self.value[j] - model, self.weight[j]);
        });
        out.rss.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(backbone: [f64; 2], squared: bool) -> EnvelopeProblem {
        let elapsed: Vec<f64> = (0..60).map(|i| 0.13 * i as f64 + 0.01 * (i % 3) as f64).collect();
        let n = elapsed.len();
        EnvelopeProblem {
            elapsed,
            value: vec![0.0; n],
            weight: vec![1.0; n],
            omega: 11.0,
            backbone,
            squared,
            lowpass: None,
        }
    }

    /// Central differences against the derivatives carried along.
    fn check(problem: &EnvelopeProblem, p: [f64; 5], tolerance: f64) {
        for k in 0..4 {
            let h = 1e-5 * p[k].abs().max(1e-2);
            let (mut up, mut down) = (p, p);
            up[k] += h;
            down[k] -= h;
            let numeric: Vec<f64> = problem
                .amplitudes(&up)
                .iter()
                .zip(problem.amplitudes(&down))
                .map(|(a, b)| (a - b) / (2.0 * h))
                .collect();
            let scale = numeric.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            problem.walk(&p, |j, _, by| {
                let error = (by[k] - numeric[j]).abs() / scale;
                assert!(error < tolerance, "parameter {k}, point {j}: {} against {}", by[k], numeric[j]);
            });
        }
    }

    #[test]
    fn derivatives_hold_for_every_loss_term() {
        for p in [
            [1.0, 0.0, 0.2, 0.0, 0.0],
            [1.0, 0.01, 0.0, 0.0, 0.0],
            [1.0, 0.01, 0.1, 0.0, 0.0],
            [1.0, 0.0, 0.1, 0.2, 0.0],
            [2.0, 0.005, 0.05, 0.1, 0.0],
        ] {
            check(&problem([0.0; 2], false), p, 2e-5);
            // The loss terms' own change with amplitude is left out of the derivatives.
            check(&problem([0.01, -0.001], false), p, 2e-2);
        }
    }

    #[test]
    fn steps_add_up_to_the_closed_form() {
        let p = [1.5, 0.01, 0.1, 0.07, 0.0];
        let problem = problem([0.0; 2], true);
        let law = law_of(&p, problem.omega);
        for (a, t) in problem.amplitudes(&p).iter().zip(&problem.elapsed) {
            assert!((a - law.amplitude_extended(*t)).abs() < 1e-13);
        }
    }
}
