//! Drag, weighed over all ring-downs of a series together: each alone may hide what all of them show.

use super::answer::SingleAnswer;
use super::criteria::Criteria;
use super::single::Compared;
use super::solved::SolvedMeasurement;
use crate::answer::Parameter;

/// What a measurement says without drag, and beside it.
pub(super) struct Candidates {
    pub(super) without: SolvedMeasurement,
    pub(super) beside: Option<BesideDrag>,
}

/// Damping and friction beside a drag.
pub(super) struct BesideDrag {
    pub(super) solved: SolvedMeasurement,
    /// Drag rate over its standard error, the limit at zero lifted.
    pub(super) significance: f64,
}

impl Candidates {
    pub(super) fn new(measurement: usize, scale: f64, found: &Compared) -> Result<Self, &'static str> {
        let without = SolvedMeasurement::new(measurement, scale, &found.without_drag)?;
        let beside = |answer: &SingleAnswer| {
            let rate = answer.parameters().get(Parameter::DRAG_RATE)?;
            let significance = rate.unbounded_value / rate.std_error;
            let solved = SolvedMeasurement::new(measurement, scale, answer).ok()?;
            significance.is_finite().then_some(BesideDrag { solved, significance })
        };
        Ok(Self { without, beside: found.beside_drag.as_ref().and_then(beside) })
    }
}

/// The measurements, each averaged over the model without drag and that with it, by one weight for all that may have it
/// (Buckland et al. 1997, Biometrics 53, 603).
///
/// Minus twice the logarithm of the likelihood falls by about the square of the significance; a drag below zero, which
/// none is, speaks against one as much.
pub(super) fn averaged(all: Vec<Candidates>, criteria: &Criteria) -> Vec<SolvedMeasurement> {
    let significances = || all.iter().filter_map(|c| c.beside.as_ref()).map(|b| b.significance);
    let gain: f64 = significances().map(|z| z * z.abs() - criteria.drag_penalty).sum();
    let weight = 1.0 / (1.0 + (-0.5 * gain).exp());
    let of = |c: Candidates| match c.beside {
        Some(b) if weight.is_finite() => c.without.averaged_with(b.solved, weight),
        _ => c.without,
    };
    all.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Condition, Data, Measurement, Options, analyse};
    use crate::motion::simulate::Drive;
    use crate::motion::simulate::smooth::{SmoothMotion, drag};
    use crate::noise::jitter;
    use crate::{Oscillator, Record, ringdown};
    use std::f64::consts::{PI, TAU};

    const HZ: f64 = 5.0;
    const DELTA: f64 = PI * HZ / 60.0;

    /// Five ring-downs from 1 with drag, at the beginning a part of the viscous loss.
    fn series(part: f64, seed: usize) -> Vec<Measurement> {
        let measured = |i: usize| {
            let oscillator = Oscillator::kinematic(TAU * HZ, DELTA, 2e-3 * (i + 1) as f64).expect("valid");
            // dA/dt = -(4/3π) c ω A² for an acceleration c v².
            let acceleration = part * DELTA * 3.0 * PI / (4.0 * TAU * HZ);
            let law = drag(acceleration / (TAU * HZ).powi(2)).expect("valid");
            let mut motion =
                SmoothMotion::new(&oscillator, law, Drive::none(), 0.0, 1.0, 0.0).expect("valid");
            let time: Vec<f64> = (0..800).map(|k| 0.01 * k as f64).collect();
            let sample = |(k, t): (usize, &f64)| {
                motion.state_at(*t).expect("moves").position + 0.01 * jitter(k, (5 * seed + i) as u64)
            };
            let signal = time.iter().enumerate().map(sample).collect();
            Measurement {
                name: format!("{i}"),
                condition: Condition { label: format!("{i}"), value: None },
                data: Data::RingDown {
                    record: Box::new(Record::new(time, signal).expect("valid")),
                    options: Box::new(ringdown::Options::default()),
                },
                scale: 1.0,
            }
        };
        (0..5).map(measured).collect()
    }

    /// A tenth of the viscous loss moves the decay rate by five of its errors, and no ring-down shows it alone.
    #[test]
    fn drag_that_all_ring_downs_show_together_is_counted() {
        const SERIES: usize = 8;
        for part in [0.0, 0.1, 0.4] {
            let held = (0..SERIES).flat_map(|seed| {
                let rows = analyse(&series(part, seed), &Options::default()).expect("measured").table;
                rows.into_iter().map(|row| row.ring_down.expect("solved").damping.interval_95)
            });
            let held = held.filter(|[low, high]| (*low..=*high).contains(&DELTA)).count();
            // Of 40 at 95 % fewer than 33 are one run in ten thousand.
            assert!(held >= 33, "{part}: {held} of {}", 5 * SERIES);
        }
    }
}
