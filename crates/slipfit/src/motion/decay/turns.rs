//! The turning points of a free decay in sequence, with their derivatives.

use super::amplitude::sliding_gain;
use super::drag::Slowing;
use super::parameters::{BACKBONE, CHIRP, DELTA, DRAG, OFFSET, OMEGA, PHASE, X_F, by_parameters, law_of};
use super::path::{AmplitudePath, CARRIED, Carried, LinearStep};
use super::window::Window;
use std::f64::consts::PI;

/// Relative change of the amplitude over several half cycles up to which they are passed in one step; the effect of
/// drag on the phase is evaluated in the middle of the step.
const MOST_CHANGE: f64 = 0.02;

/// A turning point with the quantities that its half cycles need.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) time: f64,
    /// Phase rate without the effect of drag.
    pub(super) omega: f64,
    pub(super) amplitude: f64,
    /// Derivatives of the phase with respect to all loss and phase parameters.
    pub(super) phase_by: [f64; OFFSET],
    /// Derivatives of the amplitude with respect to all loss and phase parameters.
    pub(super) by: [f64; OFFSET],
}

/// Sequence of the turning points.
#[derive(Clone)]
pub(super) struct Turns<'a> {
    window: &'a Window<'a>,
    p: &'a [f64],
    gain: [f64; 3],
    path: AmplitudePath,
    /// Time of the current position of `path`.
    now: f64,
    /// Phase lag due to drag so far, and its derivatives with respect to amplitude and losses.
    lag: f64,
    lag_by: [f64; CARRIED],
    /// Whether drag is part of the model.
    drags: bool,
    /// Whether the phase, apart from drag, is linear in time.
    straight: bool,
    /// The steps from one turning point to the next, if all half cycles are equal.
    even: Option<(usize, LinearStep)>,
    /// Whether the path has reached its first turning point.
    begun: bool,
}

impl<'a> Turns<'a> {
    #[inline(always)]
    pub(super) fn new(window: &'a Window<'a>, p: &'a [f64]) -> Self {
        // Relative frequency shift per A², which also changes the loss terms.
        let backbone = if window.backbone.is_some() { [p[BACKBONE] / p[OMEGA], 0.0] } else { [0.0; 2] };
        let carried = Carried::for_parameters(window.active);
        let path = AmplitudePath::new(law_of(p, p[OMEGA]), backbone).carrying(carried);
        let drags = p[DRAG] != 0.0 || window.active.contains(&DRAG);
        let straight = (window.backbone.is_none() || p[BACKBONE] == 0.0) && p[CHIRP] == 0.0;
        // Zero drag changes no half cycle, but its derivative may be needed.
        let alike = straight && p[DRAG] == 0.0 && carried != Carried::All;
        let even = if alike { path.even_steps(PI / p[OMEGA]) } else { None };
        Self {
            window,
            p,
            gain: sliding_gain(p[DELTA], p[OMEGA]),
            path,
            now: 0.0,
            lag: 0.0,
            lag_by: [0.0; CARRIED],
            drags,
            straight,
            even,
            begun: false,
        }
    }

    /// `lambda` of all half cycles if they are equal: the turning points of viscous and sliding loss obey
    /// `X' + x_F = e^(-pi delta/omega) (X - x_F)`.
    #[inline(always)]
    pub(super) fn common_lambda(&self) -> Option<f64> {
        self.even.map(|_| -self.p[DELTA] / self.p[OMEGA])
    }

    /// Turning point `n`, the next after the last one requested, near `guess`.
    #[inline(always)]
    pub(super) fn at(&mut self, n: f64, guess: f64) -> Turn {
        let even = self.even.filter(|_| self.begun);
        self.reach(n, guess, even)
    }

    /// The turning point `count` after `turn`, which has number `n` and was the last one requested, in one step.
    #[inline(never)]
    pub(super) fn leap(&mut self, n: f64, turn: &Turn, count: f64) -> Turn {
        self.reach(n + count, turn.time + count * PI / turn.omega, None)
    }

    /// Number of half cycles in which the amplitude changes so little that they can be one step.
    pub(super) fn most_in_one(&self) -> f64 {
        MOST_CHANGE * self.path.amplitude.abs() * self.p[OMEGA] / (PI * self.path.rate().abs())
    }

    #[inline(always)]
    fn reach(&mut self, n: f64, guess: f64, even: Option<(usize, LinearStep)>) -> Turn {
        let p = self.p;
        let slowing = self.slowing(guess);
        let time = match self.even {
            Some(_) => (n * PI - p[PHASE]) / p[OMEGA],
            None => self.turn_time(n, guess, slowing.rate),
        };
        let (before, passed) = (self.path.by, time - self.now);
        match even {
            Some((parts, step)) => (0..parts).for_each(|_| self.path.advance_linear(&step)),
            None => self.path.advance(passed),
        }
        self.now = time;
        self.begun = true;
        let mut by = [0.0; OFFSET];
        by[..CARRIED].copy_from_slice(&by_parameters(self.path.by, p, &self.gain));
        if self.drags {
            self.lag += slowing.rate * passed;
            let before = by_parameters(before, p, &self.gain);
            for ((lag, before), after) in self.lag_by.iter_mut().zip(before).zip(by) {
                *lag += slowing.by_amplitude * 0.5 * (before + after) * passed;
            }
            self.lag_by[DELTA] += slowing.by_decay * passed;
            self.lag_by[DRAG] += slowing.by_drag * passed;
        }
        let (_, omega, shapes) = self.window.phase(p, time);
        let mut phase_by = [0.0; OFFSET];
        phase_by[PHASE..].copy_from_slice(&shapes);
        for (by, lag) in phase_by.iter_mut().zip(self.lag_by) {
            *by = -lag;
        }
        phase_by[OMEGA] += self.lag / p[OMEGA];
        // A shift of the phase moves the turning point: dX/dp = rate S/omega; and a0 depends on omega.
        let rate = self.path.rate() / (omega - slowing.rate);
        for (by, phase_by) in by.iter_mut().zip(phase_by) {
            *by += rate * phase_by;
        }
        by[OMEGA] += self.path.by[X_F] * p[X_F] * self.gain[2];
        Turn { time, omega, amplitude: self.path.amplitude, phase_by, by }
    }

    /// Reduction of the phase rate by drag on the way to the turning point near `guess`, with its derivatives.
    #[inline(always)]
    fn slowing(&self, guess: f64) -> Slowing {
        let p = self.p;
        if !self.drags {
            return Slowing::default();
        }
        let halfway = self.path.amplitude - 0.5 * (guess - self.now) * self.path.rate();
        Slowing::new(halfway, [p[DELTA], p[DRAG]], p[OMEGA])
    }

    /// Time at which the phase reaches `n pi`, starting from a guess.
    #[inline(never)]
    fn turn_time(&self, n: f64, guess: f64, slowing: f64) -> f64 {
        let mut t = guess;
        for _ in 0..8 {
            let (phase, omega, _) = self.window.phase(self.p, t);
            let (phase, omega) = (phase - self.lag - slowing * (t - self.now), omega - slowing);
            let step = (n * PI - phase) / omega;
            t += step;
            if self.straight || step.abs() * omega < 1e-12 * (1.0 + n.abs()) {
                break;
            }
        }
        t
    }
}
