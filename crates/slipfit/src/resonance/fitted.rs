//! The fitted curve, for plotting or subtraction.

use super::problem::Problem;
use super::response::Modelled;
use crate::motion::steady::Phasor;
use crate::motion::steady::fundamental::Follower;
use std::f64::consts::TAU;

/// The fitted response at any frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedCurve {
    pub(crate) problem: Problem,
    pub(crate) parameters: Vec<f64>,
    /// Parameters of the same oscillator without sliding friction.
    pub(crate) friction_free: Vec<f64>,
    /// Angular frequency and amplitude of the points that select the branch: those of the first run, if the frequency
    /// was swept both up and down.
    pub(crate) guide: Vec<[f64; 2]>,
}

impl FittedCurve {
    /// The fitted response, instrument terms included, at the mean drive; if there are several branches, on the one
    /// closest to the measured points. NaN if the model has no motion.
    pub fn response(&self, frequency_hz: f64) -> Phasor {
        self.at(&self.parameters, frequency_hz)
    }

    /// The response of the same oscillator with the same drive, without sliding friction; instrument terms included.
    pub fn friction_free(&self, frequency_hz: f64) -> Phasor {
        self.at(&self.friction_free, frequency_hz)
    }

    /// The fitted response at a relative drive level, valid for an oscillator without friction.
    pub(super) fn response_at(&self, frequency_hz: f64, drive: f64) -> Phasor {
        self.response(frequency_hz) * drive
    }

    /// The oscillator alone: no background, delay or phase offset.
    pub fn oscillator(&self, frequency_hz: f64) -> Phasor {
        self.modelled(&self.parameters, frequency_hz)
            .map_or(Phasor::new(f64::NAN, f64::NAN), |m| m.oscillator)
    }

    fn at(&self, p: &[f64], frequency_hz: f64) -> Phasor {
        let stretched = |m: Modelled| {
            let size = m.value.norm();
            let read = m.size() + m.offset;
            if size > 0.0 { m.value * (read / size) } else { Phasor::new(read, 0.0) }
        };
        self.modelled(p, frequency_hz).map_or(Phasor::new(f64::NAN, f64::NAN), stretched)
    }

    fn modelled(&self, p: &[f64], frequency_hz: f64) -> Option<Modelled> {
        let omega = TAU * frequency_hz;
        let at = self.problem.response(p, false);
        // If the search was stopped because of its work, evaluation for a plot would take as long.
        let cut = self.problem.main.work.was_cut();
        let mut follower = if cut { Follower::without_search() } else { Follower::default() };
        at.at(omega, 1.0, self.guess(omega), &mut follower)
    }

    /// Measured amplitude at the point closest to a frequency.
    fn guess(&self, omega: f64) -> f64 {
        if !self.guide.is_empty() {
            let near = |p: &&[f64; 2]| (p[0] - omega).abs();
            let nearest = self.guide.iter().min_by(|p, q| near(p).total_cmp(&near(q)));
            return nearest.map_or(0.0, |p| p[1]);
        }
        let b = &self.problem.main;
        let above = b.omega.partition_point(|w| *w < omega).min(b.len() - 1);
        let below = above.saturating_sub(1);
        let nearest = if omega - b.omega[below] < b.omega[above] - omega { below } else { above };
        let at = self.problem.response(&self.parameters, false);
        let background = at.background_at(b.omega[nearest]);
        if b.complex {
            (b.data[nearest] - background).norm()
        } else {
            at.amplitude_from_reading(b.data[nearest].re)
        }
    }
}
