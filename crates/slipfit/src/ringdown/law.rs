//! The amplitude law `dA/dt = -(a0 + a1 A + a2 A²)`, solved.

/// Amplitude law with its starting amplitude.
///
/// `a0` is the sliding, `a1` the viscous, `a2` the drag term. Turning points
/// of the exact motion with viscous and sliding friction lie on this law when
/// `a0 = delta x_F coth(pi delta / 2 omega_d)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LossLaw {
    pub(crate) amplitude_0: f64,
    pub(crate) a0: f64,
    pub(crate) a1: f64,
    pub(crate) a2: f64,
}

impl LossLaw {
    /// Rate of loss `-dA/dt` at an amplitude.
    pub(crate) fn rate(&self, amplitude: f64) -> f64 {
        self.a0 + amplitude * (self.a1 + amplitude * self.a2)
    }

    /// Derivative of a later amplitude by an earlier one, `h` before it.
    pub(crate) fn carry(&self, before: f64, after: f64, h: f64) -> f64 {
        // Both lie on one curve A(t), so the derivative is the ratio of its slopes.
        let ratio = self.rate(after) / self.rate(before);
        if self.a2 == 0.0 || !(ratio > 0.0 && ratio.is_finite()) {
            (-(self.a1 + self.a2 * (before + after)) * h).exp()
        } else {
            ratio
        }
    }

    /// Amplitude `elapsed` after the start, zero from the stop on.
    pub(crate) fn amplitude(&self, elapsed: f64) -> f64 {
        self.amplitude_extended(elapsed).max(0.0)
    }

    /// The same law followed past zero, as the closed form has it: a fit needs
    /// a function that stays smooth there.
    pub(crate) fn amplitude_extended(&self, elapsed: f64) -> f64 {
        let Self { amplitude_0: start, a0, a1, a2 } = *self;
        if a2 == 0.0 {
            // A = A0 e^(-a1 t) - a0 (1 - e^(-a1 t))/a1
            let x = a1 * elapsed;
            let e = (-x).exp();
            return start * e - a0 * elapsed * phi(x);
        }
        // T = tan(t sqrt(D)/2)/sqrt(D); with D < 0 the hyperbolic tangent.
        let d = 4.0 * a0 * a2 - a1 * a1;
        let half = 0.5 * elapsed;
        let s = d.abs().sqrt();
        let x = half * s;
        if d > 0.0 && x >= 1.5 {
            // The tangent's pole lies past the stop when A0 > 0: the motion ended.
            let stop = 2.0 * (s * start).atan2(a1 * start + 2.0 * a0) / s;
            if elapsed >= stop {
                return 0.0;
            }
        }
        let t = if x < 1e-4 {
            half * (1.0 + d.signum() * x * x / 3.0)
        } else if d > 0.0 {
            x.tan() / s
        } else {
            x.tanh() / s
        };
        (start * (1.0 - a1 * t) - 2.0 * a0 * t) / (1.0 + (2.0 * a2 * start + a1) * t)
    }

    /// Shares of the loss at an amplitude: sliding, viscous, drag.
    pub(crate) fn shares(&self, amplitude: f64) -> [f64; 3] {
        let parts = [self.a0, self.a1 * amplitude, self.a2 * amplitude * amplitude].map(|p| p.max(0.0));
        let total: f64 = parts.iter().sum();
        parts.map(|p| if total > 0.0 { p / total } else { 0.0 })
    }

    /// Time from the start to amplitude zero; infinite without sliding friction.
    pub(crate) fn stop_time(&self) -> f64 {
        let Self { amplitude_0: start, a0, a1, a2 } = *self;
        if a0 <= 0.0 {
            return f64::INFINITY;
        }
        let d = 4.0 * a0 * a2 - a1 * a1;
        let t = start / (a1 * start + 2.0 * a0);
        if d > 0.0 {
            let s = d.sqrt();
            2.0 * (s * t).atan() / s
        } else {
            let s = (-d).sqrt();
            if s * t < 1e-6 { 2.0 * t } else { 2.0 * (s * t).atanh() / s }
        }
    }
}

/// `(1 - e^(-x))/x`, right also at zero.
pub(crate) fn phi(x: f64) -> f64 {
    if x.abs() < 1e-5 { 1.0 - 0.5 * x + x * x / 6.0 } else { -(-x).exp_m1() / x }
}
