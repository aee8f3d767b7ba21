//! Drag shared by all measurements of a series: together they may show what each alone cannot.

use super::answer::SingleAnswer;
use super::criteria::Criteria;
use super::likelihood::lowest;
use super::single::ComparedAnswers;
use super::solved::SolvedMeasurement;
use crate::answer::Parameter;
use nalgebra::Vector2;

/// Results of a measurement without drag, and with it.
pub(super) struct Candidates {
    pub(super) without_drag: SolvedMeasurement,
    pub(super) with_drag: Option<WithDrag>,
}

/// Damping and friction of the model with drag, without limits.
pub(super) struct WithDrag {
    pub(super) solved: SolvedMeasurement,
    /// Drag rate in the common unit.
    rate: f64,
    std_error: f64,
    /// Change of damping and friction per change of the drag rate.
    slope: Vector2<f64>,
}

impl Candidates {
    pub(super) fn new(measurement: usize, scale: f64, found: &ComparedAnswers) -> Result<Self, &'static str> {
        let without_drag = SolvedMeasurement::new(measurement, scale, &found.without_drag)?;
        let with_drag = found.with_drag.as_ref().and_then(|answer| WithDrag::new(measurement, scale, answer));
        Ok(Self { without_drag, with_drag })
    }
}

impl WithDrag {
    fn new(measurement: usize, scale: f64, answer: &SingleAnswer) -> Option<Self> {
        let solved = SolvedMeasurement::new(measurement, scale, answer).ok()?;
        let drag = answer.parameters().get(Parameter::DRAG_RATE)?;
        let std_error = answer.own_error(Parameter::DRAG_RATE).unwrap_or(drag.std_error) / scale;
        let rate = drag.unbounded_value / scale;
        let correlations = [Parameter::DECAY_RATE, Parameter::FRICTION_DISPLACEMENT]
            .map(|parameter| answer.correlation(parameter, Parameter::DRAG_RATE).unwrap_or(0.0));
        let slope = Vector2::from_fn(|k, _| correlations[k] * solved.covariance[(k, k)].sqrt() / std_error);
        let found = rate.is_finite() && std_error > 0.0 && slope.iter().all(|v| v.is_finite());
        found.then_some(Self { solved, rate, std_error, slope })
    }
}

/// The drag rate estimated from all measurements together.
struct Pooled {
    rate: f64,
    std_error: f64,
    /// Variance between measurements.
    between: f64,
}

impl Pooled {
    /// Estimated as in a random-effects meta-analysis (REML).
    fn of(all: &[&WithDrag]) -> Self {
        let with = |deviation: f64| {
            let between = deviation * deviation;
            let weights = || all.iter().map(|b| 1.0 / (b.std_error * b.std_error + between));
            let weight: f64 = weights().sum();
            let rate = weights().zip(all).map(|(w, b)| w * b.rate).sum::<f64>() / weight;
            let off = weights().zip(all).map(|(w, b)| w * (b.rate - rate).powi(2) - w.ln());
            (Self { rate, std_error: weight.sqrt().recip(), between }, off.sum::<f64>() + weight.ln())
        };
        let rates = || all.iter().map(|b| b.rate);
        let range = rates().fold(f64::NEG_INFINITY, f64::max) - rates().fold(f64::INFINITY, f64::min);
        with(lowest(range, |deviation| with(deviation).1).0).0
    }
}

/// Viscous damping and sliding friction of the measurements, averaged over models with and without drag.
pub(super) struct AveragedMeasurements {
    pub(super) averaged: Vec<SolvedMeasurement>,
    /// The models without and with drag, with their weights.
    pub(super) models: Vec<(f64, Vec<SolvedMeasurement>)>,
}

impl AveragedMeasurements {
    /// The measurements, each averaged over the models without and with drag, with one weight for all (Buckland et
    /// al. 1997, Biometrics 53, 603).
    ///
    /// A body in one medium has one drag, so that its rate is estimated from all measurements together, and its
    /// uncertainty affects all of them alike. If the rates scatter between measurements, each keeps its own to that
    /// extent.
    ///
    /// Minus twice the logarithm of the likelihood falls by about the square of the significance; a negative drag,
    /// which is unphysical, counts against the model with drag by the same amount.
    pub(super) fn new(all: Vec<Candidates>, criteria: &Criteria) -> Self {
        let known: Vec<&WithDrag> = all.iter().filter_map(|c| c.with_drag.as_ref()).collect();
        let pooled = if known.is_empty() { None } else { Some(Pooled::of(&known)) };
        let significance = pooled.as_ref().map_or(f64::NEG_INFINITY, |p| p.rate / p.std_error);
        let weight = 1.0 / (1.0 + (0.5 * (criteria.drag_penalty - significance * significance.abs())).exp());
        let Some(pooled) = pooled.filter(|_| weight.is_finite() && weight > 0.0) else {
            let without: Vec<SolvedMeasurement> = all.into_iter().map(|c| c.without_drag).collect();
            return Self { averaged: without.clone(), models: vec![(1.0, without)] };
        };
        let (mut without, mut with_drag) = (Vec::new(), Vec::new());
        for candidates in all {
            let by_all =
                candidates.with_drag.as_ref().map(|b| b.given_rate(&pooled, &candidates.without_drag));
            with_drag.push(by_all.unwrap_or_else(|| candidates.without_drag.clone()));
            without.push(candidates.without_drag);
        }
        let averaged =
            without.iter().zip(&with_drag).map(|(a, b)| mean(a, b, weight, significance)).collect();
        Self { averaged, models: vec![(1.0 - weight, without), (weight, with_drag)] }
    }
}

impl WithDrag {
    /// The result for the common drag rate, as far as the measurement follows it.
    fn given_rate(&self, pooled: &Pooled, without: &SolvedMeasurement) -> SolvedMeasurement {
        let variance = self.std_error * self.std_error;
        let gives_way = variance / (variance + pooled.between);
        let slope = self.slope * gives_way;
        let given = self.solved.covariance - self.slope * self.slope.transpose() * (variance * gives_way);
        SolvedMeasurement {
            value: self.solved.value + slope * (pooled.rate - self.rate),
            // Correlations of an answer need not be consistent; the errors without drag are close to those for a
            // given drag.
            covariance: if given.cholesky().is_some() { given } else { without.covariance },
            shared: slope * pooled.std_error,
            ..self.solved.clone()
        }
    }
}

/// The average of a measurement without drag and with a drag of this significance, with this weight of the latter.
fn mean(
    without: &SolvedMeasurement,
    with_drag: &SolvedMeasurement,
    weight: f64,
    significance: f64,
) -> SolvedMeasurement {
    let apart = with_drag.value - without.value;
    // The choice of model moves all measurements through the shared rate, and the rest of the difference moves each
    // independently.
    let own = apart - with_drag.shared * significance;
    let shared = weight * (1.0 + (1.0 - weight) * significance * significance);
    SolvedMeasurement {
        value: without.value + apart * weight,
        covariance: without.covariance * (1.0 - weight)
            + with_drag.covariance * weight
            + own * own.transpose() * (weight * (1.0 - weight)),
        shared: with_drag.shared * shared.sqrt(),
        ..if weight > 0.5 { with_drag.clone() } else { without.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Condition, Data, Measurement, Options, analyse};
    use crate::motion::simulate::Drive;
    use crate::motion::simulate::smooth::{SmoothMotion, drag};
    use crate::motion::steady::Phasor;
    use crate::motion::steady::fundamental::{Point, fundamental};
    use crate::noise::jitter;
    use crate::resonance::{Curve, DriveAmplitude};
    use crate::{Oscillator, Record, resonance, ringdown};
    use std::f64::consts::{FRAC_PI_4, PI, TAU};

    const HZ: f64 = 5.0;
    const DELTA: f64 = PI * HZ / 60.0;
    const NOISE: f64 = 0.01;

    fn friction(load: usize) -> f64 {
        2e-3 * (load + 1) as f64
    }

    fn measurement(load: usize, data: Data) -> Measurement {
        let label = load.to_string();
        Measurement { name: label.clone(), condition: Condition { label, value: None }, data, scale: 1.0 }
    }

    /// A ring-down from amplitude 1 whose drag is initially a given part of the viscous loss.
    fn ring_down(load: usize, part: f64, seed: usize) -> Data {
        let oscillator = Oscillator::kinematic(TAU * HZ, DELTA, friction(load)).expect("valid");
        // dA/dt = -(4/3π) c ω A² for an acceleration c v².
        let acceleration = part * DELTA * 3.0 * FRAC_PI_4 / (TAU * HZ);
        let law = drag(acceleration / (TAU * HZ).powi(2)).expect("valid");
        let mut motion = SmoothMotion::new(&oscillator, law, Drive::none(), 0.0, 1.0, 0.0).expect("valid");
        let time: Vec<f64> = (0..800).map(|k| 0.01 * k as f64).collect();
        let sample = |(k, t): (usize, &f64)| {
            motion.state_at(*t).expect("moves").position + NOISE * jitter(k, (5 * seed + load) as u64)
        };
        let signal = time.iter().enumerate().map(sample).collect();
        Data::RingDown {
            record: Box::new(Record::new(time, signal).expect("valid")),
            options: Box::new(ringdown::Options::default()),
        }
    }

    /// A resonance curve of about the same amplitude.
    fn sweep(load: usize, part: f64, seed: usize) -> Data {
        let (omega_0, x_f) = (TAU * HZ, friction(load));
        let x_0 = 2.0 * 1.5 * DELTA / omega_0 + friction(4) / FRAC_PI_4;
        let omega: Vec<f64> = (0..101).map(|i| omega_0 + 6.0 * DELTA * (f64::from(i) / 50.0 - 1.0)).collect();
        let response = |omega: f64| {
            // Drag acts as a viscous loss proportional to the speed.
            let at = |amplitude: f64| {
                let delta = DELTA * (1.0 + part * amplitude * omega / omega_0);
                let point = Point { omega, omega_0, detuning: omega - omega_0, delta, x_0, x_f };
                fundamental(&point).expect("moves").value
            };
            let [mut low, mut high] = [0.0, x_0 * omega_0 / DELTA];
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *(if at(middle).norm() > middle { &mut low } else { &mut high }) = middle;
            }
            at(low)
        };
        let noisy = |(k, omega): (usize, &f64)| {
            let normal = |i: usize| NOISE * jitter(2 * k + i, (1000 + 5 * seed + load) as u64);
            response(*omega) + Phasor::new(normal(0), normal(1))
        };
        let signal = omega.iter().enumerate().map(noisy).collect();
        let hz = omega.iter().map(|w| w / TAU).collect();
        let options = resonance::Options {
            drive_amplitude: Some(DriveAmplitude { value: x_0, std_error: 0.0 }),
            ..resonance::Options::default()
        };
        Data::Sweep {
            curve: Box::new(Curve::complex(hz, signal).build().expect("valid")),
            options: Box::new(options),
        }
    }

    /// Drag of a tenth of the viscous loss shifts the decay rate by five of its errors, and no ring-down shows it
    /// alone. Its uncertainty is common to all of them, so that averaging does not reduce it in the decay rate.
    #[test]
    fn drag_that_all_ring_downs_show_together_is_counted() {
        const SERIES: usize = 8;
        let mut options = Options::default();
        options.shared.decay_rate = true;
        let mut held_together = 0;
        for part in [0.0, 0.1, 0.4] {
            let mut held = 0;
            for seed in 0..SERIES {
                let all: Vec<Measurement> =
                    (0..5).map(|load| measurement(load, ring_down(load, part, seed))).collect();
                let answer = analyse(&all, &options).expect("measured");
                let holds = |[low, high]: [f64; 2]| usize::from((low..=high).contains(&DELTA));
                let rows = answer.table.into_iter().map(|row| row.ring_down.expect("solved").damping);
                held += rows.map(|damping| holds(damping.interval_95)).sum::<usize>();
                let together = answer.joint.expect("several").decay_rate_per_s.expect("shared");
                held_together += holds(together.interval_95);
            }
            // Of 40 at 95 %, fewer than 33 occur in one run in ten thousand.
            assert!(held >= 33, "{part}: {held} of {}", 5 * SERIES);
        }
        // Of 24, fewer than 19 occur in one run in two hundred.
        assert!(held_together >= 19, "{held_together} of {}", 3 * SERIES);
    }

    /// Models of curves without drag covered the decay rate in none of the cases; a background or a delay mistaken
    /// for drag still covers it in a quarter.
    #[test]
    fn drag_counts_in_sweeps_as_well() {
        const SERIES: usize = 8;
        let mut held = 0;
        for seed in 0..SERIES {
            let all: Vec<Measurement> =
                (0..5).map(|load| measurement(load, sweep(load, 0.1, seed))).collect();
            let rows = analyse(&all, &Options::default()).expect("measured").table;
            let intervals = rows.into_iter().map(|row| row.resonance.expect("solved").damping.interval_95);
            held += intervals.filter(|[low, high]| (*low..=*high).contains(&DELTA)).count();
        }
        // Of 40 at 75 %, fewer than 22 occur in one run in four hundred.
        assert!(held >= 22, "{held} of {}", 5 * SERIES);
    }
}
