//! Deviation of the exact motion from the straight line of eq. (9).

use super::answer::Answer;
use super::criteria::LevelCriteria;
use super::measurement::Levels;
use crate::answer::Parameter;
use crate::motion::steady::scan;
use crate::{Error, Oscillator};
use std::f64::consts::FRAC_PI_4;

/// Corrects the answer for the deviation of the exact motion from the line: the deviation according to the `first`
/// answer is subtracted from the amplitudes and the line is fitted again, until Q and friction converge.
///
/// At the undamped resonance the fundamental of the exact motion (J. P. Den Hartog, Trans. ASME 53, 107 (1931))
/// deviates from the line by a relative amount `2 (x_F/R_0)²` at high Q, and by more at low Q, where friction shapes
/// the motion. The deviation depends on Q and the threshold only; without a calibration of the drive nothing is
/// subtracted.
pub(super) fn corrected_for_exact_motion(
    levels: &Levels,
    first: Answer,
    criteria: &LevelCriteria,
    line: impl Fn(&Levels) -> Result<Answer, Error>,
) -> Answer {
    let mut answer = first;
    for _ in 0..criteria.exact_rounds {
        let Some(deviation) = deviation_from_line(levels, &answer) else { break };
        let Ok(mut next) = line(&levels.subtracting(&deviation)) else { break };
        for point in &mut next.points {
            point.fitted += deviation[point.index];
            point.amplitude = levels.amplitude()[point.index];
        }
        let settled = is_settled(&answer, &next, criteria);
        answer = next;
        if settled {
            break;
        }
    }
    answer
}

/// Exact amplitude at each level minus that of the line, which is zero below its threshold; `None` without Q or
/// friction.
fn deviation_from_line(levels: &Levels, answer: &Answer) -> Option<Vec<f64>> {
    let value = |parameter| answer.parameter(parameter).map(|q| q.value).filter(|v| *v > 0.0);
    let q = value(Parameter::QFactor)?;
    let (slope, threshold) = value(Parameter::Slope).zip(value(Parameter::Threshold))?;
    if !answer.detected {
        return None;
    }
    // Drives in units of the threshold `4 x_F/pi`, amplitudes in that of `slope threshold/q`.
    let oscillator =
        Oscillator::builder().frequency_hz(1.0).q_factor(q).friction_displacement(FRAC_PI_4).build().ok()?;
    let deviation = |drive: &f64| {
        let u = drive / threshold;
        // Friction keeps the mass at rest.
        if !(u > FRAC_PI_4) {
            return Some(0.0);
        }
        let exact = scan::reading(&oscillator, u, 1.0).ok()?.amplitude();
        let off = (exact - (q * (u - 1.0)).max(0.0)) * slope * threshold / q;
        off.is_finite().then_some(off)
    };
    levels.drive().iter().map(deviation).collect()
}

/// Whether Q and friction have changed by a small fraction of their standard errors.
fn is_settled(before: &Answer, now: &Answer, criteria: &LevelCriteria) -> bool {
    [Parameter::QFactor, Parameter::FRICTION_DISPLACEMENT].iter().all(|parameter| {
        let pair = before.parameter(*parameter).zip(now.parameter(*parameter));
        pair.is_none_or(|(a, b)| (a.value - b.value).abs() <= criteria.exact_settled * b.std_error)
    })
}

#[cfg(test)]
mod tests {
    use crate::levels::{Levels, Options, analyse};
    use crate::motion::steady::scan;
    use crate::noise::jitter;
    use crate::{Oscillator, Parameter};

    /// The intervals of exact levels cover Q and friction at every Q, and no bend is found.
    #[test]
    fn exact_levels_hold_the_truth_at_every_q() {
        for (q, noise) in [(1.0, 0.01), (2.0, 1e-3), (5.0, 1e-3), (50.0, 1e-3), (50.0, 1e-4)] {
            let oscillator = Oscillator::builder()
                .frequency_hz(2.0)
                .q_factor(q)
                .friction_displacement(0.4)
                .build()
                .unwrap();
            let drive: Vec<f64> = (1..=20).map(|i| 0.15 * f64::from(i)).collect();
            let of = |d: &f64| scan::reading(&oscillator, *d, 2.0).unwrap().amplitude();
            let clean: Vec<f64> = drive.iter().map(of).collect();
            let top = clean[clean.len() - 1];
            let [mut held_q, mut held_x_f, mut bent] = [0; 3];
            const REPEATS: usize = 40;
            for seed in 0..REPEATS {
                let noisy = |(i, a): (usize, &f64)| (a + noise * top * jitter(i, seed as u64)).abs();
                let amplitude = clean.iter().enumerate().map(noisy).collect();
                let levels =
                    Levels::builder(drive.clone(), amplitude).unit("mm").drive_unit("mm").build().unwrap();
                let answer = analyse(&levels, &Options::default()).unwrap();
                let holds = |parameter, truth: f64| {
                    let [low, high] = answer.parameter(parameter).unwrap().interval_95;
                    usize::from(low <= truth && truth <= high)
                };
                held_q += holds(Parameter::QFactor, q);
                held_x_f += holds(Parameter::FRICTION_DISPLACEMENT, 0.4);
                bent += usize::from(answer.warnings.iter().any(|w| w.code() == "bent"));
            }
            assert!(held_q >= 34 && held_x_f >= 34, "Q {q}, noise {noise}: {held_q} {held_x_f} of {REPEATS}");
            assert!(bent <= 2, "Q {q}, noise {noise}: {bent} bent");
        }
    }
}
