//! Disturbances of simulated decays in addition to or instead of white noise.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// A disturbance of a recorded displacement of amplitude 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Nuisance {
    /// White noise alone.
    None,
    /// Noise with autocorrelation 0.9 from sample to sample, in place of white noise.
    Ar,
    /// Noise of density 1/f, in place of white noise.
    Pink,
    /// A random walk of the offset by 5 % of the amplitude over the record.
    OffsetWalk,
    /// A random walk of the phase by 0.3 rad over the record.
    PhaseWalk,
    /// Mains hum at 50 Hz of 5 % of the amplitude, aliased to a fraction of the frequency if above half the sampling
    /// rate.
    Hum,
    /// Clipping at 85 % of the amplitude.
    Clipped,
    /// Outliers: one sample in 500 is off by 20 % to twice the amplitude.
    Spikes,
    /// The mass is held deflected before its release, for half as long as it is recorded afterwards.
    Held,
    /// A second release after the first, from 70 % of the amplitude and recorded as long.
    SecondRelease,
    /// Samples rounded to steps of a twentieth of the amplitude, recorded until the motion is far below one step.
    CoarseSteps,
    /// A nonlinear reading, `x - 0.1 x³`.
    BentReading,
}

pub(super) const DISTURBANCES: [Nuisance; 11] = [
    Nuisance::Ar,
    Nuisance::Pink,
    Nuisance::OffsetWalk,
    Nuisance::PhaseWalk,
    Nuisance::Hum,
    Nuisance::Clipped,
    Nuisance::Spikes,
    Nuisance::Held,
    Nuisance::SecondRelease,
    Nuisance::CoarseSteps,
    Nuisance::BentReading,
];

const AUTOCORRELATION: f64 = 0.9;
const OFFSET_WALK: f64 = 0.05;
const PHASE_WALK_RAD: f64 = 0.3;
const HUM: f64 = 0.05;
const MAINS_HZ: f64 = 50.0;
const CEILING: f64 = 0.85;
const SPIKES: f64 = 0.002;
const SPIKE: std::ops::Range<f64> = 0.2..2.0;
const BEND: f64 = -0.1;
const STEP: f64 = 0.05;
/// Length of the records with coarse steps, in decay times.
pub(super) const COARSE_DECAY_TIMES: f64 = 8.0;
/// Amplitude of the second release.
pub(super) const SECOND_RELEASE: f64 = 0.7;
/// Number of relaxations, with time constants in factors of 3, whose sum makes noise of density 1/f.
const RELAXATIONS: i32 = 9;

impl Nuisance {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::None => "white noise",
            Self::Ar => "autocorrelation 0.9",
            Self::Pink => "1/f noise",
            Self::OffsetWalk => "offset walks",
            Self::PhaseWalk => "phase walks",
            Self::Hum => "mains hum",
            Self::Clipped => "clipped",
            Self::Spikes => "spikes",
            Self::Held => "held before",
            Self::SecondRelease => "second release",
            Self::CoarseSteps => "coarse steps",
            Self::BentReading => "bent reading",
        }
    }

    /// The motion with the samples recorded before and after it, and the number of samples before it; `second` is the
    /// motion after the second release.
    pub(super) fn with_surroundings(
        self,
        motion: Vec<f64>,
        second: impl FnOnce() -> Vec<f64>,
    ) -> (usize, Vec<f64>) {
        match self {
            Self::Held => {
                let held = vec![motion[0]; motion.len() / 2];
                (held.len(), [held, motion].concat())
            }
            Self::SecondRelease => (0, [motion, second()].concat()),
            _ => (0, motion),
        }
    }

    /// Phase to add to the motion at each of `count` samples, rad.
    pub(super) fn phase(self, count: usize, rng: &mut impl Rng) -> Option<Vec<f64>> {
        (self == Self::PhaseWalk).then(|| walk(PHASE_WALK_RAD, count, rng))
    }

    /// The motion as recorded, with noise of standard deviation `sigma` per sample.
    pub(super) fn recorded(self, time_s: &[f64], motion: &[f64], sigma: f64, rng: &mut impl Rng) -> Vec<f64> {
        let n = motion.len();
        let noise = match self {
            Self::Ar => relaxation(AUTOCORRELATION, n, rng),
            Self::Pink => pink(n, rng),
            _ => (0..n).map(|_| rng.sample(StandardNormal)).collect(),
        };
        let read = |x: f64| if self == Self::BentReading { x + BEND * x.powi(3) } else { x };
        let mut signal: Vec<f64> = motion.iter().zip(&noise).map(|(x, v)| read(*x) + sigma * v).collect();
        match self {
            Self::OffsetWalk => {
                let offset = walk(OFFSET_WALK, n, rng);
                signal.iter_mut().zip(offset).for_each(|(x, o)| *x += o);
            }
            Self::Hum => {
                let phase: f64 = TAU * rng.random::<f64>();
                let hum = |t: &f64| HUM * (TAU * MAINS_HZ * t + phase).sin();
                signal.iter_mut().zip(time_s).for_each(|(x, t)| *x += hum(t));
            }
            Self::Clipped => signal.iter_mut().for_each(|x| *x = x.clamp(-CEILING, CEILING)),
            Self::Spikes => {
                for x in &mut signal {
                    if rng.random::<f64>() < SPIKES {
                        *x += rng.random_range(SPIKE) * if rng.random::<bool>() { 1.0 } else { -1.0 };
                    }
                }
            }
            Self::CoarseSteps => {
                let zero = rng.random::<f64>();
                signal.iter_mut().for_each(|x| *x = STEP * (*x / STEP + zero).round());
            }
            _ => {}
        }
        signal
    }
}

/// A random walk with this standard deviation at its end.
fn walk(end: f64, count: usize, rng: &mut impl Rng) -> Vec<f64> {
    let step = end / (count as f64).sqrt();
    let mut value = 0.0;
    (0..count)
        .map(|_| {
            value += step * rng.sample::<f64, _>(StandardNormal);
            value
        })
        .collect()
}

/// AR(1) noise of unit variance.
fn relaxation(autocorrelation: f64, count: usize, rng: &mut impl Rng) -> Vec<f64> {
    let mut value = rng.sample::<f64, _>(StandardNormal);
    let step = (1.0 - autocorrelation * autocorrelation).sqrt();
    (0..count)
        .map(|_| {
            value = autocorrelation * value + step * rng.sample::<f64, _>(StandardNormal);
            value
        })
        .collect()
}

/// Noise of unit variance and density 1/f over four decades: relaxations with time constants in
/// geometric steps (M. B. Weissman, Rev. Mod. Phys. 60, 537 (1988), eq. 1.9).
fn pink(count: usize, rng: &mut impl Rng) -> Vec<f64> {
    let mut sum = vec![0.0; count];
    for k in 0..RELAXATIONS {
        let samples = 3f64.powi(k);
        let part = relaxation((-1.0 / samples).exp(), count, rng);
        sum.iter_mut().zip(part).for_each(|(s, p)| *s += p / f64::from(RELAXATIONS).sqrt());
    }
    sum
}
