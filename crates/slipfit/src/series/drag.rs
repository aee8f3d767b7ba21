//! Drag that all measurements of a series share: each alone may hide what all of them show.

use super::answer::SingleAnswer;
use super::criteria::Criteria;
use super::likelihood::lowest;
use super::single::Compared;
use super::solved::SolvedMeasurement;
use crate::answer::Parameter;
use nalgebra::Vector2;

/// What a measurement says without drag, and beside it.
pub(super) struct Candidates {
    pub(super) without: SolvedMeasurement,
    pub(super) beside: Option<BesideDrag>,
}

/// Damping and friction beside a drag, limits lifted.
pub(super) struct BesideDrag {
    pub(super) solved: SolvedMeasurement,
    /// Drag rate in the common unit.
    rate: f64,
    std_error: f64,
    /// By how much damping and friction rise with it.
    slope: Vector2<f64>,
}

impl Candidates {
    pub(super) fn new(measurement: usize, scale: f64, found: &Compared) -> Result<Self, &'static str> {
        let without = SolvedMeasurement::new(measurement, scale, &found.without_drag)?;
        let beside =
            found.beside_drag.as_ref().and_then(|answer| BesideDrag::new(measurement, scale, answer));
        Ok(Self { without, beside })
    }
}

impl BesideDrag {
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

/// The drag rate of all measurements together.
struct Pooled {
    rate: f64,
    std_error: f64,
    /// Variance from one measurement to another.
    between: f64,
}

impl Pooled {
    /// As a random-effects meta-analysis does (REML).
    fn of(all: &[&BesideDrag]) -> Self {
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

/// What measurements say of viscous damping and sliding friction, drag weighed.
pub(super) struct Weighed {
    pub(super) averaged: Vec<SolvedMeasurement>,
    /// Without drag and beside it, with their weights.
    pub(super) models: Vec<(f64, Vec<SolvedMeasurement>)>,
}

impl Weighed {
    /// The measurements, each averaged over the model without drag and that with it, by one weight for all
    /// (Buckland et al. 1997, Biometrics 53, 603).
    ///
    /// A body in one medium has one drag, so that its rate is estimated from all measurements together, and what is not known
    /// of it moves all of them alike. Where the rates scatter from one to another, each has its own as far as they do.
    ///
    /// Minus twice the logarithm of the likelihood falls by about the square of the significance; a drag below zero, which
    /// none is, speaks against one as much.
    pub(super) fn new(all: Vec<Candidates>, criteria: &Criteria) -> Self {
        let known: Vec<&BesideDrag> = all.iter().filter_map(|c| c.beside.as_ref()).collect();
        let pooled = if known.is_empty() { None } else { Some(Pooled::of(&known)) };
        let significance = pooled.as_ref().map_or(f64::NEG_INFINITY, |p| p.rate / p.std_error);
        let weight = 1.0 / (1.0 + (0.5 * (criteria.drag_penalty - significance * significance.abs())).exp());
        let Some(pooled) = pooled.filter(|_| weight.is_finite() && weight > 0.0) else {
            let without: Vec<SolvedMeasurement> = all.into_iter().map(|c| c.without).collect();
            return Self { averaged: without.clone(), models: vec![(1.0, without)] };
        };
        let (mut without, mut beside) = (Vec::new(), Vec::new());
        for candidates in all {
            let by_all = candidates.beside.as_ref().map(|b| b.given_rate(&pooled, &candidates.without));
            beside.push(by_all.unwrap_or_else(|| candidates.without.clone()));
            without.push(candidates.without);
        }
        let averaged = without.iter().zip(&beside).map(|(a, b)| mean(a, b, weight, significance)).collect();
        Self { averaged, models: vec![(1.0 - weight, without), (weight, beside)] }
    }
}

impl BesideDrag {
    /// With the drag rate of all measurements, as far as that is its own.
    fn given_rate(&self, pooled: &Pooled, without: &SolvedMeasurement) -> SolvedMeasurement {
        let variance = self.std_error * self.std_error;
        let gives_way = variance / (variance + pooled.between);
        let slope = self.slope * gives_way;
        let given = self.solved.covariance - self.slope * self.slope.transpose() * (variance * gives_way);
        SolvedMeasurement {
            value: self.solved.value + slope * (pooled.rate - self.rate),
            // Correlations of an answer need not fit together; without drag the errors are about those given it.
            covariance: if given.cholesky().is_some() { given } else { without.covariance },
            shared: slope * pooled.std_error,
            ..self.solved.clone()
        }
    }
}

/// The mean of a measurement without drag and beside one of such a significance, by the weight of the latter.
fn mean(
    without: &SolvedMeasurement,
    beside: &SolvedMeasurement,
    weight: f64,
    significance: f64,
) -> SolvedMeasurement {
    let apart = beside.value - without.value;
    // Whether there is drag moves all measurements by the shared rate, and what is left each by itself.
    let own = apart - beside.shared * significance;
    let shared = weight * (1.0 + (1.0 - weight) * significance * significance);
    SolvedMeasurement {
        value: without.value + apart * weight,
        covariance: without.covariance * (1.0 - weight)
            + beside.covariance * weight
            + own * own.transpose() * (weight * (1.0 - weight)),
        shared: beside.shared * shared.sqrt(),
        ..if weight > 0.5 { beside.clone() } else { without.clone() }
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

    /// A ring-down from 1 with drag, at the beginning a part of the viscous loss.
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
            // Drag is a viscous loss in proportion to the speed.
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

    /// A tenth of the viscous loss moves the decay rate by five of its errors, and no ring-down shows it alone. What is not
    /// known of it is the same in all of them: the decay rate of all is no surer for it.
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
            // Of 40 at 95 % fewer than 33 are one run in ten thousand.
            assert!(held >= 33, "{part}: {held} of {}", 5 * SERIES);
        }
        // Of 24 fewer than 19 are one in two hundred.
        assert!(held_together >= 19, "{held_together} of {}", 3 * SERIES);
    }

    /// Curves without drag in their model held the decay rate in none of the cases; a background or a delay that passes for
    /// drag does so still in a quarter.
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
        // Of 40 at 75 % fewer than 22 are one run in four hundred.
        assert!(held >= 22, "{held} of {}", 5 * SERIES);
    }
}
