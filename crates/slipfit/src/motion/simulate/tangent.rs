//! Effect of a small change of the initial state on a later state.

use super::event::{EventKind, State};
use super::motion::Motion;
use super::transition::Constants;

/// A later state and its derivative with respect to the initial state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// The state reached.
    pub state: State,
    /// `d (position, velocity) / d (position, velocity)` at the start, row by row.
    pub matrix: [[f64; 2]; 2],
}

type Matrix = [[f64; 2]; 2];

impl Motion {
    /// Runs to `until_s` and propagates the Jacobian of the event map.
    ///
    /// Arcs contribute their closed-form transition; a turning point multiplies the velocity row by the ratio of the
    /// accelerations after and before; a stop sets it to zero; a release makes it
    /// `-(acceleration at release / drive's slope)` times the position row. A mass that sticks at the start is
    /// assumed to stick also when perturbed.
    pub fn tangent(mut self, until_s: f64) -> Tangent {
        let mut m = if self.direction() == 0.0 { [[1.0, 0.0], [0.0, 0.0]] } else { [[1.0, 0.0], [0.0, 1.0]] };
        loop {
            let (length, before) = self.segment_end();
            let left = self.until(until_s);
            if length.is_nan() || left.is_nan() || length > left {
                if let Some((_, k)) = before {
                    m = product(&transition(&k, left.max(0.0)), &m);
                }
                let (position, velocity) = self.peek(left.max(0.0));
                return Tangent { state: State { time_s: until_s, position, velocity }, matrix: m };
            }
            if let Some((_, k)) = before {
                m = product(&transition(&k, length), &m);
            }
            let Some(event) = self.advance() else { continue };
            match event.kind {
                EventKind::Turn => {
                    let ratio = before.map_or(0.0, |(a, _)| self.pull_here() / a);
                    m[1] = m[1].map(|x| x * ratio);
                }
                EventKind::Stop | EventKind::Rest => m[1] = [0.0; 2],
                EventKind::Release => {
                    let ratio = -self.pull_here() / self.drive_slope();
                    m[1] = m[0].map(|x| if ratio.is_finite() { x * ratio } else { 0.0 });
                }
                EventKind::DriveChange => {}
            }
        }
    }
}

fn transition(k: &Constants, u: f64) -> Matrix {
    let (sin, cos) = (k.omega_d * u).sin_cos();
    let e = (-k.delta * u).exp();
    let s = e * sin / k.omega_d;
    let c = e * cos;
    [[c + k.delta * s, s], [-k.square * s, c - k.delta * s]]
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut out = [[0.0; 2]; 2];
    for (i, row) in out.iter_mut().enumerate() {
        for (j, cell) in row.iter_mut().enumerate() {
            *cell = a[i][0] * b[0][j] + a[i][1] * b[1][j];
        }
    }
    out
}
