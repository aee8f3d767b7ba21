//! The motions that can be described by sums gathered about a reference, and their state as a function of
//! time.

use crate::motion::decay::amplitude::sliding_gain;
use crate::motion::decay::drag::Slowing;
use crate::motion::decay::parameters::{A0, DELTA, DRAG, OFFSET, OMEGA, PHASE, X_F, by_parameters, law_of};
use crate::motion::decay::path::{AmplitudePath, Carried};

/// The parameters of the motions described, in the order of the lanes: losses, phase, frequency, offset.
pub(super) const DESCRIBED: [usize; LANES - 1] = [A0, X_F, DELTA, DRAG, PHASE, OMEGA, OFFSET];
pub(super) const A: usize = 0;
pub(super) const X: usize = 1;
pub(super) const D: usize = 2;
pub(super) const C: usize = 3;
pub(super) const P: usize = 4;
pub(super) const W: usize = 5;
pub(super) const O: usize = 6;
/// The described parameters and one that is always zero.
pub(super) const LANES: usize = 8;
pub(super) type Lanes = [f64; LANES];

/// Amplitude and phase of a motion at a given time, with their derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) amplitude: f64,
    pub(super) phase: f64,
    pub(super) by: Lanes,
    pub(super) phase_by: Lanes,
}

/// A motion advanced from time to time.
pub(super) struct Follow<'a> {
    p: &'a [f64],
    gain: [f64; 3],
    path: AmplitudePath,
    drags: bool,
    now: f64,
    lag: f64,
    lag_by: [f64; 4],
}

impl<'a> Follow<'a> {
    pub(super) fn new(p: &'a [f64], drags: bool) -> Self {
        let gain = sliding_gain(p[DELTA], p[OMEGA]);
        let path = AmplitudePath::new(law_of(p, p[OMEGA]), [0.0; 2]).carrying(Carried::Closed);
        Self { p, gain, path, drags, now: 0.0, lag: 0.0, lag_by: [0.0; 4] }
    }

    pub(super) fn to(&mut self, time: f64) -> State {
        let (p, passed) = (self.p, time - self.now);
        if self.drags {
            self.path.advance(0.5 * passed);
            let slowing = Slowing::new(self.path.amplitude, [p[DELTA], p[DRAG]], p[OMEGA]);
            let by = by_parameters(self.path.by, p, &self.gain);
            self.lag += slowing.rate * passed;
            for (lag, by) in self.lag_by.iter_mut().zip(by) {
                *lag += slowing.by_amplitude * by * passed;
            }
            self.lag_by[DELTA] += slowing.by_decay * passed;
            self.lag_by[DRAG] += slowing.by_drag * passed;
            self.path.advance(0.5 * passed);
        } else {
            self.path.advance(passed);
        }
        self.now = time;
        let losses = by_parameters(self.path.by, p, &self.gain);
        let (mut by, mut phase_by) = ([0.0; LANES], [0.0; LANES]);
        by[..4].copy_from_slice(&losses[..4]);
        by[W] = self.path.by[X_F] * p[X_F] * self.gain[2];
        for (by, lag) in phase_by.iter_mut().zip(self.lag_by) {
            *by = -lag;
        }
        phase_by[P] = 1.0;
        phase_by[W] = time + self.lag / p[OMEGA];
        let phase = p[PHASE] + p[OMEGA] * time - self.lag;
        State { amplitude: self.path.amplitude, phase, by, phase_by }
    }
}

/// Whether all losses and disturbances of a motion are among those described.
pub(super) fn is_described(p: &[f64]) -> bool {
    p.iter().enumerate().all(|(k, v)| *v == 0.0 || DESCRIBED.contains(&k))
}
