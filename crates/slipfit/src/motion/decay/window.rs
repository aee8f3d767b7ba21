//! The samples of a window and the phase of the motion along it.

use super::parameters::{BACKBONE, CHIRP, OMEGA, PHASE};
use std::f64::consts::FRAC_PI_2;

/// Integral of the squared amplitude along a reference decay, for the backbone.
#[derive(Debug, Clone, Default)]
pub(crate) struct BackboneIntegral {
    /// Even spacing of the knots, s.
    step: f64,
    /// Integral and its rate at the knots.
    knots: Vec<(f64, f64)>,
}

impl BackboneIntegral {
    /// From an amplitude law over `[0, duration]`.
    pub(crate) fn along(amplitude: impl Fn(f64) -> f64, duration: f64) -> Self {
        let count = 129;
        let step = duration / (count - 1) as f64;
        let square = |t: f64| amplitude(t).powi(2);
        let mut sum = 0.0;
        let mut knots = Vec::with_capacity(count);
        let mut before = 0.0;
        for i in 0..count {
            let t = i as f64 * step;
            let here = square(t);
            if i > 0 {
                sum += step / 6.0 * (before + 4.0 * square(t - 0.5 * step) + here);
            }
            knots.push((sum, here));
            before = here;
        }
        Self { step, knots }
    }

    /// Integral and rate at a time; extrapolated with the end rates.
    #[inline(always)]
    pub(crate) fn at(&self, t: f64) -> (f64, f64) {
        let last = self.knots.len() - 1;
        let i = ((t / self.step).max(0.0) as usize).min(last - 1);
        let ((p, u), (q, v)) = (self.knots[i], self.knots[i + 1]);
        let d = t - i as f64 * self.step;
        if d < 0.0 {
            return (p + u * d, u);
        }
        let e = d - self.step;
        if e > 0.0 {
            return (q + v * e, v);
        }
        let h = self.step;
        let slope = (q - p) / h;
        let a = (slope - u) / h;
        let b = (u + v - 2.0 * slope) / (h * h);
        (p + d * (u + d * (a + b * e)), u + 2.0 * a * d + b * (2.0 * d * e + d * d))
    }
}

/// The quantity that is sampled.
///
/// Parameters with the unit of the signal (amplitude and friction displacement) are displacements times `omega` for
/// velocities, times `omega²` for accelerations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Observable {
    #[default]
    Displacement,
    Velocity,
    Acceleration,
}

impl Observable {
    /// Number of times the displacement is differentiated.
    pub(crate) fn order(self) -> i32 {
        match self {
            Self::Displacement => 0,
            Self::Velocity => 1,
            Self::Acceleration => 2,
        }
    }

    /// Phase lead of the signal over the displacement, rad.
    pub(crate) fn phase_lead(self) -> f64 {
        f64::from(self.order()) * FRAC_PI_2
    }
}

/// Samples of a window and the structure of the model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<'a> {
    /// s, non-decreasing.
    pub(crate) time: &'a [f64],
    pub(crate) signal: &'a [f64],
    pub(crate) observable: Observable,
    /// Samples closer to a turning point than this, rad, are excluded.
    pub(crate) guard: f64,
    /// Reference time of the parameters, s.
    pub(crate) origin: f64,
    pub(crate) duration: f64,
    /// Shape of the backbone; `None` disables [`BACKBONE`].
    pub(crate) backbone: Option<&'a BackboneIntegral>,
    /// Whether the rest position is part of the model; otherwise the model is zero there.
    pub(crate) models_rest_position: bool,
    /// Parameters whose derivatives are computed.
    pub(crate) active: &'a [usize],
}

impl Window<'_> {
    /// Phase and its rate at the time `t` after the origin, and the shape functions of the phase parameters.
    #[inline(always)]
    pub(crate) fn phase(&self, p: &[f64], t: f64) -> (f64, f64, [f64; 4]) {
        let (i, r) = self.backbone.map_or((0.0, 0.0), |b| b.at(t));
        (
            p[PHASE] + p[OMEGA] * t + p[BACKBONE] * i + 0.5 * p[CHIRP] * t * (t - self.duration),
            p[OMEGA] + p[BACKBONE] * r + p[CHIRP] * (t - 0.5 * self.duration),
            [1.0, t, i, 0.5 * t * (t - self.duration)],
        )
    }
}
